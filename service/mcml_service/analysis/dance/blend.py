"""Place bars on the floor, and make transitions from one to the next.

Kovar, Gleicher, Pighin (2002), sect. 3.2: the weight; Choi (2024): the last pose of the first motion is held, so that
its beat stays. Y is up.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from mcml.motion.rotations import multiply
from mcml.motion.skeleton import Array

Blend = Literal["hold", "classic", "none"]
Placement = Literal["cloud", "facing"]
_PARALLEL = 1e-9
_ALIKE = 1e-3


def weight(part: Array) -> Array:
    """alpha of the first motion at part p / k of the window: 1 at 0, 0 at 1, level at both. Kovar et al. (2002).

    >>> weight(np.array([0.0, 0.5, 1.0])).tolist()
    [1.0, 0.5, 0.0]
    """
    alpha: Array = 2 * part**3 - 3 * part**2 + 1
    return alpha


def join_transforms(outer: Array, inner: Array) -> Array:
    """The transform (3,) theta, x0, z0 that applies `inner` first. See `place_roots`."""
    cosine, sine = np.cos(outer[0]), np.sin(outer[0])
    return np.array(
        [
            outer[0] + inner[0],
            inner[1] * cosine + inner[2] * sine + outer[1],
            -inner[1] * sine + inner[2] * cosine + outer[2],
        ]
    )


def place_roots(transforms: Array, translations: Array, rotations: Array) -> tuple[Array, Array]:
    """Roots moved on the floor: x = x' cos theta + z' sin theta + x0, z = -x' sin theta + z' cos theta + z0.

    transforms: (n, 3). translations: (n, R, 3), rotations: (n, R, 4) of roots. Heights stay.
    """
    theta = transforms[:, None, 0]
    cosine, sine = np.cos(theta), np.sin(theta)
    moved = translations.copy()
    moved[..., 0] = translations[..., 0] * cosine + translations[..., 2] * sine + transforms[:, None, 1]
    moved[..., 2] = -translations[..., 0] * sine + translations[..., 2] * cosine + transforms[:, None, 2]
    turn = np.zeros((*theta.shape, 4))
    turn[..., 1], turn[..., 3] = np.sin(theta / 2), np.cos(theta / 2)
    return moved, multiply(turn, rotations)


def facing(root: Array, place: Array, root_after: Array, place_after: Array) -> Array:
    """The transform (3,) that gives the second motion the first one's heading and place: Choi (2024).

    root, root_after: (4,) rotations of the roots where they meet. place, place_after: (3,).
    """
    theta = 2 * (np.arctan2(root[1], root[3]) - np.arctan2(root_after[1], root_after[3]))
    cosine, sine = np.cos(theta), np.sin(theta)
    return np.array(
        [
            theta,
            place[0] - place_after[0] * cosine - place_after[2] * sine,
            place[2] + place_after[0] * sine - place_after[2] * cosine,
        ]
    )


def continuous(rotations: Array) -> Array:
    """Quaternions (n, J, 4) whose signs follow from frame to frame."""
    products = np.sum(rotations[1:] * rotations[:-1], axis=-1)
    signs = np.cumprod(np.where(products < 0, -1.0, 1.0), axis=0)
    followed: Array = rotations.copy()
    followed[1:] *= signs[..., None]
    return followed


def blend_rotations(first: Array, second: Array, alpha: Array) -> Array:
    """Rotations (n, J, 4) over a window, alpha (n,) parts of the first.

    Each track is made continuous, and the arc between them kept, even past 180 degrees: the shortest arc frame by frame
    would flip in the middle of a transition. Of the two ways around a joint takes the one that turns it less in any one
    frame; the nearer one over the whole window where both are alike.
    """
    if not len(first):
        return first
    first, second = continuous(first), continuous(second)
    part = np.broadcast_to(1 - alpha[:, None], first.shape[:-1])
    near = np.where(np.sum(first * second, axis=(0, 2)) < 0, -1.0, 1.0)[:, None]
    one, other = arc(first, near * second, part), arc(first, -near * second, part)
    better = _greatest_turn(other) < _greatest_turn(one) - _ALIKE
    return np.where(better[:, None], other, one)


def _greatest_turn(rotations: Array) -> Array:
    """(J,) the greatest angle of each joint from one frame to the next, radians. rotations: (n, J, 4)."""
    cosines = np.abs(np.sum(rotations[1:] * rotations[:-1], axis=-1))
    turns: Array = 2 * np.arccos(np.clip(cosines.min(axis=0, initial=1.0), 0.0, 1.0))
    return turns


def arc(start: Array, end: Array, t: Array) -> Array:
    """slerp (..., 4) that keeps the signs it is given, so it may take the longer way. t: (...,), 0 at start."""
    cosine = np.clip(np.sum(start * end, axis=-1), -1.0, 1.0)
    angle = np.arccos(cosine)
    sine = np.sin(angle)
    near = sine < _PARALLEL
    divisor = np.where(near, 1.0, sine)
    before = np.where(near, 1.0 - t, np.sin((1.0 - t) * angle) / divisor)
    after = np.where(near, t, np.sin(t * angle) / divisor)
    # Opposite signs of one rotation: no movement, in any direction.
    after = np.where(near & (cosine < 0), -after, after)
    between = before[..., None] * start + after[..., None] * end
    unit: Array = between / np.linalg.norm(between, axis=-1, keepdims=True)
    return unit
