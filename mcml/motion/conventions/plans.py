"""Plans of skeletons in another convention: joints, rest orientations, orders of angles.

A plan has for every joint of the target its joint of the source (none: a connector that ASF needs), its rest offset and
its rest orientation G. Formulas: docs/conventions.md.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from mcml.motion.conventions.survey import Survey
from mcml.motion.lexemes import lexeme, triple
from mcml.motion.rotations import IDENTITY, inverse, multiply, rotate, shortest_arc, to_euler
from mcml.motion.skeleton import Array, Convention, EndSite, Joint, Skeleton

FLIP = np.array([1.0, 0.0, 0.0, 0.0])
"""Half a turn about X: takes -Y to Y, and only changes the sign of angles about Y and Z."""

ALIGNED = 1e-6
"""Radians by which a bone may differ from an axis and still count as aligned."""

_Y = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True)
class PlannedJoint:
    """One joint of the target.

    source: index in the source, None for a connector. parent: index in the target. offset: (3,) in world axes at rest.
    orientation: G, (4,). order: letters of the product of its rotations, "" for none. moves: whether it has Tx Ty Tz.
    adds: joints of the source whose translation is added to its own.
    """

    source: int | None
    parent: int
    offset: Array
    orientation: Array
    order: str
    moves: bool
    adds: tuple[int, ...] = ()


@dataclass(frozen=True)
class Plan:
    """A plan of a conversion.

    joints: of the target in pre-order; skeleton: built from them; fields: header fields for it.
    """

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


def is_within(order: str, whole: str) -> bool:
    """Tell whether the letters occur in this order in the other one."""
    letters = iter(whole)
    return all(letter in letters for letter in order)


def is_identity(rotation: Array) -> bool:
    """Whether a quaternion is no rotation at all, exactly."""
    return bool((rotation[:3] == 0).all())


def children_of(skeleton: Skeleton) -> list[list[int]]:
    """The children of each joint in their order."""
    children: list[list[int]] = [[] for _ in skeleton.joints]
    for index, joint in enumerate(skeleton.joints):
        if joint.parent >= 0:
            children[joint.parent].append(index)
    return children


def still_offsets(skeleton: Skeleton, found: Survey) -> Array:
    """Return (J, 3) the position of each joint in its parent: a constant translation counts as the offset."""
    moving = found.moving()
    middles = found.middles()
    offsets = found.rest.offsets.copy()
    for index, joint in enumerate(skeleton.joints):
        if joint.parent >= 0 and not moving[index]:
            offsets[index] = middles[index]
    return offsets


def bone_vectors(skeleton: Skeleton, found: Survey, offsets: Array) -> Array:
    """(J, 3) from each joint to its first child, or to its tip where it has none; world axes at rest."""
    vectors = np.zeros((len(skeleton), 3))
    tips = dict(reversed(found.rest.tips))
    for index, children in enumerate(children_of(skeleton)):
        vectors[index] = offsets[children[0]] if children else tips.get(index, np.zeros(3))
    return vectors


def made(joint: Joint, convention: Convention, parent: int, channels: tuple[str, ...], order: str) -> Joint:
    """A joint of another convention under the same names."""
    return Joint(
        joint.name, parent, joint.source_name, convention, channels, order, mapped=joint.mapped, role=joint.role
    )


def plan_listed(skeleton: Skeleton, found: Survey) -> Plan:
    """BVH: offsets and end sites in world axes, no rest rotation, positions only where a joint moves."""
    rest = found.rest
    moving, middles = found.moving(), found.middles()
    offsets = still_offsets(skeleton, found)
    children = children_of(skeleton)
    tips: dict[int, list[Array]] = {}
    for index, vector in rest.tips:
        tips.setdefault(index, []).append(vector)
    planned, joints = [], []
    for index, joint in enumerate(skeleton.joints):
        moves = joint.parent < 0 or bool(moving[index])
        offset = offsets[index]
        if joint.parent < 0:
            # The positions replace it, and a root at 0 cannot be misread as one whose positions add to it.
            offset = np.zeros(3)
        elif moves and np.linalg.norm(middles[index] - offset) > 0.5 * np.linalg.norm(offset):
            offset = middles[index]
        order = product_order(joint)
        order = "ZYX" if is_within(order, "ZYX") or len(order) < 3 else order
        planned.append(PlannedJoint(index, joint.parent, offset, IDENTITY, order, moves))
        channels = (("Tx", "Ty", "Tz") if moves else ()) + tuple(f"R{letter.lower()}" for letter in order)
        sites = joint.end_sites if joint.convention is Convention.LISTED else ()
        sites = sites or tuple(EndSite(triple(vector)) for vector in tips.get(index, []))
        if not sites and not children[index]:
            sites = (EndSite(("0", "0", "0")),)
        joints.append(
            replace(
                made(joint, Convention.LISTED, joint.parent, channels, order),
                offset=triple(offset),
                translation="absolute" if moves else "",
                end_sites=sites,
            )
        )
    return Plan(tuple(planned), Skeleton(tuple(joints)), {})


def plan_base(skeleton: Skeleton, found: Survey) -> Plan:
    """HTR: one order for all. G is the source's, so that angles stay; bones without a child point along Y."""
    order = _common_order(skeleton)
    offsets = still_offsets(skeleton, found)
    vectors = bone_vectors(skeleton, found, offsets)
    children = children_of(skeleton)
    orientations: list[Array] = []
    planned, joints = [], []
    for index, joint in enumerate(skeleton.joints):
        own = found.rest.orientations[index]
        orientation = own if children[index] else _along_y(own, vectors[index])
        above = orientations[joint.parent] if joint.parent >= 0 else IDENTITY
        orientations.append(orientation)
        # BVH's root positions replace its offset: without one they stay the numbers they are.
        replaces = joint.parent < 0 and joint.convention is Convention.LISTED and joint.translation == "absolute"
        offset = np.zeros(3) if replaces else offsets[index]
        planned.append(PlannedJoint(index, joint.parent, offset, orientation, order, True))
        joints.append(
            replace(
                made(joint, Convention.BASE, joint.parent, ("Tx", "Ty", "Tz", "Rx", "Ry", "Rz", "SF"), order),
                offset=triple(rotate(inverse(above), offset)),
                axis=triple(_by_letter(multiply(inverse(above), orientation), order)),
                axis_order=order,
                length=lexeme(float(np.linalg.norm(vectors[index]))),
            )
        )
    fields = {"units_angle": "Degrees", "bone_length_axis": "Y", "euler_rotation_order": order}
    return Plan(tuple(planned), Skeleton(tuple(joints)), fields)


def _common_order(skeleton: Skeleton) -> str:
    """The order that most joints have, if all fit it; else ZYX."""
    orders = Counter(product_order(joint) for joint in skeleton.joints)
    whole = [order for order, _ in orders.most_common() if len(order) == 3]
    for order in [*whole[:1], "ZYX"]:
        if all(is_within(other, order) for other in orders):
            return order
    return "ZYX"


def _along_y(own: Array, vector: Array) -> Array:
    """A rest orientation whose Y is the bone, as near to the own one as it can be."""
    length = float(np.linalg.norm(vector))
    if not length:
        return own
    local = rotate(inverse(own), vector / length)
    if np.linalg.norm(local - _Y) < ALIGNED:
        return own
    if np.linalg.norm(local + _Y) < ALIGNED:
        return multiply(own, FLIP)
    return multiply(own, shortest_arc(_Y, local))


def _by_letter(rotation: Array, order: str) -> Array:
    """Degrees about X, Y, Z (3,) of a rotation as a product in that order."""
    angles = np.degrees(to_euler(rotation[None], order)[0])
    by_letter = np.zeros(3)
    for place, letter in enumerate(order):
        by_letter["XYZ".index(letter)] = angles[place]
    return by_letter
