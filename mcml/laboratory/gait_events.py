"""Gait events from positions: when each foot strikes the ground, and when it leaves it.

One method for markers and joints, for the ground and for belts, straight or in turns. All directions are relative to
where the pelvis faces, because a body on a belt does not travel and a body in a turn travels in every direction.

Sources: J. A. Zeni, J. G. Richards and J. S. Higginson, "Two simple methods for determining gait events during
treadmill and overground walking using kinematic data", Gait & Posture 27 (2008), pages 710-714: a foot strikes about
when the heel is farthest in front of the pelvis, and leaves when the toe is farthest behind it. D. A. Winter,
"Biomechanics and Motor Control of Human Movement" (2009), section 3.4.4: Butterworth filters that run both ways. The
strike is refined by the upward acceleration of the heel, which has a peak where the ground stops it (A. Hreljac and
R. N. Marshall, Journal of Biomechanics 33 (2000), pages 783-786, use the same peak).
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Final, Literal, TypeAlias

import numpy as np
import scipy

from mcml.motion.skeleton import Array
from mcml.motion.vectors import cross, dot, unit
from mcml.numerics.runs import find_true

Side: TypeAlias = Literal["left", "right"]
Kind: TypeAlias = Literal["strike", "off"]
Source: TypeAlias = Literal["label", "plate", "positions"]

SIDES: Final[tuple[Side, Side]] = ("left", "right")
KINDS: Final[tuple[Kind, Kind]] = ("strike", "off")
LONGEST_BRIDGE: Final = 0.1
"""Seconds of the longest gap that a line bridges."""
RUNNING: Final = 0.45
"""Share of a stride in which a foot is on the ground, below which the gait is running."""

_FACING, _SLOW, _FAST = 1.0, 10.0, 20.0
"""Corner frequencies in Hz: of the facing direction, of positions, and of accelerations."""
_TWICE = 0.802
"""A second-order filter that runs twice has its corner at this part of the corner of one run (Winter 2009)."""
_PROMINENCE, _APART = 0.1, 0.3
"""Of a maximum: leg lengths above the minima beside it, and seconds from the next one."""
_STRIKE_WINDOW, _STRIKE_DELAY = 0.10, 0.035
"""Seconds after the heel is farthest in front: where a strike is, and the delay where no acceleration tells."""
_OFF_WINDOW = (-0.08, 0.02)
"""Seconds around the time when the toe is farthest behind, where a running foot leaves the ground."""


@dataclass(frozen=True, order=True)
class GaitEvent:
    """A foot that strikes the ground or leaves it.

    seconds: from the first frame. source: a label of the clip, a force plate, or the positions of feet and pelvis.
    """

    seconds: float
    side: Side
    kind: Kind
    source: Source


@dataclass(frozen=True, eq=False)
class WalkerPaths:
    """Where feet and pelvis of a walking body are.

    heels, toes: (n, 3) by side, NaN where not seen; ankles and toe joints of a skeleton will do. pelvis: (n, 3).
    across: (n, 3) from the right to the left side of the pelvis. up: (3,) unit vector. rate: frames a second. All
    lengths are in one unit; metres where speeds are to be compared with limits.
    """

    heels: Mapping[Side, Array]
    toes: Mapping[Side, Array]
    pelvis: Array
    across: Array
    up: Array
    rate: float

    def __len__(self) -> int:
        return len(self.pelvis)

    @property
    def leg(self) -> float:
        """Height of the pelvis above the heels, the median of the higher side; NaN where both are never seen."""
        heights = [(self.pelvis - self.heels[side]) @ self.up for side in SIDES]
        medians = [float(np.median(some)) for all_ in heights if len(some := all_[np.isfinite(all_)])]
        return max(medians, default=float("nan"))


@dataclass(frozen=True, eq=False)
class EventsFromPositions:
    """events: in order of time. is_running: whether feet are on the ground for less than 0.45 of a stride; None where
    no stride tells. duty_factor: that share, NaN where unknown."""

    events: tuple[GaitEvent, ...]
    is_running: bool | None
    duty_factor: float


def bridge_gaps(values: Array, rate: float) -> Array:
    """Return (n, k) values with a line over each gap of at most 0.1 s; longer ones, and ends, stay NaN.

    A frame in which one value is missing is a gap of all. rate: frames a second.
    """
    bridged = np.array(values, dtype=np.float64)
    seen = np.asarray(np.isfinite(bridged).all(axis=1))
    bridged[~seen] = np.nan
    gaps = find_true(np.logical_not(seen))
    short = (gaps[:, 0] > 0) & (gaps[:, 1] < len(seen)) & (gaps[:, 1] - gaps[:, 0] <= round(LONGEST_BRIDGE * rate))
    if not short.any():
        return bridged
    frames = np.flatnonzero(seen)
    rows = np.concatenate([np.arange(first, end) for first, end in gaps[short]])
    for column in range(bridged.shape[1]):
        bridged[rows, column] = np.interp(rows, frames, bridged[frames, column])
    return bridged


def smooth(values: Array, rate: float, corner: float) -> Array:
    """Return (n, k) values after a Butterworth filter of fourth order without delay, each stretch between gaps by
    itself.

    corner: Hz; from half of the rate on nothing is filtered.
    """
    smoothed = np.array(values, dtype=np.float64)
    limit = corner / _TWICE
    if limit >= 0.5 * rate:
        return smoothed
    sections = _low_pass(limit, rate)
    pad = int(np.ceil(rate / corner))
    for first, end in find_true(np.asarray(np.isfinite(smoothed).all(axis=1))):
        if end - first > 2:
            part = smoothed[first:end]
            smoothed[first:end] = scipy.signal.sosfiltfilt(sections, part, axis=0, padlen=min(pad, end - first - 1))
    return smoothed


@lru_cache(maxsize=64)
def _low_pass(corner: float, rate: float) -> Array:
    """Second-order sections of the Butterworth filter. To design one takes longer than to run it over a short clip."""
    sections: Array = scipy.signal.butter(2, corner, fs=rate, output="sos")
    return sections


def find_facing(walker: WalkerPaths) -> Array:
    """(n, 3) level unit vectors to where the pelvis faces, slower than 1 Hz; NaN in long gaps."""
    across = bridge_gaps(walker.across, walker.rate)
    facing = cross(across, np.broadcast_to(walker.up, across.shape))
    return unit(smooth(unit(facing), walker.rate, _FACING))


def find_events(walker: WalkerPaths) -> EventsFromPositions:
    """Find strikes and offs of both feet; none where feet or pelvis are not seen, or do not swing."""
    facing = find_facing(walker)
    strikes = {side: _find_strikes(walker, side, facing) for side in SIDES}
    slow = {side: _find_extremes(walker, walker.toes[side], facing, -1.0) for side in SIDES}
    fast = {side: _find_running_offs(walker, side, slow[side]) for side in SIDES}
    running = _in_order(strikes, fast)
    duty = measure_duty(running)
    if np.isfinite(duty) and duty < RUNNING:
        return EventsFromPositions(running, True, duty)
    return EventsFromPositions(_in_order(strikes, slow), False if np.isfinite(duty) else None, duty)


def choose_events(by_trust: Sequence[Sequence[GaitEvent]]) -> tuple[GaitEvent, ...]:
    """Choose the strikes and the offs of each side from the first source that has any of them.

    by_trust: events of several sources, the most trusted first. One side and kind is never of two sources.
    """
    chosen: list[GaitEvent] = []
    for side in SIDES:
        for kind in KINDS:
            alike = ([event for event in some if (event.side, event.kind) == (side, kind)] for some in by_trust)
            chosen += next((some for some in alike if some), [])
    return tuple(sorted(set(chosen)))


def times_of(events: Sequence[GaitEvent], side: Side, kind: Kind) -> list[float]:
    """Seconds of the strikes or offs of a side, in order."""
    return sorted(event.seconds for event in events if event.side == side and event.kind == kind)


def between(times: Sequence[float], begin: float, end: float) -> Sequence[float]:
    """The times, which are in order, after one and before another."""
    return times[bisect_right(times, begin) : bisect_left(times, end)]


def measure_duty(events: Sequence[GaitEvent]) -> float:
    """Return the duty factor: the median share of a stride in which its foot is on the ground; NaN without a stride
    that has an off."""
    shares = []
    for side in SIDES:
        offs = times_of(events, side, "off")
        for begin, end in pairwise(times_of(events, side, "strike")):
            shares += [(off - begin) / (end - begin) for off in between(offs, begin, end)[:1]]
    return float(np.median(shares)) if shares else float("nan")


def _in_order(strikes: Mapping[Side, Sequence[float]], offs: Mapping[Side, Sequence[float]]) -> tuple[GaitEvent, ...]:
    by_kind: tuple[tuple[Kind, Mapping[Side, Sequence[float]]], ...] = (("strike", strikes), ("off", offs))
    events = (
        GaitEvent(seconds, side, kind, "positions")
        for kind, by_side in by_kind
        for side in SIDES
        for seconds in by_side[side]
    )
    return tuple(sorted(events))


def _find_extremes(walker: WalkerPaths, foot: Array, facing: Array, sign: float) -> list[float]:
    """Seconds at which a foot is farthest in front of the pelvis (sign 1) or behind it (-1)."""
    ahead = sign * dot(bridge_gaps(foot - walker.pelvis, walker.rate), facing)
    signal = smooth(ahead[:, None], walker.rate, _SLOW)[:, 0]
    leg = walker.leg
    seconds: list[float] = []
    if not leg > 0:
        return seconds
    apart = max(1.0, _APART * walker.rate)
    for first, end in find_true(np.isfinite(signal)):
        part = signal[first:end]
        peaks, _ = scipy.signal.find_peaks(part, prominence=_PROMINENCE * leg, distance=apart)
        seconds += [(int(first) + _vertex(part, int(peak))) / walker.rate for peak in peaks]
    return seconds


def _vertex(values: Array, place: int) -> float:
    """Where the parabola through a value and its neighbours has its vertex; the place itself at an end."""
    if not 0 < place < len(values) - 1:
        return float(place)
    before, here, after = values[place - 1 : place + 2]
    bend = before - 2 * here + after
    return float(place) if not bend < 0 else place + float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5))


def _upward_acceleration(walker: WalkerPaths, foot: Array) -> Array:
    """(n,) of a foot, NaN where unknown."""
    heights = bridge_gaps((foot @ walker.up)[:, None], walker.rate)
    heights = smooth(heights, walker.rate, _FAST)[:, 0]
    acceleration = np.full(len(heights), np.nan)
    acceleration[1:-1] = (heights[2:] - 2 * heights[1:-1] + heights[:-2]) * walker.rate**2
    return acceleration


def _find_strikes(walker: WalkerPaths, side: Side, facing: Array) -> list[float]:
    acceleration = _upward_acceleration(walker, walker.heels[side])
    strikes = []
    for begin in _find_extremes(walker, walker.heels[side], facing, 1.0):
        low = max(1, int(np.ceil(begin * walker.rate)))
        high = min(len(acceleration) - 2, int(np.floor((begin + _STRIKE_WINDOW) * walker.rate)))
        inside = np.arange(low, high + 1)
        here = acceleration[inside]
        # The largest value itself is often at an end of the window, where the peak is of something else.
        is_peak = (here >= acceleration[inside - 1]) & (here >= acceleration[inside + 1])
        peaks = inside[is_peak]
        if len(peaks):
            best = int(peaks[np.argmax(acceleration[peaks])])
            strikes.append(_vertex(acceleration, best) / walker.rate)
        else:
            strikes.append(begin + _STRIKE_DELAY)
    return strikes


def _find_running_offs(walker: WalkerPaths, side: Side, latest: Sequence[float]) -> list[float]:
    """Offs of a runner, whose toe moves back for some time after it has left the ground."""
    acceleration = _upward_acceleration(walker, walker.toes[side])
    offs = []
    for seconds in latest:
        low = max(0, int(np.ceil((seconds + _OFF_WINDOW[0]) * walker.rate)))
        high = min(len(acceleration) - 1, int(np.floor((seconds + _OFF_WINDOW[1]) * walker.rate)))
        part = acceleration[low : high + 1]
        if not np.isfinite(part).any():
            offs.append(seconds)
            continue
        offs.append(_vertex(acceleration, low + int(np.nanargmax(part))) / walker.rate)
    return offs
