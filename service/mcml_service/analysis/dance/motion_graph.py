"""Which bar may follow which: distances of point clouds, edges, pruning.

Kovar, Gleicher, Pighin (SIGGRAPH 2002): clouds, planar alignment, strongly connected components; bars as nodes:
Choi (2024). Y is up; theta turns about Y, radians.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.pieces import Spread

Indices = NDArray[np.intp]
Told = Callable[[float], None]
_ROUNDING = 1e-9
"""Relative to the mean square of coordinates: bound of rounding errors of `rough_squares`, with a wide margin."""
MOST_PIECES = 16
LEAST_ROWS = 50
"""Of the bars from which jumps are looked for in a piece of the work: fewer would not pay for the way there."""
REACH = 3
"""Samples at a thirtieth of a second on either side of a cloud's middle."""


@dataclass(frozen=True)
class Edges:
    """first, second: (E,) bars, sorted by first, then second. distances: (E,) body sizes. natural: (E,) whether the
    second follows the first in its clip. transforms: (E, 3) theta, x0, z0 that bring the second to the first."""

    first: Indices
    second: Indices
    distances: Array
    natural: NDArray[np.bool_]
    transforms: Array

    def __len__(self) -> int:
        return len(self.first)

    def among(self, kept: NDArray[np.bool_]) -> Edges:
        """The edges between kept bars (B,)."""
        chosen = kept[self.first] & kept[self.second]
        return Edges(
            self.first[chosen],
            self.second[chosen],
            self.distances[chosen],
            self.natural[chosen],
            self.transforms[chosen],
        )


@dataclass(frozen=True)
class Pairs:
    """The nearest jumps. first, second: (n,) bars. distances: (n,). complete: whether no pair was left out."""

    first: Indices
    second: Indices
    distances: Array
    complete: bool


def cloud_frames(middle: int, fps: float, frames: int) -> Indices:
    """(7,) frames of a cloud about a frame, a thirtieth of a second apart, within the clip."""
    steps = np.arange(-REACH, REACH + 1)
    around: Indices = np.clip(middle + np.floor(steps * fps / 30 + 0.5).astype(np.intp), 0, frames - 1)
    return around


def cloud_weights(points: int) -> Array:
    """(7 * points,) weights 1 / (1 + |j|), sum 1: all points of a frame, then of the next."""
    weights = np.repeat(1.0 / (1.0 + np.abs(np.arange(-REACH, REACH + 1))), points)
    normal: Array = weights / weights.sum()
    return normal


def align(end: Array, starts: Array, weights: Array) -> tuple[Array, Array]:
    """Distances (B,) and the turns and shifts (B, 3: theta, x0, z0) that bring clouds nearest to one.

    Kovar et al. (2002), eqs. 1 to 4, with atan2. end: (K, 3). starts: (B, K, 3). weights: (K,), sum 1.
    Unit of length of the clouds. Memory O(B K).
    """
    x, z = end[:, 0], end[:, 2]
    means, across, along = _moments(end, np.moveaxis(starts, -1, 0), weights)
    theta = np.arctan2(across, along)
    cosine, sine = np.cos(theta), np.sin(theta)
    x0 = float(weights @ x) - means[0] * cosine - means[1] * sine
    z0 = float(weights @ z) + means[0] * sine - means[1] * cosine
    transforms = np.stack([theta, x0, z0], axis=1)
    return np.sqrt(square_differences(end, starts, transforms) @ weights), transforms


def _moments(end: Array, planes: Array, weights: Array) -> tuple[tuple[Array, Array], Array, Array]:
    """Weighted means (B,) of x' and z', and the two arguments of the arc tangent. planes: (3, B, K) x', y', z'."""
    x, z = end[:, 0], end[:, 2]
    moments = np.stack([weights, weights * x, weights * z], axis=1)
    mean_x2, by_x_x2, by_z_x2 = (planes[0] @ moments).T
    mean_z2, by_x_z2, by_z_z2 = (planes[2] @ moments).T
    mean_x, mean_z = float(weights @ x), float(weights @ z)
    across = by_x_z2 - by_z_x2 - (mean_x * mean_z2 - mean_x2 * mean_z)
    along = by_x_x2 + by_z_z2 - (mean_x * mean_x2 + mean_z * mean_z2)
    return (mean_x2, mean_z2), across, along


