"""Possible steps from bar to bar within constraints, and a random path: Choi (2024). The cheapest path: beam.py."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.dance.motion_graph import Edges, Indices


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
