"""Landmarks of a body: recognised by the marker set of a laboratory or by words, and checked by position."""
