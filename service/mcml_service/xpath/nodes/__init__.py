"""Nodes as numbers: which there are, in what order, and the heads and frames of documents as arrays of them."""
