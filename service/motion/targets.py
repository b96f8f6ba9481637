"""Skeletons in another convention: which joints it has, how each is turned at rest, which angles it takes.

A plan says for every joint of the target which joint of the source it is (none: a connector that an ASF needs), its
rest offset and its rest orientation G. Formulas: formats.md 8.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from service.errors import ConversionError, Notice
from service.motion.clip import ClipStream
from service.motion.rotations import IDENTITY, from_euler, inverse, multiply, rotate, shortest_arc, to_euler
from service.motion.skeleton import Array, Convention, EndSite, Joint, Skeleton, Triple, unique_names
from service.motion.survey import Survey

FLIP_X = np.array([1.0, 0.0, 0.0, 0.0])
"""Half a turn about X: takes -Y to Y."""


@dataclass(frozen=True)
class PlannedJoint:
    """One joint of the target.

    source: index in the source, None for a connector. parent: index in the target. offset, bone: (3,) in world axes at
    rest. orientation: G, (4,). order: letters of the product of its rotations. moves: whether it has Tx Ty Tz.
    adds: sources whose translations are added to its own (a root that takes over its child's).
    """

    source: int | None
    parent: int
    offset: Array
    bone: Array
    orientation: Array
    order: str
    moves: bool
    adds: tuple[int, ...] = ()


@dataclass(frozen=True)
class Plan:
    """The target's joints in pre-order, and the skeleton made of them."""

    joints: tuple[PlannedJoint, ...]
    skeleton: Skeleton
    fields: dict[str, str]


def product_order(joint: Joint) -> str:
    """The letters of the product of a joint's rotations, left to right, as far as it has channels for them."""
    order = joint.rotation_order.upper()
    if joint.convention is Convention.LISTED:
        order = "".join(channel[1].upper() for channel in joint.channels if channel[0] == "R")
    order = "".join(letter for letter in order if f"R{letter.lower()}" in joint.channels)
    return order[::-1] if joint.convention is Convention.FIXED else order


def completed(order: str, default: str = "ZYX") -> str:
    """An order of all three letters that contains the given ones in their order."""
    if is_within(order, default):
        return default
    return order + "".join(letter for letter in default if letter not in order)


def is_within(order: str, whole: str) -> bool:
    """Whether the letters stand in that order in the other one."""
    letters = iter(whole)
    return all(letter in letters for letter in order)


def is_identity(rotation: Array) -> bool:
    """Whether a quaternion is no rotation at all, exactly."""
    return bool((rotation[:3] == 0).all())


Lexeme = Callable[[Array], Triple]


def plan_listed(clip: ClipStream, found: Survey, triple: Lexeme) -> Plan:
    """BVH: offsets and end sites in world axes, no rest rotation; positions only where a joint moves."""
    skeleton, rest = clip.head.skeleton, found.rest
    moving = found.moving()
    tips: dict[int, list[Array]] = {}
    for index, vector in rest.tips:
        tips.setdefault(index, []).append(vector)
    planned, joints = [], []
    for index, joint in enumerate(skeleton.joints):
        root = joint.parent < 0
        # A constant translation is an offset; the root's offset is left as it was, its positions replace it.
        offset = rest.offsets[index] if root or moving[index] else found.middles()[index]
        order = completed(product_order(joint))
        moves = root or bool(moving[index])
        planned.append(PlannedJoint(index, joint.parent, offset, rest.bones[index], IDENTITY, order, moves))
        sites = joint.end_sites or tuple(EndSite(triple(vector)) for vector in tips.get(index, []))
        if not any(other.parent == index for other in skeleton.joints) and not sites:
            sites = (EndSite(("0", "0", "0")),)
        joints.append(
            _made(joint, Convention.LISTED, joint.parent, moves, tuple(order), order, "absolute" if moves else "")
        )
        joints[-1] = _with(joints[-1], offset=triple(offset), end_sites=sites)
    return Plan(tuple(planned), Skeleton(tuple(joints)), {})


def plan_base(clip: ClipStream, found: Survey, triple: Lexeme) -> Plan:
    """HTR: one order for all; bones that end a chain lie along Y so that their tips are true."""
    skeleton, rest = clip.head.skeleton, found.rest
    order = _common_order(skeleton)
    orientations: list[Array] = []
    planned, joints = [], []
    vectors = _bone_vectors(skeleton, found)
    leaf = _is_leaf(skeleton)
    for index, joint in enumerate(skeleton.joints):
        own = rest.orientations[index]
        orientation = _along_y(own, vectors[index], leaf[index])
        above = orientations[joint.parent] if joint.parent >= 0 else IDENTITY
        orientations.append(orientation)
        # A root's translation is kept as it is, so that its numbers are.
        root = joint.parent < 0
        offset = np.zeros(3) if root and joint.convention is Convention.LISTED else rest.offsets[index]
        planned.append(PlannedJoint(index, joint.parent, offset, vectors[index], orientation, order, True))
        base = to_euler(multiply(inverse(above), orientation)[None], order)[0]
        angles = np.zeros(3)
        for place, letter in enumerate(order):
            angles["XYZ".index(letter)] = np.degrees(base[place])
        made = _made(joint, Convention.BASE, joint.parent, True, ("X", "Y", "Z"), order, "")
        joints.append(
            _with(
                made,
                channels=(*made.channels, "SF"),
                offset=triple(rotate(inverse(above), offset)),
                axis=triple(angles),
                axis_order=order,
                length=triple(np.array([np.linalg.norm(vectors[index]), 0.0, 0.0]))[0],
            )
        )
    fields = {"units_angle": "Degrees", "bone_length_axis": "Y", "euler_rotation_order": order}
    return Plan(tuple(planned), Skeleton(tuple(joints)), fields)


def _made(
    joint: Joint,
    convention: Convention,
    parent: int,
    moves: bool,
    letters: tuple[str, ...],
    order: str,
    translation: str,
) -> Joint:
    channels = (("Tx", "Ty", "Tz") if moves else ()) + tuple(f"R{letter.lower()}" for letter in letters)
    return Joint(
        name=joint.name,
        parent=parent,
        source_name=joint.source_name,
        convention=convention,
        channels=channels,
        rotation_order=order,
        translation=translation,
        mapped=joint.mapped,
    )
