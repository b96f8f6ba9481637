"""Paths: which are possible, the beam against one with plain lists, novelty, the random walk."""

from __future__ import annotations

from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml_service.analysis.dance import path as paths
from mcml_service.analysis.dance.beam import MEMORY, Costs, beam_path, cheapest_path
from mcml_service.analysis.dance.motion_graph import Edges

COUNT = 6


def edges_of(seed: int, density: float = 0.5) -> Edges:
    rng = np.random.default_rng(seed)
    pairs = [(a, b) for a in range(COUNT) for b in range(COUNT) if b == a + 1 or (a != b and rng.random() < density)]
    first, second = np.array(pairs, dtype=np.intp).T
    natural = second == first + 1
    distances = np.where(natural, 0.0, np.round(rng.random(len(pairs)), 2))
    return Edges(first, second, distances, natural, np.zeros((len(pairs), 3)))


def allowed_of(seed: int, length: int) -> np.ndarray:
    return np.random.default_rng(seed + 1).random((length, COUNT)) < 0.7


@given(seed=st.integers(0, 9999), length=st.integers(1, 4))
def test_feasible_bars_are_those_of_some_whole_path(seed: int, length: int) -> None:
    edges, allowed = edges_of(seed, 0.2), allowed_of(seed, length)
    steps = set(zip(edges.first.tolist(), edges.second.tolist(), strict=True))
    whole = [
        way
        for way in product(range(COUNT), repeat=length)
        if all(allowed[place, bar] for place, bar in enumerate(way)) and all(p in steps for p in pairwise(way))
    ]
    reach = paths.feasible(COUNT, edges, allowed)
    assert (paths.first_impossible(edges, allowed) is None) == bool(whole)
    assert set(np.flatnonzero(reach[0]).tolist()) == {way[0] for way in whole}
    for way in whole:
        assert all(reach[place, bar] for place, bar in enumerate(way))


def test_the_first_impossible_position_is_named() -> None:
    edges = edges_of(1)
    allowed = np.ones((5, COUNT), dtype=bool)
    allowed[3] = False
    assert paths.first_impossible(edges, allowed) == 3
    allowed[0] = False
    assert paths.first_impossible(edges, allowed) == 0


def steps_of(edges: Edges) -> dict[tuple[int, int], tuple[float, bool]]:
    return {
        (int(a), int(b)): (float(d), bool(n))
        for a, b, d, n in zip(edges.first, edges.second, edges.distances, edges.natural, strict=True)
    }


def step_cost(way: list[int], bar: int, distance: float, threshold: float, costs: Costs, possible: int) -> float:
    position = len(way)
    visits = sum(0.8 ** (position - place - 1) for place, seen in enumerate(way) if seen == bar)
    excess = max(0.0, way.count(bar) - position / possible)
    novelty = costs.novelty * (way[-MEMORY:].count(bar) ** 2 + excess)
    energy = 0.0 if costs.energies is None else float(costs.energies[position, bar])
    return distance / threshold + costs.repeat * visits + novelty + energy


def beam_slowly(edges: Edges, threshold: float, reach: np.ndarray, width: int, costs: Costs) -> list[int]:
    steps, possible = steps_of(edges), int(reach.any(axis=0).sum())
    begun = np.zeros(COUNT) if costs.energies is None else costs.energies[0]
    first = [(float(begun[bar]), [int(bar)], 1) for bar in np.flatnonzero(reach[0])]
    states = sorted(first, key=lambda state: (round(state[0], 9), state[1]))[:width]
    for position in range(1, len(reach)):
        grown = []
        for total, way, run in states:
            ways = [
                (bar, *steps[way[-1], bar]) for bar in range(COUNT) if (way[-1], bar) in steps and reach[position, bar]
            ]
            short = [step for step in ways if not (step[2] and run >= costs.max_run)]
            for bar, d, natural in short or ways:
                cost = total + step_cost(way, bar, d, threshold, costs, possible)
                grown.append((cost, [*way, bar], run + 1 if natural else 1))
        states = sorted(grown, key=lambda state: (round(state[0], 9), state[1]))[:width]
    return states[0][1]


@given(
    seed=st.integers(0, 9999),
    length=st.integers(1, 24),
    width=st.sampled_from([1, 3, 64]),
    repeat=st.sampled_from([0.0, 1.0]),
    novelty=st.sampled_from([0.0, 0.5]),
    max_run=st.integers(1, 3),
    loud=st.booleans(),
)
def test_the_beam_is_a_beam_of_lists(
    seed: int, length: int, width: int, repeat: float, novelty: float, max_run: int, loud: bool
) -> None:
    edges = edges_of(seed)
    reach = paths.feasible(COUNT, edges, allowed_of(seed, length) | (np.arange(COUNT) == 0))
    energies = np.random.default_rng(seed).random((length, COUNT)) if loud else None
    costs = Costs(repeat, max_run=max_run, novelty=novelty, energies=energies)
    if reach[0].any():
        ways = paths.successors(COUNT, edges, 0.7)
        path = beam_path(ways, reach, costs, width=width).path
        assert path == beam_slowly(edges, 0.7, reach, width, costs)


