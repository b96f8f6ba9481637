"""Movements of single limbs: kicks, waves, raised hands, reaches."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy

from mcml.motion.bodies.activities.activity import Activity, name_of
from mcml.motion.bodies.activities.signals import SIDES, BodySignals, Flags, Side, confidence_of, smooth
from mcml.motion.bodies.stretch import HIPS, NECK
from mcml.motion.skeleton import Array
from mcml.motion.vectors import angle_between, dot, length
from mcml.numerics.runs import find_true

_KICKS, _KICK_HEIGHT, _KICK_REACH, _KICK_THIGH = 3.0, 0.3, 0.85, 40.0
"""Of a kick: speed of the foot from the hips, in leg lengths a second; height of the foot over its standing height;
distance of ankle and hip; and degrees of the thigh from the axis down."""
_SWING, _SWINGS, _BETWEEN = 0.1, 2, 0.9
"""Of a wave: way of the hand to one side, in lengths of an arm; how many; and most seconds between two."""
_REACHES, _EXTENDED, _ARM_UP = 0.5, 0.7, 40.0
"""Of a reach: way of the hand from the trunk, and its distance from the shoulder at the end, in lengths of an arm; and
degrees of the arm from the trunk's axis down."""
_RESTS, _HURRIES = 0.3, 0.6
"""Speeds of a hand from the trunk, in lengths of an arm a second: below which it rests, above which it reaches."""
_SLOWS = 0.5
"""By how much a hand is slower than before and after, where one way ends and the next begins."""
_STRAIGHT_WAY = 0.6
"""Part of its way that a reaching hand comes forward."""
_LONGEST = 3.0
"""Most seconds of a reach."""
_OVER = 0.1
"""Lengths of an arm by which a raised hand is above the neck and the shoulder."""
_AROUND = 0.2
"""Seconds before and after that belong to a kick or a wave."""


def find_kicks(signals: BodySignals) -> Iterator[Activity]:
    """Kicks: a fast foot, raised before or beside the body with a straight leg."""
    down = -signals.stretch.up
    around = signals.frames_in(_AROUND)
    for lift, side in zip(signals.lifts, SIDES, strict=True):
        hip, knee, ankle = (signals.at(f"{side}_{part}") for part in ("up_leg", "low_leg", "foot"))
        speed = length(signals.velocity(ankle - signals.hips, settled=0.03))
        thigh = angle_between(knee - hip, np.broadcast_to(down, hip.shape))
        raised = (lift > _KICK_HEIGHT) & (thigh > _KICK_THIGH)
        for first, end in find_true(raised).tolist():
            fastest = _largest(speed[max(0, first - around) : end])
            longest = _largest(length(ankle - hip)[first:end])
            if fastest > _KICKS and longest > _KICK_REACH:
                begin, stop = max(0, first - around), min(len(lift), end + around)
                yield Activity(name_of("kick", side), begin, stop - 1, confidence_of(fastest, _KICKS, 2 * _KICKS))


def find_hand_gestures(signals: BodySignals, travels: Flags) -> Iterator[Activity]:
    """Waves, raised hands and reaches. travels: (n,) whether the body walks or runs: arms swing then."""
    for side in SIDES:
        arm = _Arm.of(signals, side)
        if arm is None:
            continue
        waves = list(_waves(signals, arm, travels))
        yield from waves
        waving = np.zeros(len(arm.hand), dtype=np.bool_)
        for wave in waves:
            waving[wave.first : wave.last + 1] = True
        yield from _reaches(signals, arm, waving, travels)


