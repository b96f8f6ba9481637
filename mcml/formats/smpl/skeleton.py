"""The joints of SMPL, SMPL-H and SMPL-X, and a body of general lengths.

The makers' own bodies may not be redistributed. These lengths are of a general adult of 1.70 m, rounded to 5 mm and
symmetrical, in metres: x to the left of the body, y up, z to the front.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from mcml.errors import FormatError
from mcml.motion.lexemes import lexeme
from mcml.motion.skeleton import ROTATIONS, TRANSLATIONS, Convention, Joint, Skeleton

Point = tuple[float, float, float]

_TRUNK: Final[tuple[tuple[str, str, Point], ...]] = (
    ("pelvis", "", (0, -0.220, 0.030)),
    ("left_hip", "pelvis", (0.070, -0.090, -0.005)),
    ("right_hip", "pelvis", (-0.070, -0.090, -0.005)),
    ("spine1", "pelvis", (0, 0.110, -0.025)),
    ("left_knee", "left_hip", (0.035, -0.380, -0.007)),
    ("right_knee", "right_hip", (-0.035, -0.380, -0.007)),
    ("spine2", "spine1", (0, 0.135, 0)),
    ("left_ankle", "left_knee", (-0.015, -0.400, -0.043)),
    ("right_ankle", "right_knee", (0.015, -0.400, -0.043)),
    ("spine3", "spine2", (0, 0.055, 0.025)),
    ("left_foot", "left_ankle", (0.025, -0.055, 0.120)),
    ("right_foot", "right_ankle", (-0.025, -0.055, 0.120)),
    ("neck", "spine3", (0, 0.215, -0.043)),
    ("left_collar", "spine3", (0.080, 0.120, -0.035)),
    ("right_collar", "spine3", (-0.080, 0.120, -0.035)),
    ("head", "neck", (0, 0.065, 0.050)),
    ("left_shoulder", "left_collar", (0.095, 0.030, -0.009)),
    ("right_shoulder", "right_collar", (-0.095, 0.030, -0.009)),
    ("left_elbow", "left_shoulder", (0.255, -0.013, -0.025)),
    ("right_elbow", "right_shoulder", (-0.255, -0.013, -0.025)),
    ("left_wrist", "left_elbow", (0.250, 0.008, -0.003)),
    ("right_wrist", "right_elbow", (-0.250, 0.008, -0.003)),
)
_PALMS: Final[tuple[tuple[str, str, Point], ...]] = (
    ("left_hand", "left_wrist", (0.085, -0.008, -0.015)),
    ("right_hand", "right_wrist", (-0.085, -0.008, -0.015)),
)
_FACE: Final[tuple[tuple[str, str, Point], ...]] = (
    ("jaw", "head", (0, -0.02, 0.03)),
    ("left_eye", "head", (0.03, 0.06, 0.08)),
    ("right_eye", "head", (-0.03, 0.06, 0.08)),
)
_JOINTS: Final = frozenset({22, 24, 52, 55})
_SAME_WAY: Final = 0.999
"""Cosine between bones that point in the same direction."""
_KNUCKLES: Final = {"index": 0.02, "middle": 0.0, "pinky": -0.04, "ring": -0.02}


@dataclass(frozen=True)
class SmplBody:
    """Joints with each before its children. places: of each among the joints of the file."""

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: tuple[Point, ...]
    places: tuple[int, ...]


def body_of(joints: int) -> SmplBody:
    """The body of a file with so many joints. FormatError where no model has that many."""
    listed = {
        22: _TRUNK,
        24: _TRUNK + _PALMS,
        52: (*_TRUNK, *_fingers("left", 1), *_fingers("right", -1)),
        55: (*_TRUNK, *_FACE, *_fingers("left", 1), *_fingers("right", -1)),
    }.get(joints)
    if listed is None:
        raise FormatError(
            f"the poses have {joints} joints; SMPL has 24, its body alone 22, SMPL-H 52 and SMPL-X 55",
            remedy="Send the poses of one of these models.",
        )
    children: dict[str, list[int]] = {}
    for place, (_, parent, _) in enumerate(listed):
        children.setdefault(parent, []).append(place)
    order: list[int] = []
    waiting = [0]
    while waiting:
        place = waiting.pop()
        order.append(place)
        waiting += reversed(children.get(listed[place][0], []))
    names = tuple(listed[place][0] for place in order)
    parents = tuple(names.index(listed[place][1]) if listed[place][1] else -1 for place in order)
    return SmplBody(names, parents, tuple(listed[place][2] for place in order), tuple(order))


def find_body(skeleton: Skeleton) -> SmplBody | None:
    """Return the model that a skeleton has the joints and the rest pose of; None for other skeletons.

    Bones may have other lengths, and point in the same directions.
    """
    names = [joint.source_name for joint in skeleton.joints]
    if len(names) not in _JOINTS or not all(joint.offset for joint in skeleton.joints):
        return None
    body = body_of(len(names))
    if sorted(names) != sorted(body.names):
        return None
    index = {name: place for place, name in enumerate(names)}
    for name, parent, offset in zip(body.names, body.parents, body.offsets, strict=True):
        joint = skeleton.joints[index[name]]
        above = names[joint.parent] if joint.parent >= 0 else None
        bone = np.array([float(text) for text in joint.offset or ()])
        size = np.linalg.norm(bone) * np.linalg.norm(offset)
        if above != (body.names[parent] if parent >= 0 else None) or joint.convention is not Convention.LISTED:
            return None
        if parent >= 0 and not bone @ np.array(offset) > _SAME_WAY * size:
            return None
    return body


def _fingers(side: str, sign: int) -> tuple[tuple[str, str, Point], ...]:
    found: list[tuple[str, str, Point]] = []
    for finger in (*_KNUCKLES, "thumb"):
        first = (sign * 0.03, -0.015, 0.03) if finger == "thumb" else (sign * 0.095, 0.0, _KNUCKLES[finger])
        for number in (1, 2, 3):
            above = f"{side}_wrist" if number == 1 else f"{side}_{finger}{number - 1}"
            found.append((f"{side}_{finger}{number}", above, first if number == 1 else (sign * 0.03, 0.0, 0.0)))
    return tuple(found)


def skeleton_of(body: SmplBody) -> Skeleton:
    """The skeleton of a body; its root has translations, which replace the place at rest."""
    joints = []
    for name, parent, offset in zip(body.names, body.parents, body.offsets, strict=True):
        joints.append(
            Joint(
                name=name,
                parent=parent,
                source_name=name,
                convention=Convention.LISTED,
                channels=(TRANSLATIONS if parent < 0 else ()) + tuple(reversed(ROTATIONS)),
                rotation_order="ZYX",
                offset=(lexeme(offset[0]), lexeme(offset[1]), lexeme(offset[2])),
                translation="absolute" if parent < 0 else "",
            )
        )
    return Skeleton(tuple(joints))
