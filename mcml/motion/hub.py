"""One form of motion for all conventions: rest offset, translation and world-aligned rotation of every joint.

In this hub form the rest pose has no rotations: a joint's axes at rest are the world's. With o the rest offset from
the parent, t the translation that replaces it in a frame and L the local rotation, forward kinematics is
P = P_parent + Q_parent t, Q = Q_parent L (docs/conventions.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from mcml.motion.clip import FrameBlock
from mcml.motion.layout import Held
from mcml.motion.rotations import IDENTITY, from_euler, from_fixed_euler, inverse, multiply, rotate
from mcml.motion.skeleton import CHANNEL_INDEX, Array, Convention, Joint, Skeleton, numbers, once_a_skeleton
from mcml.motion.units import DEGREES, Reading


@dataclass(frozen=True, eq=False)
class Rest:
    """The rest pose, in world axes. Read-only.

    offsets: (J, 3) from the parent's joint. orientations: (J, 4) of the source's local axes: the identity for LISTED,
    C for FIXED, the product of base rotations for BASE. bones: (J, 3) from a joint to the tip of its own bone (FIXED
    direction and length, BASE bone length; 0 for LISTED). tips: (joint, vector (3,)) of every end of a chain.
    """

    offsets: Array
    orientations: Array
    bones: Array
    tips: tuple[tuple[int, Array], ...]


@dataclass(frozen=True)
class HubBlock:
    """Frames. translations: (n, J, 3). rotations: (n, J, 4). scales: (n, J) of each joint's own bone; of a blend shape
    its weight.

    values: (n, D) the channels they come from, in the skeleton's columns, missing ones held.
    """

    translations: Array
    rotations: Array
    scales: Array
    values: Array


@once_a_skeleton
def rest_of(skeleton: Skeleton, reading: Reading = DEGREES) -> Rest:
    """The rest pose of a skeleton of any convention."""
    count = len(skeleton)
    offsets, bones = np.zeros((count, 3)), np.zeros((count, 3))
    orientations = np.tile(IDENTITY, (count, 1))
    has_child = {joint.parent for joint in skeleton.joints}
    tips: list[tuple[int, Array]] = []
    for index, joint in enumerate(skeleton.joints):
        parent = joint.parent
        if joint.convention is Convention.LISTED:
            offsets[index] = numbers(joint.offset)
            tips += [(index, numbers(site.offset)) for site in joint.end_sites]
        elif joint.convention is Convention.FIXED:
            orientations[index] = _rest_axes(joint, reading)
            offsets[index] = bones[parent] if parent >= 0 else numbers(joint.offset)
            bones[index] = _bone_of(joint)
        elif joint.convention is Convention.BASE:
            above = orientations[parent] if parent >= 0 else IDENTITY
            order = joint.axis_order or joint.rotation_order or "ZYX"
            angles = numbers(joint.axis)[["XYZ".index(letter) for letter in order.upper()]]
            orientations[index] = multiply(above, from_euler(angles * reading.rest_angle, order))
            offsets[index] = rotate(above, numbers(joint.offset))
            along = np.zeros(3)
            along[reading.bone_axis] = float(joint.length or 0)
            bones[index] = rotate(orientations[index], along)
        if joint.convention is Convention.LISTED:
            continue
        tips += [(index, rotate(orientations[index], numbers(site.offset))) for site in joint.end_sites]
        if not joint.end_sites and index not in has_child and bones[index].any():
            tips.append((index, bones[index].copy()))
    for made in (offsets, orientations, bones, *(vector for _, vector in tips)):
        made.setflags(write=False)
    return Rest(offsets, orientations, bones, tuple(tips))


def _rest_axes(joint: Joint, reading: Reading) -> Array:
    """C of an ASF bone, or of its root: rotations about fixed axes in the order of `axis`."""
    return from_fixed_euler(numbers(joint.axis) * reading.rest_angle, joint.axis_order or "XYZ")


def _bone_of(joint: Joint) -> Array:
    """Length times the unit direction; zero for a root and for a bone without length."""
    direction = numbers(joint.direction)
    norm = float(np.linalg.norm(direction))
    length = float(joint.length or 0)
    return direction * (length / norm) if norm else np.zeros(3)


class HubReader:
    """Blocks of a clip to the hub form; carries held values from block to block."""

    def __init__(self, skeleton: Skeleton, reading: Reading = DEGREES) -> None:
        self.skeleton = skeleton
        self.rest = rest_of(skeleton, reading)
        self.reading = reading
        self._held = Held(skeleton)
        self._groups, self._stated, self._moved, self._scaled = _places(skeleton)

    @property
    def missing(self) -> int:
        """How many samples had to be held so far."""
        return self._held.missing

    def read(self, block: FrameBlock) -> HubBlock:
        return self.of_values(self._held.values(block))

    def of_values(self, values: Array) -> HubBlock:
        """Frames without gaps. values: (n, D) in the skeleton's columns."""
        scales = self._scales(values)
        return HubBlock(self._translations(values, scales), self._rotations(values), scales, values)

    def translations(self, values: Array) -> Array:
        """(n, J, 3) of each joint in its parent, as `HubBlock` has them.

        values: (n, D) in the skeleton's columns, without gaps.
        """
        return self._translations(values, self._scales(values))

    def _rotations(self, values: Array) -> Array:
        rotations = np.empty((len(values), len(self.skeleton), 4))
        rotations[:] = IDENTITY
        for (convention, order), (joints, columns) in self._groups.items():
            angles = values[:, columns].reshape(len(values), len(joints), len(order)) * self.reading.motion_angle
            if convention is Convention.LISTED:
                rotations[:, joints] = from_euler(angles, order)
                continue
            local = from_fixed_euler(angles, order) if convention is Convention.FIXED else from_euler(angles, order)
            axes = self.rest.orientations[joints]
            rotations[:, joints] = multiply(multiply(axes, local), inverse(axes))
        return rotations

    def _scales(self, values: Array) -> Array:
        scales = np.ones((len(values), len(self.skeleton)))
        for joint, column in self._scaled:
            item = self.skeleton.joints[joint]
            if item.convention is Convention.FIXED:
                # ASF's `l` is how much longer the bone is.
                length = float(np.linalg.norm(self.rest.bones[joint]))
                scales[:, joint] = 1.0 + values[:, column] / length if length else 1.0
            else:
                scales[:, joint] = values[:, column]
        return scales

    def _translations(self, values: Array, scales: Array) -> Array:
        rest = self.rest
        translations = in_every_frame(rest.offsets, len(values))
        places, stated = self._stated
        translations.reshape(len(values), 3 * len(self.skeleton))[:, places] = values[:, stated]
        for index, columns in self._moved:
            joint = self.skeleton.joints[index]
            if joint.convention is Convention.FIXED and joint.parent >= 0:
                translations[:, index] *= scales[:, joint.parent, None]
            if not columns:
                continue
            moved = np.zeros((len(values), 3))
            for axis, column in columns:
                moved[:, axis] = values[:, column]
            if joint.convention is Convention.BASE and joint.parent >= 0:
                translations[:, index] += rotate(rest.orientations[joint.parent], moved)
            elif joint.convention is Convention.FIXED and joint.parent >= 0:
                translations[:, index] += rotate(rest.orientations[index], moved)
            else:
                translations[:, index] += moved
        return translations


