"""Frames of body segments, and the angles between them.

A frame is (n, 3, 3): its columns are x forward, y left and z up, in the laboratory. Everything is NaN where a point of
it is unknown.
"""

from __future__ import annotations

import numpy as np

from mcml.motion.skeleton import Array
from mcml.motion.vectors import cross, dot, unit


def frame_of(x: Array, y: Array, z: Array) -> Array:
    """(n, 3, 3) with these axes (n, 3) as columns."""
    return np.stack([x, y, z], axis=2)


def along_z(z: Array, left: Array) -> Array:
    """(n, 3, 3) whose z is along (n, 3), and whose y is as near to `left` (n, 3) as z allows."""
    upward = unit(z)
    y = unit(left - dot(left, upward)[:, None] * upward)
    return frame_of(cross(y, upward), y, upward)


def column(frame: Array, axis: int) -> Array:
    """(n, 3) an axis of frames."""
    axes: Array = frame[:, :, axis]
    return axes


def transpose(frame: Array) -> Array:
    """Return the inverse frames (n, 3, 3)."""
    inverse: Array = frame.transpose(0, 2, 1)
    return inverse


def turn_y(radians: float) -> Array:
    """(3, 3) the rotation about y."""
    c, s = np.cos(radians), np.sin(radians)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def turn_z(radians: float) -> Array:
    """(3, 3) the rotation about z."""
    c, s = np.cos(radians), np.sin(radians)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def joint_angles(proximal: Array, distal: Array) -> Array:
    """(n, 3) degrees alpha, beta, gamma by which frames `distal` are turned from frames `proximal`.

    Turns about y of the proximal frame, then about the floating axis, then about z of the distal frame, so that the
    rotation is Ry(alpha) Rx(beta) Rz(gamma): Grood & Suntay 1983, as the ISB recommends (Wu et al. 2002).
    """
    turn = transpose(proximal) @ distal
    alpha = np.arctan2(turn[:, 0, 2], turn[:, 2, 2])
    beta = np.arcsin(np.clip(-turn[:, 1, 2], -1.0, 1.0))
    gamma = np.arctan2(turn[:, 1, 0], turn[:, 1, 1])
    angles: Array = np.degrees(np.stack([alpha, beta, gamma], axis=1))
    return angles


def wrap(degrees: Array) -> Array:
    """Return the same angles from above -180 to 180."""
    wrapped: Array = 180.0 - (180.0 - degrees) % 360.0
    return wrapped


def make_continuous(degrees: Array) -> Array:
    """Return angles (n, k) without jumps of whole turns from one known frame to the next."""
    continuous = np.array(degrees, dtype=np.float64)
    for column in continuous.T:
        known = np.isfinite(column)
        column[known] = np.unwrap(column[known], period=360.0)
    return continuous
