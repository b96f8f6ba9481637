"""States of faces: the distances of all pairs of markers, and how far two states are apart (expression.md 1.2, 1.4)."""

from __future__ import annotations

import numpy as np

from service.motion.skeleton import Array

SAME = 1e-6
"""States nearer than this are one expression, mm."""


def state_vectors(positions: Array) -> Array:
    """States, on the scale of the paper's M x M matrices: each pair once, times the root of two.

    positions: (n, M, 3) mm, NaN where missing. Returns (n, M (M - 1) / 2) mm, NaN for pairs not seen.
    """
    first, second = np.triu_indices(positions.shape[1], 1)
    states = np.empty((len(positions), len(first)))
    for start in range(0, len(positions), 200):
        block = positions[start : start + 200]
        apart = block[:, first] - block[:, second]
        states[start : start + 200] = np.sqrt(np.einsum("nps,nps->np", apart, apart))
    states *= np.sqrt(2.0)
    return states


def distances(states: Array, others: Array | None = None) -> Array:
    """Euclidean distances of states, (n, k) mm; with themselves where there are no others, then (n, n).

    Pairs of markers seen in both frames count, scaled by sqrt(all / seen); below half of them the distance is infinite.
    """
    square = others is None
    right = states if others is None else others
    centre = np.nan_to_num(np.nanmean(right, axis=0)) if np.isnan(right).any() else right.mean(axis=0)
    a, b = states - centre, right - centre
    full_a, full_b = ~np.isnan(a).any(axis=1), ~np.isnan(b).any(axis=1)
    if square and full_a.all():
        squared = _gram(a, a)
    else:
        squared = np.empty((len(a), len(b)))
        squared[np.ix_(full_a, full_b)] = _gram(a[full_a], b[full_b])
        if not full_a.all():
            squared[~full_a] = _masked(a[~full_a], b)
        if not full_b.all():
            rest = _masked(b[~full_b], a[full_a]).T
            squared[np.ix_(full_a, ~full_b)] = rest
    if square:
        squared = np.minimum(squared, squared.T)
        np.fill_diagonal(squared, 0.0)
    _mend(squared, a, b)
    return np.sqrt(squared, out=squared)


def _gram(a: Array, b: Array) -> Array:
    squared = a @ b.T
    squared *= -2.0
    squared += np.einsum("np,np->n", a, a)[:, None]
    squared += np.einsum("np,np->n", b, b)
    return np.maximum(squared, 0.0, out=squared)


def _masked(a: Array, b: Array) -> Array:
    seen_a, seen_b = ~np.isnan(a), ~np.isnan(b)
    a, b = np.where(seen_a, a, 0.0), np.where(seen_b, b, 0.0)
    mask_a, mask_b = seen_a.astype(float), seen_b.astype(float)
    squared = (a**2) @ mask_b.T + mask_a @ (b**2).T - 2 * (a @ b.T)
    seen = mask_a @ mask_b.T
    total = a.shape[1]
    scaled = np.maximum(squared, 0.0) * (total / np.maximum(seen, 1.0))
    return np.where(seen < 0.5 * total, np.inf, scaled)


def _mend(squared: Array, a: Array, b: Array) -> None:
    """Small distances once more, directly: the Gram form loses them (1.6)."""
    scale = float(np.nanmax(np.nansum(a * a, axis=1), initial=0.0))
    rows, columns = np.nonzero(squared < 1e-9 * scale)
    total = a.shape[1]
    for start in range(0, len(rows), 2000):
        part = slice(start, start + 2000)
        gap = a[rows[part]] - b[columns[part]]
        seen = np.maximum((~np.isnan(gap)).sum(axis=1), 1)
        squared[rows[part], columns[part]] = np.nansum(gap * gap, axis=1) * (total / seen)
