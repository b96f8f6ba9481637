"""How near two expressions have to be for a step: the threshold and the curve it is chosen by (expression.md 2.2)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from service.analysis.expression_space.frame_graph import TINY
from service.analysis.expression_space.geodesics import floyd, from_sources
from service.analysis.expression_space.options import MARKER_MM
from service.analysis.expression_space.planar_map import agreement, classical_scaling
from service.motion.skeleton import Array

SAMPLE = 300
COVER = 12
"""On the way between sampled frames, a frame that lies within tau / 12 of another may be left out."""


@dataclass(frozen=True)
class Tried:
    """What a threshold does. tau: mm. r, stress: of the plane, over at most 300 frames (nan where undefined).
    components: of the whole graph. giant: share of the frames in the largest. degree: mean number of neighbours.
    stretch: mean geodesic over mean straight distance."""

    tau: float
    r: float
    stress: float
    components: int
    giant: float
    degree: float
    stretch: float


def candidates(connecting: float, longest: float, count: int, also: Sequence[float] = ()) -> Array:
    """Thresholds to try: from the connecting one to the longest distance, in equal ratios, and others."""
    low = max(connecting, 1e-6) * (1 + 1e-9)
    spread = np.geomspace(low, max(longest, low), count) if count else np.empty(0)
    return np.unique(np.concatenate([spread, np.asarray(also, dtype=float)]))


def try_threshold(apart: Array, tau: float, parts: Callable[[float], NDArray[np.intp]]) -> Tried:
    """What a threshold does to distances (n, n). parts: tau -> (n,) number of the connected part of each frame."""
    labels = parts(tau)
    sizes = np.bincount(labels)
    giant = np.flatnonzero(labels == sizes.argmax())
    step = -(-len(apart) // SAMPLE)
    sample = giant[giant % step == 0] if len(giant) > SAMPLE else giant
    degree = float((np.count_nonzero(apart <= tau) - len(apart)) / len(apart))
    if len(sample) < 3:
        nan = float("nan")
        return Tried(tau, nan, nan, len(sizes), len(giant) / len(apart), degree, nan)
    straight = apart[np.ix_(sample, sample)]
    on_the_way = sampled_geodesics(apart, tau, giant, sample)
    found = agreement(on_the_way, classical_scaling(on_the_way, 2, spectrum=False).coordinates)
    mean = float(straight.mean())
    stretch = float(on_the_way.mean()) / mean if mean > 0 else float("nan")
    return Tried(tau, found.r, found.stress, len(sizes), len(giant) / len(apart), degree, stretch)


def sampled_geodesics(apart: Array, tau: float, frames: NDArray[np.intp], sample: NDArray[np.intp]) -> Array:
    """Geodesics among sampled frames over the threshold graph of `frames`, thinned where that is denser than tau.

    Ways lead over frames that cover all others within tau / 12, and stay connected: leaving every second frame out, as
    would be quick too, tears the graph apart at small thresholds.
    """
    hubs = _cover(apart, frames, sample, tau / COVER)
    paths = _paths(apart, tau, hubs, sample)
    # Leaving frames out may tear what they held together.
    return paths if np.isfinite(paths).all() else _paths(apart, tau, frames, sample)


def _paths(apart: Array, tau: float, hubs: NDArray[np.intp], sample: NDArray[np.intp]) -> Array:
    weights = apart[np.ix_(hubs, hubs)]
    near = weights <= tau
    place = np.searchsorted(hubs, sample)
    # Where the graph is sparse and few sources are asked for, one search from each is quicker.
    if 15.0 * len(sample) * np.count_nonzero(near) > float(len(hubs)) ** 3:
        return floyd(np.where(near, weights, np.inf))[np.ix_(place, place)]
    graph = csr_array(np.where(near, np.maximum(weights, TINY), 0.0))
    return from_sources(graph, place)[:, place]


def _cover(apart: Array, frames: NDArray[np.intp], sample: NDArray[np.intp], radius: float) -> NDArray[np.intp]:
    """The sample and as many further frames, farthest first, as leave no frame farther than a radius."""
    nearest = apart[np.ix_(sample, frames)].min(axis=0)
    hubs = set(sample.tolist())
    while nearest[farthest := int(nearest.argmax())] > radius:
        hubs.add(int(frames[farthest]))
        nearest = np.minimum(nearest, apart[frames[farthest], frames])
    return np.array(sorted(hubs), dtype=np.intp)


def choose(
    tried: Sequence[Tried], rule: Literal["published", "best", "smallest"], markers: int
) -> tuple[float, str | None]:
    """The threshold of a rule, and why it is not that of the rule if so.

    best: largest r (the paper's search). smallest: the smallest connected one whose r is within 0.01 of the largest.
    """
    published = MARKER_MM * markers
    if rule == "published":
        return published, None
    usable = [found for found in tried if np.isfinite(found.r)]
    connected = [found for found in usable if found.components == 1]
    if rule == "smallest":
        usable = connected
    if not usable:
        return (
            published,
            "No threshold tried joins all frames with a correlation that is defined: 2.3 mm for each marker is taken.",
        )
    best = max(found.r for found in usable)
    if rule == "best":
        return next(found.tau for found in usable if found.r == best), None
    return next(found.tau for found in usable if found.r >= best - 0.01), None
