"""Conditions on samples, over many frames at once."""
