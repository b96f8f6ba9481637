"""Lengths of shortest paths over a graph: Floyd's algorithm in blocks, Dijkstra's by SciPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.skeleton import Array

BLOCK = 24


def floyd(weights: Array) -> Array:
    """All shortest distances. Floyd (1962), in blocks of frames; blocks that cannot shorten anything are skipped.

    weights: (n, n) symmetric, infinite without an edge. Returns (n, n). The order of the frames does not matter,
    but consecutive ones should be near each other: a block of them then represents one place.
    """
    n = len(weights)
    paths = np.array(weights, dtype=float)
    np.fill_diagonal(paths, 0.0)
    starts = np.arange(0, n, BLOCK)
    edges = [*starts.tolist(), n]
    lengths = np.diff(edges)
    longest = np.maximum.reduceat(np.maximum.reduceat(paths, starts, axis=0), starts, axis=1)
    # Any order of pivots is correct. Central ones come first: others need not try paths that these shorten.
    middle = np.add.reduceat(np.minimum(paths, _finite_most(paths)).mean(axis=1), starts) / lengths
    for block in np.argsort(middle, kind="stable").tolist():
        pivots = slice(edges[block], edges[block + 1])
        panel = np.concatenate([paths[: pivots.start, pivots].T, paths[pivots, pivots.start :]], axis=1)
        own = panel[:, pivots]
        for k in range(len(own)):
            np.minimum(own, own[:, k, None] + own[None, k], out=own)
        for k in range(len(own)):
            np.minimum(panel, own[:, k, None] + panel[None, k], out=panel)
        each = np.minimum.reduceat(panel, starts, axis=1)
        nearest = each.min(axis=0)
        wanted = np.triu(nearest[:, None] + nearest < longest)
        for row in np.flatnonzero(wanted.any(axis=1)).tolist():
            top, bottom = edges[row], edges[row + 1]
            through = np.ascontiguousarray(panel[:, top:bottom])
            blocks = np.flatnonzero(wanted[row])
            columns = np.flatnonzero(np.repeat(wanted[row], lengths))
            tile, rest = paths[top:bottom, columns], panel[:, columns]
            sums = np.empty_like(tile)
            useful = each[:, row, None] + each[:, blocks] < longest[row, blocks]
            for k in np.flatnonzero(useful.any(axis=1)).tolist():
                np.add(through[k][:, None], rest[k], out=sums)
                np.minimum(tile, sums, out=tile)
            paths[top:bottom, columns] = tile
            inside = np.concatenate([[0], np.cumsum(lengths[blocks])[:-1]])
            longest[row, blocks] = np.maximum.reduceat(tile.max(axis=0), inside)
    for row in range(len(starts)):
        # Blocks on the diagonal hold both halves; below them everything mirrors the part above.
        rows = slice(edges[row], edges[row + 1])
        paths[rows, rows] = np.minimum(paths[rows, rows], paths[rows, rows].T)
        paths[rows.stop :, rows] = paths[rows, rows.stop :].T
    return paths


def _finite_most(paths: Array) -> float:
    return 2.0 * float(np.max(paths, where=np.isfinite(paths), initial=0.0))


def from_sources(matrix: scipy.sparse.csr_array, sources: Any) -> Array:
    """Shortest distances from some frames, (s, n), or (n,) from one. Dijkstra (1959)."""
    lengths: Array = scipy.sparse.csgraph.dijkstra(matrix, directed=True, indices=sources)
    return lengths


def search(matrix: scipy.sparse.csr_array, source: int) -> tuple[Array, NDArray[np.int32]]:
    """Shortest distances (n,) from a frame, and the previous frame of each on the path, negative without one."""
    distance, before = scipy.sparse.csgraph.dijkstra(matrix, directed=True, indices=[source], return_predecessors=True)
    return distance[0], before[0]


def all_pairs(matrix: scipy.sparse.csr_array) -> Array:
    """All shortest distances, (n, n), by the algorithm that suits the graph: Floyd above a mean degree of 0.1 n."""
    n = matrix.shape[0]
    if matrix.nnz / n > 0.1 * n:
        weights = np.full((n, n), np.inf)
        edges = matrix.tocoo()
        weights[edges.row, edges.col] = edges.data
        return floyd(weights)
    return from_sources(matrix, None)