@dataclass(frozen=True, eq=False)
class _Arm:
    """hand: (n, 3) from the shoulder, to the trunk's left, up and front, in lengths of the arm. above: (n,) whether the
    hand is above the elbow. over_head: (n,) whether it is above the neck and the shoulder by a tenth of an arm."""

    side: Side
    hand: Array
    above: Flags
    over_head: Flags

    @classmethod
    def of(cls, signals: BodySignals, side: Side) -> _Arm | None:
        """None if positions of the arm are unknown."""
        shoulder, elbow, hand = (signals.at(f"{side}_{part}") for part in ("up_arm", "low_arm", "hand"))
        lengths = length(elbow - shoulder) + length(hand - elbow)
        lengths = lengths[np.isfinite(lengths)]
        size = float(lengths.mean()) if len(lengths) else 0.0
        if not size:
            return None
        axes = signals.stretch.trunk_axes(HIPS)
        places = np.stack([dot(hand - shoulder, axis) for axis in axes], axis=1) / size
        neck = signals.height(signals.at(NECK))
        over = signals.height(hand) > np.fmax(neck, signals.height(shoulder)) + _OVER * size
        return cls(side, places, signals.height(hand) > signals.height(elbow), over)

    def elevation(self, frame: int) -> float:
        """Degrees of the line from the shoulder to the hand from the trunk's axis down."""
        return float(angle_between(self.hand[frame][None], np.array([[0.0, -1.0, 0.0]]))[0])


def _waves(signals: BodySignals, arm: _Arm, travels: Flags) -> Iterator[Activity]:
    up = arm.hand[:, 1]
    raised = arm.above & np.isfinite(up) & ((up > 0) | ~travels)
    longest = _BETWEEN / signals.frame_time
    found: list[tuple[int, int, int]] = []
    for column in smooth(arm.hand, 0.03 / signals.frame_time).T[[0, 2]]:
        ways = np.where(np.isfinite(column), column, 0.0)
        ends = np.sort(np.concatenate([scipy.signal.find_peaks(way, prominence=_SWING)[0] for way in (ways, -ways)]))
        swings = np.zeros(max(0, len(ends) - 1), dtype=np.bool_)
        for place, (one, other) in enumerate(pairwise(ends.tolist())):
            part = slice(one, other + 1)
            level = raised[part].all() and np.ptp(up[part]) < abs(ways[other] - ways[one])
            swings[place] = other - one <= longest and level
        for one, other in find_true(swings).tolist():
            if other - one >= _SWINGS:
                found.append((int(ends[one]), int(ends[other]), other - one))
    flags = np.zeros(len(arm.hand), dtype=np.bool_)
    for first, last, _ in found:
        flags[first : last + 1] = True
    around = signals.frames_in(_AROUND)
    for first, end in find_true(flags).tolist():
        count = max(number for begin, last, number in found if begin < end and last >= first)
        begin, stop = max(0, first - around), min(len(flags), end + around)
        yield Activity(name_of("wave", arm.side), begin, stop - 1, confidence_of(count, _SWINGS - 1, 2 * _SWINGS))


def _reaches(signals: BodySignals, arm: _Arm, waving: Flags, travels: Flags) -> Iterator[Activity]:
    speed = length(signals.velocity(arm.hand, settled=0.05))
    moves = (speed > _RESTS) & ~waving
    # A hand that turns back at once does not rest, but slows down.
    turns, _ = scipy.signal.find_peaks(np.where(np.isfinite(speed), -speed, 0.0), prominence=_SLOWS)
    moves[turns] = False
    for first, end in find_true(moves).tolist():
        way = float(np.linalg.norm(arm.hand[end - 1] - arm.hand[first]))
        path = float(speed[first:end].sum() * signals.frame_time)
        is_straight = way >= max(_REACHES, _STRAIGHT_WAY * path)
        is_quick = _largest(speed[first:end]) >= _HURRIES and (end - first) * signals.frame_time <= _LONGEST
        if not (is_straight and is_quick and end < len(speed)):
            continue
        over_head = bool(arm.over_head[end - 1])
        extends = np.linalg.norm(arm.hand[end - 1]) >= _EXTENDED
        rises = arm.elevation(end - 1) > max(_ARM_UP, arm.elevation(first))
        if extends and rises and (over_head or not travels[first:end].any()):
            name = name_of("raise hand" if over_head else "reach", arm.side)
            yield Activity(name, first, end - 1, confidence_of(way, _REACHES, 2 * _REACHES))


def _largest(values: Array) -> float:
    seen = values[np.isfinite(values)]
    return float(seen.max()) if len(seen) else 0.0
