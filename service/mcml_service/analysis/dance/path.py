"""Find a path through the graph of bars within constraints: the cheapest without repetitive loops, or a random one.

Choi (2024) walks at random; the beam, its cost of repeats and the feasible sets: docs/analyses/dance.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.dance.motion_graph import Edges, Indices

WIDTH = 64
REPEAT_COST = 1.0
"""lambda: cost of repeating a recent bar, in thresholds."""
FORGETTING = 0.8
"""rho: the part of that cost that is left after each further bar."""
MAX_RUN = 4


@dataclass(frozen=True)
class Successors:
    """Edges by their first bar: those of bar b are `bounds[b]:bounds[b + 1]`."""

    bounds: Indices
    second: Indices
    costs: Array
    natural: NDArray[np.bool_]


def successors(count: int, edges: Edges, threshold: float) -> Successors:
    """Edges in compressed rows; a jump costs its distance over the threshold, a natural one nothing."""
    bounds = np.searchsorted(edges.first, np.arange(count + 1))
    costs = edges.distances / threshold if threshold > 0 else np.zeros(len(edges))
    return Successors(bounds, edges.second, costs, edges.natural)


def feasible(count: int, edges: Edges, allowed: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(M, B) bars at each position from which the end can be reached: R[M-1] = allowed, R[m] = allowed with a successor
    in R[m+1]. allowed: (M, B). O(M E)."""
    reach = allowed.copy()
    for position in range(len(allowed) - 2, -1, -1):
        ahead = np.zeros(count, dtype=bool)
        ahead[edges.first[reach[position + 1][edges.second]]] = True
        reach[position] &= ahead
    return reach


def first_impossible(edges: Edges, allowed: NDArray[np.bool_]) -> int | None:
    """The first position (from 0) that no path from the start reaches; None where paths reach all. allowed: (M, B)."""
    here = allowed[0]
    for position in range(len(allowed)):
        if position:
            ahead = np.zeros_like(here)
            ahead[edges.second[here[edges.first]]] = True
            here = allowed[position] & ahead
        if not here.any():
            return position
    return None


def random_path(successors: Successors, reach: NDArray[np.bool_], rng: np.random.Generator) -> list[int]:
    """Bars (M), each uniform over the successors inside `reach` (M, B). Choi (2024)."""
    path = [int(rng.choice(np.flatnonzero(reach[0])))]
    for position in range(1, len(reach)):
        following = successors.second[successors.bounds[path[-1]] : successors.bounds[path[-1] + 1]]
        path.append(int(rng.choice(following[reach[position][following]])))
    return path


def beam_path(
    successors: Successors,
    reach: NDArray[np.bool_],
    repeat_cost: float = REPEAT_COST,
    forgetting: float = FORGETTING,
    max_run: int = MAX_RUN,
    width: int = WIDTH,
) -> list[int]:
    """Bars (M) of least cost found by a beam of states by (cost to 9 decimals, path).

    A step to B costs its edge and repeat_cost * sum over earlier visits of B of forgetting ** (steps since - 1). At
    most `max_run` bars in source order, unless a state has no other way. reach: (M, B), no dead ends inside.
    """
    count = reach.shape[1]
    bars = np.flatnonzero(reach[0])[:width]
    costs, runs, ranks = np.zeros(len(bars)), np.ones(len(bars), dtype=np.intp), np.arange(len(bars))
    weights = np.zeros((len(bars), count))
    steps: list[tuple[Indices, Indices]] = [(bars, np.zeros(len(bars), dtype=np.intp))]
    for position in range(1, len(reach)):
        weights *= forgetting
        weights[np.arange(len(bars)), bars] += 1.0
        state, edge = _expansions(successors, bars, runs, reach[position], max_run)
        target = successors.second[edge]
        total = costs[state] + successors.costs[edge] + repeat_cost * weights[state, target]
        best = np.lexsort((target, ranks[state], np.round(total, 9)))[:width]
        state, edge, target = state[best], edge[best], target[best]
        ranks_before = ranks[state]
        ranks = np.empty(len(best), dtype=np.intp)
        ranks[np.lexsort((target, ranks_before))] = np.arange(len(best))
        runs = np.where(successors.natural[edge], runs[state] + 1, 1)
        bars, costs, weights = target, total[best], weights[state]
        steps.append((bars, state))
    place = 0
    path = []
    for bars, before in reversed(steps):
        path.append(int(bars[place]))
        place = int(before[place])
    return path[::-1]


def _expansions(
    successors: Successors, bars: Indices, runs: Indices, allowed: NDArray[np.bool_], max_run: int
) -> tuple[Indices, Indices]:
    """(state, edge) of every step that states may take."""
    starts, lengths = successors.bounds[bars], successors.bounds[bars + 1] - successors.bounds[bars]
    state = np.repeat(np.arange(len(bars)), lengths)
    edge = np.arange(len(state)) - np.repeat(np.cumsum(lengths) - lengths, lengths) + np.repeat(starts, lengths)
    inside = allowed[successors.second[edge]]
    state, edge = state[inside], edge[inside]
    stays = ~(successors.natural[edge] & (runs[state] >= max_run))
    other_way = np.bincount(state[stays], minlength=len(bars)) > 0
    chosen = stays | ~other_way[state]
    return state[chosen], edge[chosen]
