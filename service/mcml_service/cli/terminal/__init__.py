"""Shared code of commands: options, lazy loading, and output on a terminal."""
