"""Skeletons as ASF holds them: bones that begin where their parent ends, with connectors where that is not so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mcml.errors import ConversionError, Notice
from mcml.motion.conventions.plans import (
    Plan,
    PlannedJoint,
    bone_vectors,
    children_of,
    is_within,
    made,
    product_order,
    still_offsets,
)
from mcml.motion.conventions.survey import Survey
from mcml.motion.lexemes import lexeme, triple
from mcml.motion.rotations import IDENTITY, to_euler
from mcml.motion.skeleton import Array, Convention, Joint, Skeleton

_CHANNELS = ("Tx", "Ty", "Tz", "Rx", "Ry", "Rz")


def plan_fixed(skeleton: Skeleton, found: Survey, keep_translations: bool, notices: list[Notice]) -> Plan:
    """ASF: every joint becomes the bone that starts there; its rest axes stay the source's (C = G).

    keep_translations: joints that move in their parent get `dof tx ty tz`, which few programs read; else they are fixed
    and a notice has the largest displacement. Raises ConversionError for several roots.
    """
    if len(skeleton.roots) != 1:
        raise ConversionError(
            f"the skeleton has {len(skeleton.roots)} roots, ASF has one",
            remedy="Export one of them, or choose a format that holds several (BVH, HTR).",
        )
    offsets = still_offsets(skeleton, found)
    moving = found.moving()
    moving[0] = False
    carried = _carried(skeleton, found, moving)
    adds: tuple[int, ...] = ()
    if carried is not None:
        adds, moving[carried] = (carried,), False
        offsets[carried] = 0.0
        notices.append(
            Notice(
                "note",
                f"the root never turns and {skeleton.joints[carried].source_name!r} moves in it: in the ASF the root "
                f"stands where {skeleton.joints[carried].source_name!r} does",
            )
        )
    if not keep_translations:
        for index in np.flatnonzero(moving).tolist():
            offsets[index] = found.middles()[index]
        _report_lost(skeleton, found, moving, notices)
    builder = _Builder(skeleton, found, offsets, moving if keep_translations else np.zeros(len(skeleton), dtype=bool))
    return builder.plan(adds, notices)


def _carried(skeleton: Skeleton, found: Survey, moving: Array) -> int | None:
    """The only child of a root that never turns, if the child moves."""
    children = children_of(skeleton)[0]
    return children[0] if found.root_still and len(children) == 1 and moving[children[0]] else None


def _report_lost(skeleton: Skeleton, found: Survey, moving: Array, notices: list[Notice]) -> None:
    lost = {index: found.displacement(index) for index in np.flatnonzero(moving).tolist()}
    if lost:
        worst = max(lost, key=lambda index: lost[index])
        notices.append(
            Notice(
                "warning",
                f"ASF bones do not move in their parent: {len(lost)} joints stand still instead, by at most "
                f"{lost[worst]:.4g} ({skeleton.joints[worst].source_name!r}), in the clip's unit of length",
            )
        )


class _Builder:
    def __init__(self, skeleton: Skeleton, found: Survey, offsets: Array, moves: Array) -> None:
        self.skeleton = skeleton
        self.rest = found.rest
        self.offsets = offsets
        self.moves = moves
        self.vectors = bone_vectors(skeleton, found, offsets)
        self.planned: list[PlannedJoint] = []
        self.joints: list[Joint] = []
        names = [joint.name for joint in skeleton.joints]
        self.taken = set(names)

    def plan(self, adds: tuple[int, ...], notices: list[Notice]) -> Plan:
        children = children_of(self.skeleton)
        # (joint of the source, parent in the target, where that parent ends relative to the parent joint)
        stack: list[tuple[int, int]] = []
        self._add_root(adds)
        stack += [(child, 0) for child in reversed(children[0])]
        connectors = 0
        if not children[0] and self.vectors[0].any():
            # The root has no own bone for its end site.
            self._add_connector(f"{self.joints[0].name}_end", 0, self.vectors[0])
        ends: dict[int, Array] = {0: np.zeros(3)}
        while stack:
            index, parent = stack.pop()
            gap = self.offsets[index] - ends[parent]
            if gap.any():
                name = f"{self.joints[parent].name}_to_{self.skeleton.joints[index].name}"
                parent = self._add_connector(name, parent, gap)
                connectors += 1
            target = self._add_bone(index, parent)
            ends[target] = self.vectors[index]
            stack += [(child, target) for child in reversed(children[index])]
        if connectors:
            notices.append(
                Notice("note", f"{connectors} connector bones were added: an ASF bone begins where its parent ends")
            )
        dropped = sum(max(0, len(joint.end_sites) - (not children[i])) for i, joint in enumerate(self.skeleton.joints))
        if dropped:
            notices.append(Notice("warning", f"{dropped} end sites with sibling joints are left out"))
        return Plan(tuple(self.planned), Skeleton(tuple(self.joints)), {"units_angle": "deg"})

    def _add_root(self, adds: tuple[int, ...]) -> None:
        root = self.skeleton.joints[0]
        self.planned.append(PlannedJoint(0, -1, np.zeros(3), IDENTITY, "ZYX", True, adds))
        zeros = ("0", "0", "0")
        self.joints.append(
            replace(made(root, Convention.FIXED, -1, _CHANNELS, "XYZ"), offset=zeros, axis=zeros, axis_order="XYZ")
        )

    def _add_bone(self, index: int, parent: int) -> int:
        joint = self.skeleton.joints[index]
        axes = self.rest.orientations[index]
        moves = bool(self.moves[index])
        order = product_order(joint)
        # Fewer degrees of freedom stay fewer where the angles are copied.
        order = order if is_within(order, "ZYX") else "ZYX"
        self.planned.append(PlannedJoint(index, parent, self.offsets[index], axes, order, moves))
        channels = ("Tx", "Ty", "Tz") * moves + tuple(f"R{letter.lower()}" for letter in order[::-1])
        bone = made(joint, Convention.FIXED, parent, channels, order[::-1])
        self.joints.append(self._shaped(bone, self.vectors[index], axes))
        return len(self.joints) - 1

    def _add_connector(self, wanted: str, parent: int, vector: Array) -> int:
        name, count = wanted, 1
        while name in self.taken:
            count += 1
            name = f"{wanted}_{count}"
        self.taken.add(name)
        self.planned.append(PlannedJoint(None, parent, np.zeros(3), IDENTITY, "", False))
        connector = Joint(name, parent, name, Convention.FIXED)
        self.joints.append(self._shaped(connector, vector, IDENTITY))
        return len(self.joints) - 1

    def _shaped(self, bone: Joint, vector: Array, axes: Array) -> Joint:
        """The bone with direction, length and axis. A bone without length points up, as direction may not be zero."""
        length = float(np.linalg.norm(vector))
        direction = vector / length if length else np.array([0.0, 1.0, 0.0])
        angles = np.degrees(to_euler(axes[None], "ZYX")[0])[::-1]
        return replace(bone, direction=triple(direction), length=lexeme(length), axis=triple(angles), axis_order="XYZ")
