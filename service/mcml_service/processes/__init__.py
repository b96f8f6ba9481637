"""Separate programs with limits of time and memory."""
