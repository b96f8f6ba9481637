"""Spatio-temporal parameters of gait: strides, their times and lengths, means by side, symmetry, speed of a belt.

A stride goes from a strike of a foot to its next one. Places of feet are those of the toes, as laboratories measure
them. Sources: M. W. Whittle, "Gait Analysis: An Introduction" (2007), chapter 2 (definitions of stride, step, stance
and support); R. O. Robinson, W. Herzog and B. M. Nigg, "Use of force platform variables to quantify the effects of
chiropractic manipulation on gait symmetry", Journal of Manipulative and Physiological Therapeutics 10 (1987), pages
172-176 (symmetry index).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from mcml.laboratory.gait_events import (
    RUNNING,
    SIDES,
    GaitEvent,
    Side,
    WalkerPaths,
    between,
    bridge_gaps,
    find_facing,
    measure_duty,
    smooth,
    times_of,
)
from mcml.motion.skeleton import Array

OTHER: Final[Mapping[Side, Side]] = {"left": "right", "right": "left"}
BELT: Final = 0.15
"""Metres a second of a planted foot, above which it stands on a belt."""

_STAYS = 0.25
"""Part of the speed of the feet up to which the pelvis may travel on a belt."""
_PLANTED = (0.25, 0.55)
"""Part of a stance in which the whole foot is on the ground."""
_MEDIANS, _LEAST = 3.0, 5
"""A stride is an outlier beyond so many median absolute deviations of stride time, among at least so many strides."""
EXCLUDED: Final = "excluded by a label"
"""Why a stride that people leave out is rejected."""
OUTLIER_RULE: Final = (
    "stride time beyond median ± 3 median absolute deviations (at least two frames; of 5 or more strides)"
)


@dataclass(frozen=True)
class Parameter:
    """A measure of each stride. name: of the field of a stride. unit: "" for none. how: the formula."""

    name: str
    unit: str
    how: str


PARAMETERS: Final = (
    Parameter("stride_time", "s", "from a strike to the next one of the same foot"),
    Parameter("step_time", "s", "from the strike of the other foot to the end of the stride"),
    Parameter("cadence", "steps/min", "120 / stride time"),
    Parameter("stride_length", "m", "level distance of the toes at both strikes"),
    Parameter(
        "step_length", "m", "from the other foot's toes at its strike to this foot's at its next, along the stride"
    ),
    Parameter("step_width", "m", "of the other foot's toes from the line of the stride; negative if feet cross over"),
    Parameter("speed", "m/s", "stride length / stride time"),
    Parameter("stance", "%", "from strike to off, of stride time"),
    Parameter("double_support", "%", "both feet on the ground, of stride time; unknown in running"),
    Parameter("single_support", "%", "the other foot in the air, of stride time; unknown in running"),
)


@dataclass(frozen=True)
class Stride:
    """A stride of a side; times in seconds from the first frame, values as in PARAMETERS, NaN where not measured.

    end: the next strike. off: when the foot leaves the ground. other_off, other_strike: of the other foot. rejected:
    the rule that leaves it out of means, "" for none.
    """

    side: Side
    begin: float
    end: float
    off: float
    other_off: float
    other_strike: float
    stride_time: float
    step_time: float
    cadence: float
    stride_length: float
    step_length: float
    step_width: float
    speed: float
    stance: float
    double_support: float
    single_support: float
    rejected: str = ""


@dataclass(frozen=True)
class Exclusion:
    """Frames from 0, both included, whose strides people leave out. side: of these alone, None for both."""

    first: int
    last: int
    side: Side | None = None


@dataclass(frozen=True)
class Strides:
    """strides: in order of time. incomplete: number of strides by side that lack an event or have too many, or whose
    events are in no order of walking or running."""

    strides: tuple[Stride, ...]
    incomplete: Mapping[Side, int]


@dataclass(frozen=True)
class Summary:
    """A parameter of a side over strides: mean, standard deviation (n - 1) and number; NaN where not measured."""

    mean: float
    sd: float
    n: int


@dataclass(frozen=True)
class BeltSpeed:
    """speed: metres a second of planted feet, backwards; NaN where unknown. sd: from stance to stance. n: stances.
    is_belt: whether the feet move on a belt, under a pelvis that stays."""

    speed: float
    sd: float
    n: int
    is_belt: bool


def measure_strides(walker: WalkerPaths, events: Sequence[GaitEvent], belt_speed: float = 0.0) -> Strides:
    """Measure the strides of both sides.

    belt_speed: metres a second that the ground moves backwards, along the mean facing.
    """
    ways = {side: _travel(walker, walker.toes[side], belt_speed) for side in SIDES}
    found: list[Stride] = []
    incomplete: dict[Side, int] = dict.fromkeys(SIDES, 0)
    for side in SIDES:
        own_offs = times_of(events, side, "off")
        other_offs, other_strikes = times_of(events, OTHER[side], "off"), times_of(events, OTHER[side], "strike")
        for begin, end in pairwise(times_of(events, side, "strike")):
            inside = [between(times, begin, end) for times in (own_offs, other_offs, other_strikes)]
            if any(len(times) != 1 for times in inside):
                incomplete[side] += 1
                continue
            (off,), (other_off,), (other_strike,) = inside
            if not (other_off < other_strike < off or off < other_strike < other_off):
                incomplete[side] += 1
                continue
            found.append(_stride(walker, ways, side, (begin, end, off, other_off, other_strike)))
    return Strides(tuple(sorted(found, key=lambda stride: stride.begin)), incomplete)


def reject_outliers(strides: Sequence[Stride], rate: float) -> tuple[Stride, ...]:
    """Mark strides whose time is an outlier of their side (OUTLIER_RULE). rate: frames a second."""
    marked = list(strides)
    for side in SIDES:
        places = [place for place, stride in enumerate(marked) if stride.side == side]
        times = np.array([marked[place].stride_time for place in places])
        if len(times) < _LEAST:
            continue
        middle = float(np.median(times))
        # Two events, each of the nearest frame, say no less.
        limit = max(_MEDIANS * float(np.median(np.abs(times - middle))), 2 / rate)
        for place in places:
            if abs(marked[place].stride_time - middle) > limit:
                marked[place] = replace(marked[place], rejected=OUTLIER_RULE)
    return tuple(marked)


def exclude_strides(strides: Sequence[Stride], exclusions: Sequence[Exclusion], rate: float) -> tuple[Stride, ...]:
    """Mark strides that share time with frames that people exclude (EXCLUDED). rate: frames a second."""
    return tuple(
        replace(stride, rejected=EXCLUDED)
        if any(
            stride.begin * rate < each.last + 0.5 and stride.end * rate > each.first - 0.5
            for each in exclusions
            if each.side in (None, stride.side)
        )
        else stride
        for stride in strides
    )


def summarise(strides: Sequence[Stride], side: Side, name: str) -> Summary:
    """Summarise a parameter over the strides of a side that are not rejected. name: of a row of PARAMETERS."""
    values = np.array([getattr(stride, name) for stride in strides if stride.side == side and not stride.rejected])
    values = values[np.isfinite(values)]
    sd = float(values.std(ddof=1)) if len(values) > 1 else float("nan")
    return Summary(float(values.mean()) if len(values) else float("nan"), sd, len(values))


def symmetry(left: float, right: float) -> float:
    """Return the symmetry index in percent (Robinson 1987), 0 for equal sides; NaN where a side is unknown.

    >>> symmetry(0.55, 0.45)
    20.0
    """
    middle = (left + right) / 2
    return round(100 * (left - right) / middle, 9) if middle else float("nan")


def measure_belt(walker: WalkerPaths, events: Sequence[GaitEvent]) -> BeltSpeed:
    """Measure how fast planted feet move backwards: the speed of a belt, nearly 0 on the ground."""
    facing = find_facing(walker)
    stances = []
    for side in SIDES:
        offs = times_of(events, side, "off")
        for strike, end in pairwise([*times_of(events, side, "strike"), np.inf]):
            stances += [(side, strike, off) for off in between(offs, strike, end)[:1]]
    corner = 20.0 if measure_duty(events) < RUNNING else 10.0
    backwards = {side: _backwards(walker, side, facing, corner) for side in SIDES}
    speeds = []
    for side, strike, off in stances:
        low = int(np.ceil((strike + _PLANTED[0] * (off - strike)) * walker.rate))
        high = int(np.floor((strike + _PLANTED[1] * (off - strike)) * walker.rate))
        part = backwards[side][max(0, low) : high + 1]
        if len(part) and np.isfinite(part).all():
            speeds.append(float(np.median(part)))
    if not speeds:
        return BeltSpeed(float("nan"), float("nan"), 0, False)
    speed = float(np.median(speeds))
    sd = float(np.std(speeds, ddof=1)) if len(speeds) > 1 else float("nan")
    return BeltSpeed(speed, sd, len(speeds), bool(speed > BELT and _travel_speed(walker) <= _STAYS * speed))


def _backwards(walker: WalkerPaths, side: Side, facing: Array, corner: float) -> Array:
    """(n,) speed of a foot, the middle of heel and toe, against the facing direction."""
    middle = smooth(bridge_gaps((walker.heels[side] + walker.toes[side]) / 2, walker.rate), walker.rate, corner)
    if len(middle) < 2:
        return np.full(len(middle), np.nan)
    velocity = np.gradient(middle, axis=0) * walker.rate
    speeds: Array = -(velocity * facing).sum(axis=1)
    return speeds


def _travel_speed(walker: WalkerPaths) -> float:
    """Level speed of the pelvis from its first to its last place; infinite where it is not seen twice."""
    seen = np.flatnonzero(np.isfinite(walker.pelvis).all(axis=1))
    if len(seen) < 2:
        return float("inf")
    way = walker.pelvis[seen[-1]] - walker.pelvis[seen[0]]
    level = way - (way @ walker.up) * walker.up
    return float(np.linalg.norm(level)) * walker.rate / float(seen[-1] - seen[0])


def _travel(walker: WalkerPaths, places: Array, belt_speed: float) -> Array:
    """(n, 3) level places on the ground, as they would be if a belt stayed and the body travelled."""
    level = bridge_gaps(places, walker.rate)
    level = level - np.outer(level @ walker.up, walker.up)
    if belt_speed:
        facing = find_facing(walker)
        seen = facing[np.isfinite(facing).all(axis=1)]
        mean = seen.mean(axis=0) if len(seen) else np.full(3, np.nan)
        seconds = np.arange(len(level)) / walker.rate
        level = level + np.outer(seconds * belt_speed, mean / np.linalg.norm(mean))
    return level


def _place_at(way: Array, seconds: float, rate: float) -> Array:
    """(3,) of (n, 3) in the frame nearest to a time, as laboratories measure it; NaN outside or in a gap."""
    frame = int(np.rint(seconds * rate))
    place: Array = way[frame] if 0 <= frame < len(way) else np.full(3, np.nan)
    return place


def _stride(
    walker: WalkerPaths, ways: Mapping[Side, Array], side: Side, times: tuple[float, float, float, float, float]
) -> Stride:
    begin, end, off, other_off, other_strike = times
    lasts = end - begin
    start, goal = (_place_at(ways[side], at, walker.rate) for at in (begin, end))
    across = _place_at(ways[OTHER[side]], other_strike, walker.rate)
    along = goal - start
    length = float(np.linalg.norm(along))
    direction = along / length if length > 0 else np.full(3, np.nan)
    outwards = np.cross(direction, walker.up) * (1.0 if side == "left" else -1.0)
    walks = other_off < off
    supports = (100 * ((other_off - begin) + (off - other_strike)) / lasts, 100 * (other_strike - other_off) / lasts)
    double, single = supports if walks else (float("nan"), float("nan"))
    return Stride(
        side=side,
        begin=begin,
        end=end,
        off=off,
        other_off=other_off,
        other_strike=other_strike,
        stride_time=lasts,
        step_time=end - other_strike,
        cadence=120 / lasts,
        stride_length=length,
        step_length=float((goal - across) @ direction),
        step_width=float((across - start) @ outwards),
        speed=length / lasts,
        stance=100 * (off - begin) / lasts,
        double_support=double,
        single_support=single,
    )
