"""Repositories as Python calls them: documents, questions, operations, on a server or through what opens stores."""
