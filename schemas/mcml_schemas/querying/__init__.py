"""Queries about the library: XPath, search, facets, and saved queries of projects."""
