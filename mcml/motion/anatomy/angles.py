"""Speeds of the anatomical movements of each part of the body.

A part rotates relative to its parent segment with angular velocity w. With d the direction of its bone, v = w x d is
the velocity of the bone's end, w . d its rotation about itself. With l to the left, u up and f on (in the reference
pose, rotated with the parent segment), a hanging limb that swings to f flexes, away from the body abducts, and one held
out that swings to f about u adducts horizontally. Turning the front of a limb to the middle of the body is medial.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mcml.motion.anatomy.axes import Segment, Stance, relative_turns
from mcml.motion.rotation_vectors import to_vector
from mcml.motion.rotations import inverse, multiply, rotate
from mcml.motion.skeleton import Array, Skeleton

_AWAY = 0.35
"""Sine of the angle to its axis below which a limb does not tell a movement about that axis from a turn."""
_RAISED = 0.7
"""The same for horizontal movements: the limb is lifted by 45 degrees."""


@dataclass(frozen=True)
class Rate:
    """A movement of a part and its opposite. rate: (n,) radians a second, positive for `movement`. speed: (n,) of all
    the part does."""

    part: str
    side: str
    movement: str
    opposite: str
    rate: Array
    speed: Array


@dataclass(frozen=True)
class _Moving:
    """A part in motion.

    bone: (n, 3) unit vectors, spin: (n, 3) radians a second, both in the axes of the parent segment; own: (n, 3) spin
    in its own axes.
    """

    segment: Segment
    stance: Stance
    bone: Array
    spin: Array
    own: Array

    @property
    def inward(self) -> float:
        """1 for a left part, -1 for a right one: the sense of a medial turn about the bone, seen from its root."""
        return -1.0 if self.segment.side == "right" else 1.0

    def about(self, axis: Array) -> Array:
        """(n,) spin about a fixed axis (3,)."""
        turning: Array = self.spin @ axis
        return turning

    def twist(self) -> Array:
        """(n,) spin about its own bone."""
        turning: Array = self.own @ self.segment.bone
        return turning

    def toward(self, direction: Array) -> Array:
        """Return (n,) the speed of the bone's swing, in its own axes, to a direction (3,) of the reference pose."""
        across = direction - (direction @ self.segment.bone) * self.segment.bone
        length = float(np.linalg.norm(across))
        if length < _AWAY:
            return np.zeros(len(self.own))
        swing: Array = np.cross(self.own, self.segment.bone) @ (across / length)
        return swing

    def around(self, axis: Array, away: float) -> Array:
        """Return (n,) the speed of the bone's swing about an axis (3,); 0 where it is too near to the axis."""
        tangent = np.cross(axis, self.bone)
        lengths = np.linalg.norm(tangent, axis=1)
        swing = (np.cross(self.spin, self.bone) * tangent).sum(axis=1) / np.where(lengths > 0, lengths, 1.0)
        return np.where(lengths > away, swing, 0.0)

    def thumb(self) -> Array:
        """(3,) where a hand's thumb is: on, as in a hand that hangs or is held out flat; up for one that points on."""
        on, up, bone = self.stance.on, self.stance.up, self.segment.before
        chosen = on if abs(float(on @ bone)) < 0.8 else up
        across = chosen - (chosen @ bone) * bone
        unit: Array = across / np.linalg.norm(across)
        return unit

    def palm(self) -> Array:
        """(3,) where the palm looks."""
        looks: Array = np.cross(self.segment.before, self.thumb()) * self.inward
        return looks


_Found = list[tuple[str, str, Array]]


def _axial(moving: _Moving) -> _Found:
    stance = moving.stance
    return [
        ("flexion", "extension", moving.about(stance.left)),
        ("left-rotation", "right-rotation", moving.about(stance.up)),
        ("right-lateral-flexion", "left-lateral-flexion", moving.about(stance.on)),
    ]


def _pelvis(moving: _Moving) -> _Found:
    """In its own axes, because the body may have any facing direction."""
    stance = moving.stance
    return [
        ("anterior-tilt", "posterior-tilt", moving.own @ stance.left),
        ("left-rotation", "right-rotation", moving.own @ stance.up),
        ("right-lateral-flexion", "left-lateral-flexion", moving.own @ stance.on),
    ]


def _girdle(moving: _Moving) -> _Found:
    return [
        ("elevation", "depression", moving.toward(moving.stance.up)),
        ("protraction", "retraction", moving.toward(moving.stance.on)),
    ]


def _limb(moving: _Moving) -> _Found:
    stance, inward = moving.stance, moving.inward
    return [
        ("flexion", "extension", moving.around(-stance.left, _AWAY)),
        ("abduction", "adduction", moving.around(stance.on * inward, _AWAY)),
        ("horizontal-abduction", "horizontal-adduction", moving.around(stance.up * inward, _RAISED)),
        ("medial-rotation", "lateral-rotation", moving.twist() * inward),
    ]


def _hinge(moving: _Moving) -> _Found:
    """The angle between the two bones; a knee's small turns are its own."""
    straight = np.cross(moving.segment.before, moving.bone)
    lengths = np.linalg.norm(straight, axis=1)
    # The bend grows where the bone swings away from the one above; from straight on, any way is bending.
    swing = np.cross(moving.spin, moving.bone)
    tangent = np.cross(straight / np.where(lengths > 0, lengths, 1.0)[:, None], moving.bone)
    rate = np.where(lengths > 1e-3, (swing * tangent).sum(axis=1), np.linalg.norm(swing, axis=1))
    found: _Found = [("flexion", "extension", rate)]
    if moving.segment.part.name == "knee":
        found.append(("medial-rotation", "lateral-rotation", moving.twist() * moving.inward))
    return found


