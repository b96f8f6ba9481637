"""Clips as scenes that are seen in other programs: glTF and USD. Written, not read."""
