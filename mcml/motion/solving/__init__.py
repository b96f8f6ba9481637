"""Inverse kinematics on arrays of frames: ranges of joints, chains of joints, arms."""
