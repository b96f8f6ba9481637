"""From a graph of bars and a grid of music to a path: rate, constraints, choice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.dance.assembly import Dance, assemble
from mcml_service.analysis.dance.bar_graph import AllBars, BarGraph, keep_only, threshold_for_two
from mcml_service.analysis.dance.beam import MAX_RUN, Costs, Route, beam_path, cheapest_path
from mcml_service.analysis.dance.blend import Blend, Placement
from mcml_service.analysis.dance.energy import (
    Loudness,
    energy_costs,
    find_bar_loudness,
    find_efforts,
    match_energy,
)
from mcml_service.analysis.dance.floor import Company, fit_to_stage, make_floor, place_dance, turn_to_face
from mcml_service.analysis.dance.motion_beats import half_up
from mcml_service.analysis.dance.motion_graph import Edges
from mcml_service.analysis.dance.path import feasible, first_impossible, random_path, successors
from mcml_service.analysis.dance.sources import Clip
from mcml_service.analysis.dance.stage import Points, Stage
from mcml_service.analysis.dance.time_warp import (
    PULSES,
    Warp,
    choose_pulse,
    divides,
    frame_count,
    motion_grid,
    segments,
)
from mcml_service.analysis.interface import AnalysisError

MOST_OUT = 512
VARIATION = 0.5
"""Thresholds: random cost of a jump, at most, by which seeds give different paths."""
SHARED = 1.0
"""Thresholds: cost of a bar that another dancer dances at the same time."""
Strategy = Literal["beam", "random"]


@dataclass(frozen=True)
class Wish:
    """The bars allowed at a position (from 0, or -1: the last; None: everywhere). bars: from 0. document, label: of the
    source."""

    position: int | None = None
    bars: tuple[int, ...] = ()
    document: str | None = None
    label: str | None = None


@dataclass(frozen=True)
class Choice:
    """How a path is chosen. docs/analyses/dance.md describes the fields; most_turn and facing are in radians.

    place: where the dancer starts on the stage. company: the other dancers there.
    """

    pulse: Fraction | None = None
    max_stretch: float = 2.0
    strategy: Strategy = "beam"
    seed: int = 0
    repeat_cost: float = 1.0
    max_run: int = MAX_RUN
    wishes: tuple[Wish, ...] = ()
    novelty: float = 0.0
    energy: float = 0.0
    loudness: Loudness | None = None
    stage: Stage | None = None
    most_turn: float = 0.0
    facing: float | None = None
    place: complex = 0.0
    company: Company | None = None


@dataclass(frozen=True)
class Plan:
    """path: (M,) bars. natural: (M - 1,) whether the step to the next is. distances: (M - 1,), transforms: (M - 1, 3).

    grid: (4 M + 1,) motion beats, seconds. kept: (B,) bars that could have been danced. turns: (M,) radians that the
    dancer turns in each bar, start: before the first one, to stay on the stage or face a direction. energy_match: rank
    correlation of the music's loudness and the bars' effort, None where unknown.
    """

    path: tuple[int, ...]
    natural: tuple[bool, ...]
    distances: Array
    transforms: Array
    pulse: Fraction
    grid: Array
    kept: NDArray[np.bool_]
    turns: Array
    start: float = 0.0
    energy_match: float | None = None


def check_pulse(music_bars: int, pulse: Fraction) -> None:
    """Raises AnalysisError `bars-not-divisible` where bars of music are not whole bars of motion."""
    if divides(pulse, music_bars):
        return
    whole = int(pulse)
    lower = music_bars - music_bars % whole
    fits = [count for count in (lower, lower + whole) if count]
    raise AnalysisError(
        "bars-not-divisible",
        f"{music_bars} bars of music are not whole bars of motion with {pulse} music beats to a motion beat.",
        remedy=f"Ask for {' or '.join(map(str, fits))} bars, or another pulse.",
        nearest=min(fits, key=lambda count: abs(count - music_bars)),
    )


def plan_dance(clips: Sequence[Clip], graph: BarGraph, grid: Array, choice: Choice) -> Plan:
    """A path for a grid of music beats (4 N + 1,). Raises AnalysisError if there is none."""
    bars = graph.bars
    music_bars = (len(grid) - 1) // 4
    beat = float(np.median(np.diff(grid)))
    pulse = choice.pulse or choose_pulse(beat, float(np.median(bars.seconds[graph.kept])), music_bars)
    check_pulse(music_bars, pulse)
    beats = motion_grid(grid, pulse)
    length = (len(beats) - 1) // 4
    if length > MOST_OUT:
        raise AnalysisError(
            "too-many-bars",
            f"{length} bars of motion were requested; a dance may have {MOST_OUT}.",
            remedy="Ask for fewer.",
            most=MOST_OUT,
        )
    stretch = float(pulse) * beat / bars.seconds
    fits_tempo = graph.kept & (stretch <= choice.max_stretch + 1e-9) & (stretch >= 1 / choice.max_stretch - 1e-9)
    if not fits_tempo.any():
        raise _too_far(graph, choice)
    if not fits_tempo[graph.kept].all():
        graph = keep_only(graph, fits_tempo)
    inside = graph.edges.among(graph.kept)
    if length > 1 and not len(inside):
        raise _no_edges(graph)
    allowed = find_allowed_bars(clips, bars, graph.kept, length, choice.wishes)
    reach = feasible(len(bars), inside, allowed)
    if not reach[0].any():
        position = first_impossible(inside, allowed)
        place = length if position is None else position + 1
        raise AnalysisError(
            "no-path",
            f"No path meets the constraints: no bar is possible at position {place} of {length}.",
            remedy="Allow more bars there or before it, or raise the threshold.",
            position=place,
        )
    starts = None if choice.facing is None else turn_to_face(clips, bars, choice.facing)
    levels, efforts = None, None
    if choice.loudness is not None:
        levels, efforts = find_bar_loudness(choice.loudness, beats), find_efforts(clips, bars)
    energies = None
    if choice.energy and levels is not None and efforts is not None:
        energies = energy_costs(levels, efforts, graph.kept, choice.energy)
    others = None
    if choice.company is not None:
        shared = SHARED * choice.company.uses(len(bars))
        energies = shared if energies is None else energies + shared
        others = choice.company.find_tracks(beats)
    route = _find_route(clips, graph, inside, reach, choice, starts, energies, others)
    steps = [_edge(inside.first, inside.second, a, b) for a, b in pairwise(route.path)]
    return Plan(
        tuple(route.path),
        tuple(bool(natural) for natural in inside.natural[steps]),
        inside.distances[steps],
        inside.transforms[steps],
        pulse,
        beats,
        graph.kept,
        route.turns,
        0.0 if starts is None else float(starts[route.path[0]]),
        None if levels is None or efforts is None else match_energy(levels, efforts[route.path]),
    )


def _find_route(
    clips: Sequence[Clip],
    graph: BarGraph,
    inside: Edges,
    reach: NDArray[np.bool_],
    choice: Choice,
    starts: Array | None,
    energies: Array | None,
    others: Points | None,
) -> Route:
    """Return the path and its turns."""
    ways = successors(len(graph.bars), inside, graph.threshold)
    if choice.strategy == "random":
        path = random_path(ways, reach, np.random.default_rng(choice.seed))
        return Route(path, np.zeros(len(path)), 0.0)
    floor = None
    if choice.stage is not None:
        floor = make_floor(clips, graph.bars, inside, choice.stage, choice.most_turn, starts, choice.place, others)
    if choice.novelty and choice.seed:
        varied = VARIATION * np.random.default_rng(choice.seed).random(len(inside)) * ~inside.natural
        ways = replace(ways, costs=ways.costs + varied)
    costs = Costs(choice.repeat_cost, max_run=choice.max_run, novelty=choice.novelty, energies=energies)
    plain = not choice.novelty and floor is None and energies is None
    return beam_path(ways, reach, costs) if plain else cheapest_path(ways, reach, costs, floor)


def _edge(first: NDArray[np.intp], second: NDArray[np.intp], a: int, b: int) -> int:
    low, high = np.searchsorted(first, [a, a + 1])
    return int(low + np.searchsorted(second[low:high], b))


def _too_far(graph: BarGraph, choice: Choice) -> AnalysisError:
    pulses = [choice.pulse] if choice.pulse else list(PULSES)
    own = graph.bars.seconds[graph.kept]
    spans = sorted(
        (60 * float(pulse) / (seconds * choice.max_stretch), 60 * float(pulse) * choice.max_stretch / seconds)
        for seconds in own.tolist()
        for pulse in pulses
    )
    merged: list[list[float]] = []
    for low, high in spans:
        low, high = max(low, 40.0), min(high, 240.0)
        if low > high:
            continue
        if merged and low <= merged[-1][1]:
            merged[-1][1] = max(merged[-1][1], high)
        else:
            merged.append([low, high])
    words = ", ".join(f"{low:.1f} to {high:.1f}" for low, high in merged) or "none"
    return AnalysisError(
        "tempo-too-far",
        f"No bar can be danced at this tempo without playing more than {choice.max_stretch:g} times faster or slower.",
        remedy=f"Tempi that work: {words} beats a minute. Or raise max_stretch.",
        ranges=merged,
    )


def _no_edges(graph: BarGraph) -> AnalysisError:
    least = threshold_for_two(graph)
    reason = "no threshold gives two bars" if least is None else f"a threshold of {least:.4f} gives two bars"
    return AnalysisError(
        "no-edges",
        f"No bar leads to another and back at the threshold {graph.threshold:.4f}; {reason}.",
        remedy="Raise the threshold, add clips, or allow_repeat." if least is None else f"Use threshold={least:.4f}.",
        threshold=least,
    )


def find_allowed_bars(
    clips: Sequence[Clip], bars: AllBars, kept: NDArray[np.bool_], length: int, wishes: Sequence[Wish]
) -> NDArray[np.bool_]:
    """Return (length, B) the bars allowed at each position. A bar has a label that covers at least half of it."""
    allowed = np.tile(kept, (length, 1))
    for wish in wishes:
        fits = np.ones(len(bars), dtype=bool)
        if wish.bars:
            fits &= np.isin(np.arange(len(bars)), wish.bars)
        if wish.document is not None:
            owners = [index for index, clip in enumerate(clips) if clip.motion.document == wish.document]
            fits &= np.isin(bars.owners, owners)
        if wish.label is not None:
            fits &= _find_labelled(clips, bars, wish.label)
        if wish.position is None:
            allowed &= fits
        elif -length <= wish.position < length:
            allowed[wish.position] &= fits
    return allowed


def _find_labelled(clips: Sequence[Clip], bars: AllBars, label: str) -> NDArray[np.bool_]:
    labelled = np.zeros(len(bars), dtype=bool)
    for bar in range(len(bars)):
        first, last = half_up(bars.frames[bar, 0]), half_up(bars.frames[bar, 3])
        covered = np.zeros(last - first + 1, dtype=bool)
        for name, start, end in clips[bars.owners[bar]].motion.labels:
            if name == label:
                covered[max(0, start - first) : max(0, end + 1 - first)] = True
        labelled[bar] = covered.mean() >= 0.5
    return labelled


def dance_of(
    clips: Sequence[Clip],
    bars: AllBars,
    plan: Plan,
    fps: float,
    blend: Blend = "hold",
    blend_beats: float = 1.0,
    warp: Warp = "beats",
    placement: Placement = "cloud",
    frames: int | None = None,
) -> Dance:
    """The motion of a plan at a frame rate, as its bars lead: `stage_dance` places it.

    frames: of the motion, up to the end of its grid by default; its last pose is held.
    """
    runs = segments(
        plan.path, plan.natural, bars.frames, bars.entries, bars.leaves, plan.grid, warp, blend == "classic"
    )
    owners = [int(bars.owners[plan.path[run.first]]) for run in runs]
    jumps = plan.transforms[[not natural for natural in plan.natural]]
    frames = frames or frame_count(plan.grid, fps)
    return assemble(clips, owners, runs, jumps, frames, fps, blend, blend_beats, placement)


def stage_dance(clips: Sequence[Clip], plan: Plan, dance: Dance, fps: float, choice: Choice) -> Plan:
    """The plan with turns that keep its dance on the stage, if there is one."""
    if choice.stage is None:
        return plan
    others = None if choice.company is None else choice.company.ways
    turns = fit_to_stage(
        dance,
        clips[0],
        plan.grid,
        fps,
        choice.stage,
        plan.turns,
        plan.start,
        choice.most_turn,
        choice.place,
        others,
    )
    return replace(plan, turns=turns)


def turn_dance(clips: Sequence[Clip], plan: Plan, dance: Dance, fps: float, choice: Choice) -> Dance:
    """The dance with the turns of its plan; on a stage it starts at its place, else the middle."""
    if choice.stage is None and not plan.start:
        return dance
    place = None if choice.stage is None else choice.place
    return place_dance(dance, clips[0], plan.grid, fps, plan.turns, plan.start, place)
