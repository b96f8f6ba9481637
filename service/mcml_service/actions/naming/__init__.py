"""Names of joints: aliases of a project, documents that get the present names."""
