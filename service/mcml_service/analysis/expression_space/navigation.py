"""Paths through a space: key frames, the walk of captured frames between them, refinement."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from threading import Lock

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.expression_space.frame_graph import FrameGraph
from mcml_service.analysis.expression_space.geodesics import from_sources, search
from mcml_service.analysis.expression_space.links import Links, median_nearest
from mcml_service.analysis.interface import AnalysisError

Places = NDArray[np.int32]
ROWS_KEPT = 64
TRIED_PER_SEGMENT = 40
"""Of a large space, candidates tried between two keys: each costs a search through the graph."""


@dataclass
class Ground:
    """The data for navigation.

    plane: (n, 2). geodesics: (n, n), or None if they are computed on demand and cached. candidates, links: of each
    level; the links of a level with every frame are None: edges of the graph. Several requests may use it at once.
    """

    graph: FrameGraph
    plane: Array
    candidates: Sequence[Places]
    links: Sequence[Links | None]
    geodesics: NDArray[np.float32] | None
    _rows: dict[int, Array] = field(default_factory=dict)
    _lock: Lock = field(default_factory=Lock)
    _link_graphs: dict[int, scipy.sparse.csr_array] = field(default_factory=dict)

    def row(self, frame: int) -> Array:
        """(n,) shortest distances from a frame, mm."""
        if self.geodesics is not None:
            row: Array = self.geodesics[frame].astype(float)
            return row
        with self._lock:
            if frame not in self._rows:
                while len(self._rows) >= ROWS_KEPT:
                    self._rows.pop(next(iter(self._rows)))
                self._rows[frame] = from_sources(self.graph.matrix, frame)
            return self._rows[frame]

    def between(self, first: int, second: int) -> float:
        """Shortest distance of two frames, mm."""
        if self.geodesics is not None:
            return float(self.geodesics[first, second])
        return float(self.row(second if second in self._rows else first)[first if second in self._rows else second])

    def edge(self, first: int, second: int) -> float | None:
        """Length of the edge between two frames, if there is one."""
        matrix = self.graph.matrix
        row = matrix.indices[matrix.indptr[first] : matrix.indptr[first + 1]]
        place = np.flatnonzero(row == second)
        return float(matrix.data[matrix.indptr[first] + place[0]]) if len(place) else None

    def link_graph(self, level: int) -> scipy.sparse.csr_array:
        """Links of a level as a graph of its candidates."""
        links = self.links[level]
        if links is None:
            return self.graph.matrix
        if level not in self._link_graphs:
            count = len(self.candidates[level])
            a, b, length = links.first, links.second, np.maximum(links.length, 1e-9)
            ends = np.concatenate([a, b]), np.concatenate([b, a])
            graph = scipy.sparse.coo_array((np.concatenate([length, length]), ends), shape=(count, count)).tocsr()
            self._link_graphs[level] = graph
        return self._link_graphs[level]


@dataclass(frozen=True)
class Walk:
    """keys: (k,) frames. frames: (w,) all frames of the walk, each joined to the next by an edge. position: (w,) mm
    from the start. at: (k,) places of the keys in the walk. bridges: how many are crossed."""

    keys: Places
    frames: Places
    position: Array
    at: NDArray[np.intp]
    bridges: int

    @property
    def length(self) -> float:
        return float(self.position[-1])

    @property
    def largest_hop(self) -> float:
        return float(np.diff(self.position).max(initial=0.0))


@dataclass(frozen=True)
class Offer:
    """A candidate that a path may lead over: a frame. segment: between which keys, from 0. position: where along the
    walk, mm. apart: from the walk on the map (paper), or how much longer the way over it is (robust), mm."""

    frame: int
    segment: int
    position: float
    apart: float


def shortest_walk(ground: Ground, first: int, last: int) -> list[int]:
    """Frames of a shortest path, both ends included. Raises AnalysisError `unreachable`."""
    row = ground.row(first)
    if not np.isfinite(row[last]):
        raise AnalysisError("unreachable", "No way leads from one frame to the other.", remedy="Choose other keys.")
    matrix, frames, seen = ground.graph.matrix, [last], {last}
    while frames[-1] != first:
        here = frames[-1]
        part = slice(matrix.indptr[here], matrix.indptr[here + 1])
        near = matrix.indices[part]
        way = row[near] + matrix.data[part]
        order = np.flatnonzero(way <= way.min() * (1 + 1e-6) + 1e-6)
        # Among equal paths the one that leads farthest back; in single precision there may be a few.
        order = order[np.lexsort((near[order], row[near[order]]))]
        step = next((int(frame) for frame in near[order] if int(frame) not in seen), None)
        if step is None:
            return _search(ground, first, last)
        frames.append(step)
        seen.add(step)
    return frames[::-1]


def _search(ground: Ground, first: int, last: int) -> list[int]:
    before = search(ground.graph.matrix, first)[1]
    frames = [last]
    while frames[-1] != first:
        frames.append(int(before[frames[-1]]))
    return frames[::-1]


def walk_over(ground: Ground, keys: Sequence[int]) -> Walk:
    """The walk over key frames by shortest paths (7.2). Raises AnalysisError `unreachable`."""
    frames, at = [int(keys[0])], [0]
    for first, last in pairwise(keys):
        frames += shortest_walk(ground, int(first), int(last))[1:]
        at.append(len(frames) - 1)
    hops = [ground.edge(a, b) or 0.0 for a, b in pairwise(frames)]
    crossed = sum((min(a, b), max(a, b)) in ground.graph.bridges for a, b in pairwise(frames))
    return Walk(
        np.array(keys, dtype=np.int32),
        np.array(frames, dtype=np.int32),
        np.concatenate([[0.0], np.cumsum(hops)]),
        np.array(at, dtype=np.intp),
        crossed,
    )


def link_keys(ground: Ground, level: int, keys: Sequence[int], *, auto_route: bool) -> list[int]:
    """Return keys that may follow each other at a level (7.1): unchanged, or with candidates inserted between them.

    Raises AnalysisError `too-few-keys`, `repeated-key`, `not-a-candidate`, `not-linked` (details: suggestion, frames),
    `unreachable`.
    """
    _in_a_row(keys)
    candidates = ground.candidates[level]
    place = {int(frame): number for number, frame in enumerate(candidates.tolist())}
    for key in keys:
        if key not in place:
            raise AnalysisError(
                "not-a-candidate",
                f"Frame {key} is no candidate of level {level}.",
                remedy="Choose among the candidates that the operation `level` lists.",
                frame=key,
            )
    routed = [int(keys[0])]
    for first, last in pairwise(keys):
        chain = _chain(ground, level, place[first], place[last])
        if len(chain) > 2 and not auto_route:
            raise AnalysisError(
                "not-linked",
                f"Two successive keys are not linked at level {level}.",
                remedy="Go by the suggested frames, or say auto_route.",
                frames=[int(first), int(last)],
                suggestion=[int(candidates[number]) for number in chain],
            )
        routed += [int(candidates[number]) for number in chain[1:]]
    return routed


def _in_a_row(keys: Sequence[int]) -> None:
    if len(keys) < 2:
        raise AnalysisError("too-few-keys", "A path needs two keys at least.", remedy="Add a key.")
    if any(first == last for first, last in pairwise(keys)):
        raise AnalysisError("repeated-key", "A key follows itself.", remedy="Leave one of the two out.")


def _chain(ground: Ground, level: int, first: int, last: int) -> list[int]:
    """Return the shortest path over links, by indices of candidates; a direct link is one step, of any length."""
    graph = ground.link_graph(level)
    if last in graph.indices[graph.indptr[first] : graph.indptr[first + 1]]:
        return [first, last]
    if ground.links[level] is None:
        return shortest_walk(ground, first, last)
    distance, before = search(graph, first)
    if not np.isfinite(distance[last]):
        raise AnalysisError(
            "unreachable", f"No links of level {level} lead from one key to the other.", remedy="Choose other keys."
        )
    chain = [last]
    while chain[-1] != first:
        chain.append(int(before[chain[-1]]))
    return chain[::-1]


def offers_near(ground: Ground, walk: Walk, level: int, radius: float | None = None) -> list[Offer]:
    """Candidates near a walk on the map, in its order (7.3, paper). radius: their median nearest distance if None."""
    candidates = ground.candidates[level]
    candidates = candidates[~np.isin(candidates, walk.keys)]
    if radius is None:
        radius = median_nearest(ground.plane[ground.candidates[level]])
    path, places = ground.plane[walk.frames], ground.plane[candidates]
    apart = np.linalg.norm(places[:, None] - path[None], axis=2)
    nearest = apart.argmin(axis=1)
    distance = apart[np.arange(len(candidates)), nearest]
    offers = [
        Offer(
            int(candidates[number]),
            int(np.searchsorted(walk.at, nearest[number], side="right").clip(1, len(walk.keys) - 1)) - 1,
            float(walk.position[nearest[number]]),
            float(distance[number]),
        )
        for number in np.flatnonzero(distance <= radius).tolist()
    ]
    return sorted(offers, key=lambda offer: (offer.position, offer.frame))


def offers_on_the_way(ground: Ground, walk: Walk, level: int, delta: float = 0.1) -> list[Offer]:
    """Candidates that lengthen the way between two keys by at most a share, in the walk's order (7.3, robust)."""
    candidates = ground.candidates[level]
    offers = []
    for segment, (a, b) in enumerate(pairwise(walk.keys.tolist())):
        forth, back = ground.row(a)[candidates], ground.row(b)[candidates]
        whole = ground.between(a, b)
        detour = forth + back - whole
        inside = (forth > 0) & (back > 0) & (detour <= delta * whole + 1e-3)
        chosen = np.flatnonzero(inside & (candidates != a) & (candidates != b))
        if ground.geodesics is None:
            chosen = chosen[np.lexsort((candidates[chosen], detour[chosen]))][:TRIED_PER_SEGMENT]
        start = float(walk.position[walk.at[segment]])
        offers += [
            Offer(int(candidates[k]), segment, start + float(forth[k]), max(float(detour[k]), 0.0))
            for k in chosen.tolist()
        ]
    return sorted(offers, key=lambda offer: (offer.segment, offer.position, offer.frame))


