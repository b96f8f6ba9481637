"""States of faces: the distances of all pairs of markers, and how far two states are apart."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array

SAME = 1e-6
"""States nearer than this are one expression, mm."""

Filled: TypeAlias = tuple[Array, Array, NDArray[np.intp]]


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
    """Euclidean distances of states, (n, k) mm; with themselves without others, then (n, n).

    Pairs of markers visible in both frames are used, scaled by sqrt(all / seen); below half of them the distance is
    infinite.
    """
    square = others is None
    right = states if others is None else others
    centre = np.where(np.isnan(right), 0.0, right).sum(axis=0) / np.maximum((~np.isnan(right)).sum(axis=0), 1)
    a, patterns_a, pattern_a = _fill(states, centre)
    b, patterns_b, pattern_b = (a, patterns_a, pattern_a) if square else _fill(right, centre)
    # Sums of squares of one state over the pairs that the other has, by patterns of present values.
    squared = a @ b.T
    squared *= -2.0
    over_a = (a * a) @ patterns_b.T
    over_b = over_a if square else (b * b) @ patterns_a.T
    squared += over_a[:, pattern_b]
    squared += over_b[:, pattern_a].T
    np.maximum(squared, 0.0, out=squared)
    if square:
        squared = np.minimum(squared, squared.T)
        np.fill_diagonal(squared, 0.0)
    _mend(squared, (a, patterns_a, pattern_a), (b, patterns_b, pattern_b))
    total = a.shape[1]
    seen = patterns_a @ patterns_b.T
    if seen.min() < total:
        squared *= (total / np.maximum(seen, 1.0))[np.ix_(pattern_a, pattern_b)]
        squared[(seen < 0.5 * total)[np.ix_(pattern_a, pattern_b)]] = np.inf
        if square:
            np.fill_diagonal(squared, 0.0)
    return np.sqrt(squared, out=squared)


def step_lengths(positions: Array) -> Array:
    """Distances of consecutive frames, (n - 1,) mm. positions: (n, M, 3). Infinite where they share too few pairs."""
    lengths = np.empty(max(len(positions) - 1, 0))
    for start in range(0, len(lengths), 500):
        gaps = np.diff(state_vectors(positions[start : start + 501]), axis=0)
        share = 1.0 - np.isnan(gaps).mean(axis=1)
        squared = np.nansum(gaps * gaps, axis=1) / np.maximum(share, 1e-9)
        lengths[start : start + 500] = np.where(share >= 0.5, np.sqrt(squared), np.inf)
    return lengths


def _fill(states: Array, centre: Array) -> Filled:
    """Return states minus the centre, 0 where missing; patterns (u, P) of present values, 1.0 or 0.0; the pattern of
    each.
    """
    gone = np.isnan(states)
    incomplete = np.flatnonzero(gone.any(axis=1))
    patterns, which = np.unique(gone[incomplete], axis=0, return_inverse=True)
    pattern = np.zeros(len(states), dtype=np.intp)
    pattern[incomplete] = 1 + which.reshape(-1)
    whole = np.concatenate([np.ones((1, states.shape[1])), 1.0 - patterns])
    return np.where(gone, 0.0, states - centre), whole, pattern


def _mend(squared: Array, left: Filled, right: Filled) -> None:
    """Small distances once more, directly: the Gram form loses them (1.6)."""
    (a, seen_a, pattern_a), (b, seen_b, pattern_b) = left, right
    scale = float(np.einsum("np,np->n", a, a).max(initial=0.0))
    rows, columns = np.nonzero(squared < 1e-9 * scale)
    for start in range(0, len(rows), 1000):
        i, j = rows[start : start + 1000], columns[start : start + 1000]
        gap = a[i] - b[j]
        gap *= seen_a[pattern_a[i]]
        gap *= seen_b[pattern_b[j]]
        squared[i, j] = np.einsum("np,np->n", gap, gap)
