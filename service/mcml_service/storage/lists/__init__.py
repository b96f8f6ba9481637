"""Conditions, orders and counts of lists of documents."""
