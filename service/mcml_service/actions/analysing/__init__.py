"""Start analyses, and use their results."""
