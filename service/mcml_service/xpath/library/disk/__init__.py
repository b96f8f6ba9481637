"""Columns on disk beside the store: computed by one process, for the first queries of the next."""
