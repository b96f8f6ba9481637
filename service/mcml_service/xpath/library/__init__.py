"""Cached data of a library: documents in groups, zone maps, tracks, shared skeletons."""
