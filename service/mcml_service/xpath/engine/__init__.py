"""A tree on columns: axes, predicates, functions and aggregates, whole arrays at a time."""
