"""Changes of one document: its facts, elements and frames. Each is a revision."""