def rough_squares(end: Array, planes: Array, norms: Array, weights: Array) -> Array:
    """(B,) squared distances of `align` from moments alone: fast, and wrong by rounding where clouds nearly agree.

    planes: (3, B, K). norms: (B,) weighted means of |p'|^2.
    """
    (mean_x2, mean_z2), across, along = _moments(end, planes, weights)
    middle = weights @ end
    spread = float(weights @ np.einsum("kc,kc->k", end, end)) - middle[0] ** 2 - middle[2] ** 2
    heights = planes[1] @ (weights * end[:, 1])
    rough: Array = spread + norms - mean_x2**2 - mean_z2**2 - 2 * heights - 2 * np.hypot(across, along)
    return rough


def square_differences(end: Array, starts: Array, transforms: Array) -> Array:
    """(B, K) |p - T p'|^2 of clouds; see `align`."""
    cosine, sine = np.cos(transforms[:, :1]), np.sin(transforms[:, :1])
    x2, z2 = starts[..., 0], starts[..., 2]
    squares = (end[:, 0] - x2 * cosine - z2 * sine - transforms[:, 1:2]) ** 2
    squares += (end[:, 1] - starts[..., 1]) ** 2
    squares += (end[:, 2] + x2 * sine - z2 * cosine - transforms[:, 2:]) ** 2
    return squares


