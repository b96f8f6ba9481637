"""Two bones that reach: legs and arms bent so that their ends are at a goal."""

from __future__ import annotations

import numpy as np

from mcml.motion.rotation_vectors import shortest_arcs
from mcml.motion.rotations import rotate
from mcml.motion.skeleton import Array

STRETCHED = 0.9995
"""Of its whole length: no limb is made straighter."""


def two_bones(hip: Array, knee: Array, ankle: Array, goal: Array, hinge: Array | None = None) -> tuple[Array, Array]:
    """Return rotations in the world (n, 4) of the upper bone, and before it of the lower one, that move the ankle to
    the goal.

    hip, knee, ankle, goal: (n, 3). A goal out of reach is approached along the line to it. With a, b the lengths and d
    the distance of the goal, the cosine of the angle at the knee is (a^2 + b^2 - d^2) / 2 a b. hinge: (n, 3) unit axes
    of the knee: additional bending is about this axis, so that a nearly straight leg bends forward; by
    default it bends in the plane in which it is, or last was, bent.
    """
    upper, lower, line = knee - hip, ankle - knee, goal - hip
    a, b = np.linalg.norm(upper, axis=1), np.linalg.norm(lower, axis=1)
    distance = np.clip(np.linalg.norm(line, axis=1), np.abs(a - b) + 1e-9, STRETCHED * (a + b))
    old = np.arctan2(np.linalg.norm(np.cross(upper, lower), axis=1), (upper * lower).sum(axis=1))
    reached = np.linalg.norm(ankle - hip, axis=1)
    # If the leg already reaches that far, nothing is bent, even if it is straight.
    stays = np.abs(np.linalg.norm(line, axis=1) - reached) < 1e-12 * (a + b)
    cosine = np.clip((distance**2 - a**2 - b**2) / np.where(a * b > 0, 2 * a * b, 1.0), -1.0, 1.0)
    new = np.where(stays, old, np.arccos(cosine))
    along = upper / np.where(a > 0, a, 1.0)[:, None]
    pole = np.cross(_bend_axis(upper, lower), along)
    if hinge is not None:
        more = np.maximum(np.sin(new) - np.sin(old), 0.0)[:, None]
        pole = _unit(np.sin(old)[:, None] * pole + more * np.cross(hinge, along), pole)
    bent = b[:, None] * (np.cos(new)[:, None] * along + np.sin(new)[:, None] * pole)
    at_knee = np.where(stays[:, None], [0.0, 0.0, 0.0, 1.0], shortest_arcs(lower, bent))
    arrived = upper + rotate(at_knee, lower)
    return shortest_arcs(arrived, line), at_knee


def hinge_of(upper: Array, lower: Array) -> Array | None:
    """(3,) unit axis of a knee in the frame of its thigh; None for a knee that never bends.

    upper, lower: (n, 3) bones in that frame, in frames of a motion. The more a frame bends, the more it counts.
    """
    across = np.cross(upper, lower).sum(axis=0)
    bends = np.linalg.norm(upper, axis=1) * np.linalg.norm(lower, axis=1)
    length = float(np.linalg.norm(across))
    return across / length if length > _BENDS * float(bends.sum()) else None


_BENDS = 0.02
"""Mean sine of the angle of a knee, from which its axis is known."""


def _unit(vectors: Array, otherwise: Array) -> Array:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    unit: Array = np.where(lengths > 1e-9, vectors / np.where(lengths > 1e-9, lengths, 1.0), otherwise)
    return unit


def _bend_axis(upper: Array, lower: Array) -> Array:
    """Unit axes (n, 3) about which knees are bent; a straight knee bends as it did when it last was bent."""
    across = np.cross(upper, lower)
    lengths = np.linalg.norm(across, axis=1)
    size = np.linalg.norm(upper, axis=1) * np.linalg.norm(lower, axis=1)
    bent = lengths > 1e-4 * size
    if not bent.any():
        first = np.cross(upper, np.eye(3)[np.argmin(np.abs(upper), axis=1)])
        unit: Array = first / np.linalg.norm(first, axis=1, keepdims=True)
        return unit
    rows = np.where(bent, np.arange(len(bent)), -1)
    rows = np.maximum.accumulate(rows)
    rows = np.where(rows < 0, int(np.argmax(bent)), rows)
    axis = across[rows] / lengths[rows, None]
    # Across the bone as it now is.
    along = upper / np.linalg.norm(upper, axis=1, keepdims=True)
    axis = np.where(bent[:, None], axis, axis - (axis * along).sum(axis=1, keepdims=True) * along)
    found: Array = axis / np.linalg.norm(axis, axis=1, keepdims=True)
    return found
