"""Links of candidates, against going through all shortest paths."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse.csgraph import dijkstra

from mcml.motion.skeleton import Array
from mcml_service.analysis.expression_space.frame_graph import FrameGraph, threshold_graph
from mcml_service.analysis.expression_space.links import (
    Links,
    edge_links,
    half_nearest,
    median_nearest,
    paper_links,
    voronoi_links,
)
from tests.analysis.expression.face_motions import space


def scene(seed: int, count: int = 90) -> tuple[FrameGraph, Array]:
    points = np.random.default_rng(seed).normal(size=(count, 2)) * (40, 25)
    return threshold_graph(np.linalg.norm(points[:, None] - points[None], axis=2), 22.0), points


def pairs(links: Links) -> dict[tuple[int, int], float]:
    return dict(zip(zip(links.first.tolist(), links.second.tolist(), strict=True), links.length.tolist(), strict=True))


def naive_paper(graph: FrameGraph, candidates: Array, plane: Array, rho: float) -> dict[tuple[int, int], float]:
    found = {}
    for i, start in enumerate(candidates.tolist()):
        distance, before = dijkstra(graph.matrix, indices=start, return_predecessors=True)
        for j in range(i + 1, len(candidates)):
            frame = int(candidates[j])
            if not np.isfinite(distance[frame]):
                continue
            path = [frame]
            while path[-1] != start:
                path.append(int(before[path[-1]]))
            third = [c for k, c in enumerate(candidates.tolist()) if k not in (i, j)]
            if all(np.linalg.norm(plane[v] - plane[k]) > rho for v in path for k in third):
                found[i, j] = float(distance[frame])
    return found


def naive_voronoi(graph: FrameGraph, candidates: Array) -> dict[tuple[int, int], float]:
    distance = dijkstra(graph.matrix, indices=candidates)
    owner, nearest = distance.argmin(axis=0), distance.min(axis=0)
    found: dict[tuple[int, int], float] = {}
    for u, v, w in zip(graph.first.tolist(), graph.second.tolist(), graph.length.tolist(), strict=True):
        i, j = sorted((int(owner[u]), int(owner[v])))
        if i != j and np.isfinite(nearest[u]):
            found[i, j] = min(found.get((i, j), np.inf), nearest[u] + w + nearest[v])
    return found


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("rho", [0.0, 4.0, 9.0])
def test_the_papers_links_are_those_of_its_rule(seed: int, rho: float) -> None:
    graph, plane = scene(seed)
    candidates = np.random.default_rng(seed).choice(90, 14, replace=False).astype(np.int32)
    found, wanted = pairs(paper_links(graph, candidates, plane, rho)), naive_paper(graph, candidates, plane, rho)
    assert found.keys() == wanted.keys()
    assert all(found[pair] == pytest.approx(wanted[pair]) for pair in wanted)
    assert wanted


@pytest.mark.parametrize("seed", range(6))
def test_voronoi_links_join_touching_regions(seed: int) -> None:
    graph, _ = scene(seed)
    candidates = np.random.default_rng(seed).choice(90, 14, replace=False).astype(np.int32)
    found, wanted = pairs(voronoi_links(graph, candidates)), naive_voronoi(graph, candidates)
    assert found.keys() == wanted.keys()
    assert all(found[pair] == pytest.approx(wanted[pair]) for pair in wanted)


def test_robust_links_are_connected_at_every_level() -> None:
    found = space()
    assert found.graph.components().max() == 0
    assert [links.components for links in found.links] == [1] * len(found.levels)


def test_the_papers_links_fall_apart() -> None:
    """What the rule with one radius for all levels does: the reason for the other one."""
    found = space("paper")
    assert any(links.components > 1 for links in found.links[:-1])
    assert any(code == "links-disconnected" for code, _ in found.warnings)


def test_links_of_the_last_level_are_edges_of_the_graph() -> None:
    found = space()
    assert pairs(found.links[-1]) == pairs(edge_links(found.graph))
    assert len(found.levels[-1].candidates) == found.graph.frames


def test_links_over_bridges_say_so() -> None:
    rng = np.random.default_rng(0)
    points = np.concatenate([rng.normal(size=(30, 2)) * 8, rng.normal(size=(30, 2)) * 8 + (120, 0)])
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    graph = threshold_graph(apart, 15.0)
    assert graph.components().max() >= 1
    corner = np.unravel_index(apart[:30, 30:].argmin(), (30, 30))
    pair = np.array([[corner[0], corner[1] + 30]])
    graph = graph.add_bridges(pair, apart[pair[:, 0], pair[:, 1]])
    candidates = np.array([0, 10, 40, 50], dtype=np.int32)
    for links in (voronoi_links(graph, candidates), paper_links(graph, candidates, points, 0.0)):
        over = {
            (int(a), int(b)): bool(bridge) for a, b, bridge in zip(links.first, links.second, links.bridge, strict=True)
        }
        for (a, b), bridge in over.items():
            assert bridge == ((a < 2) != (b < 2))
        assert any(over.values())


def test_the_radius_is_half_the_median_nearest_distance() -> None:
    places = np.array([[0, 0], [3, 0], [10, 0], [10, 8.0]])
    assert median_nearest(places) == pytest.approx((3 + 7) / 2)
    assert half_nearest(places) == pytest.approx(2.5)
