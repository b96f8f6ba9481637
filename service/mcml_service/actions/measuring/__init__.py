"""Measure quantities in many frame ranges."""
