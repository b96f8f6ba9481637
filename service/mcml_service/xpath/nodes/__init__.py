"""Nodes as numbers: their numbering and order, and the heads and frames of documents as arrays of them."""
