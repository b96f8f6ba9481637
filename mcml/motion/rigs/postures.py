"""The posture of a body in a pose: the angle between trunk and legs, and the directions up, forward and left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mcml.motion.skeleton import Array

_STANDS = 125.0
"""Degrees between trunk and legs from which a body stands."""
_FORWARD, _LEFT = 0.3, 0.5
"""For a foot: forward extent of its toes. For a pair: its distance along left."""


@dataclass(frozen=True)
class Posture:
    """The joints by which a pose is judged: bottom and top of the trunk, and of each leg its start, its end, its toes
    (-1 for none)."""

    bottom: int
    top: int
    legs: tuple[tuple[int, int, int], ...]


def degrees(first: Array, second: Array) -> float:
    """Between two vectors (3,); NaN where one has no length."""
    lengths = float(np.linalg.norm(first) * np.linalg.norm(second))
    if not 0 < lengths < np.inf:
        return float("nan")
    return float(np.degrees(np.arccos(np.clip(first @ second / lengths, -1.0, 1.0))))


def trunk_angle(posture: Posture, places: Array) -> float:
    """Degrees between the trunk and the legs, 180 for a straight standing body; NaN if unknown."""
    legs = [places[end] - places[start] for start, end, _ in posture.legs]
    if not legs or posture.top < 0 or posture.bottom < 0:
        return float("nan")
    return degrees(places[posture.top] - places[posture.bottom], np.mean(legs, axis=0))


def stands(posture: Posture, places: Array) -> bool:
    """Tell whether a body stands in a pose, (J, 3)."""
    return trunk_angle(posture, places) > _STANDS


def first_standing(posture: Posture, poses: Sequence[Array]) -> Array | None:
    """Return the first pose in which the body stands, None if there is none."""
    return next((places for places in poses if stands(posture, places)), None)


def left_of(posture: Posture, places: Array, tips: Sequence[Array | None] = ()) -> Array | None:
    """The unit vector to a body's left by the way its feet point, (3,); None where these do not tell.

    tips: of each leg where its foot ends, for those without toes.
    """
    feet = np.mean([places[end] for _, end, _ in posture.legs], axis=0)
    up = places[posture.top] - feet
    height = float(np.linalg.norm(up))
    if not height > 0:
        return None
    up = up / height
    forward, length = np.zeros(3), 0.0
    for place, (_, end, toes) in enumerate(posture.legs):
        tip = places[toes] if toes >= 0 else tips[place] if place < len(tips) else None
        if tip is None:
            return None
        foot = tip - places[end]
        forward += foot - (foot @ up) * up
        length += float(np.linalg.norm(foot))
    along = float(np.linalg.norm(forward))
    if not length > 0 or along < _FORWARD * length:
        return None
    left: Array = np.cross(up, forward / along)
    return left


def side_of(left: Array, first: Array, second: Array) -> int:
    """Return 1 if the first of two limbs is to the left of the second, -1 to the right, 0 if unclear.

    first, second: places of their joints, (n, 3) and (n, 3).
    """
    apart = np.mean(first - second, axis=0)
    size = float(np.linalg.norm(apart))
    along = float(apart @ left)
    if not size > 0 or abs(along) < _LEFT * size:
        return 0
    return 1 if along > 0 else -1
