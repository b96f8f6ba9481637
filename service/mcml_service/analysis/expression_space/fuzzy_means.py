"""Fuzzy c-means. J. C. Bezdek, Pattern Recognition with Fuzzy Objective Function Algorithms (1981)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array

BLOCK_BYTES = 1_000_000
"""Bytes of frames for which memberships are computed at a time, to fit the processor's cache; they are never stored."""


@dataclass(frozen=True)
class Clustering:
    """centres: (c, p). objective: J after every iteration, with the memberships that gave the centres."""

    centres: Array
    objective: Array


def fuzzy_means(
    points: Array,
    centres: Array | None = None,
    memberships: Array | None = None,
    *,
    fuzziness: float = 2.0,
    iterations: int = 100,
    tolerance: float = 1e-6,
    relative: bool = True,
) -> Clustering:
    """Minimises J = sum u^m |x - v|^2 over centres v and memberships u that sum to one.

    points: (n, p). Start: centres (c, p), or memberships (c, n). tolerance: of the change of J, relative or not.
    """
    points = np.ascontiguousarray(points)
    norms = np.einsum("np,np->n", points, points)
    objective: list[float] = []
    for _ in range(iterations):
        if memberships is not None:
            weight = memberships**fuzziness
            sums = weight @ points, weight.sum(axis=1), weight @ norms
            memberships = None
        else:
            assert centres is not None  # by the signature one of the two is given
            sums = _sum_weighted(points, norms, centres, fuzziness)
        moments, total, squares = sums
        centres = moments / np.maximum(total, 1e-300)[:, None]
        # Sum of w |x - v|^2 about the weighted mean v, from its moments.
        objective.append(float((squares - total * np.einsum("cp,cp->c", centres, centres)).sum()))
        if len(objective) > 1:
            change = abs(objective[-1] - objective[-2])
            if change < (tolerance * abs(objective[-2]) if relative else tolerance):
                break
    assert centres is not None
    return Clustering(centres, np.array(objective))


def _memberships(points: Array, norms: Array, centres: Array, fuzziness: float) -> Array:
    lengths = np.einsum("cp,cp->c", centres, centres)
    squared = points @ (-2.0 * centres.T)
    squared += norms[:, None]
    squared += lengths
    floor = 1e-13 * max(float(norms.max(initial=0.0)), float(lengths.max(initial=0.0)), 1e-300)
    at_centre = squared <= floor
    touching = at_centre.any(axis=1)
    squared[at_centre] = 1.0
    share = 1.0 / squared if fuzziness == 2.0 else squared ** (-1.0 / (fuzziness - 1.0))
    share[touching] = at_centre[touching]
    share /= share.sum(axis=1, keepdims=True)
    return share


def _sum_weighted(points: Array, norms: Array, centres: Array, fuzziness: float) -> tuple[Array, Array, Array]:
    """Sums over all points, weighted by u^m: of points (c, p), of ones (c,), of squared lengths (c,)."""
    rows = max(1, BLOCK_BYTES // (8 * len(centres)))
    moments, total, squares = np.zeros_like(centres), np.zeros(len(centres)), np.zeros(len(centres))
    for start in range(0, len(points), rows):
        part = slice(start, start + rows)
        weight = _memberships(points[part], norms[part], centres, fuzziness)
        weight = weight * weight if fuzziness == 2.0 else weight**fuzziness
        moments += weight.T @ points[part]
        total += weight.sum(axis=0)
        squares += norms[part] @ weight
    return moments, total, squares


def top_memberships(
    points: Array, centres: Array, fuzziness: float = 2.0, most: int = 3
) -> tuple[NDArray[np.int32], Array]:
    """The clusters (n, k) that each point belongs to most, and how much; k is at most `most`."""
    count = min(most, len(centres))
    which, share = np.empty((len(points), count), dtype=np.int32), np.empty((len(points), count))
    rows = max(1, BLOCK_BYTES // (8 * len(centres)))
    norms = np.einsum("np,np->n", points, points)
    for start in range(0, len(points), rows):
        part = slice(start, start + rows)
        memberships = _memberships(points[part], norms[part], centres, fuzziness)
        best = np.argpartition(-memberships, count - 1, axis=1)[:, :count]
        values = np.take_along_axis(memberships, best, axis=1)
        order = np.lexsort((best, -values), axis=1)
        which[part] = np.take_along_axis(best, order, axis=1)
        share[part] = np.take_along_axis(values, order, axis=1)
    return which, share
