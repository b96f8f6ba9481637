"""Several dancers of one dance: in unison, in canon, or each on a path of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.edits.mirroring import mirrored_poses
from mcml.motion.hub import rest_of, walked
from mcml.motion.sides import Sagittal, sagittal
from mcml.motion.skeleton import Array
from mcml_service.analysis.dance.assembly import Dance
from mcml_service.analysis.dance.bar_graph import BarGraph
from mcml_service.analysis.dance.choreography import Choice, Plan, plan_dance, stage_dance, turn_dance
from mcml_service.analysis.dance.floor import Company, metres_of
from mcml_service.analysis.dance.group_dance.formation import find_room, form_lines
from mcml_service.analysis.dance.sources import Clip
from mcml_service.analysis.dance.stage import NEAR, Points, Stage
from mcml_service.analysis.dance.time_warp import frame_count, motion_grid
from mcml_service.analysis.interface import AnalysisError

TRIES = 4
"""Paths of a dancer that are tried to keep away from the others."""
_UP = np.array([0.0, 1.0, 0.0])
Make = Callable[[Plan, int], Dance]
"""The motion of a plan with a number of frames."""


@dataclass(frozen=True)
class Group:
    """Several dancers. delay: bars of music in canon. spacing: metres. mirrored: every second one, not if free."""

    count: int
    mode: Literal["unison", "canon", "free"] = "unison"
    delay: int = 1
    spacing: float = 1.2
    mirrored: bool = False


@dataclass(frozen=True)
class Dancer:
    """One dancer. dance: placed on the floor, as many frames as the others."""

    plan: Plan
    dance: Dance


def make_dancers(
    clips: Sequence[Clip], graph: BarGraph, grid: Array, fps: float, choice: Choice, wish: Group | None, make: Make
) -> tuple[list[Dancer], Choice]:
    """The dancers of a dance, and the choice that they follow: for several of them with a facing, and its room.

    grid: (4 N + 1,) music beats. make: the motion of a plan. Raises AnalysisError as `plan_dance`, and
    `stage-too-small`, `canon-too-long`, `sides-unknown`.
    """
    frames = frame_count(grid, fps)
    if wish is None:
        plan = plan_dance(clips, graph, grid, choice)
        return [_dance(clips, plan, fps, choice, make, frames)], choice
    if choice.facing is None and _knows_sides(clips[0]):
        choice = replace(choice, facing=0.0)
    elif choice.facing is None and wish.mirrored:
        raise AnalysisError(
            "sides-unknown",
            f"{clips[0].motion.name}: no joints tell left from right, so a dancer cannot be mirrored.",
            remedy="Leave mirrored out, or name joints of both sides.",
            document=clips[0].motion.document,
        )
    places = form_lines(wish.count, wish.spacing, choice.facing or 0.0)
    room = None if choice.stage is None else find_room(choice.stage, places)
    if choice.stage is not None and room is None:
        raise AnalysisError(
            "stage-too-small",
            f"{wish.count} dancers, {wish.spacing:g} m apart, do not fit on the stage, {choice.stage.text}.",
            remedy="Use a larger stage, or a smaller spacing.",
        )
    if wish.mode == "free":
        return _dance_freely(clips, graph, grid, fps, choice, places, make, frames), choice
    choice = replace(choice, stage=room)
    return _dance_alike(clips, graph, grid, fps, choice, wish, places, make, frames), choice


def find_ways(dancers: Sequence[Dancer], clip: Clip) -> Points:
    """(N, F) places of the dancers' roots on the floor, metres."""
    roots = np.array([dancer.dance.translations[:, clip.motion.skeleton.roots[0]] for dancer in dancers])
    ways: Points = (roots[..., 0] + 1j * roots[..., 2]) * metres_of(clip)
    return ways


def bars_of_each(bars: int, wish: Group | None) -> int:
    """Bars of music that each dancer dances: in canon fewer than all. Raises AnalysisError `canon-too-long`."""
    if wish is None or wish.mode != "canon":
        return bars
    later = wish.delay * (wish.count - 1)
    if later >= bars:
        raise AnalysisError(
            "canon-too-long",
            f"The last of {wish.count} dancers starts {later} bars after the first, but the dance has {bars} bars.",
            remedy=f"Ask for more than {later} bars, or a shorter delay.",
            least=later + 1,
        )
    return bars - later


