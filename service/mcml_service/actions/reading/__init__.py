"""Clips out of files and out of the store, and what is said of them."""
