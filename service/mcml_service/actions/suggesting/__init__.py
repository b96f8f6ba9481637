"""Suggestions for queries, from the motion of the library."""
