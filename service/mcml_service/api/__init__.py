"""The HTTP API: routes made from OPERATIONS, and the few that are made by hand."""