def _twist(moving: _Moving) -> _Found:
    return [("pronation", "supination", moving.twist() * moving.inward)]


def _fingers(moving: _Moving) -> _Found:
    return [("flexion", "extension", moving.toward(moving.palm()))]


def _hand(moving: _Moving) -> _Found:
    return [*_fingers(moving), ("abduction", "adduction", moving.toward(moving.thumb()))]


def _finger(moving: _Moving) -> _Found:
    """Fingers spread from the middle one: the index to the thumb, the others from it."""
    spread = moving.thumb() if moving.segment.part.name == "finger-two" else -moving.thumb()
    return [*_fingers(moving), ("abduction", "adduction", moving.toward(spread))]


def _thumb(moving: _Moving) -> _Found:
    """A thumb bends across the palm, and is abducted out of its plane."""
    return [
        ("flexion", "extension", moving.toward(-moving.thumb())),
        ("abduction", "adduction", moving.toward(moving.palm())),
    ]


def _foot(moving: _Moving) -> _Found:
    return [
        ("dorsiflexion", "plantarflexion", moving.toward(moving.stance.up)),
        ("eversion", "inversion", moving.twist() * moving.inward),
    ]


def _toes(moving: _Moving) -> _Found:
    return [("extension", "flexion", moving.toward(moving.stance.up))]


_KINDS: dict[str, Callable[[_Moving], _Found]] = {
    "pelvis": _pelvis,
    "axial": _axial,
    "girdle": _girdle,
    "limb": _limb,
    "hinge": _hinge,
    "twist": _twist,
    "hand": _hand,
    "fingers": _fingers,
    "finger": _finger,
    "thumb": _thumb,
    "foot": _foot,
    "toes": _toes,
}


def anatomical_rates(
    skeleton: Skeleton, segment: Segment, rotations: Array, stance: Stance, frame_time: float
) -> list[Rate]:
    """The movements of one part. rotations: (n, J, 4) of the joints in the world, from rest. frame_time: seconds."""
    turns = relative_turns(skeleton, rotations, stance, segment)
    own = spins(turns, frame_time)
    bone = rotate(turns, segment.bone)
    moving = _Moving(segment, stance, bone, rotate(turns, own), own)
    found = _KINDS[segment.part.kind](moving)
    if segment.part.kind == "hinge" and segment.part.name == "elbow":
        speed = np.linalg.norm(np.cross(own, segment.bone), axis=1)
    elif segment.part.kind == "twist":
        speed = np.abs(own @ segment.bone)
    else:
        speed = np.linalg.norm(own, axis=1)
    return [
        Rate(segment.part.name, segment.side, positive, negative, rate, speed) for positive, negative, rate in found
    ]


_TWISTS = frozenset({"pronation", "medial-rotation", "left-rotation", "eversion"})
"""Movements about the bone itself: the twist of a turn."""
_TWISTING = frozenset({"axial", "pelvis", "limb", "hinge", "twist", "foot"})
"""Kinds of parts that have such movements; hands, fingers and toes only swing."""
_UNTWISTED = 1e-6
"""Of the sine of half a turn: of a swing as near to half a turn as this no twist is known."""


def turned_angles(segment: Segment, stance: Stance, turns: Array) -> list[tuple[str, str, Array]]:
    """Return (movement, opposite, radians (n,)) by which a part is rotated from the reference pose, NaN where unknown.

    turns: (n, 4) of the part relative to its parent segment (`relative_turns`). For parts that twist, each rotation is
    split into a twist about the bone (of the trunk, neck and head about the vertical), within half a turn, and a swing
    after it, whose rotation vector has a component for each other movement. So a forearm pronated by 60 degrees gives
    60, however the elbow is bent. For other parts the components are those of the rotation vector of the whole
    rotation.
    """
    bone = np.tile(segment.bone, (len(turns), 1))
    show = _KINDS[segment.part.kind]
    if segment.part.kind not in _TWISTING:
        vectors = to_vector(turns)
        return show(_Moving(segment, stance, bone, vectors, vectors))
    axis = stance.up if segment.part.kind in ("axial", "pelvis") else segment.bone
    along, real = turns[:, :3] @ axis, turns[:, 3]
    lengths = np.hypot(along, real)
    twisted = lengths > _UNTWISTED
    half = np.where(twisted, np.arctan2(along, real), 0.0)
    twists = np.concatenate([np.sin(half)[:, None] * axis, np.cos(half)[:, None]], axis=1)
    # Half a turn more is the same rotation, by the other way round.
    angles = np.pi - np.mod(np.pi - 2.0 * half, 2.0 * np.pi)
    vectors = to_vector(multiply(turns, inverse(twists))) + angles[:, None] * axis
    found = show(_Moving(segment, stance, bone, vectors, vectors))
    return [
        (movement, opposite, np.where(twisted, radians, np.nan) if movement in _TWISTS else radians)
        for movement, opposite, radians in found
    ]


def spins(turns: Array, frame_time: float) -> Array:
    """Return (n, 3) radians a second about the part's own axes from rotations (n, 4): the mean of the steps before
    and after.
    """
    if len(turns) < 2:
        return np.zeros((len(turns), 3))
    steps = to_vector(multiply(inverse(turns[:-1]), turns[1:])) / frame_time
    before, after = np.vstack([steps[:1], steps]), np.vstack([steps, steps[-1:]])
    mean: Array = (before + after) / 2
    return mean
