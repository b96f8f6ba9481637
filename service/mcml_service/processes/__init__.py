"""How requests share a few processes."""
