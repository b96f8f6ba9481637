"""Anatomical axes of a body: left, up and forward, the joints of each part, the directions of its bones.

Everything refers to a reference pose: the rest pose, or a frame of the clip if no body could stand in the rest pose
(rigs with all bones along one axis at rest). Rotations are those from the reference pose, in its axes.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.errors import ConversionError
from mcml.motion.hub import Rest, walked
from mcml.motion.rotations import inverse, multiply, rotate
from mcml.motion.sides import sagittal
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.vectors import dot, length

_MOST_POSES = 500
"""Of a clip that are looked at for the most upright one."""

STANDS = 0.3
"""Cosine: limits for the uprightness of the trunk and of the legs in a standing pose."""


@dataclass(frozen=True)
class AnatomicalPart:
    """A part of the body.

    name: in the vocabulary of motion names. kind: class of its movements, see `anatomical_rates`. joints: MCML's names,
    nearest to the trunk first, `*` for the side; only those in the skeleton are used.
    """

    name: str
    kind: str
    joints: tuple[str, ...]

    @property
    def sides(self) -> tuple[str, ...]:
        """Left and right, or none."""
        return ("left", "right") if self.joints[0].startswith("*") else ("",)


PARTS = (
    AnatomicalPart("pelvis", "pelvis", ("Root",)),
    AnatomicalPart("trunk", "axial", ("waist", "torso2", "torso3", "torso4", "torso5", "torso6", "torso7")),
    AnatomicalPart("neck", "axial", ("neck1", "neck2")),
    AnatomicalPart("head", "axial", ("Head",)),
    AnatomicalPart("shoulder", "girdle", ("*_shoulder",)),
    AnatomicalPart("arm", "limb", ("*_up_arm",)),
    AnatomicalPart("elbow", "hinge", ("*_low_arm",)),
    AnatomicalPart("forearm", "twist", ("*_low_arm", "*_wrist")),
    AnatomicalPart("wrist", "hand", ("*_hand",)),
    AnatomicalPart("fingers", "fingers", ("*_fingers",)),
    AnatomicalPart("thumb", "thumb", ("*_finger_one",)),
    AnatomicalPart("finger-two", "finger", ("*_finger_two",)),
    AnatomicalPart("finger-three", "fingers", ("*_finger_three",)),
    AnatomicalPart("finger-four", "finger", ("*_finger_four",)),
    AnatomicalPart("finger-five", "finger", ("*_finger_five",)),
    AnatomicalPart("leg", "limb", ("*_hip", "*_up_leg")),
    AnatomicalPart("knee", "hinge", ("*_low_leg",)),
    AnatomicalPart("foot", "foot", ("*_foot",)),
    AnatomicalPart("toes", "toes", ("*_toes",)),
    AnatomicalPart("toe-one", "toes", ("*_toe_one",)),
    AnatomicalPart("toe-two", "toes", ("*_toe_two",)),
    AnatomicalPart("toe-three", "toes", ("*_toe_three",)),
    AnatomicalPart("toe-four", "toes", ("*_toe_four",)),
    AnatomicalPart("toe-five", "toes", ("*_toe_five",)),
)
"""Every part whose movements angles can show, the trunk first."""


BODY = frozenset(name.replace("*", side) for part in PARTS for side in ("left", "right") for name in part.joints)
"""MCML's names of joints of parts."""


def joints_of_part(name: str, side: str) -> str:
    """The joints of a part of a side, any of which will do, with `|` between them."""
    part = next(part for part in PARTS if part.name == name)
    return "|".join(joint.replace("*", side) for joint in part.joints)


@dataclass(frozen=True)
class Stance:
    """A reference pose. positions: (J, 3), turned: (J, 4) from rest, in the world. left, up, on: unit vectors (3,)."""

    positions: Array
    turned: Array
    left: Array
    up: Array
    on: Array


