"""Motions: skeletons, clips, rotations, kinematics. Arrays and plain data; no files, HTTP or SQL."""