def in_every_frame(rest: Array, frames: int) -> Array:
    """(n, J, 3) an array (J, 3) in every frame, to be written to: of one without joints `np.tile` makes none."""
    repeated = np.empty((frames, *rest.shape))
    repeated[:] = rest
    return repeated


_Groups: TypeAlias = dict[tuple[Convention, str], tuple[list[int], list[int]]]


@once_a_skeleton
def _places(
    skeleton: Skeleton,
) -> tuple[_Groups, tuple[list[int], list[int]], list[tuple[int, list[tuple[int, int]]]], list[tuple[int, int]]]:
    """Return the indices of values in the skeleton's columns: angles, see `_rotation_groups`; translations that replace
    the offset, places in (J, 3) and columns; those of other joints that may move, by axis; scales.
    """
    place = {column: index for index, column in enumerate(skeleton.columns())}
    joints = range(len(skeleton))
    moved = [(index, [(axis, place[index, axis]) for axis in range(3) if (index, axis) in place]) for index in joints]
    scale = CHANNEL_INDEX["SF"]
    scaled = [(index, place[index, scale]) for index in joints if (index, scale) in place]
    weight = CHANNEL_INDEX["weight"]
    scaled += [(index, place[index, weight]) for index in skeleton.blend_shapes if (index, weight) in place]
    replaced = {
        index
        for index, joint in enumerate(skeleton.joints)
        if joint.convention is Convention.LISTED and joint.translation != "relative"
    }
    stated = [(3 * index + axis, column) for index, columns in moved if index in replaced for axis, column in columns]
    others = [(index, columns) for index, columns in moved if index not in replaced]
    columns = [column for _, column in stated]
    return _rotation_groups(skeleton, place), ([at for at, _ in stated], columns), others, scaled


