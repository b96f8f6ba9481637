"""Hands that touch each other, the head or a thigh in the source touch them on the target too.

Where a hand of the source is near another part of the body, the vector from that part to the hand, scaled by the
bodies, is kept on the target by bending the arm: relative constraints as of Gleicher, "Retargetting motion to new
characters" (1998), solved frame by frame and faded in and out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy

from mcml.motion.feet.legs import is_below
from mcml.motion.feet.two_bones import hinge_of, two_bones
from mcml.motion.hub import walked
from mcml.motion.hub_writer import Flags
from mcml.motion.rotations import inverse, multiply, rotate
from mcml.motion.skeleton import Array, Skeleton
from mcml.numerics.runs import find_true

FADE = 0.2
"""Seconds over which a correction grows and fades."""
_SHORTEST = 0.1
"""Seconds: shorter contacts are passes, and shorter gaps are closed."""
_NEAR = {"hand": 0.25, "head": 0.4, "thigh": 0.22}
"""Lengths of the arm from a wrist to the other, to the joint of the head, and to the line from hip to knee: up to this
they touch."""
_FARTHEST = 0.6
"""Lengths of the arm: the most that a hand is moved."""
_MISSED = 0.02
"""Lengths of the arm: a hand that misses its place by more is told."""
_ROUNDS = 4
"""Of bending an arm whose joints cannot turn freely, or have limits."""

Limiter = Callable[[int, Array], Array]
"""From a joint and its local rotations (n, 4) to those that it can have."""


@dataclass(frozen=True)
class HandContact:
    """A contact of a hand, of frames `first` to `last`, from 0.

    hand, other: joints of the target. before, after: the greatest distance of the hand from its place relative to the
    other part, in the target's unit, without and with correction. is_missed: by over a fiftieth of the arm.
    """

    hand: int
    other: int
    first: int
    last: int
    before: float
    after: float
    is_missed: bool


class Arm(NamedTuple):
    """Joints of an arm."""

    shoulder: int
    elbow: int
    hand: int

    def length(self, positions: Array) -> float:
        """From shoulder to hand along the bones, the median over frames of positions (n, J, 3)."""
        bones = np.linalg.norm(np.diff(positions[:, list(self)], axis=1), axis=2)
        return float(np.median(bones.sum(axis=1))) if len(bones) else 0.0


@dataclass(frozen=True)
class _Touch:
    """A contact. moves: (n, 3) of the hand in all frames. weights: (n,) of the moves, 0 to 1. frames: first, last."""

    arm: Arm
    other: int
    moves: Array
    weights: Array
    frames: tuple[int, int]


@dataclass(frozen=True)
class HandKeeper:
    """Keeps contacts of hands on a target.

    pairs: joint of the target -> joint of the source. positions: (n, Js, 3) of the source, in the world. ratio: of
    lengths of the target to those of the source. frame_time: seconds. limit: see `Limiter`.
    """

    skeleton: Skeleton
    pairs: Mapping[int, int]
    positions: Array
    ratio: float
    frame_time: float
    limit: Limiter

    def keep(self, translations: Array, rotations: Array) -> tuple[Array, tuple[HandContact, ...]]:
        """Return rotations (n, J, 4) with bent arms, and the contacts. translations: (n, J, 3); both of the hub."""
        places, world = walked(self.skeleton, translations, rotations)
        touches = list(self._touches(places))
        if not touches:
            return rotations, ()
        for arm in self._arms():
            own = [touch for touch in touches if touch.arm == arm]
            total = sum((touch.weights for touch in own), np.zeros(len(places)))
            moves = sum((touch.weights[:, None] * touch.moves for touch in own), np.zeros((len(places), 3)))
            moves = moves / np.maximum(total, 1.0)[:, None]
            rotations = self._move_hand(arm, moves, translations, rotations, world)
        after = walked(self.skeleton, translations, rotations)[0]
        return rotations, tuple(self._describe(touch, places, after) for touch in touches)

    def _arms(self) -> list[Arm]:
        at = {joint.name: index for index, joint in enumerate(self.skeleton.joints) if index in self.pairs}
        arms = []
        for side in ("left", "right"):
            hand = at.get(f"{side}_wrist", at.get(f"{side}_hand"))
            shoulder, elbow = at.get(f"{side}_up_arm"), at.get(f"{side}_low_arm")
            if hand is None or shoulder is None or elbow is None:
                continue
            if is_below(self.skeleton, elbow, shoulder) and is_below(self.skeleton, hand, elbow):
                arms.append(Arm(shoulder, elbow, hand))
        return arms

    def _touches(self, places: Array) -> Iterator[_Touch]:
        """Find contacts in the source, and the moves of hands of the target at `places` (n, J, 3) that they need."""
        at = {joint.name: index for index, joint in enumerate(self.skeleton.joints) if index in self.pairs}
        arms = self._arms()
        for arm in arms:
            mine, source = places[:, arm.hand], self.positions[:, self.pairs[arm.hand]]
            length = Arm(*(self.pairs[joint] for joint in arm)).length(self.positions)
            if "Head" in at:
                wanted = source - self.positions[:, self.pairs[at["Head"]]]
                move = places[:, at["Head"]] + self.ratio * wanted - mine
                yield from self._spans(arm, at["Head"], np.linalg.norm(wanted, axis=1), _NEAR["head"] * length, move)
            yield from self._at_thighs(arm, places, at)
        if len(arms) == 2:
            one, two = arms
            wanted = self.positions[:, self.pairs[one.hand]] - self.positions[:, self.pairs[two.hand]]
            length = Arm(*(self.pairs[joint] for joint in one)).length(self.positions)
            # Each hand goes half of the way.
            half = (self.ratio * wanted - (places[:, one.hand] - places[:, two.hand])) / 2
            apart = np.linalg.norm(wanted, axis=1)
            yield from self._spans(one, two.hand, apart, _NEAR["hand"] * length, half)
            yield from self._spans(two, one.hand, apart, _NEAR["hand"] * length, -half)

    def _at_thighs(self, arm: Arm, places: Array, at: Mapping[str, int]) -> Iterator[_Touch]:
        """Contacts with the nearer thigh."""
        mine, source = places[:, arm.hand], self.positions[:, self.pairs[arm.hand]]
        near = _NEAR["thigh"] * Arm(*(self.pairs[joint] for joint in arm)).length(self.positions)
        found = []
        for side in ("left", "right"):
            hip, knee = at.get(f"{side}_up_leg"), at.get(f"{side}_low_leg")
            if hip is None or knee is None:
                continue
            start, end = self.positions[:, self.pairs[hip]], self.positions[:, self.pairs[knee]]
            part = _part_along(start, end, source)
            wanted = source - (start + part * (end - start))
            move = places[:, hip] + part * (places[:, knee] - places[:, hip]) + self.ratio * wanted - mine
            found.append((hip, np.linalg.norm(wanted, axis=1), move))
        nearest = np.min([distance for _, distance, _ in found], axis=0, initial=np.inf)
        for hip, distance, move in found:
            yield from self._spans(arm, hip, np.where(distance <= nearest, distance, np.inf), near, move)

    def _spans(self, arm: Arm, other: int, distance: Array, near: float, moves: Array) -> Iterator[_Touch]:
        least = max(1, round(_SHORTEST / self.frame_time))
        flags: Flags = scipy.ndimage.binary_closing(
            np.pad(distance <= near, least), np.ones(least + 1, dtype=np.bool_)
        )[least:-least]
        for first, end in find_true(flags).tolist():
            if end - first >= least:
                fade = max(1, round(FADE / self.frame_time))
                yield _Touch(arm, other, moves, fade_weights(len(distance), first, end - 1, fade), (first, end - 1))

    def _move_hand(self, arm: Arm, moves: Array, translations: Array, rotations: Array, before: Array) -> Array:
        """Bend an arm so that its hand moves by (n, 3). before: (n, J, 4) in the world, which hands keep."""
        rows = np.flatnonzero((moves != 0).any(axis=1))
        if not len(rows):
            return rotations
        places, world = walked(self.skeleton, translations, rotations)
        most = _FARTHEST * arm.length(places)
        far = np.linalg.norm(moves, axis=1, keepdims=True)
        goals = (places[:, arm.hand] + moves * np.minimum(1.0, most / np.maximum(far, 1e-300)))[rows]
        back = inverse(world[:, arm.shoulder])
        bones = [rotate(back, places[:, end] - places[:, start]) for start, end in pairwise(arm)]
        hinge = hinge_of(*bones)
        bent, moved = rotations[rows].copy(), translations[rows]
        for _ in range(_ROUNDS):
            at, turned = walked(self.skeleton, moved, bent)
            axes = None if hinge is None else rotate(turned[:, arm.shoulder], hinge)
            swing, bend = two_bones(at[:, arm.shoulder], at[:, arm.elbow], at[:, arm.hand], goals, axes)
            self._turn(arm.shoulder, multiply(swing, turned[:, arm.shoulder]), moved, bent)
            self._turn(arm.elbow, multiply(swing, multiply(bend, turned[:, arm.elbow])), moved, bent)
            self._turn(arm.hand, before[rows, arm.hand], moved, bent)
            reached = walked(self.skeleton, moved, bent)[0][:, arm.hand]
            if np.linalg.norm(reached - goals, axis=1).max() < 1e-6 * most:
                break
        changed = rotations.copy()
        changed[rows] = bent
        return changed

    def _turn(self, joint: int, wanted: Array, translations: Array, rotations: Array) -> None:
        """Turn a joint to rotations (n, 4) in the world, as far as its channels and limits allow."""
        parent = self.skeleton.joints[joint].parent
        world = walked(self.skeleton, translations, rotations)[1]
        local = wanted if parent < 0 else multiply(inverse(world[:, parent]), wanted)
        rotations[:, joint] = self.limit(joint, local)

    def _describe(self, touch: _Touch, before: Array, after: Array) -> HandContact:
        first, last = touch.frames
        rows = slice(first, last + 1)
        hand, other = touch.arm.hand, touch.other
        # Both hands share the way to each other.
        factor = 2.0 if other in {arm.hand for arm in self._arms()} else 1.0
        missed = factor * touch.moves[rows] - (after[rows, hand] - before[rows, hand])
        missed += (after - before)[rows, other]
        far = np.linalg.norm(missed, axis=1)
        return HandContact(
            hand=hand,
            other=other,
            first=first,
            last=last,
            before=float(np.linalg.norm(factor * touch.moves[rows], axis=1).max(initial=0.0)),
            after=float(far.max()),
            is_missed=bool(far.max() > _MISSED * touch.arm.length(before)),
        )


def fade_weights(count: int, first: int, last: int, fade: int) -> Array:
    """(n,) weights: 1 in frames first to last, smoothly from and to 0 in `fade` frames around."""
    frames = np.arange(count)
    away = np.maximum(np.maximum(first - frames, frames - last), 0) / (fade + 1)
    part = np.clip(1.0 - away, 0.0, 1.0)
    weights: Array = part * part * (3.0 - 2.0 * part)
    return weights


def _part_along(start: Array, end: Array, point: Array) -> Array:
    """(n, 1) where the point of a line that is nearest to another point lies, from 0 to 1 between its ends."""
    way = end - start
    size = (way**2).sum(axis=1, keepdims=True)
    part: Array = np.clip(((point - start) * way).sum(axis=1, keepdims=True) / np.maximum(size, 1e-300), 0.0, 1.0)
    return part
