"""Stored documents as clips, and derived data: bodies in space, and their calibration."""
