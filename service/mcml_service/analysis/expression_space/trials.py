"""Effects of thresholds on a set of distances: geodesics of the graph for each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.expression_space.frame_graph import TINY, spanning_tree
from mcml_service.analysis.expression_space.geodesics import floyd, from_sources
from mcml_service.analysis.expression_space.planar_map import agreement, classical_scaling
from mcml_service.analysis.expression_space.states import SAME

Places = NDArray[np.intp]
SPREAD = 450
SPREAD_RADIUS = 0.02
COVER = 12
"""On paths between sampled frames, a frame within tau / 12 of another may be left out."""
NEAR = (0.05, 0.10, 0.15)
FEWEST_PAIRS = 30
SHORTER = 2 / 3


@dataclass(frozen=True)
class Tried:
    """The effect of a threshold.

    tau: mm. broken: share of the near pairs that are far on the graph. r, stress: of the plane, over the frames of
    `spread` (nan where undefined). components: of the whole graph. giant: share of frames in the largest. degree: mean
    number of neighbours. stretch: mean geodesic over mean straight distance.
    """

    tau: float
    broken: float
    r: float
    stress: float
    components: int
    giant: float
    degree: float
    stretch: float


@dataclass(frozen=True)
class Trials:
    """Distances to try thresholds on. apart: (n, n) mm, infinite where undefined. least: mm, below which no threshold
    is worth a try."""

    apart: Array
    least: float = SAME

    @cached_property
    def tree(self) -> tuple[Places, Array]:
        """The spanning tree. Its longest edge is the smallest threshold that connects all frames."""
        return spanning_tree(self.apart)

    @cached_property
    def low(self) -> float:
        """The smallest threshold that joins what can be joined, mm."""
        lengths = self.tree[1]
        return max(self.least, float(lengths[np.isfinite(lengths)].max(initial=SAME)))

    @cached_property
    def longest(self) -> float:
        return float(np.max(self.apart, where=np.isfinite(self.apart), initial=0.0))

    @cached_property
    def far(self) -> float:
        """The distance that 95 % of the pairs do not exceed, mm."""
        apart = self.apart[np.triu_indices(len(self.apart), 1)]
        return float(np.percentile(apart[np.isfinite(apart)], 95))

    @cached_property
    def spread(self) -> Places:
        """At most 450 frames, each the farthest from those before it, until all are within 0.02 `far`; sorted."""
        chosen = [int(np.where(np.isfinite(self.apart), self.apart, 0.0).sum(axis=1).argmin())]
        nearest = self.apart[chosen[0]].copy()
        while len(chosen) < SPREAD and nearest[farthest := int(nearest.argmax())] > SPREAD_RADIUS * self.far:
            chosen.append(farthest)
            np.minimum(nearest, self.apart[farthest], out=nearest)
        return np.array(sorted(chosen), dtype=np.intp)

    def steps(self, count: int, *also: float) -> list[float]:
        """Thresholds to try: from `low` to the longest distance, in equal ratios, and others."""
        low = self.low * (1 + 1e-9)
        spread = np.geomspace(low, max(self.longest, low), count) if count else np.empty(0)
        thresholds: list[float] = np.unique(np.concatenate([spread, np.asarray(also, dtype=float)])).tolist()
        return thresholds

    def parts(self, tau: float) -> Places:
        """(n,) number of the connected part of each frame."""
        edges, lengths = self.tree
        near = edges[lengths <= tau]
        square = (len(self.apart), len(self.apart))
        graph = scipy.sparse.coo_array((np.ones(len(near)), (near[:, 0], near[:, 1])), shape=square).tocsr()
        return scipy.sparse.csgraph.connected_components(graph, directed=False)[1].astype(np.intp)

    def geodesics(self, tau: float, sample: Places) -> Array:
        """Geodesics (s, s) among frames, which are sorted; infinite between parts."""
        labels = self.parts(tau)
        lengths = np.full((len(sample), len(sample)), np.inf)
        np.fill_diagonal(lengths, 0.0)
        for part in np.flatnonzero(np.bincount(labels[sample]) > 1).tolist():
            inside = np.flatnonzero(labels[sample] == part)
            ways = sample_geodesics(self.apart, tau, np.flatnonzero(labels == part), sample[inside])
            lengths[np.ix_(inside, inside)] = ways
        return lengths

    def try_threshold(self, tau: float) -> Tried:
        """Compute the effect of a threshold."""
        sizes = np.bincount(labels := self.parts(tau))
        giant = labels[self.spread] == sizes.argmax()
        ways = self.geodesics(tau, self.spread)
        degree = float((np.count_nonzero(self.apart <= tau) - len(labels)) / len(labels))
        r = stress = stretch = float("nan")
        if np.count_nonzero(giant) >= 3:
            paths = ways[np.ix_(giant, giant)]
            fit = agreement(paths, classical_scaling(paths, 2, spectrum=False).coordinates)
            r, stress = fit.r, fit.stress
            straight = float(self.apart[np.ix_(self.spread[giant], self.spread[giant])].mean())
            stretch = float(paths.mean()) / straight if straight > 0 else stretch
        share = float(sizes.max() / len(labels))
        return Tried(tau, self._broken(ways), r, stress, len(sizes), share, degree, stretch)

    def _broken(self, ways: Array) -> float:
        """The largest share, over some reaches, of the pairs within a reach whose geodesic is longer than twice it.

        ways: (s, s) geodesics among `spread`.
        """
        pairs = np.triu_indices(len(self.spread), 1)
        straight, ways = self.apart[np.ix_(self.spread, self.spread)][pairs], ways[pairs]
        within = [(straight <= rho * self.far, rho * self.far) for rho in NEAR]
        return max(
            (float((ways[near] > 2.0 * reach).mean()) for near, reach in within if near.sum() >= FEWEST_PAIRS),
            default=0.0,
        )

    def jump(self, tau: float, larger: float) -> float:
        """Share of the pairs of `spread` whose geodesic falls below two thirds from a threshold to a larger one."""
        pairs = np.triu_indices(len(self.spread), 1)
        before, after = (self.geodesics(each, self.spread)[pairs] for each in (tau, larger))
        return float((after < SHORTER * before).mean())


def sample_geodesics(apart: Array, tau: float, frames: Places, sample: Places) -> Array:
    """Geodesics among sampled frames over the threshold graph of `frames`, thinned where that is denser than tau.

    Ways lead over frames that cover all others within tau / 12, and stay connected: leaving every second frame out, as
    would be quick too, tears the graph apart at small thresholds.
    """
    hubs = _cover(apart, frames, sample, tau / COVER)
    paths = _paths(apart, tau, hubs, sample)
    # Leaving frames out may tear what they held together.
    return paths if np.isfinite(paths).all() else _paths(apart, tau, frames, sample)


def _paths(apart: Array, tau: float, hubs: Places, sample: Places) -> Array:
    weights = apart[np.ix_(hubs, hubs)]
    near = weights <= tau
    place = np.searchsorted(hubs, sample)
    # If the graph is sparse and there are few sources, one search from each is faster.
    if 15.0 * len(sample) * np.count_nonzero(near) > float(len(hubs)) ** 3:
        return floyd(np.where(near, weights, np.inf))[np.ix_(place, place)]
    graph = scipy.sparse.csr_array(np.where(near, np.maximum(weights, TINY), 0.0))
    return from_sources(graph, place)[:, place]


def _cover(apart: Array, frames: Places, sample: Places, radius: float) -> Places:
    """The sample and as many further frames, farthest first, as leave no frame farther than a radius."""
    nearest = apart[np.ix_(sample, frames)].min(axis=0)
    hubs = set(sample.tolist())
    while nearest[farthest := int(nearest.argmax())] > radius:
        hubs.add(int(frames[farthest]))
        nearest = np.minimum(nearest, apart[frames[farthest], frames])
    return np.array(sorted(hubs), dtype=np.intp)
