"""Faces laid on one another: the rotation and shift that bring markers closest to a reference. Kabsch (1976)."""

from __future__ import annotations

import numpy as np

from mcml.motion.skeleton import Array

BLOCK = 4000


def align(positions: Array, reference: Array) -> Array:
    """Rotate and shift each frame separately, closest to a reference in the least squares of common markers.

    positions: (F, M, 3), NaN where missing. reference: (M, 3), NaN where missing. Returns (F, M, 3). A frame with fewer
    than three common markers is unchanged.
    """
    aligned = np.empty_like(positions)
    for start in range(0, len(positions), BLOCK):
        part = slice(start, start + BLOCK)
        aligned[part] = _align(positions[part], reference)
    return aligned


def _align(positions: Array, reference: Array) -> Array:
    both = ~(np.isnan(positions[..., 0]) | np.isnan(reference[:, 0]))
    weight = both[..., None] / np.maximum(both.sum(axis=1), 1)[:, None, None]
    here, there = np.where(both[..., None], positions, 0.0), np.where(both[..., None], reference, 0.0)
    centre, target = (weight * here).sum(axis=1), (weight * there).sum(axis=1)
    covariance = np.einsum(
        "fmi,fmj->fij", (here - centre[:, None]) * both[..., None], there - target[:, None], optimize=True
    )
    u, _, vt = np.linalg.svd(covariance)
    # A rotation, never a reflection: the weakest direction turns its sign where the determinant is -1.
    sign = np.sign(np.linalg.det(u) * np.linalg.det(vt))
    u[..., -1] *= np.where(sign == 0, 1.0, sign)[:, None]
    turned: Array = (positions - centre[:, None]) @ (u @ vt) + target[:, None]
    return np.where((both.sum(axis=1) >= 3)[:, None, None], turned, positions)
