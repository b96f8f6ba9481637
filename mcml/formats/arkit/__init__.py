"""Faces captured with ARKit, as Live Link Face and other apps for phones write them: CSV."""
