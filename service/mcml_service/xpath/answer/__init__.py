"""Nodes and values as they go out: pages, runs, streams, XML, and how the answer came about."""
