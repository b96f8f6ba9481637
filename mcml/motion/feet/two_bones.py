"""Two bones that reach: legs and arms bent so that their ends are at a goal."""

from __future__ import annotations

import numpy as np

from mcml.motion.rotation_vectors import from_vector, shortest_arcs
from mcml.motion.rotations import rotate
from mcml.motion.skeleton import Array

STRETCHED = 0.9995
"""Of its whole length: no limb is made straighter."""


def two_bones(hip: Array, knee: Array, ankle: Array, goal: Array) -> tuple[Array, Array]:
    """Return rotations in the world (n, 4) of the upper bone, and before it of the lower one, that move the ankle to
    the goal.

    hip, knee, ankle, goal: (n, 3). The knee bends in the plane in which it is bent; a goal out of reach is approached
    along the line to it. With a, b the lengths and d the distance of the goal, the cosine of the angle at the knee is
    (a^2 + b^2 - d^2) / 2 a b.
    """
    upper, lower, line = knee - hip, ankle - knee, goal - hip
    a, b = np.linalg.norm(upper, axis=1), np.linalg.norm(lower, axis=1)
    distance = np.clip(np.linalg.norm(line, axis=1), np.abs(a - b) + 1e-9, STRETCHED * (a + b))
    old = np.arctan2(np.linalg.norm(np.cross(upper, lower), axis=1), (upper * lower).sum(axis=1))
    reached = np.linalg.norm(ankle - hip, axis=1)
    # If the leg already reaches that far, nothing is bent, even if it is straight.
    stays = np.abs(np.linalg.norm(line, axis=1) - reached) < 1e-12 * (a + b)
    cosine = np.clip((distance**2 - a**2 - b**2) / np.where(a * b > 0, 2 * a * b, 1.0), -1.0, 1.0)
    bend = np.where(stays, 0.0, np.arccos(cosine) - old)
    axis = _bend_axis(upper, lower)
    at_knee = from_vector(axis * bend[:, None])
    arrived = upper + rotate(at_knee, lower)
    return shortest_arcs(arrived, line), at_knee


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
