"""Parameters and results of each analysis, one file a subject."""
