"""Revisions, and what of the past is let go."""