def _rotation_groups(skeleton: Skeleton, place: dict[tuple[int, int], int]) -> _Groups:
    """Joints that turn in the same way, with the columns of their angles one joint after the other."""
    groups: _Groups = {}
    for index, joint in enumerate(skeleton.joints):
        order = joint.rotation_order.upper()
        if joint.convention is Convention.LISTED:
            order = "".join(channel[1].upper() for channel in joint.channels if channel[0] == "R")
        order = "".join(letter for letter in order if f"R{letter.lower()}" in joint.channels)
        if order and joint.has_axes:
            joints, columns = groups.setdefault((joint.convention, order), ([], []))
            joints.append(index)
            columns += [place[index, CHANNEL_INDEX[f"R{letter.lower()}"]] for letter in order]
    return groups


def walked(skeleton: Skeleton, translations: Array, rotations: Array) -> tuple[Array, Array]:
    """Forward kinematics: positions (n, J, 3) and rotations from the rest pose (n, J, 4), in the world.

    translations (n, J, 3), rotations (n, J, 4): of each joint in its parent, as `HubBlock` has them. Blend shapes have
    no position: NaN.
    """
    if translations.size <= AT_ONCE:
        positions, turned = _walked_by_depth(skeleton, translations, rotations)
        positions[:, skeleton.blend_shapes] = np.nan
        return positions, turned
    positions, turned = np.empty_like(translations), np.empty_like(rotations)
    for index, joint in enumerate(skeleton.joints):
        parent = joint.parent
        if parent < 0:
            positions[:, index] = translations[:, index]
            turned[:, index] = rotations[:, index]
            continue
        turn = turned[:, parent]
        positions[:, index] = positions[:, parent] + rotate(turn, translations[:, index])
        turned[:, index] = multiply(turn, rotations[:, index])
    positions[:, skeleton.blend_shapes] = np.nan
    return positions, turned


AT_ONCE = 1 << 16
"""Numbers of places up to which all joints of one depth are walked together: of more, arrays of one joint are long."""


def _walked_by_depth(skeleton: Skeleton, translations: Array, rotations: Array) -> tuple[Array, Array]:
    """As `walked`, to the bit: few operations, for short arrays cost by their number."""
    # Copies: the input may be read again, as for the rest pose.
    turned = rotations.T.copy(order="C")
    x, y, z, w = turned
    # The sums of `multiply` for its four components: w, x, y and z of the first, each with these of the second.
    second = np.array([(x, y, z, w), (w, -z, y, -x), (z, w, -x, -y), (-y, x, w, -z)])
    for joints, parents in _levels(skeleton)[1:]:
        first = turned[:, parents][[3, 0, 1, 2], None]
        turned[:, joints] = (first * second[:, :, joints]).sum(axis=0)
    positions = translations.T.copy(order="C")
    below = [index for index, joint in enumerate(skeleton.joints) if joint.parent >= 0]
    above = [skeleton.joints[index].parent for index in below]
    positions[:, below] = rotate(turned[:, above].T, positions[:, below].T).T
    for joints, parents in _levels(skeleton)[1:]:
        positions[:, joints] += positions[:, parents]
    return np.ascontiguousarray(positions.T), np.ascontiguousarray(turned.T)


@once_a_skeleton
def _levels(skeleton: Skeleton) -> list[tuple[list[int], list[int]]]:
    """Joints of each depth, roots first, and their parents."""
    depths: list[int] = []
    levels: list[list[int]] = []
    for index, joint in enumerate(skeleton.joints):
        depths.append(depths[joint.parent] + 1 if joint.parent >= 0 else 0)
        if depths[-1] == len(levels):
            levels.append([])
        levels[depths[-1]].append(index)
    return [(level, [skeleton.joints[index].parent for index in level]) for level in levels]
