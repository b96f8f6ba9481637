"""Frames of body segments, the angles between them, and the construction of a joint centre beside a marker.

A frame is (n, 3, 3): its columns are x forward, y left and z up, in the laboratory. Everything is NaN where a point of
it is unknown.
"""

from __future__ import annotations

from typing import Final, Literal, TypeAlias

import numpy as np

from mcml.motion.skeleton import Array
from mcml.motion.vectors import cross, dot, length, unit

Sign: TypeAlias = Literal[1, -1]
"""1 on the left, -1 on the right."""

_ROUNDS: Final = 12
"""Steps of the search for a turned joint centre: each one divides the error by five or more."""


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


def angle_about(axis: Array, begin: Array, end: Array) -> Array:
    """(n,) radians from vectors `begin` to vectors `end` (n, 3), counter-clockwise about `axis` (n, 3)."""
    along = unit(axis)
    flat = begin - dot(begin, along)[:, None] * along
    angle: Array = np.arctan2(dot(along, cross(flat, end)), dot(flat, end))
    return angle


def place_centre(
    proximal: Array, marker: Array, wand: Array, radius: float, turn: float = 0.0, tilt: float = 0.0
) -> Array:
    """(n, 3) the centre of a joint beside a marker on its side, as Davis et al. 1991 construct knee and ankle.

    The centre is `radius` from the marker, and the angle at it between the marker and the proximal joint is 90 degrees
    + tilt. The wand, a marker of the segment between both, tells the plane: seen along the segment from the centre, the
    angle from the marker to the wand is `turn`, counter-clockwise. proximal, marker, wand: (n, 3) of one unit, which
    `radius` has too. turn, tilt: radians. NaN where the marker is nearer to the proximal joint than the centre can be.
    """
    upward = unit(proximal - marker)
    away = wand - marker
    away = unit(away - dot(away, upward)[:, None] * upward)
    across = cross(upward, away)
    with np.errstate(invalid="ignore", divide="ignore"):
        open_angle = np.pi / 2 - tilt - np.arcsin(radius * np.cos(tilt) / length(proximal - marker))
    on = (radius * np.cos(open_angle))[:, None] * upward
    beside = (radius * np.sin(open_angle))[:, None]

    def at(phi: Array) -> Array:
        place: Array = marker + on - beside * (np.cos(phi)[:, None] * away + np.sin(phi)[:, None] * across)
        return place

    if turn == 0.0:
        return at(np.zeros(len(marker)))
    phi = np.full(len(marker), -turn)
    for _ in range(_ROUNDS):
        centre = at(phi)
        phi = phi + angle_about(proximal - centre, marker - centre, wand - centre) - turn
    return at(phi)
