"""Repositories in Python: documents, queries, operations, on a server or in a local store."""
