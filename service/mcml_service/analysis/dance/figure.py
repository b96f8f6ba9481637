"""The figure of a body: joints without fingers, the points of a cloud, body size; and motions rotated to Y up."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcml.motion.carriers import carriers
from mcml.motion.hub import walked
from mcml.motion.lexemes import triple
from mcml.motion.rotation_vectors import from_vector, twist
from mcml.motion.rotations import from_euler, inverse, multiply, rotate
from mcml.motion.skeleton import ROTATIONS, TRANSLATIONS, Array, Convention, EndSite, Joint, Skeleton, numbers
from mcml_service.analysis.interface import AnalysisError, Motion

COINCIDENT = 0.001
"""Of the body size: a bone shorter than this puts its joint where the parent is."""

_FINGER = re.compile(r"thumb|index|middle|ring|pinky|little|finger", re.IGNORECASE)
_BEARER = re.compile(r"hand|wrist|palm|arm|carp", re.IGNORECASE)
_FOOT = re.compile(r"foot|feet|toe", re.IGNORECASE)
_HELPERS = frozenset({"control", "origin", "twist"})
"""Roles of joints that are no part of the body: they would count twice, or stay where they are."""
_TURNS = {"X": np.array([0.0, 0.0, np.pi / 2]), "Z": np.array([-np.pi / 2, 0.0, 0.0])}
"""Angles about X, Y, Z that take an axis up to Y."""


@dataclass(frozen=True)
class Figure:
    """A body, Y up.

    size: the longest path between two nodes of the tree, end sites among them, in the rest pose; the clip's unit.
    used: (U,) joints that count. tips: (joint, vector (3,)) of the end sites that count, in the joint's axes.
    feet: joints of feet and toes. moved: (J,) whether a joint's translation comes from the clip, not the rest pose.
    """

    skeleton: Skeleton
    size: float
    used: NDArray[np.intp]
    tips: tuple[tuple[int, Array], ...]
    feet: NDArray[np.intp]
    moved: NDArray[np.bool_]

    @property
    def points(self) -> int:
        """Points of a pose in a cloud."""
        return len(self.used) + len(self.tips)


def figure_of(skeleton: Skeleton, translations: Array) -> Figure:
    """Return the figure of a skeleton; translations (F, J, 3) give the size for markers, which have no bones."""
    offsets = np.array([numbers(joint.offset) for joint in skeleton.joints])
    moved = np.array(
        [joint.parent < 0 or any(channel[0] == "T" for channel in joint.channels) for joint in skeleton.joints]
    )
    sites = tuple(
        (index, numbers(site.offset)) for index, joint in enumerate(skeleton.joints) for site in joint.end_sites
    )
    helpers = np.array([joint.role in _HELPERS for joint in skeleton.joints], dtype=bool)
    within = offsets.copy()
    within[[index for index, joint in enumerate(skeleton.joints) if _is_beside(skeleton, index)]] = 0.0
    size = body_size(skeleton.parents, within, sites)
    if size == 0 and len(translations):
        # Markers: the greatest distance between two of them, from their middles.
        middles = np.median(translations, axis=0)
        size = float(np.linalg.norm(middles[:, None] - middles[None], axis=-1).max(initial=0.0))
    fingers = finger_joints(skeleton)
    lengths = np.linalg.norm(offsets, axis=1)
    counts = ~fingers & ~helpers & (moved | (lengths >= COINCIDENT * size))
    tips = tuple(
        (joint, vector)
        for joint, vector in sites
        if not (fingers[joint] or helpers[joint]) and np.linalg.norm(vector) >= COINCIDENT * size
    )  # fmt: skip
    feet = [
        index
        for index, joint in enumerate(skeleton.joints)
        if not helpers[index] and any(map(_FOOT.search, _names(joint)))
    ]
    return Figure(skeleton, size, np.flatnonzero(counts), tips, np.array(feet, dtype=np.intp), moved)


def _is_beside(skeleton: Skeleton, index: int) -> bool:
    """Whether the way from the joint above is no bone of the body: that of helpers, and of the hips."""
    joint = skeleton.joints[index]
    above = skeleton.joints[joint.parent].role if joint.parent >= 0 else None
    return joint.role in _HELPERS or above == "origin"


def body_size(parents: NDArray[np.intp], offsets: Array, sites: tuple[tuple[int, Array], ...] = ()) -> float:
    """The longest path between two nodes of the tree, summing bone lengths. O(J).

    parents: (J,), -1 at a root, parents first. offsets: (J, 3) from the parent. sites: end sites, (joint, offset (3,)).

    >>> float(body_size(np.array([-1, 0, 0]), np.array([[9.0, 9, 9], [2, 0, 0], [0, 3, 0]])))
    5.0
    """
    deepest = np.zeros(len(parents))
    longest = 0.0
    for joint, offset in sites:
        longest, deepest[joint] = _add_branch(longest, deepest[joint], float(np.linalg.norm(offset)))
    for joint in reversed(range(len(parents))):
        parent = parents[joint]
        if parent >= 0:
            reach = deepest[joint] + float(np.linalg.norm(offsets[joint]))
            longest, deepest[parent] = _add_branch(longest, deepest[parent], reach)
    return longest


def _add_branch(longest: float, deepest: float, reach: float) -> tuple[float, float]:
    """The longest path and the deepest branch, once a branch of length `reach` hangs at the node too."""
    return max(longest, deepest + reach), max(deepest, reach)


def finger_joints(skeleton: Skeleton) -> NDArray[np.bool_]:
    """(J,) joints named like a finger below one named hand, wrist, palm, arm or carp, and all below them."""
    fingers = np.zeros(len(skeleton), dtype=bool)
    below = np.zeros(len(skeleton), dtype=bool)
    for index, joint in enumerate(skeleton.joints):
        parent = joint.parent
        if parent >= 0:
            bears = any(map(_BEARER.search, _names(skeleton.joints[parent])))
            below[index] = below[parent] or bears
            fingers[index] = fingers[parent] or (below[index] and any(map(_FINGER.search, _names(joint))))
    return fingers


def _names(joint: Joint) -> tuple[str, str]:
    return joint.name, joint.source_name


def cloud_points(figure: Figure, translations: Array, rotations: Array) -> Array:
    """Positions (F, P, 3) of the points of poses: joints that count, then end sites. Kovar et al. (2002).

    translations: (F, J, 3), rotations: (F, J, 4), as in `Motion`.
    """
    positions, turned = walked(figure.skeleton, translations, rotations)
    joints = positions[:, figure.used]
    if not figure.tips:
        return joints
    tips = [positions[:, joint] + rotate(turned[:, joint], vector) for joint, vector in figure.tips]
    return np.concatenate([joints, np.stack(tips, axis=1)], axis=1)


def check_finite(motion: Motion) -> None:
    """Raises AnalysisError `not-finite` with the joint and the first frame (from 1) that has no finite number."""
    wrong = ~(np.isfinite(motion.translations).all(axis=2) & np.isfinite(motion.rotations).all(axis=2))
    if wrong.any():
        frame, joint = (int(index) for index in np.argwhere(wrong)[0])
        name = motion.skeleton.joints[joint].name
        raise AnalysisError(
            "not-finite",
            f"{motion.name}: the joint {name} has no finite number in frame {frame + 1}.",
            remedy="Mend or cut the clip there.",
            document=motion.document,
            joint=name,
            frame=frame + 1,
        )


def upright(motion: Motion) -> Motion:
    """Rotate a motion to Y up, including its rest pose. Returns the same motion if Y is up already."""
    return _turn(motion, _TURNS.get((motion.up or "Y").upper()), "Y")


def carry_by_roots(motion: Motion) -> Motion:
    """The motion, Y up, with the way over the floor and the heading of each body in its root.

    The hips of some rigs move below a root that stays, as in Unreal Engine; dances are placed by their roots. Joints of
    the body stand where they stood. A root that cannot move and turn stays as it is.
    """
    skeleton = motion.skeleton
    moving = [
        (root, joint)
        for root, joint in zip(skeleton.roots, carriers(skeleton, motion.translations), strict=True)
        if joint != root and {*TRANSLATIONS, *ROTATIONS} <= set(skeleton.joints[root].channels)
    ]
    if not moving:
        return motion
    places, turned = walked(skeleton, motion.translations, motion.rotations)
    translations, rotations = motion.translations.copy(), motion.rotations.copy()
    up = np.array([0.0, 1.0, 0.0])
    for root, joint in moving:
        translations[:, root, ::2] = places[:, joint, ::2]
        rotations[:, root] = from_vector(twist(turned[:, joint], up)[:, None] * up)
    own_places, own_turned = walked(skeleton, translations, rotations)
    for _, joint in moving:
        above = skeleton.joints[joint].parent
        back = inverse(own_turned[:, above])
        translations[:, joint] = rotate(back, places[:, joint] - own_places[:, above])
        rotations[:, joint] = multiply(back, turned[:, joint])
    return replace(motion, translations=translations, rotations=rotations)


def lay_back(motion: Motion, up: str | None) -> Motion:
    """Rotate a motion with Y up back to another up axis: the inverse of `upright`."""
    turn = _TURNS.get((up or "Y").upper())
    return _turn(motion, None if turn is None else -turn, up)


def scale_motion(motion: Motion, factor: float) -> Motion:
    """The motion with every length multiplied, rest pose included."""
    joints = tuple(
        replace(
            joint,
            offset=triple(numbers(joint.offset) * factor),
            end_sites=tuple(EndSite(triple(numbers(s.offset) * factor), s.name, s.before) for s in joint.end_sites),
        )
        for joint in motion.skeleton.joints
    )
    skeleton = replace(motion.skeleton, joints=joints)
    metres = None if motion.metres is None else motion.metres / factor
    return replace(motion, skeleton=skeleton, translations=motion.translations * factor, metres=metres)


def _turn(motion: Motion, angles: Array | None, up: str | None) -> Motion:
    if angles is None:
        return motion if up == motion.up else replace(motion, up=up)
    turn = from_euler(angles, "XYZ")
    joints = tuple(_turn_joint(joint, turn) for joint in motion.skeleton.joints)
    return replace(
        motion,
        skeleton=replace(motion.skeleton, joints=joints),
        translations=rotate(turn, motion.translations),
        rotations=multiply(multiply(turn, motion.rotations), inverse(turn)),
        up=up,
    )


def _turn_joint(joint: Joint, turn: Array) -> Joint:
    if joint.convention is Convention.MARKER:
        return joint
    sites = tuple(EndSite(triple(_exact(turn, numbers(s.offset))), s.name, s.before) for s in joint.end_sites)
    return replace(joint, offset=triple(_exact(turn, numbers(joint.offset))), end_sites=sites)


def _exact(turn: Array, vector: Array) -> Array:
    """A vector after a quarter turn: its numbers change places and signs, not digits."""
    turned = rotate(turn, vector)
    nearest = np.abs(np.abs(turned)[:, None] - np.abs(vector)[None]).argmin(axis=1)
    exact: Array = np.copysign(np.abs(vector)[nearest], turned) + 0.0
    return exact
