"""Centres of joints that no marker has on both sides, constructed from the pelvis and from markers beside the joint.

Points are (n, 3) of one unit, NaN where unknown.
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
_MILLIMETRES: Final = 1000.0
_BELOW_ACROMION: Final = 0.17
"""Of the distance between the acromia: so far below its acromion is the centre of a shoulder (Rab et al. 2002)."""


def pelvis_frame(left: Array, right: Array, sacrum: Array) -> tuple[Array, Array]:
    """(origin (n, 3), frame (n, 3, 3)) of the pelvis: the middle of the front spines, y along them to the left, x
    forward in their plane with the sacrum, z up. Columns of a frame are its axes.

    left, right: the front spines. sacrum: the middle of the back spines, or the marker between them.
    """
    origin = (left + right) / 2
    y = unit(left - right)
    z = unit(cross(origin - sacrum, y))
    return origin, np.stack([cross(y, z), y, z], axis=2)


def harrington_hip(side: Sign, width: Array, depth: Array) -> Array:
    """(n, 3) millimetres of a hip centre in the frame of the pelvis, from its origin.

    width: (n,) between the front spines. depth: (n,) from their middle to the middle of the back spines. Source:
    Harrington, Zavatsky, Lawson, Yuan and Theologis 2007 ("Prediction of the hip joint centre in adults, children, and
    patients with cerebral palsy based on magnetic resonance imaging").
    """
    return np.stack([-0.24 * depth - 9.9, side * (0.33 * width + 7.3), -0.30 * width - 10.9], axis=-1)


def place_hip(side: Sign, left: Array, right: Array, sacrum: Array, metres: float | None) -> Array:
    """(n, 3) the centre of a hip by the regression of Harrington 2007, NaN where the unit is unknown.

    left, right, sacrum: as for `pelvis_frame`. metres: of a unit of the points.
    """
    if metres is None:
        return np.full_like(left, np.nan)
    scale = metres * _MILLIMETRES
    origin, frame = pelvis_frame(left, right, sacrum)
    point = harrington_hip(side, length(left - right) * scale, length(origin - sacrum) * scale) / scale
    place: Array = origin + (frame @ point[:, :, None])[:, :, 0]
    return place


def place_shoulder(own: Array, other: Array, pelvis: Array) -> Array:
    """(n, 3) the centre of a shoulder below its acromion, towards the middle of the pelvis.

    own, other: both acromia. Source: Rab, Petuskey and Bagley 2002 ("A method for determination of upper extremity
    kinematics").
    """
    down = unit(pelvis - (own + other) / 2)
    return own + _BELOW_ACROMION * length(own - other)[:, None] * down


def angle_about(axis: Array, begin: Array, end: Array) -> Array:
    """(n,) radians from vectors `begin` to vectors `end` (n, 3), counter-clockwise about `axis` (n, 3)."""
    along = unit(axis)
    flat = begin - dot(begin, along)[:, None] * along
    angle: Array = np.arctan2(dot(along, cross(flat, end)), dot(flat, end))
    return angle


def place_centre(
    proximal: Array, marker: Array, wand: Array, radius: float | Array, turn: float = 0.0, tilt: float = 0.0
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