def nearest_jumps(
    ends: Array,
    starts: Array,
    weights: Array,
    size: float,
    natural: NDArray[np.intp],
    allow_repeat: bool,
    keep: int,
    within: float = np.inf,
    told: Told = lambda share: None,
    spread: Spread | None = None,
) -> Pairs:
    """The `keep` nearest pairs of bars that are jumps, and those as near as the last of them, row by row.

    ends, starts: (B, K, 3). natural: (B,) the bar that follows in the source, -1 if none: no jump. size: body size, in
    which distances are given. within: distances above it are left out. Memory O(B K + keep), never O(B^2).
    Time O(B^2 K); pairs that are certainly too far by `rough_squares` are not compared exactly.
    """
    shared = (ends, starts, weights, natural, (size, allow_repeat, keep, within))
    if spread is None:
        jumps = [_jumps_from(range(len(ends)), *shared, told)]
    else:
        step = max(LEAST_ROWS, -(-len(ends) // MOST_PIECES))
        pieces = [range(at, min(at + step, len(ends))) for at in range(0, len(ends), step)]
        jumps = spread(_jumps_from, pieces, shared, told)
    first, second, distances, complete = zip(*jumps, strict=True)
    rows = [(np.concatenate(first), np.concatenate(second), np.concatenate(distances))]
    held, whole = len(rows[0][0]), all(complete)
    if held > keep:
        rows, _ = _nearest(rows, keep)
        whole = whole and len(rows[0][0]) == held
    return Pairs(*rows[0], whole)


def _jumps_from(
    bars: range,
    ends: Array,
    starts: Array,
    weights: Array,
    natural: NDArray[np.intp],
    options: tuple[float, bool, int, float],
    told: Told = lambda share: None,
) -> tuple[Indices, Indices, Array, bool]:
    """`nearest_jumps` from some of the bars: first, second, distances, and whether no pair was left out."""
    size, allow_repeat, keep, within = options
    planes = np.ascontiguousarray(np.moveaxis(starts, -1, 0))
    norms = np.einsum("cbk,cbk,k->b", planes, planes, weights)
    rows: list[tuple[Indices, Indices, Array]] = []
    held, complete, limit = 0, True, within
    for bar in bars:
        allowed = np.ones(len(starts), dtype=bool)
        if np.isfinite(limit):
            slack = _ROUNDING * (norms + float(weights @ np.einsum("kc,kc->k", ends[bar], ends[bar])))
            allowed = rough_squares(ends[bar], planes, norms, weights) <= (limit * size) ** 2 + slack
        if natural[bar] >= 0:
            allowed[natural[bar]] = False
        if not allow_repeat:
            allowed[bar] = False
        second = np.flatnonzero(allowed)
        distances = align(ends[bar], starts[second], weights)[0] / size
        near = distances <= limit
        second, distances = second[near], distances[near]
        rows.append((np.full(len(second), bar), second, distances))
        held += len(second)
        if held > 2 * keep:
            rows, limit = _nearest(rows, keep)
            held, complete = len(rows[0][0]), False
        told((bar + 1 - bars.start) / len(bars))
    first, second, distances = (np.concatenate(part) for part in zip(*rows, strict=True))
    return first, second, distances, complete


def _nearest(
    rows: list[tuple[Indices, Indices, Array]], keep: int
) -> tuple[list[tuple[Indices, Indices, Array]], float]:
    first, second, distances = (np.concatenate(part) for part in zip(*rows, strict=True))
    limit = float(np.partition(distances, keep - 1)[keep - 1])
    chosen = distances <= limit
    return [(first[chosen], second[chosen], distances[chosen])], limit


def largest_component(count: int, first: Indices, second: Indices) -> NDArray[np.bool_]:
    """(count,) nodes of the largest strongly connected component; of equal ones, that of the lowest node."""
    chosen: NDArray[np.bool_] = strong_components(count, first, second) == 0
    return chosen


def strong_components(count: int, first: Indices, second: Indices) -> NDArray[np.intp]:
    """(count,) the strongly connected component of each node: 0 for the largest and so on, of equal ones the one with
    the lowest node first."""
    graph = scipy.sparse.csr_array((np.ones(len(first), dtype=np.int8), (first, second)), shape=(count, count))
    _, labels = scipy.sparse.csgraph.connected_components(graph, directed=True, connection="strong")
    _, lowest, sizes = np.unique(labels, return_index=True, return_counts=True)
    rank = np.empty(len(sizes), dtype=np.intp)
    rank[np.lexsort((lowest, -sizes))] = np.arange(len(sizes))
    ranked: NDArray[np.intp] = rank[labels]
    return ranked


def least_threshold(count: int, pairs: Pairs, wanted: int) -> float | None:
    """The least distance for which the jumps up to it alone have a component of `wanted` bars; None if none does."""
    levels = np.unique(pairs.distances)

    def connects(level: float) -> bool:
        near = pairs.distances <= level
        return int(largest_component(count, pairs.first[near], pairs.second[near]).sum()) >= wanted

    if wanted < 2 or not len(levels) or not connects(float(levels[-1])):
        return None
    low, high = 0, len(levels) - 1
    while low < high:
        middle = (low + high) // 2
        if connects(float(levels[middle])):
            high = middle
        else:
            low = middle + 1
    return float(levels[low])


def connect(
    ends: Array,
    starts: Array,
    weights: Array,
    size: float,
    natural: NDArray[np.intp],
    threshold: float | None = None,
    coverage: float = 0.8,
    allow_repeat: bool = False,
    told: Told = lambda share: None,
    spread: Spread | None = None,
) -> tuple[Edges, float, Pairs]:
    """Edges between bars, the threshold, and all jumps that were found, also beyond it.

    threshold: body sizes; None: the least for which the jumps alone have a component of max(2, ceil(coverage B)) bars,
    the greatest distance if none does. How many pairs that needs is guessed; where they do not suffice, four times as
    many are taken.
    """
    count = len(ends)
    everything = count * count
    if threshold is not None:
        pairs = nearest_jumps(ends, starts, weights, size, natural, allow_repeat, everything, threshold, told, spread)
        return _edges(ends, starts, weights, size, natural, pairs), threshold, pairs
    wanted, keep = max(2, int(np.ceil(coverage * count - 1e-9))), max(4096, 32 * count)
    while True:
        most = min(keep, everything)
        pairs = nearest_jumps(ends, starts, weights, size, natural, allow_repeat, most, told=told, spread=spread)
        least = least_threshold(count, pairs, wanted)
        if least is not None or pairs.complete:
            break
        keep *= 4
    level = float(pairs.distances.max(initial=0.0)) if least is None else least
    near = pairs.distances <= level
    chosen = Pairs(pairs.first[near], pairs.second[near], pairs.distances[near], pairs.complete)
    return _edges(ends, starts, weights, size, natural, chosen), level, pairs


def _edges(ends: Array, starts: Array, weights: Array, size: float, natural: NDArray[np.intp], pairs: Pairs) -> Edges:
    """Jumps with their transforms, and the natural pairs (identity, distance 0), in order."""
    transforms = np.zeros((len(pairs.first), 3))
    bounds = np.searchsorted(pairs.first, np.arange(len(ends) + 1))
    for bar in range(len(ends)):
        row = slice(bounds[bar], bounds[bar + 1])
        if row.start < row.stop:
            transforms[row] = align(ends[bar], starts[pairs.second[row]], weights)[1]
    before = np.flatnonzero(natural >= 0)
    first = np.concatenate([pairs.first, before])
    second = np.concatenate([pairs.second, natural[before]])
    order = np.lexsort((second, first))
    return Edges(
        first[order],
        second[order],
        np.concatenate([pairs.distances, np.zeros(len(before))])[order],
        np.concatenate([np.zeros(len(pairs.first), dtype=bool), np.ones(len(before), dtype=bool)])[order],
        np.concatenate([transforms, np.zeros((len(before), 3))])[order],
    )
