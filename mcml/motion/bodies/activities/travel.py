"""Walks, runs, steps, turns and jumps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy

from mcml.motion.bodies.activities.activity import Activity, name_of
from mcml.motion.bodies.activities.signals import SIDES, BodySignals, confidence_of, smooth
from mcml.motion.bodies.local_fit import slopes
from mcml.motion.feet.contacts import hysteresis
from mcml.motion.skeleton import Array
from mcml.numerics.runs import Places, find_true

_MOVES, _MOVES_ON = 0.45, 0.2
"""Speeds in leg lengths a second at which travelling begins, and below which it ends."""
_STEP, _STEP_APART = 0.12, 0.18
"""Of a step: how far the feet come apart, in leg lengths; and the least seconds between two."""
_STEP_SMOOTH, _SLOW = 0.04, 0.4
"""Standard deviations in seconds of Gaussians over the distance of the feet, and over what steps leave."""
_STEPS, _STRIDE, _STEP_WAY = 3, 2, 0.25
"""Steps of a walk or a run at least; those of a clip that begins and ends within it, such as a loop of one stride; and
leg lengths that a body moves in a step at least."""
_FLIES, _FLIES_ON, _FLIES_SURELY = 0.1, 0.0, 0.3
"""Share of time in flight, less that with both feet planted, at which a run begins, below which it ends, and from
which on it is sure; in other words, duty factors of 0.45, 0.5 and 0.35."""
_TURNS, _TURNS_ON, _TURN = 30.0, 12.0, 40.0
"""Degrees a second at which a turn begins and ends, and its degrees at least."""
_FEET_GO = 0.5
"""Part of the turn of the hips that the feet turn at least; else the body only twists."""
_FEET_FOLLOW = 0.3
"""Seconds before and after a turn of the hips in which the feet turn."""
_LIFTED, _JUMP, _LEAP, _IN_AIR, _FALLS = 0.06, 0.12, 0.35, 0.12, -4.0
"""Of a jump: height of both feet in flight; at its top; at the top of one in a run; seconds in flight; and the
acceleration of the hips upwards, in leg lengths a second squared (free fall is about -11)."""
_CROUCHES = 0.5
"""Seconds before and after flight in which the body bends its knees."""


def find_travel(signals: BodySignals) -> Iterator[Activity]:
    """Walks, runs and single steps.

    A run differs from a walk by its flight: each foot is planted for less than half of the time (duty factor below 0.5,
    Alexander 1989), and the hips are highest when the feet are farthest apart, where in a walk they are lowest
    (Cavagna, Heglund, Taylor, "Mechanical work in terrestrial locomotion", 1977).
    """
    speed = signals.speed
    gait = _Gait.of(signals)
    for first, end in find_true(hysteresis(speed > _MOVES, speed > _MOVES_ON)).tolist():
        is_cut = first == 0 and end == len(speed)
        least = _STRIDE if is_cut else _STEPS
        count = gait.steps(first, end)
        way = float(np.nansum(speed[first:end]) * signals.frame_time)
        if count < least or way < _STEP_WAY * count:
            if count and way >= _STEP_WAY:
                yield Activity("step", first, end - 1, confidence_of(way, _STEP_WAY, 2 * _STEP_WAY), steps=count)
            continue
        for begin, stop, is_run in gait.pieces(first, end, least):
            count = gait.steps(begin, stop)
            if is_run:
                sure = confidence_of(float(gait.flight[begin:stop].mean()), _FLIES / 2, _FLIES_SURELY)
                yield Activity("run", begin, stop - 1, sure, steps=count)
            elif count:
                name = "walk" if count >= least else "step"
                yield Activity(name, begin, stop - 1, confidence_of(count, _STRIDE, 2 * _STEPS), steps=count)


def find_turns(signals: BodySignals) -> Iterator[Activity]:
    """Turns to the left and to the right, with their angle."""
    rate = signals.turning
    for sign, side in ((1.0, "left"), (-1.0, "right")):
        towards = sign * rate
        for first, end in find_true(hysteresis(towards > _TURNS, towards > _TURNS_ON)).tolist():
            degrees = float(towards[first:end].sum() * signals.frame_time)
            if degrees >= _TURN and not _feet_stay(signals, first, end, sign * degrees):
                sure = confidence_of(degrees, _TURN, 1.5 * _TURN)
                yield Activity(name_of("turn", side), first, end - 1, sure, degrees=degrees)


def _feet_stay(signals: BodySignals, first: int, end: int, degrees: float) -> bool:
    """Whether the feet are known and turn much less than the hips. degrees: of the hips, to the left."""
    around = signals.frames_in(_FEET_FOLLOW)
    before, after = slice(max(0, first - around), first + 1), slice(end - 1, end + around)
    turned = []
    for side, stands in zip(SIDES, signals.stands, strict=True):
        line = signals.level(signals.at(f"{side}_toes") - signals.at(f"{side}_foot"))
        ends = [line[part][stands[part] & np.isfinite(line[part, 0])] for part in (before, after)]
        if all(map(len, ends)):
            one, other = signals.directions(np.stack([vectors.mean(axis=0) for vectors in ends]))
            # Whole turns more or fewer cannot be told apart.
            turned.append(degrees + (other - one - degrees + 180.0) % 360.0 - 180.0)
    return bool(turned) and float(np.mean(turned)) / degrees < _FEET_GO


def find_jumps(signals: BodySignals, runs: list[Activity]) -> Iterator[Activity]:
    """Jumps, from bent knees to bent knees. runs: in whose flight only leaps are jumps."""
    lift = signals.lifts.min(axis=0)
    heights = signals.height(signals.hips)
    rise = slopes(heights[:, None], signals.frame_time)[:, 0]
    in_run = np.zeros(len(lift), dtype=np.bool_)
    for run in runs:
        in_run[run.first : run.last + 1] = True
    around = signals.frames_in(_CROUCHES)
    for first, end in find_true(lift > _LIFTED).tolist():
        seconds = (end - first) * signals.frame_time
        top = float(lift[first:end].max())
        if seconds < _IN_AIR or top < (_LEAP if in_run[first:end].any() else _JUMP):
            continue
        fall = (rise[end - 1] - rise[first]) / max(seconds - signals.frame_time, signals.frame_time)
        if not fall < _FALLS:
            continue
        before, after = heights[max(0, first - around) : first + 1], heights[end - 1 : end + around]
        begin = max(0, first - around) + int(np.nanargmin(before)) if np.isfinite(before).any() else first
        stop = end - 1 + int(np.nanargmin(after)) if np.isfinite(after).any() else end - 1
        yield Activity("jump", begin, stop, confidence_of(top, _JUMP, 2 * _JUMP))


@dataclass(frozen=True, eq=False)
class _Gait:
    """apart: (n,) level distance of the feet, of which each step is a peak in `peaks`. flight: (n,) share of time in
    flight, less that with both feet planted. bounce: (n,) heights of the hips without their slow part."""

    apart: Array
    peaks: Places
    flight: Array
    bounce: Array

    @classmethod
    def of(cls, signals: BodySignals) -> _Gait:
        apart = smooth(signals.apart[:, None], _STEP_SMOOTH / signals.frame_time)[:, 0]
        shown = np.where(np.isnan(apart), -1.0, apart)
        peaks: Places = scipy.signal.find_peaks(
            shown, prominence=_STEP, distance=signals.frames_in(_STEP_APART)
        )[0]  # fmt: skip
        slow = _SLOW / signals.frame_time
        balance = 1.0 - signals.stands.sum(axis=0)
        heights = signals.height(signals.hips)[:, None]
        return cls(apart, peaks, smooth(balance[:, None], slow)[:, 0], (heights - smooth(heights, slow))[:, 0])

    def steps(self, first: int, end: int) -> int:
        """The number of steps."""
        return int(((self.peaks >= first) & (self.peaks < end)).sum())

    def pieces(self, first: int, end: int, least: int) -> Iterator[tuple[int, int, bool]]:
        """(first, end, whether a run) of a travel; too few steps between or beside runs belong to these."""
        runs = hysteresis(self.flight[first:end] > _FLIES, self.flight[first:end] > _FLIES_ON)
        for begin, stop in find_true(runs).tolist():
            runs[begin:stop] = self.steps(first + begin, first + stop) >= least and self._bounces(
                slice(first + begin, first + stop)
            )
        if runs.any():
            for begin, stop in find_true(~runs).tolist():
                runs[begin:stop] = self.steps(first + begin, first + stop) < least
        edges = [0, *(np.flatnonzero(np.diff(runs)) + 1).tolist(), len(runs)]
        for begin, stop in pairwise(edges):
            yield first + begin, first + stop, bool(runs[begin])

    def _bounces(self, part: slice) -> bool:
        """Whether the hips are high where the feet are far apart."""
        apart, bounce = self.apart[part], self.bounce[part]
        seen = np.isfinite(apart) & np.isfinite(bounce)
        return bool(seen.sum() > 2 and np.cov(apart[seen], bounce[seen])[0, 1] > 0)
