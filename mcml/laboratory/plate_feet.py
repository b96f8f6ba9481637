"""Feet on force plates: which foot loads which plate, and the force of the ground on each foot.

A load is that of a foot if the centre of pressure is near its line from heel to toe. Loads of both feet, or of none
that is seen, belong to no foot: their forces are unknown, not 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from mcml.laboratory.force_plates import LEAST_FORCE, Plate, PlateForces
from mcml.laboratory.gait_events import SIDES, GaitEvent, Kind, Side, WalkerPaths
from mcml.motion.skeleton import Array

NEAR: Final = 0.1
"""Metres from the line between heel and toe within which a centre of pressure is that of the foot."""

SAME_EVENT: Final = 0.15
"""Seconds between an event of the positions and one of a plate that are the same."""

_SHORTEST: Final = 0.12
"""Seconds of the shortest load that is a step."""

_LEAST_PEAK: Final = 150.0
"""Newtons that a step reaches."""

_MIDDLE: Final = 0.5
"""Of the line from heel to toe."""

_MOST_OF_OTHER: Final = 0.2
"""Share of a load in which the other foot may be nearer."""


@dataclass(frozen=True)
class Load:
    """Frames `first` to before `end` in which a plate is loaded. side: of the foot, None where it is not clear."""

    plate: int
    first: int
    end: int
    side: Side | None


@dataclass(frozen=True, eq=False)
class FootForces:
    """The reaction of the ground on one foot, in the axes of the laboratory; NaN where it stands on no plate.

    force: (n, 3) newtons. centre_of_pressure: (n, 3) metres. free_moment: (n,) newton metres about the vertical.
    """

    force: Array
    centre_of_pressure: Array
    free_moment: Array


def find_loads(plates: Sequence[PlateForces], paths: WalkerPaths) -> tuple[Load, ...]:
    """Find the loads of all plates, with the feet that they are of.

    plates: forces in each frame. paths: of the same frames, in metres of the laboratory.
    """
    return tuple(load for number, plate in enumerate(plates) for load in _loads_of(number, plate, paths))


def sum_forces(plates: Sequence[PlateForces], loads: Sequence[Load], side: Side) -> FootForces:
    """Sum the forces on a foot, which may stand on several plates. Frames with a load of no clear foot are unknown."""
    count = len(plates[0].force) if plates else 0
    force, pressure, turning = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count)
    weight, is_unclear, moment = np.zeros(count), np.zeros(count, bool), np.zeros((count, 3))
    for load in loads:
        some, plate = slice(load.first, load.end), plates[load.plate]
        if load.side is None:
            is_unclear[some] = True
        elif load.side == side:
            upward = plate.force[some] @ plate.vertical
            force[some] += plate.force[some]
            pressure[some] += upward[:, None] * plate.centre_of_pressure[some]
            moment[some] += np.cross(plate.centre_of_pressure[some], plate.force[some])
            turning[some] += plate.free_moment[some]
            weight[some] += upward
    unknown = is_unclear | (weight <= 0)
    weight[unknown] = np.nan
    centre = pressure / weight[:, None]
    # Moments of several plates about their common centre of pressure.
    about = moment - np.cross(centre, force)
    vertical = plates[0].vertical if plates else np.zeros(3)
    return FootForces(np.where(unknown[:, None], np.nan, force), centre, turning + about @ vertical)


def is_whole_step(load: Load, plate: Plate, paths: WalkerPaths) -> bool:
    """Whether a load begins with a heel and ends with a toe on the plate, without the other foot, inside the record."""
    if load.side is None or load.first == 0 or load.end >= len(paths):
        return False
    other = SIDES[1 - SIDES.index(load.side)]
    ends = [load.first, load.end - 1]
    middle = (paths.heels[other][ends] + paths.toes[other][ends]) / 2
    heel, toe = paths.heels[load.side][ends[:1]], paths.toes[load.side][ends[1:]]
    own = bool(plate.has_inside(heel).all() and plate.has_inside(toe).all())
    return own and not plate.has_inside(middle).any()


def is_rolled_over(load: Load, pressure: Array, paths: WalkerPaths) -> bool:
    """Whether a load inside the record begins in the half of the heel and ends in that of the toe, the other foot away.

    It tells whole steps where no surface of a plate is known. pressure: (n, 3) centre of pressure in all frames.
    """
    if load.side is None or load.first == 0 or load.end >= len(paths):
        return False
    other = SIDES[1 - SIDES.index(load.side)]
    tenth = max(1, (load.end - load.first) // 10)
    for some, is_end in ((slice(load.first, load.first + tenth), False), (slice(load.end - tenth, load.end), True)):
        away, share = _distance(pressure[some], paths.heels[load.side][some], paths.toes[load.side][some], paths.up)
        beside = _distance(pressure[some], paths.heels[other][some], paths.toes[other][some], paths.up)[0]
        own = share[away <= NEAR]
        if not len(own) or (np.median(own) >= _MIDDLE) != is_end or (beside <= NEAR).any():
            return False
    return True


def find_step_events(
    loads: Sequence[Load],
    plates: Sequence[Plate],
    forces: Sequence[PlateForces],
    paths: WalkerPaths,
    sampling: tuple[int, float],
    read_upward: Callable[[int, int], Array | None],
) -> list[GaitEvent]:
    """Find the strikes and offs of whole steps, at the rate of the plates, in seconds from the first frame.

    forces: on each plate in these frames, for plates without a known surface. sampling: samples of a plate in a frame,
    and in a second. read_upward: returns the upward force on a plate (its place among the plates) in all samples of a
    frame and the following one, None where these do not follow in the file.
    """
    samples, rate = sampling
    events = []
    for load in loads:
        plate, pressure = plates[load.plate], forces[load.plate].centre_of_pressure
        is_whole = is_whole_step(load, plate, paths) if plate.has_surface else is_rolled_over(load, pressure, paths)
        if load.side is None or not is_whole:
            continue
        kinds: tuple[tuple[Kind, int, int], ...] = (("strike", load.first, 1), ("off", load.end - 1, 0))
        for kind, at, before in kinds:
            upward = read_upward(load.plate, at - before)
            if upward is None:
                continue
            place = find_crossing(upward, rising=kind == "strike")
            seconds = at / paths.rate + (place - before * samples) / rate
            if np.isfinite(seconds):
                events.append(GaitEvent(seconds, load.side, kind, "plate"))
    return events


def find_crossing(upward: Array, *, rising: bool) -> float:
    """Return the place, between samples, at which a vertical force (n,) first reaches LEAST_FORCE, or last leaves it.

    NaN where it does not.
    """
    above = np.nan_to_num(upward) >= LEAST_FORCE
    steps = np.flatnonzero(above[1:] & ~above[:-1] if rising else above[:-1] & ~above[1:])
    if not len(steps):
        return float("nan")
    at = int(steps[0] if rising else steps[-1])
    return at + float((LEAST_FORCE - upward[at]) / (upward[at + 1] - upward[at]))


def prefer_plates(found: Sequence[GaitEvent], plates: Sequence[GaitEvent]) -> tuple[GaitEvent, ...]:
    """Replace events of positions by those of force plates for the same foot within SAME_EVENT; others stay."""
    left = list(found)
    for event in plates:
        near = [
            other
            for other in left
            if (other.side, other.kind) == (event.side, event.kind) and abs(other.seconds - event.seconds) <= SAME_EVENT
        ]
        for other in near:
            left.remove(other)
    return tuple(sorted([*left, *plates]))


def _loads_of(number: int, plate: PlateForces, paths: WalkerPaths) -> list[Load]:
    upward = np.nan_to_num(plate.force @ plate.vertical)
    edges = np.diff((upward >= LEAST_FORCE).astype(np.int8), prepend=0, append=0)
    runs = zip(np.flatnonzero(edges == 1).tolist(), np.flatnonzero(edges == -1).tolist(), strict=True)
    loads = []
    for first, end in runs:
        is_step = end - first >= _SHORTEST * paths.rate and upward[first:end].max() >= _LEAST_PEAK
        side = _side_of(plate.centre_of_pressure[first:end], first, paths) if is_step else None
        loads.append(Load(number, first, end, side))
    return loads


def _side_of(pressure: Array, first: int, paths: WalkerPaths) -> Side | None:
    """The foot whose line from heel to toe is near a centre of pressure (n, 3) from frame `first` on."""
    some = slice(first, first + len(pressure))
    away: Mapping[Side, Array] = {
        side: _distance(pressure, paths.heels[side][some], paths.toes[side][some], paths.up)[0] for side in SIDES
    }
    middle = slice(len(pressure) // 4, len(pressure) - len(pressure) // 4)
    for side, other in (SIDES, SIDES[::-1]):
        known = away[side][middle][np.isfinite(away[side][middle])]
        if not len(known) or np.median(known) > NEAR:
            continue
        both = np.isfinite(away[side]) & np.isfinite(away[other])
        if both.any() and (away[other][both] < away[side][both]).mean() > _MOST_OF_OTHER:
            continue
        return side
    return None


def _distance(points: Array, begin: Array, end: Array, up: Array) -> tuple[Array, Array]:
    """(level distances (n,) of points from the lines between two other points; shares (n,) of these lines there)."""
    points, begin, end = (place - np.outer(place @ up, up) for place in (points, begin, end))
    line = end - begin
    with np.errstate(invalid="ignore", divide="ignore"):
        share = ((points - begin) * line).sum(axis=1) / (line * line).sum(axis=1)
    nearest = begin + np.clip(np.nan_to_num(share), 0.0, 1.0)[:, None] * line
    return np.linalg.norm(points - nearest, axis=1), share
