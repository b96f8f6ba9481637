"""The transfer of poses from one body to another, joint by joint."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mcml.motion.hub_writer import HubWriter
from mcml.motion.retargeting.checks import angles_between
from mcml.motion.retargeting.connectors import side_lines, turn_about
from mcml.motion.retargeting.hinges import best_twist
from mcml.motion.retargeting.limits import ClampedJoint, Limits, clamp_joint, describe_clamped, joint_limits
from mcml.motion.retargeting.posed_bodies import PosedBody, upright_axes
from mcml.motion.retargeting.report import BoneError
from mcml.motion.retargeting.travel import Travel
from mcml.motion.rotation_vectors import from_vector, shortest_arcs
from mcml.motion.rotations import from_matrix, inverse, multiply, rotate, shortest_arc
from mcml.motion.sides import is_left, partners
from mcml.motion.skeleton import Array

_LOOKED_AT = 60
"""Number of frames used to find the twist of limbs."""
_STEPS = 12
"""Of the search for the angles of a joint that cannot turn freely."""
_FINGERS = {f"finger_{finger}": place for place, finger in enumerate(("three", "two", "four", "five", "one"), 1)}
"""Fingers to which the bone of a hand may lead, the middle one first."""


@dataclass(frozen=True)
class SourceMotion:
    """The source's frames in the world: positions (n, Js, 3), turned (n, Js, 4); moved: (n, Js, 3) in parents."""

    positions: Array
    turned: Array
    moved: Array

    def at(self, rows: NDArray[np.intp]) -> SourceMotion:
        """Some of the frames."""
        return SourceMotion(self.positions[rows], self.turned[rows], self.moved[rows])


