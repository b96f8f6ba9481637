"""Links: pairs of candidates with a direct transition."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.expression_space.frame_graph import FrameGraph
from mcml_service.analysis.expression_space.neighbours import nearest

Places = NDArray[np.int32]
NOTHING, SEVERAL = -1, -2


@dataclass(frozen=True)
class Links:
    """first, second: (L,) places of candidates, first < second. length: (L,) mm. bridge: (L,) over an added edge.
    components: parts of the graph of links."""

    first: Places
    second: Places
    length: Array
    bridge: NDArray[np.bool_]
    components: int


def _links(count: int, first: Places, second: Places, length: Array, bridge: NDArray[np.bool_]) -> Links:
    graph = scipy.sparse.coo_array((np.ones(len(first), dtype=np.int8), (first, second)), shape=(count, count)).tocsr()
    return Links(
        first.astype(np.int32),
        second.astype(np.int32),
        length,
        bridge,
        int(scipy.sparse.csgraph.connected_components(graph, directed=False)[0]),
    )


def edge_links(graph: FrameGraph) -> Links:
    """Of the level that has every frame: the edges of the frame graph."""
    return _links(graph.frames, graph.first, graph.second, graph.length, graph.bridge)


def voronoi_links(graph: FrameGraph, candidates: Places) -> Links:
    """Candidates whose regions touch (6.3): an edge joins a frame nearest to one to a frame nearest to the other.

    Length: of the shortest way over such an edge. Connected whenever the frame graph is.
    """
    distance, before, source = scipy.sparse.csgraph.dijkstra(
        graph.matrix, indices=candidates, min_only=True, return_predecessors=True
    )
    number = np.full(graph.frames, -1, dtype=np.int64)
    number[candidates] = np.arange(len(candidates))
    owner = np.where(source >= 0, number[np.maximum(source, 0)], -1)
    a, b = owner[graph.first], owner[graph.second]
    other = np.flatnonzero((a != b) & (a >= 0) & (b >= 0))
    way = distance[graph.first[other]] + graph.length[other] + distance[graph.second[other]]
    count = len(candidates)
    key = np.minimum(a[other], b[other]) * count + np.maximum(a[other], b[other])
    best = np.full(count * count, np.inf)
    np.minimum.at(best, key, way)
    shortest = np.flatnonzero(way == best[key])
    key, place = np.unique(key[shortest], return_index=True)
    first = shortest[place]
    crossed = _find_crossings(graph, before, distance)
    edges = other[first]
    bridge = graph.bridge[edges] | crossed[graph.first[edges]] | crossed[graph.second[edges]]
    return _links(
        count,
        (key // count).astype(np.int32),
        (key % count).astype(np.int32),
        way[first],
        bridge,
    )


def _find_crossings(graph: FrameGraph, before: Places, distance: Array) -> NDArray[np.bool_]:
    """(n,) whether the way of a frame to its source leads over a bridge."""
    crossed = np.zeros(graph.frames, dtype=bool)
    if graph.bridges:
        for frame in np.argsort(distance, kind="stable").tolist():
            parent = int(before[frame])
            if parent >= 0:
                crossed[frame] = crossed[parent] or (min(frame, parent), max(frame, parent)) in graph.bridges
    return crossed


def half_nearest(places: Array) -> float:
    """Half the median distance of candidates to the nearest other. places: (c, 2) on the map."""
    return 0.5 * median_nearest(places)


def median_nearest(places: Array) -> float:
    """Median distance of candidates to the nearest other. places: (c, 2) on the map."""
    if len(places) < 2:
        return 0.0
    return float(np.median(nearest(places, places, 2)[0][:, 1]))


def paper_links(graph: FrameGraph, candidates: Places, plane: Array, rho: float) -> Links:
    """Candidates whose shortest path comes within rho of no third one on the map (6.1), by one tree a candidate.

    plane: (n, 2). For each frame of a tree: which foreign candidates the way to it has met: none, one, several.
    """
    count = len(candidates)
    met, which = _near(plane, candidates, rho)
    number = np.full(graph.frames, -1, dtype=np.int64)
    number[candidates] = np.arange(count)
    firsts, seconds, lengths, bridges = [], [], [], []
    for start in range(0, count, 64):
        rows = np.arange(start, min(start + 64, count))
        path_lengths, trees = scipy.sparse.csgraph.dijkstra(
            graph.matrix, indices=candidates[rows], return_predecessors=True
        )
        for own, distance, before in zip(rows.tolist(), path_lengths, trees, strict=True):
            near_own = np.linalg.norm(plane - plane[candidates[own]], axis=1) <= rho
            foreign = met - near_own
            state = np.where(foreign == 0, NOTHING, np.where(foreign == 1, which - own * near_own, SEVERAL))
            state = _along(state, before, int(candidates[own]))[candidates]
            later = np.arange(count) > own
            linked = np.flatnonzero(
                later & np.isfinite(distance[candidates]) & ((state == NOTHING) | (state == np.arange(count)))
            )
            firsts.append(np.full(len(linked), own, dtype=np.int32))
            seconds.append(linked.astype(np.int32))
            lengths.append(distance[candidates[linked]])
            crossed = _find_crossings(graph, before, distance)
            bridges.append(crossed[candidates[linked]])
    return _links(
        count, np.concatenate(firsts), np.concatenate(seconds), np.concatenate(lengths), np.concatenate(bridges)
    )


def _near(plane: Array, candidates: Places, rho: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return for each frame the number of candidates within rho, and the sum of their numbers."""
    count, total = np.zeros(len(plane), dtype=np.int64), np.zeros(len(plane), dtype=np.int64)
    for number, frame in enumerate(candidates.tolist()):
        near = np.linalg.norm(plane - plane[frame], axis=1) <= rho
        count += near
        total += number * near
    return count, total


def _along(state: NDArray[np.int64], before: Places, root: int) -> NDArray[np.int64]:
    """States of frames joined along the way from the root, by pointer doubling: log2(depth) rounds."""
    above = before.astype(np.int64)
    above[above < 0] = np.flatnonzero(above < 0)
    above[root] = root
    state = state.copy()
    while True:
        higher = state[above]
        joined = np.where(state == NOTHING, higher, np.where((higher == NOTHING) | (higher == state), state, SEVERAL))
        further = above[above]
        state = joined
        if np.array_equal(further, above):
            return state
        above = further
