"""The element store: documents as rows and compressed tracks, with every revision kept.

SQL lives here and nowhere else (design in docs/decisions/0001 and docs/store.md).
"""
