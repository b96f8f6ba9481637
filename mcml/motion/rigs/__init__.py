"""Rigs recognised: which joint is which of a person's, by words, tree and rest pose; arrays and texts only."""
