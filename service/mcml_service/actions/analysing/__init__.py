"""Analyses started, and what became of them used."""
