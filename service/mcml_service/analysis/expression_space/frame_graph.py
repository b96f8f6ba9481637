"""The graph of frames: possible transitions between expressions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.expression_space.neighbours import nearest
from mcml_service.analysis.expression_space.states import SAME

Places = NDArray[np.int32]
TINY = 1e-9
"""Length of an edge between equal frames: a stored zero would mean no edge."""
HUBS_OF_A_FRAME = 4


@dataclass(frozen=True)
class FrameGraph:
    """frames: how many. first, second: (E,) ends of edges, first < second. length: (E,) mm. bridge: (E,) joins parts
    that nothing else joins."""

    frames: int
    first: Places
    second: Places
    length: Array
    bridge: NDArray[np.bool_]

    @cached_property
    def matrix(self) -> scipy.sparse.csr_array:
        """Both directions of every edge."""
        length = np.where(self.length < SAME, TINY, self.length)
        rows, columns = np.concatenate([self.first, self.second]), np.concatenate([self.second, self.first])
        square = (self.frames, self.frames)
        edges = scipy.sparse.coo_array((np.concatenate([length, length]), (rows, columns)), shape=square).tocsr()
        # Dijkstra of SciPy copies a graph with 64-bit indices at each call.
        edges.indices, edges.indptr = edges.indices.astype(np.int32), edges.indptr.astype(np.int32)
        return edges

    @cached_property
    def bridges(self) -> frozenset[tuple[int, int]]:
        return frozenset(zip(self.first[self.bridge].tolist(), self.second[self.bridge].tolist(), strict=True))

    def components(self) -> NDArray[np.int32]:
        """(n,) number of the connected part of each frame."""
        labels: NDArray[np.int32] = scipy.sparse.csgraph.connected_components(self.matrix, directed=False)[1]
        return labels

    def mean_degree(self) -> float:
        return 2.0 * len(self.first) / max(self.frames, 1)

    def keep(self, frames: NDArray[np.bool_]) -> FrameGraph:
        """Return the subgraph of some frames, which are renumbered."""
        number = np.cumsum(frames) - 1
        inside = frames[self.first] & frames[self.second]
        return FrameGraph(
            int(frames.sum()),
            number[self.first[inside]].astype(np.int32),
            number[self.second[inside]].astype(np.int32),
            self.length[inside],
            self.bridge[inside],
        )

    def add_bridges(self, pairs: NDArray[np.intp], length: Array) -> FrameGraph:
        """With further edges, (k, 2) frames, marked as bridges."""
        pairs = np.sort(pairs, axis=1)
        return FrameGraph(
            self.frames,
            np.concatenate([self.first, pairs[:, 0].astype(np.int32)]),
            np.concatenate([self.second, pairs[:, 1].astype(np.int32)]),
            np.concatenate([self.length, length]),
            np.concatenate([self.bridge, np.ones(len(pairs), dtype=bool)]),
        )


def threshold_graph(apart: Array, tau: float) -> FrameGraph:
    """Edges between frames at most tau apart. apart: (n, n) mm."""
    firsts, seconds, lengths = [], [], []
    for row in range(len(apart)):
        near = np.flatnonzero(apart[row, row + 1 :] <= tau) + row + 1
        firsts.append(np.full(len(near), row, dtype=np.int32))
        seconds.append(near.astype(np.int32))
        lengths.append(apart[row, near])
    length = np.concatenate(lengths)
    return FrameGraph(
        len(apart), np.concatenate(firsts), np.concatenate(seconds), length, np.zeros(len(length), dtype=bool)
    )


def spanning_tree(apart: Array) -> tuple[NDArray[np.intp], Array]:
    """Edges (n - 1, 2) of a minimum spanning tree and their lengths. Prim (1957). Its longest edge is the smallest
    threshold that connects all frames. apart: (n, n), infinite where undefined."""
    n = len(apart)
    edges, lengths = np.empty((n - 1, 2), dtype=np.intp), np.empty(n - 1)
    closest, parent = apart[0].copy(), np.zeros(n, dtype=np.intp)
    outside = np.ones(n, dtype=bool)
    outside[0] = False
    for step in range(n - 1):
        waiting = np.flatnonzero(outside)
        new = waiting[closest[waiting].argmin()]
        edges[step], lengths[step] = (parent[new], new), closest[new]
        outside[new] = False
        closer = apart[new] < closest
        closest[closer], parent[closer] = apart[new][closer], new
    return edges, lengths


def hub_graph(
    states: Array, hubs: NDArray[np.integer], tau: float, take: NDArray[np.int32], frame: NDArray[np.int32]
) -> FrameGraph:
    """Edges between hubs at most tau apart, from each frame to its 4 nearest hubs within tau, and between consecutive
    frames of a take. states: (n, d) reduced. hubs: (h,) frames. take, frame: (n,)."""
    between = scipy.spatial.distance.cdist(states[hubs], states[hubs])
    one, other = np.nonzero(np.triu(between <= tau, 1))
    distances, near = nearest(states[hubs], states, HUBS_OF_A_FRAME)
    row, column = np.nonzero(distances <= tau)
    chain = np.flatnonzero((np.diff(take) == 0) & (np.diff(frame) == 1))
    pairs = np.concatenate(
        [
            np.stack([hubs[one], hubs[other]], axis=1),
            np.stack([row, hubs[near[row, column]]], axis=1),
            np.stack([chain, chain + 1], axis=1),
        ]
    )
    after = np.linalg.norm(states[chain + 1] - states[chain], axis=1)
    length = np.concatenate([between[one, other], distances[row, column], after])
    pairs = np.sort(pairs.astype(np.int64), axis=1)
    different = pairs[:, 0] != pairs[:, 1]
    n = len(states)
    key, place = np.unique(pairs[different, 0] * n + pairs[different, 1], return_index=True)
    return FrameGraph(
        n,
        (key // n).astype(np.int32),
        (key % n).astype(np.int32),
        length[different][place],
        np.zeros(len(key), dtype=bool),
    )


def closest_bridges(states: Array, labels: NDArray[np.int32]) -> tuple[NDArray[np.intp], Array]:
    """Edges of the spanning tree over the parts of a graph, each between the closest frames of two parts.

    states: (n, d). labels: (n,) part of each frame. Returns (parts - 1, 2) and their lengths.
    """
    labels = labels.copy()
    pairs, lengths = [], []
    while len(counts := np.bincount(labels)[np.unique(labels)]) > 1:
        # The closest pair that leaves any part belongs to the tree; the smallest part is the cheapest to search.
        smallest = np.unique(labels)[counts.argmin()]
        inside, outside = np.flatnonzero(labels == smallest), np.flatnonzero(labels != smallest)
        distances, near = (column[:, 0] for column in nearest(states[outside], states[inside]))
        place = int(distances.argmin())
        pairs.append((int(inside[place]), int(outside[near[place]])))
        lengths.append(float(distances[place]))
        labels[inside] = labels[pairs[-1][1]]
    return np.array(pairs, dtype=np.intp).reshape(-1, 2), np.array(lengths)