class Transfer:
    """The transfer of poses from one body to another. pairs: joint of the target -> joint of the source."""

    def __init__(
        self,
        one: PosedBody,
        two: PosedBody,
        pairs: dict[int, int],
        writer: HubWriter,
        turning: Set[int],
        from_rest: bool = False,
        limits: Limits | None = None,
    ) -> None:
        """turning: joints of the source that turn in their parents. from_rest: joints turn from rest as their sources
        do, wherever their bones point then. limits: of joints of the target, which are kept; without them the file's
        limits only decide between twists of limbs.
        """
        self._limits = {} if limits is None else limits
        self.one, self.two, self.pairs, self._writer, self._from_rest = one, two, pairs, writer, from_rest
        self._partners = partners(two.skeleton)
        self._above = self._matched_above()
        self._travel = Travel(one, two, pairs)
        self._lines = side_lines(one.skeleton, two.skeleton, pairs, writer.letters, turning)
        self._ends = {joint: self._end_of(joint) for joint in pairs}
        self._turns: dict[int, Array] = {}
        for joint in sorted(pairs):
            above = self._above[joint]
            before = self._turns[above] if above >= 0 else np.array([0.0, 0.0, 0.0, 1.0])
            self._turns[joint] = self._turn(joint, before)

    def _matched_above(self) -> list[int]:
        """The nearest matched joint above each joint of the target, -1 for none."""
        above: list[int] = []
        for joint in self.two.skeleton.joints:
            parent = joint.parent
            above.append(-1 if parent < 0 else parent if parent in self.pairs else above[parent])
        return above

    def _vectors(self, start: int, end: int) -> tuple[Array, Array] | None:
        """From one matched joint to another, in the source and in the target; None where one is too short."""
        first = self.one.positions[self.pairs[end]] - self.one.positions[self.pairs[start]]
        second = self.two.positions[end] - self.two.positions[start]
        fits = np.linalg.norm(first) > self.one.short and np.linalg.norm(second) > self.two.short
        return (first, second) if fits else None

    def _end_of(self, joint: int) -> int | None:
        """The matched joint below to which the bone leads: the one in the middle where it branches, of the body or of a
        hand."""
        names = self.two.skeleton.names
        below = [end for end in self.pairs if self._above[end] == joint and self._vectors(joint, end)]
        below.sort(key=lambda end: (_FINGERS.get(names[end].partition("_")[2], 0), names[end]))
        middle = [end for end in below if self._partners[end] == end]
        if len(below) == 1 or not below:
            return below[0] if below else None
        if middle:
            return middle[0]
        return None if int(self._partners[below[0]]) in below else below[0]

    def _turn(self, joint: int, before: Array) -> Array:
        """D of a joint; before: that of the matched joint above."""
        if self._from_rest:
            return before
        if self._partners[joint] == joint:
            axes = self._axes(joint)
            if axes is not None:
                return from_matrix(axes[0] @ axes[1].T)
        end = self._ends[joint]
        vectors = None if end is None else self._vectors(joint, end)
        if vectors is None:
            return before
        return multiply(shortest_arc(rotate(before, vectors[1]), vectors[0]), before)

    def _axes(self, joint: int) -> tuple[Array, Array] | None:
        """Axes (3, 3) to the left, up and on of a joint in the middle of the body, in the source and in the target."""
        # The nearest sides first: the legs of a pelvis, not its arms.
        names = self.two.skeleton.names
        below = [other for other in self.pairs if self._is_below(other, joint)]
        below.sort(key=lambda other: (self._depth(other), names[other]))
        middle = [other for other in below if self._partners[other] == other and self._vectors(joint, other)]
        for left in below:
            right = int(self._partners[left])
            if right == left or right not in self.pairs or not is_left(self.two.skeleton, left, right):
                continue
            across = self._vectors(right, left)
            if across is None or min(self._breadths(across)) < 0.02 or not middle:
                continue
            upward = self._vectors(joint, middle[-1])
            assert upward is not None
            found = [upright_axes(side, high) for side, high in zip(across, upward, strict=True)]
            if found[0] is not None and found[1] is not None:
                return found[0], found[1]
        return None

    def _breadths(self, across: tuple[Array, Array]) -> tuple[float, float]:
        """Lengths in parts of the bodies' extents."""
        sizes = (np.ptp(self.one.positions, axis=0).max(), np.ptp(self.two.positions, axis=0).max())
        return float(np.linalg.norm(across[0]) / sizes[0]), float(np.linalg.norm(across[1]) / sizes[1])

    def _depth(self, joint: int) -> int:
        above = self._above[joint]
        return 0 if above < 0 else 1 + self._depth(above)

    def _is_below(self, joint: int, other: int) -> bool:
        above = self._above[joint]
        while above >= 0 and above != other:
            above = self._above[above]
        return above == other

    def rotations(self, motion: SourceMotion) -> tuple[Array, tuple[ClampedJoint, ...]]:
        """Local rotations (n, J, 4) of the target, and joints that are kept inside their limits.

        Joints that cannot rotate freely are rotated so that their bone's direction is as close as possible.
        """
        positions, turned = motion.positions, motion.turned
        if not self._from_rest:
            self._turn_limbs(motion)
        skeleton = self.two.skeleton
        local = np.empty((len(positions), len(skeleton), 4))
        world = np.empty_like(local)
        clamped: list[ClampedJoint | None] = []
        for index, joint in enumerate(skeleton.joints):
            above = (
                world[:, joint.parent] if joint.parent >= 0 else np.broadcast_to([0.0, 0.0, 0.0, 1.0], (len(local), 4))
            )
            source = self.pairs.get(index)
            if source is None:
                local[:, index] = self._turn_connector(index, above, world, positions)
            elif self._from_rest:
                local[:, index] = multiply(inverse(above), self._wanted(index, turned))
            else:
                local[:, index] = self._point_bone(index, above, self._wanted(index, turned), motion)
                local[:, index] = self._face_sides(index, above, local[:, index], positions)
            if index in self._limits:
                local[:, index], outside = clamp_joint(self._limits[index], index, self._writer, local[:, index])
                clamped.append(describe_clamped(index, outside))
            # Else lengths beside 1 would grow from joint to joint, since `inverse` takes rotations as unit quaternions.
            local[:, index] /= np.linalg.norm(local[:, index], axis=-1, keepdims=True)
            world[:, index] = multiply(above, local[:, index])
        return local, tuple(each for each in clamped if each is not None)

    def allow(self, index: int, local: Array) -> Array:
        """Return the local rotations (n, 4) nearest to given ones that the channels and limits of a joint allow."""
        held = self._writer.nearest(index, local)
        return clamp_joint(self._limits[index], index, self._writer, held)[0] if index in self._limits else held

    def beyond_limits(self, local: Array) -> tuple[ClampedJoint, ...]:
        """Find joints of rotations (n, J, 4) that are outside the limits."""
        found = (
            describe_clamped(index, clamp_joint(limits, index, self._writer, local[:, index])[1])
            for index, limits in self._limits.items()
        )
        return tuple(each for each in found if each is not None)

    def _turn_connector(self, index: int, above: Array, world: Array, positions: Array) -> Array:
        """Local rotations (n, 4) of a joint without a match: as in the pose, or as the line between two sides needs."""
        held = np.broadcast_to(self.two.local[index], (len(positions), 4))
        line = next((line for line in self._lines if index in line.connectors), None)
        if line is None or self._from_rest:
            return held
        bearer = multiply(world[:, line.above], inverse(self.two.turned[line.above]))
        own = rotate(bearer, self.two.positions[line.left] - self.two.positions[line.right])
        goal = positions[:, self.pairs[line.left]] - positions[:, self.pairs[line.right]]
        wanted = multiply(shortest_arcs(own, goal), multiply(above, held))
        return self._writer.nearest(index, multiply(inverse(above), wanted))

    def _face_sides(self, index: int, above: Array, local: Array, positions: Array) -> Array:
        """Local rotations (n, 4) of a matched joint, turned about its bone for the line of the sides below it."""
        line = next((line for line in self._lines if line.above == index and not line.connectors), None)
        end = self._ends[index]
        if line is None or end is None or not self._writer.is_free(index):
            return local
        turned = multiply(above, local)
        back = inverse(self.two.turned[index])
        own, bone = (
            rotate(turned, rotate(back, self.two.positions[one] - self.two.positions[two]))
            for one, two in ((line.left, line.right), (end, index))
        )
        goal = positions[:, self.pairs[line.left]] - positions[:, self.pairs[line.right]]
        return multiply(inverse(above), multiply(turn_about(bone, own, goal), turned))

    def _wanted(self, index: int, turned: Array) -> Array:
        """Rotations (n, 4) of a matched joint in the world, before its bone is pointed."""
        source = self.pairs[index]
        turn = multiply(inverse(self.one.turned[source]), self._turns[index])
        return multiply(turned[:, source], multiply(turn, self.two.turned[index]))

    def _turn_limbs(self, motion: SourceMotion) -> None:
        """Turns limbs about themselves where the hinge below could not point its bone else."""
        count = len(motion.positions)
        motion = motion.at(np.unique(np.linspace(0, max(count - 1, 0), _LOOKED_AT).astype(np.intp))[:count])
        for joint in sorted(self.pairs):
            hinge = self._ends[joint]
            end = None if hinge is None else self._ends[hinge]
            if hinge is None or end is None or not self._writer.is_free(joint) or self._writer.is_free(hinge):
                continue
            bone = self.two.positions[hinge] - self.two.positions[joint]
            limb = (joint, hinge, end, bone / np.linalg.norm(bone), self._turns[joint])
            error = partial(self._measure_miss, limb, motion)
            error(best_twist(error))

    def _measure_miss(self, limb: tuple[int, int, int, Array, Array], motion: SourceMotion, angle: float) -> float:
        """Return the error of the direction of the bone at a hinge in degrees, with the limb twisted by an angle.

        limb: (joint, hinge, end of the hinge's bone, unit vector (3,) along the limb, its D before). The twist stays.
        """
        joint, hinge, end, bone, before = limb
        self._turns[joint] = multiply(before, from_vector(angle * bone))
        positions, turned = motion.positions, motion.turned
        nothing = np.tile([0.0, 0.0, 0.0, 1.0], (len(positions), 1))
        above = self._point_bone(joint, nothing, self._wanted(joint, turned), motion)
        local = self._point_bone(hinge, above, self._wanted(hinge, turned), motion)
        along = rotate(inverse(self.two.turned[hinge]), self.two.positions[end] - self.two.positions[hinge])
        goal = positions[:, self.pairs[end]] - positions[:, self.pairs[hinge]]
        missed = angles_between(rotate(multiply(above, local), along), goal)
        limits = joint_limits(self.two.skeleton.joints[hinge], self._writer.letters(hinge))
        outside = 0.0 if limits is None else clamp_joint(limits, hinge, self._writer, local)[1]
        return float((missed + outside).mean()) if len(missed) else 0.0

    def _point_bone(self, index: int, above: Array, wanted: Array, motion: SourceMotion) -> Array:
        """Local rotations (n, 4) that are near the wanted ones in the world and point the bone where it should be."""
        end = self._ends[index]
        free = self._writer.is_free(index)
        back = inverse(above)
        if end is None:
            return self._writer.nearest(index, multiply(back, wanted))
        goal = self._line(index, end, motion)
        bone = rotate(inverse(self.two.turned[index]), self.two.positions[end] - self.two.positions[index])
        found = wanted
        for _ in range(1 if free else _STEPS):
            found = multiply(shortest_arcs(rotate(found, bone), goal), found)
            found = multiply(above, self._writer.nearest(index, multiply(back, found)))
        return multiply(back, found)

    def _line(self, index: int, end: int, motion: SourceMotion) -> Array:
        """(n, 3) from a matched joint to the end of its bone in the source, without the way that the end moves along
        with its source from its place at rest.
        """
        joint, other = self.pairs[index], self.pairs[end]
        line = motion.positions[:, other] - motion.positions[:, joint]
        if not self._travel.moves_along(end):
            return line
        return line - rotate(motion.turned[:, joint], motion.moved[:, other] - self.one.rest.offsets[other])

    def scale(self) -> float:
        """From the legs; without legs from all common bones; 1 without bones."""
        one, two = self.leg(self.one, source=True), self.leg(self.two, source=False)
        if one and two:
            return two / one
        first = second = 0.0
        for joint, end in self._ends.items():
            vectors = None if end is None else self._vectors(joint, end)
            if vectors is not None:
                first, second = first + float(np.linalg.norm(vectors[0])), second + float(np.linalg.norm(vectors[1]))
        return second / first if first else 1.0

    def leg(self, body: PosedBody, source: bool) -> float:
        """The mean length of matched legs, from hip to ankle along the bones; 0 without legs."""
        places = {joint.name: index for index, joint in enumerate(self.two.skeleton.joints) if index in self.pairs}
        lengths = []
        for side in ("left", "right"):
            joints = [places.get(f"{side}_{part}") for part in ("up_leg", "low_leg", "foot")]
            if all(joint is not None for joint in joints):
                at = [self.pairs[joint] if source else joint for joint in joints if joint is not None]
                lengths.append(sum(np.linalg.norm(np.diff(body.positions[at], axis=0), axis=1)))
        return float(np.mean(lengths)) if lengths else 0.0

    def bone_errors(self, positions: Array, made: Array) -> tuple[BoneError, ...]:
        """How far bones that both have point elsewhere. positions: of the source, made: of the target, in the world."""
        errors = []
        for end in self.pairs:
            joint = self._above[end]
            if joint < 0 or self._vectors(joint, end) is None:
                continue
            one = positions[:, self.pairs[end]] - positions[:, self.pairs[joint]]
            two = made[:, end] - made[:, joint]
            angles = angles_between(one, two)
            largest, mean = (float(angles.max()), float(angles.mean())) if len(angles) else (0.0, 0.0)
            worst = int(angles.argmax()) if len(angles) else 0
            errors.append(BoneError(joint, end, self._ends[joint] == end, largest, mean, worst))
        return tuple(errors)
