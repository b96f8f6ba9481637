"""Lock planted feet: legs bend, and the body sinks a little, so that a standing foot stays where it stands.

Kovar, Schreiner, Gleicher, "Footskate cleanup for motion capture editing" (2002): the root is lowered where a leg would
be too short, then each leg is bent by two-bone inverse kinematics; the foot keeps its orientation in the world.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from mcml.motion.carriers import carriers
from mcml.motion.feet.contacts import contact_flags, sliding
from mcml.motion.feet.legs import Leg, is_below
from mcml.motion.feet.limbs import bend_limb, limb_hinge
from mcml.motion.feet.moves import hold_moves, spread_moves
from mcml.motion.feet.two_bones import STRETCHED
from mcml.motion.hub import walked
from mcml.motion.hub_writer import Flags, HubWriter
from mcml.motion.rotations import inverse, rotate
from mcml.motion.skeleton import TRANSLATIONS, Array, Skeleton
from mcml.numerics.runs import find_true

FADE = 0.15
"""Seconds over which a correction fades out."""
_FARTHEST = 0.25
"""Leg lengths: the most that a foot is moved."""
_MISSED = 0.02
"""Leg lengths: a foot that misses its place by more is told."""
_LOWEST = 0.08
"""Leg lengths: the most that the body is lowered."""
_CALM = 0.2
"""Seconds over which the body is lowered and lifted."""


@dataclass(frozen=True)
class FootReport:
    """joint: the planted joint of the target.

    contacts: (first frame, last frame) from 0. before, after: distance that it slides over the ground during contacts,
    in the target's unit, over all frames. missed: the farthest that it is from where it should be held, in lengths of
    the leg; 0 if nothing is locked. left: number of contacts that are left alone, since the foot slides too far.
    """

    joint: int
    contacts: tuple[tuple[int, int], ...]
    before: float
    after: float
    missed: float = 0.0
    left: int = 0

    def shortcomings(self) -> list[str]:
        """Words for contacts left alone, and for a place that the leg does not reach."""
        told = []
        if self.left:
            told.append(f"{self.left} contacts slide too far and are left alone")
        if self.missed > _MISSED:
            told.append(f"it misses its place by up to {self.missed:.2f} leg lengths")
        return told


@dataclass(frozen=True)
class Contacts:
    """Contacts of a foot, (n,) each: of its toe, and of its ankle."""

    toe: Flags
    ankle: Flags

    @property
    def any(self) -> Flags:
        """Whether any part of it stands."""
        return self.toe | self.ankle


@dataclass(frozen=True)
class Locked:
    """Frames in the hub form, (n, J, 3) and (n, J, 4), and a report by leg."""

    translations: Array
    rotations: Array
    reports: tuple[FootReport, ...]


def foot_contacts(places: Array, toe: int, ankle: int, frame_time: float, leg: float, up: Array) -> Contacts:
    """Contacts of a foot of a body at positions (n, J, 3). leg: its length."""
    stands = contact_flags(places[:, ankle], frame_time, leg, up)
    return Contacts(stands if toe == ankle else contact_flags(places[:, toe], frame_time, leg, up), stands)


def lock_feet(
    skeleton: Skeleton,
    legs: Sequence[Leg],
    contacts: Sequence[Contacts],
    translations: Array,
    rotations: Array,
    frame_time: float,
    up: Array,
    writer: HubWriter,
    lock: bool = True,
) -> Locked:
    """Lock planted feet during contacts.

    contacts: of each leg. translations (n, J, 3), rotations (n, J, 4): hub form. frame_time: seconds. up: (3,) unit
    vector. writer: knows the channels of the joints. lock: if false, nothing is changed, only reported. Feet that would
    be moved by over a quarter of the leg are left alone.
    """
    places = walked(skeleton, translations, rotations)[0]
    moves, left = [], []
    for leg, stands in zip(legs, contacts, strict=True):
        most = _FARTHEST * leg.length(places)
        held = hold_moves(places[:, leg.toe], places[:, leg.ankle], stands.toe, stands.ankle, up, most)
        left.append(sum(bool(np.isnan(held[first, 0])) for first, _ in find_true(stands.any).tolist()) if lock else 0)
        moves.append(spread_moves(held, max(1, round(FADE / frame_time))))
    missed = np.zeros(len(legs))
    after = places
    if lock:
        translations, rotations, missed = move_feet(
            skeleton, legs, moves, translations, rotations, frame_time, up, writer
        )
        after = walked(skeleton, translations, rotations)[0]
    reports = []
    for leg, stands, miss, alone in zip(legs, contacts, missed, left, strict=True):
        flags = stands.toe if leg.toe != leg.ankle else stands.ankle
        spans = tuple((first, end - 1) for first, end in find_true(flags).tolist())
        slid = [sliding(at[:, leg.toe], spans, up) for at in (places, after)]
        length = leg.length(places)
        reports.append(FootReport(leg.toe, spans, slid[0], slid[1], float(miss) / length if length else 0.0, alone))
    return Locked(translations, rotations, tuple(reports))


def move_feet(
    skeleton: Skeleton,
    legs: Sequence[Leg],
    moves: Sequence[Array],
    translations: Array,
    rotations: Array,
    frame_time: float,
    up: Array,
    writer: HubWriter,
    fixed_ends: bool = False,
    hinges: Sequence[Array | None] | None = None,
) -> tuple[Array, Array, Array]:
    """Move feet by (n, 3) each; return translations, rotations, and by leg the farthest that a foot misses its place.

    Feet keep their orientation in the world. The body is lowered where a leg is too short, by a twelfth of the leg at
    most. Frames without moves keep their bits. fixed_ends: the frames continue others that stay as they are, where the
    body is not lowered. hinges: axes of knees in their thighs; default those of these frames (`limb_hinge`).
    """
    missed = np.zeros(len(legs))
    if not len(translations) or not any(move.any() for move in moves):
        return translations, rotations, missed
    places, world = walked(skeleton, translations, rotations)
    goals = [places[:, leg.toe] + move for leg, move in zip(legs, moves, strict=True)]
    if hinges is None:
        hinges = [limb_hinge(places, world, leg.joints) for leg in legs]
    translations, lowered = _lower(skeleton, legs, moves, (places, world), translations, frame_time, up, fixed_ends)
    for index, (leg, goal, move, hinge) in enumerate(zip(legs, goals, moves, hinges, strict=True)):
        rows = np.flatnonzero(lowered | move.any(axis=1))
        if len(rows):
            bent = bend_limb(skeleton, leg.joints, translations, rotations, goal, world[:, leg.ankle], hinge, writer)
            rotations = rotations.copy()
            rotations[rows] = bent[rows]
            at = walked(skeleton, translations[rows], rotations[rows])[0][:, leg.toe]
            missed[index] = np.linalg.norm(at - goal[rows], axis=1).max()
    return translations, rotations, missed


def _lower(
    skeleton: Skeleton,
    legs: Sequence[Leg],
    moves: Sequence[Array],
    poses: tuple[Array, Array],
    translations: Array,
    frame_time: float,
    up: Array,
    fixed_ends: bool,
) -> tuple[Array, Flags]:
    """Return translations with the body lowered where a leg would be too short, and in which frames (n,)."""
    places, world = poses
    depth = np.zeros(len(places))
    for leg, move in zip(legs, moves, strict=True):
        depth = np.maximum(depth, _missing_height(places[:, [leg.hip, leg.knee, leg.ankle]], move, up))
    if not depth.any():
        return translations, depth > 0
    window = max(1, round(_CALM / frame_time)) // 2 * 2 + 1
    weights = np.hanning(window + 2)[1:-1]
    # The smoothed maximum over as many frames is nowhere below the depth itself.
    depth = scipy.ndimage.convolve1d(
        scipy.ndimage.maximum_filter1d(depth, window, mode="nearest"), weights / weights.sum(), mode="nearest"
    )
    if fixed_ends:
        rows = np.arange(len(depth))
        part = np.minimum(1.0, np.minimum(rows + 1, len(depth) - rows) / (window / 2 + 1))
        depth *= part * part * (3 - 2 * part)
    bearers = [joint for joint in carriers(skeleton, translations) if any(_bears(skeleton, joint, leg) for leg in legs)]
    translations = translations.copy()
    for joint in bearers:
        parent = skeleton.joints[joint].parent
        shift = -depth[:, None] * up
        translations[:, joint] += shift if parent < 0 else rotate(inverse(world[:, parent]), shift)
    return translations, (depth > 0) & bool(bearers)


def _bears(skeleton: Skeleton, joint: int, leg: Leg) -> bool:
    moves = set(TRANSLATIONS) <= set(skeleton.joints[joint].channels)
    return moves and (joint == leg.hip or is_below(skeleton, leg.hip, joint))


def _missing_height(joints: Array, move: Array, up: Array) -> Array:
    """(n,) by how much a hip is to be lowered so that the leg reaches. joints: (n, 3, 3) hip, knee, ankle."""
    bones = np.linalg.norm(np.diff(joints, axis=1), axis=2).sum(axis=1)
    line = joints[:, 2] + move - joints[:, 0]
    reach = np.maximum(STRETCHED * bones, np.linalg.norm(joints[:, 2] - joints[:, 0], axis=1))
    height = -(line @ up)
    across = np.linalg.norm(line + np.outer(height, up), axis=1)
    depth = height - np.sqrt(np.maximum(reach**2 - across**2, 0.0))
    short = move.any(axis=1) & (np.linalg.norm(line, axis=1) > reach)
    return np.where(short, np.clip(depth, 0.0, _LOWEST * bones), 0.0)
