"""Documents: their heads, tracks, labels, files and derived data."""