def stance_of(
    skeleton: Skeleton,
    rest: Rest,
    translations: Array,
    rotations: Array,
    up: Array,
    facing: Array | None = None,
) -> Stance:
    """Return the rest pose if a body could stand in it, else the most upright frame.

    translations: (n, J, 3), rotations: (n, J, 4) local, of the hub form; rigs without offsets have all joints in one
    place at rest. up: (3,). facing: (3,) direction that the body faces in that pose; else names of joints decide left
    and right. Raises ConversionError if neither does.
    """
    still = np.tile(np.array([0.0, 0.0, 0.0, 1.0]), (1, len(skeleton), 1))
    positions, turned = walked(skeleton, rest.offsets[None], still)
    if uprightness(skeleton, positions, up)[0] > STANDS:
        with suppress(ConversionError):
            return stance_in(skeleton, positions[0], turned[0], up, facing)
    # A pose a few frames from the most upright one is hardly less so.
    chosen = slice(None, None, -(-len(rotations) // _MOST_POSES))
    positions, turned = walked(skeleton, translations[chosen], rotations[chosen])
    best = int(np.argmax(uprightness(skeleton, positions, up)))
    return stance_in(skeleton, positions[best], turned[best], up, facing)


def stance_in(skeleton: Skeleton, positions: Array, turned: Array, up: Array, facing: Array | None = None) -> Stance:
    """A pose as the reference: positions (J, 3), turned (J, 4) from rest, in the world; see `stance_of`."""
    plane = sagittal(skeleton, positions, up, facing)
    return Stance(positions, turned, plane.normal, up, np.cross(plane.normal, up))


def uprightness(skeleton: Skeleton, positions: Array, up: Array) -> Array:
    """(n,) the cosine, at least, with which legs point down and the trunk up; -1 where left is on both sides.

    positions: (n, J, 3), up: (3,) unit vector.
    """
    places = {joint.name: index for index, joint in enumerate(skeleton.joints)}
    found = np.ones(len(positions))
    for start, end, sense in (
        ("Root", "Head", 1.0),
        ("left_up_leg", "left_foot", -1.0),
        ("right_up_leg", "right_foot", -1.0),
    ):
        if start in places and end in places:
            vector = positions[:, places[end]] - positions[:, places[start]]
            far = length(vector)
            found = np.minimum(found, sense * (vector @ up) / np.where(far > 0, far, 1.0))
    pairs = [
        positions[:, places[f"left_{part}"]] - positions[:, places[f"right_{part}"]]
        for part in ("up_leg", "up_arm")
        if f"left_{part}" in places and f"right_{part}" in places
    ]
    if len(pairs) == 2:
        found = np.where(dot(*pairs) > 0, found, -1.0)
    return found


@dataclass(frozen=True)
class Segment:
    """A part of one side in a skeleton.

    joint: the last of its joints; above: the joint that it moves in, -1 for the world. bone: (3,) unit vector along it
    in the reference pose; before: along the bone above. side: "left", "right" or "".
    """

    part: AnatomicalPart
    side: str
    joint: int
    above: int
    bone: Array
    before: Array


def segments_of(skeleton: Skeleton, rest: Rest, stance: Stance) -> list[Segment]:
    """The parts that a skeleton has, by MCML's names."""
    places = {joint.name: index for index, joint in enumerate(skeleton.joints)}
    found = []
    for part in PARTS:
        for side in part.sides:
            joints = sorted(places[n] for name in part.joints if (n := name.replace("*", side)) in places)
            if not joints:
                continue
            above = skeleton.joints[joints[0]].parent if part.kind != "pelvis" else -1
            bone = bone_of(skeleton, rest, stance, joints[-1])
            part_above = above
            while part_above >= 0 and skeleton.joints[part_above].name not in BODY:
                part_above = skeleton.joints[part_above].parent
            before = bone if above < 0 else bone_of(skeleton, rest, stance, part_above if part_above >= 0 else above)
            found.append(Segment(part, side, joints[-1], above, bone, before))
    return found


def bone_of(skeleton: Skeleton, rest: Rest, stance: Stance, joint: int) -> Array:
    """(3,) the direction of a joint's bone in the reference pose. The order of its children does not matter.

    A bone leads to the next joint of the body by MCML's names: of a hand to the middle finger, else midway between the
    fingers without the thumb. Of other joints it leads to the first child that is elsewhere, or the tip; it is that of
    the bone above if there is neither.
    """
    near = 1e-3 * (float(np.ptp(stance.positions, axis=0).max()) or 1.0)
    while joint >= 0:
        vectors = stance.positions - stance.positions[joint]
        away = np.linalg.norm(vectors, axis=1) > near
        ends = _next_parts(skeleton, joint, away) or [child for child in skeleton.children(joint) if away[child]][:1]
        vector = vectors[ends].mean(axis=0) if ends else np.zeros(3)
        if (norm := np.linalg.norm(vector)) > near:
            unit: Array = vector / norm
            return unit
        for owner, tip in rest.tips:
            if owner == joint and np.linalg.norm(tip) > near:
                return rotate(stance.turned[joint], tip / np.linalg.norm(tip))
        joint = skeleton.joints[joint].parent
    return stance.up


def _next_parts(skeleton: Skeleton, joint: int, away: NDArray[np.bool_]) -> list[int]:
    """The joints of the body to which the bone of one of them leads, none of another joint. away: (J,) where joints are
    in another place."""
    if skeleton.joints[joint].name not in BODY:
        return []
    names: dict[int, str] = {}
    below = list(skeleton.children(joint))
    while below:
        end = below.pop()
        if (name := skeleton.joints[end].name) in BODY and away[end]:
            names[end] = name
        else:
            below += skeleton.children(end)
    for middle in ("_fingers", "_finger_three", "_toes"):
        if found := [end for end, name in names.items() if name.endswith(middle)]:
            return found
    return [end for end, name in names.items() if not name.endswith("_finger_one")] or list(names)


def relative_turns(skeleton: Skeleton, rotations: Array, stance: Stance, segment: Segment) -> Array:
    """Return (n, 4) rotations of a part relative to its parent segment, from the reference pose, in its axes.

    rotations: (n, J, 4) of the joints in the world, from rest.
    """
    own = multiply(rotations[:, segment.joint], inverse(stance.turned[segment.joint]))
    if segment.above < 0:
        return own
    above = multiply(rotations[:, segment.above], inverse(stance.turned[segment.above]))
    return multiply(inverse(above), own)
