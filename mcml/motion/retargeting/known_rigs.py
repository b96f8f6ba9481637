"""Rigs that motions are brought to without a file: names and tree of the joints of a program, in a rest pose.

Joints of a rig have the names of its program. They lie where those of one body do that is made here for all of them:
1.75 m tall, with lengths of segments from Winter, Biomechanics and Motor Control of Human Movement (2009), figure 4.1,
and a straight trunk. `known_rigs.csv` has the joints of each rig, `body_places.csv` the places of the body.
"""

from __future__ import annotations

import csv
import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, full_shape
from mcml.motion.hub_writer import HubWriter
from mcml.motion.lexemes import triple
from mcml.motion.pictures.figures import axis_of
from mcml.motion.rotations import IDENTITY
from mcml.motion.skeleton import TRANSLATIONS, Array, Convention, Joint, Skeleton
from mcml.motion.units import metres_per_unit
from mcml.resources import body_places_path, known_rigs_path

_SIDES: Final = re.compile(r"<(.*)\|(.*)>")
"""In the name of a joint that both sides have: its letters on the left and on the right."""
_ARMS: Final = ("up_arm", "low_arm", "hand", "finger")
"""Places that turn with a lowered arm, by their first letters."""
_SHOULDER: Final = "up_arm"


@dataclass(frozen=True)
class KnownRig:
    """The rig of a program.

    name: as requests name it. title: of the program. unit: of length. up, front: the axes that point up and to the
    front of the body at rest, such as "Y" and "-Y". lowered: degrees by which the arms at rest are below the horizon,
    0 in a T-pose.
    """

    name: str
    title: str
    unit: str
    up: str
    front: str
    lowered: float = 0.0

    def clip(self) -> ClipStream:
        """The rig at rest, as a clip of one frame in the conventions of BVH: joints have no rotation at rest."""
        return _clip(self)


KNOWN_RIGS: Final[dict[str, KnownRig]] = {
    rig.name: rig
    for rig in (
        KnownRig("mixamo", "Mixamo", "cm", "Y", "Z"),
        KnownRig("unreal5", "Unreal Engine 5 mannequin", "cm", "Z", "-Y", lowered=45),
        KnownRig("metahuman", "MetaHuman", "cm", "Z", "-Y", lowered=45),
        KnownRig("unity", "Unity humanoid", "m", "Y", "Z"),
        KnownRig("vrm", "VRM 1.0", "m", "Y", "Z"),
        KnownRig("rigify", "Blender Rigify", "m", "Z", "-Y"),
        KnownRig("smplx", "SMPL-X", "m", "Y", "Z"),
        KnownRig("character-creator", "Character Creator", "cm", "Y", "Z"),
        KnownRig("daz9", "DAZ Genesis 9", "cm", "Y", "Z", lowered=45),
        KnownRig("opensim", "OpenSim bodies", "m", "Y", "X", lowered=90),
    )
}
"""Every known rig, by its name."""


@dataclass(frozen=True)
class _Row:
    """A joint of a rig. parent: "" of the root. name: of MCML, "" without one. position: (3,) of the body, metres."""

    joint: str
    parent: str
    name: str
    position: Array


@cache
def _clip(rig: KnownRig) -> ClipStream:
    skeleton = _skeleton(rig, list(_sided_rows(rig)))
    fields = {
        "skeleton_name": rig.title,
        "calibration_unit": rig.unit,
        "global_axis_of_gravity": rig.up,
        "euler_rotation_order": skeleton.joints[0].rotation_order,
    }
    writer = HubWriter(skeleton)
    values = writer.write(writer.rest.offsets[None], np.tile(IDENTITY, (1, len(skeleton), 1)))
    columns = skeleton.columns()
    block = FrameBlock(values, columns, (full_shape(columns),), np.array([1]))
    return ClipStream(ClipHead("bvh", skeleton, fields=fields), lambda: iter([block]), 1)


def _skeleton(rig: KnownRig, rows: list[_Row]) -> Skeleton:
    axes = _axes(rig) / metres_per_unit(rig.unit)
    order = "".join("XYZ"[int(np.argmax(np.abs(axis)))] for axis in axes.T)
    turns = tuple(f"R{letter.lower()}" for letter in order)
    places = {row.joint: axes @ row.position for row in rows}
    rows = list(_by_subtree(rows, ""))
    number = {row.joint: index for index, row in enumerate(rows)}
    joints = []
    for row in rows:
        moves = not row.parent or row.name == "Root"
        offset = places[row.joint] - (places[row.parent] if row.parent else 0.0)
        joints.append(
            Joint(
                name=row.name or row.joint,
                parent=number.get(row.parent, -1),
                source_name=row.joint,
                convention=Convention.LISTED,
                channels=(*TRANSLATIONS, *turns) if moves else turns,
                rotation_order=order,
                offset=triple(np.round(offset, 9)),
                translation="absolute" if moves else "",
                mapped=bool(row.name),
            )
        )
    return Skeleton(tuple(joints))


def _axes(rig: KnownRig) -> Array:
    """(3, 3) from the axes of the body, to its left, up and to its front, to those of the rig."""
    upward, front = axis_of(rig.up), axis_of(rig.front)
    return np.stack([np.cross(upward, front), upward, front], axis=1)


def _by_subtree(rows: list[_Row], parent: str) -> Iterator[_Row]:
    for row in rows:
        if row.parent == parent:
            yield row
            yield from _by_subtree(rows, row.joint)


def _sided_rows(rig: KnownRig) -> Iterator[_Row]:
    """The joints of a rig, those of both sides twice."""
    places = _body(rig.lowered)
    for row in _table()[rig.name]:
        both = _SIDES.search(row["joint"])
        position = _place(places, row["place"] or row["name"])
        if both is None:
            yield _Row(row["joint"], row["parent"], row["name"], position)
            continue
        for side, letters, mirror in (("left", both[1], 1), ("right", both[2], -1)):
            joint, parent = (_SIDES.sub(letters, row[part]) for part in ("joint", "parent"))
            name = f"{side}_{row['name']}" if row["name"] else ""
            yield _Row(joint, parent, name, position * [mirror, 1, 1])


def _place(places: dict[str, Array], place: str) -> Array:
    """A place of the body, or one on the line between two: `up_arm low_arm 0.5`."""
    if place in places:
        return places[place]
    one, other, part = place.split(" ")
    return places[one] + float(part) * (places[other] - places[one])


@cache
def _body(lowered: float) -> dict[str, Array]:
    """Places (3,) of the middle and of the left side of the body in metres, to its left, up and to its front from the
    ground between its feet.
    """
    with body_places_path().open(encoding="utf-8", newline="") as stream:
        places = {row["place"]: np.array([float(row[axis]) for axis in "xyz"]) for row in csv.DictReader(stream)}
    angle = np.deg2rad(lowered)
    turn = np.array([[np.cos(angle), np.sin(angle), 0.0], [-np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    shoulder = places[_SHOULDER]
    return {
        place: shoulder + turn @ (position - shoulder) if place.startswith(_ARMS) else position
        for place, position in places.items()
    }


@cache
def _table() -> dict[str, list[dict[str, str]]]:
    """The rows of each rig, parents before children."""
    rigs: dict[str, list[dict[str, str]]] = defaultdict(list)
    with known_rigs_path().open(encoding="utf-8", newline="") as stream:
        for row in csv.DictReader(stream):
            rigs[row.pop("rig")].append(row)
    return dict(rigs)
