"""Frames on a plane: classical scaling of geodesics, and of landmarks.

Torgerson (1952), de Silva and Tenenbaum (2004).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.skeleton import Array

SAMPLE = 600
NEIGHBOURS = 10


@dataclass(frozen=True)
class Scaling:
    """coordinates: (n, p) mm, columns by falling eigenvalue, zeros if there are fewer positive ones.

    eigenvalues: (p,). mean: (n,) mean of the squared distances to each frame. negative: share of the negative
    eigenvalues in the sum of absolute ones, computed on every k-th frame if there are more than 600.
    """

    coordinates: Array
    eigenvalues: Array
    mean: Array
    negative: float

    def place(self, squared: Array) -> Array:
        """Coordinates (q, p) of other frames from their squared distances (q, n) to these (9.4)."""
        safe = np.where(self.eigenvalues > 0, self.eigenvalues, 1.0)
        placed: Array = -0.5 * (squared - self.mean) @ (self.coordinates / safe)
        return placed


def classical_scaling(apart: Array, dimensions: int, *, spectrum: bool = True) -> Scaling:
    """Points whose distances are near given ones: B = -1/2 J G^2 J, its largest eigenpairs, y = v sqrt(lambda).

    apart: (n, n) finite. Lanczos from a fixed vector; the entry of largest magnitude of each column is positive.
    spectrum: whether the share of negative eigenvalues is wanted, else it is nan.
    """
    n = len(apart)
    squared = apart * apart
    mean = squared.mean(axis=0)
    wanted = min(dimensions, n)
    values, vectors = _largest(_centre(squared, mean), wanted)
    positive = np.where(values > 1e-12 * max(values[0], 1e-300), values, 0.0) if len(values) else values
    coordinates = np.zeros((n, dimensions))
    coordinates[:, :wanted] = vectors * np.sqrt(positive)
    biggest = coordinates[np.abs(coordinates).argmax(axis=0), np.arange(dimensions)]
    coordinates *= np.where(biggest < 0, -1.0, 1.0)
    padded = np.zeros(dimensions)
    padded[:wanted] = positive
    return Scaling(coordinates, padded, mean, _negative(squared) if spectrum else float("nan"))


def _negative(squared: Array) -> float:
    step = -(-len(squared) // SAMPLE)
    part = squared[::step, ::step]
    values = np.linalg.eigvalsh(_centre(part, part.mean(axis=0)))
    total = float(np.abs(values).sum())
    return float(-values[values < 0].sum() / total) if total > 0 else 0.0


def _centre(squared: Array, mean: Array) -> Array:
    b = squared - mean
    b -= mean[:, None]
    b += mean.mean()
    b *= -0.5
    return b


def _largest(b: Array, count: int) -> tuple[Array, Array]:
    if len(b) <= max(3 * count, 40):
        values, vectors = np.linalg.eigh(b)
        return values[::-1][:count], vectors[:, ::-1][:, :count]
    # Not the constant vector: that is another eigenvector, with eigenvalue 0.
    values, vectors = scipy.sparse.linalg.eigsh(b, k=count, which="LA", v0=np.cos(1.0 + np.arange(len(b))), tol=0)
    order = np.argsort(-values, kind="stable")
    return values[order], vectors[:, order]


@dataclass(frozen=True)
class Agreement:
    """How far a map of p dimensions keeps geodesics: Pearson's r, and stress = sqrt(sum (g - d)^2 / sum g^2)."""

    dimensions: int
    r: float
    stress: float


def agreement(apart: Array, coordinates: Array) -> Agreement:
    """Over all pairs of frames. apart: (n, n). coordinates: (n, p). r is nan where all distances are equal."""
    n = len(apart)

    def pairs() -> Iterator[tuple[Array, Array]]:
        for start in range(0, n, 500):
            stop = min(start + 500, n)
            later = np.arange(start + 1, n) > np.arange(start, stop)[:, None]
            d = _between(coordinates[start:stop], coordinates[start + 1 :])
            yield apart[start:stop, start + 1 :][later], d[later]

    return _agreement(pairs(), coordinates.shape[1])


def agreement_between(apart: Array, some: Array, others: Array) -> Agreement:
    """Over pairs of one frame each of two sets. apart: (q, k). some: (q, p). others: (k, p)."""
    return _agreement(iter([(apart.reshape(-1), _between(some, others).reshape(-1))]), some.shape[1])


def _between(some: Array, others: Array) -> Array:
    squared = np.einsum("np,np->n", some, some)[:, None] + np.einsum("np,np->n", others, others)
    squared -= 2 * some @ others.T
    apart: Array = np.sqrt(np.maximum(squared, 0.0))
    return apart


def _agreement(pairs: Iterator[tuple[Array, Array]], dimensions: int) -> Agreement:
    sums, count, missed = np.zeros(5), 0, 0.0
    for g, d in pairs:
        sums += (g.sum(), d.sum(), g @ g, d @ d, g @ d)
        missed += float(((g - d) ** 2).sum())
        count += len(g)
    spread = np.maximum(sums[2:4] - sums[:2] ** 2 / count, 0.0)
    level = 1e-12 * sums[2:4]
    r = (sums[4] - sums[0] * sums[1] / count) / np.sqrt(spread.prod()) if (spread > level).all() else float("nan")
    return Agreement(dimensions, float(r), float(np.sqrt(missed / sums[2])) if sums[2] > 0 else 0.0)


def neighbourhoods(apart: Array, coordinates: Array) -> tuple[float, float]:
    """Return trustworthiness and continuity of a map: whether frames near on it are near, and near ones stay near; 1 at
    best. Venna and Kaski (2001), over the 10 nearest of each (fewer with under 40 frames).
    apart: (n, n). coordinates: (n, p).
    """
    n = len(apart)
    count = max(1, min(NEIGHBOURS, n // 4))
    ranks = [_ranks(apart), _ranks(scipy.spatial.distance.cdist(coordinates, coordinates))]
    most = n * count * (2 * n - 3 * count - 1) / 2
    shares = [
        1.0 - float((of_all - count)[(of_near <= count) & (of_all > count)].sum()) / most
        for of_all, of_near in (ranks, ranks[::-1])
    ]
    return shares[0], shares[1]


def _ranks(apart: Array) -> NDArray[np.intp]:
    """(n, n) place of each frame among the others by distance, from 1; the frame itself: 0."""
    apart = apart.copy()
    np.fill_diagonal(apart, -1.0)
    order = np.argsort(apart, axis=1, kind="stable")
    ranks = np.empty_like(order)
    np.put_along_axis(ranks, order, np.broadcast_to(np.arange(len(apart)), order.shape), axis=1)
    return ranks
