"""Revisions, pruning and purging."""
