"""The cheapest path through the graph of bars by a beam: smooth, without repetition, on a stage, along the loudness.

The cost of a step to a bar is that of its jump, plus a cost of repeats, of distance outside the stage, and of another
energy than the music's: docs/analyses/dance.md, "Path".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.dance.path import Successors
from mcml_service.analysis.dance.stage import Indices, Points, Stage, crowd, ease

WIDTH = 64
REPEAT_COST = 1.0
"""lambda: cost of repeating a recent bar, in thresholds."""
FORGETTING = 0.8
"""rho: the part of that cost that is left after each further bar."""
MAX_RUN = 4
MEMORY = 16
"""Bars in which repeats cost by their square."""
OUTSIDE = 4.0
"""Cost of a metre outside the stage, squared, in thresholds."""
MEETING = 10.0
"""Cost of a metre too near to another dancer, squared, in those outside the stage."""
AHEAD = 0.25
"""Weight of the places ahead against those of the bar, where a turn is chosen."""
TURNS = np.array([0.0, -1.0, 1.0, -0.5, 0.5])
"""Turns that are tried in a bar, in greatest turns; of equal ones the first is taken."""
MOST_PLACED = 4096
"""Steps of which the places are computed: the cheapest without their places."""


@dataclass(frozen=True)
class Costs:
    """Weights, in thresholds. repeat, forgetting: of recent visits. novelty: of uses in the last 16 bars, squared, and
    of uses above the mean. energies: (M, B) of each bar at each position; None: 0. max_run: bars in source order."""

    repeat: float = REPEAT_COST
    forgetting: float = FORGETTING
    max_run: int = MAX_RUN
    novelty: float = 0.0
    energies: Array | None = None


@dataclass(frozen=True)
class Floor:
    """Where bars lead. stage: to be kept. most: greatest turn in a bar, radians.

    tracks: (B, L) the root's way through each bar, from its lead-in to its last beat, metres in its clip; `first` is
    the index of its first beat. spins, shifts: (E,) of the edges: multipliers and moves that bring the second bar to
    the first. ahead: (B,) mean move of the bars that may follow, in the axes of the bar's clip. start: (B,) multipliers
    that turn the first bar. place: where it starts. others: (N, M, L) places of other dancers through each bar.
    """

    stage: Stage
    most: float
    tracks: Points
    first: int
    spins: Points
    shifts: Points
    ahead: Points
    start: Points
    place: complex = 0.0
    others: Points | None = None

    @property
    def turns(self) -> Array:
        """(T,) turns to try, radians."""
        tried: Array = self.most * TURNS if self.most > 0 else np.zeros(1)
        return tried

    def shapes(self) -> Points:
        """(B, T, L) ways of each bar from its first point, with each turn."""
        part = ease((np.arange(self.tracks.shape[1] - 1) + 0.5) / (self.tracks.shape[1] - 1))
        steps = np.exp(-1j * self.turns[:, None] * part) * np.diff(self.tracks, axis=1)[:, None]
        ways: Points = np.concatenate([np.zeros((*steps.shape[:2], 1)), np.cumsum(steps, axis=-1)], axis=-1)
        return ways


@dataclass(frozen=True)
class Route:
    """path: (M,) bars. turns: (M,) radians. cost: in thresholds."""

    path: list[int]
    turns: Array
    cost: float


@dataclass
class _States:
    """States of the beam, W of each. weights, uses, recent: (W, B) visits that fade, in all, in the last 16 bars.
    history: (W, 16) these bars, -1 before the start. spins, shifts: of the world of each."""

    bars: Indices
    costs: Array
    runs: Indices
    ranks: Indices
    weights: Array
    uses: NDArray[np.int32]
    recent: NDArray[np.int32]
    history: Indices
    spins: Points
    shifts: Points

    def take(self, chosen: Indices) -> None:
        """Keep states, in this order, as often as named."""
        for name in ("weights", "uses", "recent", "history", "spins", "shifts"):
            setattr(self, name, getattr(self, name)[chosen])

    def remember(self, costs: Costs, position: int) -> None:
        """Count the bar that each state is at, the `position`-th."""
        rows = np.arange(len(self.bars))
        self.weights *= costs.forgetting
        self.weights[rows, self.bars] += 1.0
        if costs.novelty:
            slot = (position - 1) % MEMORY
            old = self.history[:, slot]
            known = old >= 0
            self.recent[rows[known], old[known]] -= 1
            self.history[:, slot] = self.bars
            self.recent[rows, self.bars] += 1
            self.uses[rows, self.bars] += 1


def cheapest_path(successors: Successors, reach: NDArray[np.bool_], costs: Costs, floor: Floor | None = None) -> Route:
    """The path of a beam, or that of the cheapest next steps, which a beam may lose, if it costs less."""
    routes = [beam_path(successors, reach, costs, floor, width) for width in (WIDTH, 1)]
    return min(routes, key=lambda route: round(route.cost, 9))


def beam_path(
    successors: Successors, reach: NDArray[np.bool_], costs: Costs, floor: Floor | None = None, width: int = WIDTH
) -> Route:
    """The path of least cost found by a beam of states by (cost to 9 decimals, path).

    A step to bar B costs its edge; repeat * sum over earlier visits of B of forgetting ** (steps since - 1); novelty *
    (uses of B in the last 16 bars squared + uses of B above the mean of all bars); 4 per square metre that its way is
    outside the stage and 40 per square metre that it is too near to other dancers; and its energy. At most `max_run`
    bars in source order, unless a state has no other way.
    reach: (M, B), no dead ends inside. O(M width degree), memory O(width B).
    """
    count = reach.shape[1]
    possible = max(1, int(reach.any(axis=0).sum()))
    bars = np.flatnonzero(reach[0])
    begun = np.zeros(len(bars)) if costs.energies is None else costs.energies[0, bars]
    order = np.lexsort((bars, np.round(begun, 9)))[:width]
    bars, begun = bars[order], begun[order]
    size, turn = len(bars), np.zeros(len(bars))
    states = _States(
        bars,
        begun,
        np.ones(size, dtype=np.intp),
        np.argsort(np.argsort(bars)),
        np.zeros((size, count)),
        np.zeros((size, count), dtype=np.int32),
        np.zeros((size, count), dtype=np.int32),
        np.full((size, MEMORY), -1, dtype=np.intp),
        np.ones(size, dtype=complex),
        np.zeros(size, dtype=complex),
    )
    shapes = None
    if floor is not None:
        shapes = floor.shapes()
        states.spins *= floor.start[bars]
        states.shifts = floor.place - states.spins * floor.tracks[bars, floor.first]
    steps: list[tuple[Indices, Indices, Array]] = [(bars, np.zeros(size, dtype=np.intp), turn)]
    for position in range(1, len(reach)):
        states.remember(costs, position)
        state, edge = _expansions(successors, states.bars, states.runs, reach[position], costs.max_run)
        target = successors.second[edge]
        total = states.costs[state] + successors.costs[edge] + costs.repeat * states.weights[state, target]
        if costs.novelty:
            excess = np.maximum(states.uses[state, target] - position / possible, 0.0)
            total += costs.novelty * (states.recent[state, target].astype(float) ** 2 + excess)
        if costs.energies is not None:
            total += costs.energies[position, target]
        turn, spins, shifts = np.zeros(len(state)), None, None
        if floor is not None and shapes is not None:
            near = np.sort(np.argsort(np.round(total, 9), kind="stable")[:MOST_PLACED])
            state, edge, target, total = state[near], edge[near], target[near], total[near]
            others = None if floor.others is None else floor.others[:, position]
            away, turn, spins, shifts = _place(floor, shapes, states, state, edge, target, others)
            total = total + OUTSIDE * away
        best = np.lexsort((target, states.ranks[state], np.round(total, 9)))[:width]
        state, edge, target = state[best], edge[best], target[best]
        ranks_before = states.ranks[state]
        ranks = np.empty(len(best), dtype=np.intp)
        ranks[np.lexsort((target, ranks_before))] = np.arange(len(best))
        states.ranks = ranks
        states.runs = np.where(successors.natural[edge], states.runs[state] + 1, 1)
        states.bars, states.costs = target, total[best]
        states.take(state)
        if spins is not None and shifts is not None:
            states.spins, states.shifts = spins[best], shifts[best]
        steps.append((target, state, turn[best]))
    place, path, turns = 0, [], []
    for bars, before, turn in reversed(steps):
        path.append(int(bars[place]))
        turns.append(float(turn[place]))
        place = int(before[place])
    return Route(path[::-1], np.array(turns[::-1]), float(states.costs[0]))


def _place(
    floor: Floor,
    shapes: Points,
    states: _States,
    state: Indices,
    edge: Indices,
    target: Indices,
    others: Points | None,
) -> tuple[Array, Array, Points, Points]:
    """Squared distances (n,) outside the stage and into others (N, L), each with the best turn (n,), and the worlds
    after it.

    The best turn leaves the stage least in this bar and in the next ones, if they go on as bars usually do from here.
    """
    spins = states.spins[state] * floor.spins[edge]
    shifts = states.shifts[state] + states.spins[state] * floor.shifts[edge]
    first = shifts + spins * floor.tracks[target, 0]
    ways = first[:, None, None] + spins[:, None, None] * shapes[target]
    away = floor.stage.outside(ways).max(axis=-1) ** 2
    for other in () if others is None else others:
        away += MEETING * (np.abs(crowd(ways, other)) ** 2).max(axis=-1)
    turned = spins[:, None] * np.exp(-1j * floor.turns)
    ahead = turned * floor.ahead[target][:, None]
    later = sum(floor.stage.outside(ways[..., -1] + steps * ahead) ** 2 for steps in (1, 2, 4))
    best = np.round(away + AHEAD * later, 9).argmin(axis=1)
    rows = np.arange(len(state))
    after = turned[rows, best]
    return away[rows, best], floor.turns[best], after, ways[rows, best, -1] - after * floor.tracks[target, -1]


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