def accept_keys(ground: Ground, walk: Walk, offers: Sequence[Offer], delta: float = 0.1) -> list[int]:
    """Keys of a walk and, between each two, candidates by growing detour while the way over all of them grows by at
    most a share (7.3, robust). The walk over the result is at most (1 + delta) as long."""
    keys = [int(walk.keys[0])]
    for segment, (a, b) in enumerate(pairwise(walk.keys.tolist())):
        whole = ground.between(a, b)
        chain: list[tuple[float, int]] = [(-1.0, a), (np.inf, b)]
        length, limit = whole, (1 + delta) * whole
        own = [offer for offer in offers if offer.segment == segment]
        start = float(walk.position[walk.at[segment]])
        for offer in sorted(own, key=lambda offer: (offer.apart, offer.frame)):
            item = (offer.position - start, offer.frame)
            place = bisect_left(chain, item)
            before, after = chain[place - 1][1], chain[place][1]
            first, second = ground.between(before, offer.frame), ground.between(offer.frame, after)
            longer = length - ground.between(before, after) + first + second
            if longer <= limit and first > 0 and second > 0:
                chain.insert(place, item)
                length = longer
        keys += [frame for _, frame in chain[1:]]
    return keys


def with_picks(ground: Ground, walk: Walk, level: int, picks: Sequence[int]) -> list[int]:
    """Keys of a walk with candidates of a level that a person chose, each where it costs least, in the walk's order.

    Raises AnalysisError `not-a-candidate`, `unreachable`.
    """
    known = set(ground.candidates[level].tolist())
    between: list[list[tuple[float, int]]] = [[] for _ in walk.keys[1:]]
    for pick in dict.fromkeys(picks):
        if pick not in known:
            raise AnalysisError(
                "not-a-candidate",
                f"Frame {pick} is no candidate of level {level}.",
                remedy="Choose among the candidates that are offered.",
                frame=pick,
            )
        if pick in walk.keys:
            continue
        row = ground.row(pick)[walk.keys]
        detour = row[:-1] + row[1:] - [ground.between(a, b) for a, b in pairwise(walk.keys.tolist())]
        segment = int(detour.argmin())
        if not np.isfinite(detour[segment]):
            raise AnalysisError("unreachable", f"No way leads to frame {pick}.", remedy="Choose another.", frame=pick)
        between[segment].append((float(row[segment]), pick))
    keys = [int(walk.keys[0])]
    for segment, key in enumerate(walk.keys[1:].tolist()):
        keys += [pick for _, pick in sorted(between[segment])]
        keys.append(int(key))
    return keys


def check_links(ground: Ground, level: int, keys: Sequence[int]) -> None:
    """Whether successive keys that both are candidates of a level are linked. Raises AnalysisError `not-linked`."""
    known = set(ground.candidates[level].tolist())
    for first, last in pairwise(keys):
        if first in known and last in known:
            link_keys(ground, level, [first, last], auto_route=False)
