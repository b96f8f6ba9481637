"""Distances of clouds, the nearest pairs, thresholds and components: against slow twins."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml_service.analysis.dance import motion_graph as graph
from tests import fuzz


def clouds(seed: int, bars: int = 5, points: int = 3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    ends, starts = rng.normal(0, 1, (2, bars, 7 * points, 3)) + rng.normal(0, 3, (2, bars, 1, 3))
    return ends, starts, graph.cloud_weights(points)


def turned(cloud: np.ndarray, theta: float, x0: float, z0: float) -> np.ndarray:
    x, y, z = cloud.T
    return np.stack(
        [x * np.cos(theta) + z * np.sin(theta) + x0, y, -x * np.sin(theta) + z * np.cos(theta) + z0], axis=1
    )


def distance(end: np.ndarray, start: np.ndarray, weights: np.ndarray, transform: np.ndarray) -> float:
    return float(np.sqrt((weights * ((end - turned(start, *transform)) ** 2).sum(axis=1)).sum()))


@pytest.mark.slow
@fuzz.examples(20)
@given(seed=st.integers(0, 9999))
def test_alignment_is_the_best_turn_and_shift(seed: int) -> None:
    ends, starts, weights = clouds(seed)
    distances, transforms = graph.align(ends[0], starts, weights)
    for start, found, transform in zip(starts, distances, transforms, strict=True):
        assert found == pytest.approx(distance(ends[0], start, weights, transform))
        least = np.inf
        for theta in np.linspace(-np.pi, np.pi, 361):
            shift = weights @ (ends[0] - turned(start, theta, 0.0, 0.0))
            least = min(least, distance(ends[0], start, weights, np.array([theta, shift[0], shift[2]])))
        assert least - 1e-3 <= found <= least + 1e-9


@given(seed=st.integers(0, 9999), far=st.sampled_from([0.0, 30.0]))
def test_rough_distances_are_the_distances_but_for_rounding(seed: int, far: float) -> None:
    ends, starts, weights = clouds(seed)
    ends, starts = ends + far, starts - far
    planes = np.moveaxis(starts, -1, 0)
    norms = ((starts**2).sum(axis=-1) * weights).sum(axis=-1)
    rough = graph.rough_squares(ends[0], planes, norms, weights)
    assert rough == pytest.approx(graph.align(ends[0], starts, weights)[0] ** 2, abs=1e-9 * (1 + far**2))


@given(seed=st.integers(0, 9999), theta=st.floats(-3.1, 3.1), shift=st.floats(-9, 9))
def test_a_cloud_that_was_moved_is_brought_back(seed: int, theta: float, shift: float) -> None:
    """All of the circle: an arc tangent of a quotient would lose half of it."""
    _, starts, weights = clouds(seed, bars=1)
    end = turned(starts[0], theta, shift, -shift)
    distances, transforms = graph.align(end, starts, weights)
    assert distances[0] < 1e-7
    assert np.cos(transforms[0, 0] - theta) == pytest.approx(1)
    assert transforms[0, 1:] == pytest.approx([shift, -shift], abs=1e-6)


def test_weights_fall_with_the_distance_from_the_middle() -> None:
    weights = graph.cloud_weights(2).reshape(7, 2)
    assert weights.sum() == pytest.approx(1)
    assert weights[:, 0] / weights[3, 0] == pytest.approx([1 / 4, 1 / 3, 1 / 2, 1, 1 / 2, 1 / 3, 1 / 4])


def test_frames_of_a_cloud_are_a_thirtieth_of_a_second_apart_and_in_the_clip() -> None:
    assert graph.cloud_frames(50, 120.0, 100).tolist() == [38, 42, 46, 50, 54, 58, 62]
    assert graph.cloud_frames(-5, 30.0, 100).tolist() == [0] * 7
    assert graph.cloud_frames(98, 30.0, 100).tolist() == [95, 96, 97, 98, 99, 99, 99]


def all_pairs(
    ends: np.ndarray, starts: np.ndarray, weights: np.ndarray, size: float, natural: np.ndarray, repeat: bool
) -> dict[tuple[int, int], float]:
    return {
        (a, b): float(graph.align(ends[a], starts[b : b + 1], weights)[0][0] / size)
        for a in range(len(ends))
        for b in range(len(starts))
        if natural[a] != b and (repeat or a != b)
    }


@given(seed=st.integers(0, 9999), keep=st.integers(1, 80), repeat=st.booleans(), within=st.sampled_from([np.inf, 1.0]))
def test_the_nearest_pairs_are_the_nearest_of_all(seed: int, keep: int, repeat: bool, within: float) -> None:
    ends, starts, weights = clouds(seed, bars=8)
    natural = np.array([1, 2, -1, 4, -1, -1, -1, -1])
    found = graph.nearest_jumps(ends, starts, weights, 2.0, natural, repeat, keep, within)
    expected = {p: d for p, d in all_pairs(ends, starts, weights, 2.0, natural, repeat).items() if d <= within}
    nearest = sorted(expected.items(), key=lambda item: item[1])[:keep]
    assert {(int(a), int(b)) for a, b in zip(found.first, found.second, strict=True)} == {pair for pair, _ in nearest}
    assert np.allclose(sorted(found.distances), [d for _, d in nearest])
    assert found.complete == (len(nearest) == len(expected))


def reaches(edges: set[tuple[int, int]], start: int) -> set[int]:
    seen, waiting = {start}, [start]
    while waiting:
        node = waiting.pop()
        for a, b in edges:
            if a == node and b not in seen:
                seen.add(b)
                waiting.append(b)
    return seen


def component_slowly(count: int, edges: set[tuple[int, int]]) -> set[int]:
    reach = [reaches(edges, node) for node in range(count)]
    components = [{b for b in reach[a] if a in reach[b]} for a in range(count)]
    return max(components, key=lambda found: (len(found), -min(found)))


@given(st.sets(st.tuples(st.integers(0, 6), st.integers(0, 6)), max_size=14))
def test_the_largest_component_is_that_of_the_lowest_bar_among_equals(edges: set[tuple[int, int]]) -> None:
    first, second = (np.array([edge[side] for edge in sorted(edges)], dtype=np.intp) for side in (0, 1))
    found = graph.largest_component(7, first, second)
    assert set(np.flatnonzero(found).tolist()) == component_slowly(7, edges)


@given(seed=st.integers(0, 9999), wanted=st.integers(2, 7), coarse=st.booleans())
def test_the_threshold_is_the_least_that_connects(seed: int, wanted: int, coarse: bool) -> None:
    rng = np.random.default_rng(seed)
    pairs = [(a, b) for a in range(7) for b in range(7) if a != b and rng.random() < 0.5]
    distances = np.round(rng.random(len(pairs)), 1 if coarse else 6)
    first, second = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
    found = graph.least_threshold(7, graph.Pairs(first, second, distances, True), wanted)
    working = [
        level
        for level in sorted(set(distances.tolist()))
        if len(component_slowly(7, {p for p, d in zip(pairs, distances, strict=True) if d <= level})) >= wanted
    ]
    assert found == (working[0] if working else None)


@pytest.mark.parametrize("threshold", [None, 0.9])
def test_edges_are_natural_pairs_and_jumps_up_to_the_threshold(threshold: float | None) -> None:
    ends, starts, weights = clouds(3, bars=9)
    natural = np.array([1, 2, -1, 4, 5, -1, -1, -1, -1])
    edges, level, _ = graph.connect(ends, starts, weights, 2.0, natural, threshold, 0.8)
    pairs = all_pairs(ends, starts, weights, 2.0, natural, False)
    jumps = {p for p, d in pairs.items() if d <= level + 1e-9}
    found = set(zip(edges.first.tolist(), edges.second.tolist(), strict=True))
    assert found == jumps | {(a, int(b)) for a, b in enumerate(natural) if b >= 0}
    assert list(zip(edges.first, edges.second, strict=True)) == sorted(found)
    assert not edges.distances[edges.natural].any()
    assert not edges.transforms[edges.natural].any()
    if threshold is None:
        assert len(component_slowly(9, jumps)) >= 8
        assert len(component_slowly(9, {p for p in jumps if pairs[p] < level - 1e-9})) < 8
    for a, b, d, transform in zip(edges.first, edges.second, edges.distances, edges.transforms, strict=True):
        if natural[a] != b:
            assert distance(ends[a], starts[b], weights, transform) / 2.0 == pytest.approx(d)


def test_too_few_pairs_are_guessed_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    ends, starts, weights = clouds(5, bars=9)
    natural = np.full(9, -1)
    asked: list[int] = []
    full = graph.nearest_jumps

    def few(*args: object, **options: object) -> graph.Pairs:
        asked.append(int(args[6]))  # type: ignore[call-overload]
        return full(*args[:6], len(asked) * 12, **options)  # type: ignore[arg-type]

    expected = graph.connect(ends, starts, weights, 1.0, natural)
    monkeypatch.setattr(graph, "nearest_jumps", few)
    edges, level, _ = graph.connect(ends, starts, weights, 1.0, natural)
    assert len(asked) > 1
    assert level == expected[1]
    assert np.array_equal(edges.distances, expected[0].distances)


def test_without_any_connection_the_greatest_distance_stands() -> None:
    ends, starts, weights = clouds(1, bars=2)
    natural = np.array([1, -1])
    edges, level, _ = graph.connect(ends, starts, weights, 1.0, natural)
    assert len(edges) == 2
    assert level == edges.distances.max()
    single, level, _ = graph.connect(ends[:1], starts[:1], weights, 1.0, np.array([-1]))
    assert (len(single), level) == (0, 0.0)


@pytest.mark.slow
def test_memory_is_bounded_by_rows() -> None:
    """A row of clouds at a time, and the pairs kept: four times the bars take four times the memory, not sixteen."""

    def peak(bars: int) -> int:
        ends, starts, weights = clouds(2, bars=bars, points=2)
        natural = np.full(bars, -1)
        tracemalloc.start()
        graph.nearest_jumps(ends, starts, weights, 1.0, natural, False, 2 * bars)
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    small, large = peak(300), peak(1200)
    assert large < 5 * small
    assert large < 1200 * 1200 * 8