def _dance(clips: Sequence[Clip], plan: Plan, fps: float, choice: Choice, make: Make, frames: int) -> Dancer:
    dance = make(plan, frames)
    plan = stage_dance(clips, plan, dance, fps, choice)
    return Dancer(plan, turn_dance(clips, plan, dance, fps, choice))


def _dance_alike(
    clips: Sequence[Clip],
    graph: BarGraph,
    grid: Array,
    fps: float,
    choice: Choice,
    wish: Group,
    places: Points,
    make: Make,
    frames: int,
) -> list[Dancer]:
    """Dancers on one path, each at its place; in canon each some bars of music after the one before."""
    own = bars_of_each((len(grid) - 1) // 4, wish)
    first = _dance(clips, plan_dance(clips, graph, grid[: 4 * own + 1], choice), fps, choice, make, frames)
    dancers = []
    for index, place in enumerate(places):
        plan, dance = first.plan, first.dance
        if wish.mode == "canon" and index:
            start = 4 * index * wish.delay
            plan = replace(plan, grid=motion_grid(grid[start : start + 4 * own + 1], plan.pulse))
            dance = turn_dance(clips, plan, make(plan, frames), fps, choice)
        if wish.mirrored and index % 2:
            dance = _mirror(dance, clips[0], choice.facing or 0.0)
        dancers.append(Dancer(plan, _shift(dance, clips[0], place)))
    return dancers


def _dance_freely(
    clips: Sequence[Clip],
    graph: BarGraph,
    grid: Array,
    fps: float,
    choice: Choice,
    places: Points,
    make: Make,
    frames: int,
) -> list[Dancer]:
    """Dancers on paths of their own, one after another, each away from those before it."""
    dancers: list[Dancer] = []
    stage = choice.stage or Stage(np.inf)
    for place in places:
        wanted = replace(choice, stage=stage, place=complex(place))
        if dancers:
            ways, paths = find_ways(dancers, clips[0]), np.array([dancer.plan.path for dancer in dancers])
            wanted = replace(wanted, pulse=dancers[0].plan.pulse, company=Company(ways, fps, paths))
        tried: list[tuple[float, Dancer]] = []
        for seed in range(choice.seed, choice.seed + TRIES):
            plan = plan_dance(clips, graph, grid, replace(wanted, seed=seed))
            dancer = _dance(clips, plan, fps, wanted, make, frames)
            ways = find_ways([*dancers, dancer], clips[0])
            outside = float(stage.outside(ways[-1]).max())
            near = float(np.abs(ways[:-1] - ways[-1]).min(initial=np.inf))
            tried.append((max(outside, NEAR - near), dancer))
            if not dancers or (near >= NEAR and not outside):
                break
        dancers.append(min(tried, key=lambda pair: pair[0])[1])
    return dancers


def _knows_sides(clip: Clip) -> bool:
    motion = clip.motion
    positions, _ = walked(motion.skeleton, motion.translations[:1], motion.rotations[:1])
    try:
        sagittal(motion.skeleton, positions[0], _UP)
    except ConversionError:
        return False
    return True


def _mirror(dance: Dance, clip: Clip, facing: float) -> Dance:
    """The dance with left and right exchanged, at the plane through its first place in the direction it faces."""
    skeleton = clip.motion.skeleton
    normal = np.array([np.cos(facing), 0.0, -np.sin(facing)])
    plane = Sagittal(normal, dance.translations[0, skeleton.roots[0]])
    moved, turned = mirrored_poses(skeleton, rest_of(skeleton), dance.translations, dance.rotations, plane)
    return replace(dance, translations=moved, rotations=turned)


def _shift(dance: Dance, clip: Clip, place: complex) -> Dance:
    """The dance moved on the floor. place: metres."""
    shift = np.array([place.real, 0.0, place.imag]) / metres_of(clip)
    translations = dance.translations.copy()
    translations[:, list(clip.motion.skeleton.roots)] += shift
    return replace(dance, translations=translations)
