"""Columns beside the store: what one process worked out, for the first questions of the next."""
