"""Feet across a seam: a foot that stands before or after a transition stands in it too."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcml.motion.feet.moves import spread_moves
from mcml.motion.hub_writer import Flags
from mcml.motion.rotations import rotate
from mcml.motion.skeleton import Array

NEAR = 0.05
"""Leg lengths: places of a foot before and after a seam that differ by more are a step apart."""
_PACE = 0.35
"""Leg lengths: a body is not placed further than this from where its speed leads it, for the sake of a foot."""
_LIFT, _HIGHEST = 0.3, 0.1
"""Height of a step in parts of its length, and at most in leg lengths."""


@dataclass(frozen=True)
class Stance:
    """Legs in consecutive frames. places: (n, L, 2, 3) of toes and ankles. stands: (n, L, 2)."""

    places: Array
    stands: Flags

    def rows(self, first: int, end: int) -> Stance:
        """Frames from `first` up to before `end`."""
        return Stance(self.places[first:end], self.stands[first:end])

    def over(self, frames: int) -> Stance:
        """Over so many frames: itself, or its only frame in each."""
        if len(self.places) == frames:
            return self
        return Stance(np.repeat(self.places[:1], frames, axis=0), np.repeat(self.stands[:1], frames, axis=0))

    def place(self, turn: Array, shift: Array) -> Stance:
        """Turned by a rotation (4,), then shifted by (3,)."""
        return Stance(rotate(turn, self.places) + shift, self.stands)


def pivot_shift(before: Stance, after: Stance, turned: Array, shift: Array, up: Array, size: float) -> Array:
    """The shift (3,) along the ground by which a foot that stands in both frames stays in place.

    before, after: one frame each. turned: (L, 2, 3) `after.places`, turned to the facing of `before`. shift: (3,) that
    follows from the speed of the body; it stays where no foot stands in both, or only far from it. size: of a leg.
    """
    best, least = shift, _PACE * size
    for leg in range(turned.shape[0]):
        point = _point(before.stands[:, leg], after.stands[:, leg])
        if not (before.stands[0, leg].any() and after.stands[0, leg].any()):
            continue
        move = before.places[0, leg, point] - turned[leg, point]
        move = move - (move @ up) * up
        distance = float(np.linalg.norm(move - shift))
        if distance < least:
            best, least = move, distance
    return best


def seam_moves(
    between: Array, before: Stance, after: Stance, up: Array, size: float, hips: Array, reach: Array
) -> list[Array]:
    """Moves (m, 3) by leg that hold feet over a transition.

    between: (m, L, 2, 3) places of toes and ankles as they are. before, after: (m frames) where the two sides of the
    seam have them, placed. A foot that stands on one side is held for its half of the transition; on both sides, all
    the way; places that are a step apart are joined by a step, one foot after the other. A foot is released where its
    leg would be too short: hips (m, L, 3), reach (L,). The frames around the transition stay as they are.
    """
    feet = [
        _SeamFoot.of(between[:, leg], before, after, leg, up, hips[:, leg], reach[leg])
        for leg in range(between.shape[1])
    ]
    return [foot.moves(*_spans(feet, place, NEAR * size), up, size) for place, foot in enumerate(feet)]


def _spans(feet: list[_SeamFoot], place: int, near: float) -> tuple[float, float]:
    """Until which part of a transition a foot is held where it stood, and from which part on where it stands then."""
    foot = feet[place]
    if not foot.both:
        return 0.5, 0.5
    if foot.apart <= near:
        return 1.0, 0.0
    others = [other for index, other in enumerate(feet) if index != place]
    if any(other.both and other.apart <= near for other in others):
        return 1 / 3, 2 / 3
    for other in others:
        steps_first = (foot.apart, place) > (other.apart, 1 - place) if other.both else other.stood.any()
        if other.both or other.stood.any() or other.stands.any():
            return (0.0, 0.5) if steps_first else (0.5, 1.0)
    return 1 / 3, 2 / 3


@dataclass(frozen=True)
class _SeamFoot:
    """A foot in the frames of a transition, (m,) each: its place, where both sides have it, and whether they hold it.

    apart: the largest distance of the two sides along the ground.
    """

    at: Array
    goals: tuple[Array, Array]
    stood: Flags
    stands: Flags
    apart: float

    @staticmethod
    def of(at: Array, before: Stance, after: Stance, leg: int, up: Array, hips: Array, reach: float) -> _SeamFoot:
        point = _point(before.stands[:, leg], after.stands[:, leg])
        one, two = (side.places[:, leg, point] for side in (before, after))
        stood, stands = (
            side.stands[:, leg].any(axis=1) & _within(hips, at[:, 1] + goal - at[:, point], reach)
            for side, goal in ((before, one), (after, two))
        )
        apart = two - one
        apart = np.linalg.norm(apart - np.outer(apart @ up, up), axis=1).max(initial=0.0)
        stood, stands = np.logical_and.accumulate(stood), np.logical_and.accumulate(stands[::-1])[::-1]
        return _SeamFoot(at[:, point], (one, two), stood, stands, float(apart))

    @property
    def both(self) -> bool:
        """Whether it stands at both ends."""
        return bool(self.stood[0] and self.stands[-1])

    def moves(self, until: float, since: float, up: Array, size: float) -> Array:
        """(m, 3) held at its first place until a part of the transition, and at its second since another."""
        frames = len(self.at)
        part = np.arange(1, frames + 1) / (frames + 1)
        known = np.full((frames + 2, 3), np.nan)
        known[[0, -1]] = 0.0
        one, two = (goal - self.at for goal in self.goals)
        if until > since:
            weight = (part * part * (3 - 2 * part))[:, None]
            held = self.stood | self.stands
            known[1:-1][held] = ((1 - weight) * one + weight * two)[held]
            return spread_moves(known, frames)[1:-1]
        first, second = self.stood & (part <= until), self.stands & (part >= since)
        known[1:-1][first], known[1:-1][second] = one[first], two[second]
        moves = spread_moves(known, frames)[1:-1]
        free = np.flatnonzero(~(first | second))
        if self.both and len(free):
            height = min(_LIFT * self.apart, _HIGHEST * size)
            rise = np.sin(np.pi * (np.arange(len(free)) + 1) / (len(free) + 1)) ** 2
            moves[free] += height * rise[:, None] * up
        return moves


def _within(hips: Array, ankles: Array, reach: float) -> Flags:
    """(n,) whether a leg reaches, of a body that may be lowered a little."""
    near: Flags = np.linalg.norm(ankles - hips, axis=1) <= _SLACK * reach
    return near


_SLACK = 1.03
"""Leg lengths from hip to ankle, up to which lowering the body lets a leg reach."""


def _point(before: Flags, after: Flags) -> int:
    """0 to hold a toe, 1 for an ankle. before, after: (n, 2)."""
    toes, ankles = (any(side[:, place].any() for side in (before, after)) for place in (0, 1))
    shared_ankle = before[:, 1].any() and after[:, 1].any() and not (before[:, 0].any() and after[:, 0].any())
    return 1 if ankles and (shared_ankle or not toes) else 0


def slide_of(places: Array, up: Array, frame_time: float, size: float) -> float:
    """Mean speed over the ground of the part of a foot that moves least, in leg lengths a second.

    places: (n, L, 2, 3) of toes and ankles. 0 without legs or movement.
    """
    if len(places) < 2 or not size or not places.shape[1]:
        return 0.0
    steps = np.diff(places, axis=0)
    flat = np.linalg.norm(steps - (steps @ up)[..., None] * up, axis=-1)
    return float(flat.reshape(len(flat), -1).min(axis=1).mean() / (frame_time * size))
