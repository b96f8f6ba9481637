"""A folder and the documents of a project, kept equal."""