@given(seed=st.integers(0, 9999), length=st.integers(1, 40))
def test_the_cost_is_that_of_the_path(seed: int, length: int) -> None:
    edges, costs = edges_of(seed, 0.6), Costs(novelty=0.5)
    reach = paths.feasible(COUNT, edges, np.ones((length, COUNT), dtype=bool))
    route = beam_path(paths.successors(COUNT, edges, 0.7), reach, costs)
    steps, possible = steps_of(edges), int(reach.any(axis=0).sum())
    total = sum(
        step_cost(route.path[:place], bar, steps[route.path[place - 1], bar][0], 0.7, costs, possible)
        for place, bar in enumerate(route.path)
        if place
    )
    assert route.cost == pytest.approx(total, abs=1e-6)


@given(seed=st.integers(0, 9999), length=st.integers(1, 40), novelty=st.sampled_from([0.0, 0.5, 3.0]))
def test_the_cheapest_path_never_costs_more_than_cheapest_steps(seed: int, length: int, novelty: float) -> None:
    edges, costs = edges_of(seed, 0.3), Costs(novelty=novelty)
    reach = paths.feasible(COUNT, edges, allowed_of(seed, length) | (np.arange(COUNT) == 0))
    if reach[0].any():
        ways = paths.successors(COUNT, edges, 0.7)
        chosen, greedy = cheapest_path(ways, reach, costs), beam_path(ways, reach, costs, width=1)
        assert chosen.cost <= greedy.cost + 1e-9
        assert len(chosen.path) == length
        assert all(reach[place, bar] for place, bar in enumerate(chosen.path))


@given(seed=st.integers(0, 9999), length=st.integers(1, 120), novelty=st.sampled_from([0.3, 1.0, 3.0]))
def test_with_novelty_no_bar_is_used_more_than_needed(seed: int, length: int, novelty: float) -> None:
    """Every bar may follow every other one: uses differ by two at most, and all are used if there is time."""
    pairs = [(a, b) for a in range(COUNT) for b in range(COUNT) if a != b]
    first, second = np.array(pairs, dtype=np.intp).T
    distances = np.random.default_rng(seed).random(len(pairs)) * 0.5
    edges = Edges(first, second, distances, np.zeros(len(pairs), dtype=bool), np.zeros((len(pairs), 3)))
    reach = np.ones((length, COUNT), dtype=bool)
    path = beam_path(paths.successors(COUNT, edges, 0.5), reach, Costs(novelty=novelty)).path
    uses = np.bincount(path, minlength=COUNT)
    assert uses.max() <= -(-length // COUNT) + 1
    assert (uses > 0).sum() >= min(COUNT, length // 2)


def test_without_a_cost_of_repeats_the_cheapest_loop_repeats() -> None:
    pairs = [(a, b) for a in range(COUNT) for b in range(COUNT) if a != b]
    first, second = np.array(pairs, dtype=np.intp).T
    distances = np.where(first + second == 1, 0.1, 0.5)
    edges = Edges(first, second, distances, np.zeros(len(pairs), dtype=bool), np.zeros((len(pairs), 3)))
    ways, reach = paths.successors(COUNT, edges, 0.5), np.ones((30, COUNT), dtype=bool)
    assert set(beam_path(ways, reach, Costs(0.0)).path) == {0, 1}
    assert set(beam_path(ways, reach, Costs(1.0)).path) == set(range(COUNT))


@pytest.mark.parametrize("max_run", [1, 2, 4])
def test_bars_in_source_order_are_not_more_than_asked(max_run: int) -> None:
    ways = paths.successors(COUNT, edges_of(4, 1.0), 0.5)
    found = beam_path(ways, np.ones((40, COUNT), dtype=bool), Costs(max_run=max_run)).path
    run = longest = 1
    for a, b in pairwise(found):
        run = run + 1 if b == a + 1 else 1
        longest = max(longest, run)
    assert longest == max_run


def test_where_there_is_no_other_way_the_source_goes_on() -> None:
    first = np.arange(COUNT - 1)
    chain = Edges(first, first + 1, np.zeros(5), np.ones(5, dtype=bool), np.zeros((5, 3)))
    reach = paths.feasible(COUNT, chain, np.ones((COUNT, COUNT), dtype=bool))
    assert beam_path(paths.successors(COUNT, chain, 0.0), reach, Costs(max_run=2)).path == list(range(COUNT))


def test_a_random_walk_takes_each_successor_alike_and_the_same_by_seed() -> None:
    edges = edges_of(7, 0.6)
    reach = paths.feasible(COUNT, edges, np.ones((400, COUNT), dtype=bool))
    ways = paths.successors(COUNT, edges, 1.0)
    found = paths.random_path(ways, reach, np.random.default_rng(3))
    assert found == paths.random_path(ways, reach, np.random.default_rng(3))
    assert found != paths.random_path(ways, reach, np.random.default_rng(4))
    steps = set(zip(edges.first.tolist(), edges.second.tolist(), strict=True))
    taken = list(pairwise(found))
    assert set(taken) <= steps
    for bar in range(COUNT):
        counts = np.bincount([b for a, b in taken if a == bar], minlength=COUNT)
        following = [b for a, b in steps if a == bar and reach[5, b]]
        if counts.sum() > 60:
            assert all(counts[b] > 0.3 * counts.sum() / len(following) for b in following)
