"""The graph of frames and its geodesics, against SciPy and scikit-learn."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra, floyd_warshall, minimum_spanning_tree

from mcml.motion.skeleton import Array
from mcml_service.analysis.expression_space import geodesics
from mcml_service.analysis.expression_space.frame_graph import (
    closest_bridges,
    hub_graph,
    spanning_tree,
    threshold_graph,
)
from mcml_service.analysis.expression_space.geodesics import all_pairs, floyd, from_sources
from tests.analysis.expression.face_motions import space


def cloud(seed: int, count: int = 60, dimensions: int = 3) -> Array:
    return np.random.default_rng(seed).normal(size=(count, dimensions)) * 20


def apart_of(points: Array) -> Array:
    found: Array = np.linalg.norm(points[:, None] - points[None], axis=2)
    return found


@given(st.integers(0, 2**31), st.integers(1, 130), st.floats(5, 60))
def test_floyd_is_floyd_and_dijkstra(seed: int, count: int, tau: float) -> None:
    apart = apart_of(cloud(seed, count))
    weights = np.where(apart <= tau, apart, np.inf)
    found = floyd(weights)
    dense = np.where(np.isfinite(weights), weights, 0.0)
    assert np.allclose(found, floyd_warshall(dense), rtol=1e-9)
    assert np.allclose(found, dijkstra(csr_array(dense)), rtol=1e-9)


def test_floyd_needs_no_metric() -> None:
    rng = np.random.default_rng(4)
    weights = rng.uniform(1, 100, (90, 90))
    weights = np.where(rng.random((90, 90)) < 0.5, np.inf, weights)
    weights = np.minimum(weights, weights.T)
    np.fill_diagonal(weights, 0.0)
    assert np.allclose(floyd(weights), floyd_warshall(np.where(np.isfinite(weights), weights, 0.0)), rtol=1e-9)


def test_both_algorithms_agree_on_the_generated_set(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = space().graph
    assert graph.mean_degree() > 0.1 * graph.frames
    by_floyd = all_pairs(graph.matrix)
    monkeypatch.setattr(geodesics, "floyd", None)
    by_dijkstra = from_sources(graph.matrix, None)
    assert np.allclose(by_floyd, by_dijkstra, rtol=1e-9)


def test_a_sparse_graph_is_left_to_dijkstra(monkeypatch: pytest.MonkeyPatch) -> None:
    points = cloud(0, 200)
    frames = np.arange(200, dtype=np.int32)
    graph = hub_graph(points, frames[::10], 15.0, np.zeros(200, np.int32), frames)
    monkeypatch.setattr(geodesics, "floyd", None)
    assert np.allclose(all_pairs(graph.matrix), dijkstra(graph.matrix), rtol=1e-12)


def test_the_threshold_graph_has_the_near_pairs() -> None:
    apart = apart_of(cloud(1))
    graph = threshold_graph(apart, 25.0)
    wanted = {(i, j) for i in range(60) for j in range(i + 1, 60) if apart[i, j] <= 25.0}
    assert set(zip(graph.first.tolist(), graph.second.tolist(), strict=True)) == wanted
    assert np.array_equal(graph.length, apart[graph.first, graph.second])
    assert graph.mean_degree() == pytest.approx(2 * len(wanted) / 60)


def test_equal_frames_are_joined() -> None:
    points = cloud(2, 20)
    points[7] = points[3]
    graph = threshold_graph(apart_of(points), 1.0)
    assert graph.components()[7] == graph.components()[3]
    assert from_sources(graph.matrix, 3)[7] == pytest.approx(1e-9)


@given(st.integers(0, 2**31))
def test_the_spanning_tree_is_scipys(seed: int) -> None:
    apart = apart_of(cloud(seed))
    edges, lengths = spanning_tree(apart)
    assert lengths.sum() == pytest.approx(minimum_spanning_tree(apart).sum())
    assert np.allclose(lengths, apart[edges[:, 0], edges[:, 1]])
    connecting = lengths.max()
    for tau, parts in ((connecting * (1 + 1e-12), 1), (connecting * (1 - 1e-9), 2)):
        assert connected_components(csr_array(apart <= tau), directed=False)[0] == parts


def test_the_spanning_tree_of_frames_that_share_no_markers() -> None:
    """Undefined distances leave parts; within each the tree is whole."""
    apart = apart_of(cloud(6))
    apart[:40, 40:] = apart[40:, :40] = np.inf
    edges, lengths = spanning_tree(apart)
    near = np.isfinite(lengths)
    assert near.sum() == 58
    assert lengths[near].sum() == pytest.approx(
        sum(minimum_spanning_tree(apart[part, part]).sum() for part in (slice(40), slice(40, None)))
    )
    assert set(edges[:, 1].tolist()) == set(range(1, 60))


def test_bridges_join_parts_by_their_closest_frames() -> None:
    points = np.concatenate([cloud(3, 20) * 0.1 + offset for offset in ((0, 0, 0), (50, 0, 0), (50, 90, 0))])
    apart = apart_of(points)
    labels = threshold_graph(apart, 15.0).components()
    assert labels.max() == 2
    pairs, lengths = closest_bridges(points, labels)
    wanted = sorted([apart[:20, 20:40].min(), apart[20:40, 40:].min()])
    assert sorted(lengths) == pytest.approx(wanted)
    graph = threshold_graph(apart, 15.0).add_bridges(pairs, lengths)
    assert graph.components().max() == 0
    assert len(graph.bridges) == 2


def test_the_hub_graph_joins_hubs_frames_to_hubs_and_the_chain() -> None:
    points = cloud(5, 80)
    take = np.repeat([0, 1], 40).astype(np.int32)
    frame = np.concatenate([np.arange(40), np.r_[0:20, 25:45]]).astype(np.int32)
    hubs = np.random.default_rng(1).permutation(80)[:30]
    tau, apart = 22.0, apart_of(points)
    wanted = np.zeros((80, 80))
    for row in range(80):
        near = hubs[np.argsort(apart[row, hubs])][:4]
        for other in hubs if row in hubs else near:
            if apart[row, other] <= tau:
                wanted[row, other] = wanted[other, row] = apart[row, other]
    for row in range(79):
        if take[row] == take[row + 1] and frame[row + 1] == frame[row] + 1:
            wanted[row, row + 1] = wanted[row + 1, row] = apart[row, row + 1]
    graph = hub_graph(points, hubs, tau, take, frame)
    assert np.allclose(graph.matrix.toarray(), wanted)
    assert (graph.first < graph.second).all()
