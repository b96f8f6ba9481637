"""Apply proposed changes, and carry them over to other revisions."""
