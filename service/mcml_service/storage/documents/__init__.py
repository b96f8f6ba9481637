"""Documents: their heads, tracks, labels, files and what is derived of them."""
