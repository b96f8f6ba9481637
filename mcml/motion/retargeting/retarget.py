"""Retarget a motion to another skeleton.

Every matched joint is rotated in the world like its source, Q_t = Q_s A_s^-1 D A_t: A are the two at rest (or in poses
that show the same), D takes the target's bones there to the source's, by their directions in the world. Where bones
between matched joints bend that the target does not have, the remaining difference of directions is corrected by the
shortest arc. The hips are at the source's position, times the ratio of the lengths of the legs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.clip import FrameBlock, full_shape
from mcml.motion.feet.legs import legs_of
from mcml.motion.feet.locking import FootReport, foot_contacts, lock_feet
from mcml.motion.frames import leave_out, rows_of
from mcml.motion.hub import HubReader, walked
from mcml.motion.hub_writer import Flags, HubWriter, Shortfall
from mcml.motion.kinematics import unseen
from mcml.motion.retargeting.bone_mapping import Match, check_matches
from mcml.motion.retargeting.checks import check_across, check_rest
from mcml.motion.retargeting.connectors import without_hip_connectors, without_rigid
from mcml.motion.retargeting.hand_contacts import HandContact, HandKeeper
from mcml.motion.retargeting.limits import Limits
from mcml.motion.retargeting.parts import part_errors
from mcml.motion.retargeting.report import RetargetReport
from mcml.motion.retargeting.rest_poses import Known, comparable_bodies
from mcml.motion.retargeting.transfer import SourceMotion, Transfer
from mcml.motion.retargeting.travel import Travel
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.units import DEGREES, Reading

_STILL = 1e-9
"""Sine of half the angle by which a joint may turn that does not."""
_LOOKED_AT = 60
"""Frames of the target, from which the lengths of its bones are known."""


@dataclass(frozen=True)
class Retargeted:
    """block: frames on the target, in its own columns."""

    block: FrameBlock
    shortfall: Shortfall
    report: RetargetReport


def retarget(
    source: Skeleton,
    block: FrameBlock,
    target: Skeleton,
    matches: Sequence[Match],
    frame_time: float,
    *,
    reading: Reading = DEGREES,
    target_reading: Reading = DEGREES,
    source_pose: Array | None = None,
    target_pose: Array | None = None,
    clean: bool = False,
    up: str = "Y",
    scale: float | None = None,
    travel_scale: float | None = None,
    limits: Limits | None = None,
    keep_hands: bool = False,
    match_rest: bool = False,
    target_block: FrameBlock | None = None,
) -> Retargeted:
    """Return the frames of a clip on another skeleton.

    matches: of `suggest_matches`, or changed. source_pose, target_pose: (J, 4) local rotations of the hub form that
    show the same body pose on both; the rest poses by default. clean: lock planted feet. scale: of positions, by
    default from the legs. travel_scale: of positions along the ground, by default as `scale`. limits: of joints of the
    target, which are kept inside. keep_hands: bend arms so that hands which are near each other, the head or a thigh
    stay there (`hand_contacts`). match_rest: joints rotate from rest as their sources do, for any directions of their
    bones at rest; else bones point as they do in the source. target_block: frames of the target, for the lengths of a
    skeleton without any at rest. frame_time: seconds, up: "X", "Y" or "Z", for the feet. Both have the same up axis.
    A joint has no sample in frames in which that of its source, or of a joint above it, is missing.
    Raises ConversionError for a mapping that is empty, or names a joint twice or an unknown joint, and for impossible
    results: a rest pose without lengths, hips that point elsewhere (`checks`).
    """
    if not matches:
        raise ConversionError(
            "no joint of the two is matched", remedy="Name at least the joints of the trunk and limbs."
        )
    check_matches(source, target, matches)
    hub = HubReader(source, reading).read(block)
    writer = HubWriter(target, target_reading)
    shown = hub if target == source else None
    if target_block is not None:
        shown = HubReader(target, target_reading).read(rows_of(target_block, 0, min(len(target_block), _LOOKED_AT)))
    one, two = comparable_bodies(
        Known(source, HubReader(source, reading).rest, source_pose, hub),
        Known(target, writer.rest, target_pose, shown),
    )
    turning = set(np.flatnonzero(np.abs(hub.rotations[:, :, :3]).max(axis=(0, 2), initial=0.0) > _STILL).tolist())
    matched = without_hip_connectors(one, two, {match.target: match.source for match in matches})
    pairs = without_rigid(target, matched, writer.letters, turning)
    positions, turned = walked(source, hub.translations, hub.rotations)
    if source != target:
        check_rest(one, two, pairs, positions)
    transfer = Transfer(one, two, pairs, writer, turning, match_rest, limits)
    rotations, clamped = transfer.rotations(SourceMotion(positions, turned, hub.translations))
    scale = transfer.scale() if scale is None else scale
    travel = scale if travel_scale is None else travel_scale
    upward = np.eye(3)["XYZ".index(up.upper())]
    scales = np.where(upward > 0, scale, travel)
    translations = Travel(one, two, pairs).translations(hub.translations, positions, turned, rotations, scale, scales)
    translations, rotations, reports = _feet(
        transfer, positions, translations, rotations, frame_time, upward, writer, clean
    )
    hands: tuple[HandContact, ...] = ()
    if keep_hands:
        keeper = HandKeeper(target, pairs, positions, transfer.scale(), frame_time, transfer.allow)
        rotations, hands = keeper.keep(translations, rotations)
    values = writer.write(translations, rotations, _weights(source, target, hub.scales))
    columns = target.columns()
    names = block.motion_names
    made = FrameBlock(values, columns, (full_shape(columns),), block.ids, None, names)
    made = leave_out(made, _known(source, block, len(target), pairs))
    placed = walked(target, translations, rotations)[0]
    bones = transfer.bone_errors(positions, placed)
    parts = part_errors(one, two, pairs, bones, positions, placed)
    if not match_rest:
        check_across(one, two, pairs, parts)
    report = RetargetReport(
        tuple(matches),
        scale,
        tuple(sorted(set(range(len(source))) - set(matched.values()))),
        tuple(sorted(set(range(len(target))) - set(matched))),
        bones,
        reports,
        parts,
        travel,
        clamped,
        transfer.beyond_limits(rotations),
        hands,
    )
    return Retargeted(made, writer.shortfall, report)


def _weights(source: Skeleton, target: Skeleton, scales: Array) -> Array | None:
    """(n, J) scales of the target: 1 of joints; of blend shapes the source's weights by their names, else 0."""
    if not target.blend_shapes:
        return None
    found = np.ones((len(scales), len(target)))
    own = {source.joints[index].name: index for index in source.blend_shapes}
    for index in target.blend_shapes:
        place = own.get(target.joints[index].name)
        found[:, index] = 0.0 if place is None else scales[:, place]
    return found


def _known(source: Skeleton, block: FrameBlock, joints: int, pairs: Mapping[int, int]) -> Flags:
    """(n, J) where the joints of the target that take their motion from one of the source can know it."""
    known = np.ones((len(block), joints), dtype=bool)
    lost = unseen(source, block)
    for target, own in pairs.items():
        known[:, target] = ~lost[:, own]
    return known


def _feet(
    transfer: Transfer,
    positions: Array,
    translations: Array,
    rotations: Array,
    frame_time: float,
    up: Array,
    writer: HubWriter,
    clean: bool,
) -> tuple[Array, Array, tuple[FootReport, ...]]:
    """Feet of the target as they stand in the source. positions: of the source."""
    skeleton, pairs = transfer.two.skeleton, transfer.pairs
    legs = [leg for leg in legs_of(skeleton) if {leg.hip, leg.knee, leg.ankle} <= set(pairs)]
    legs = [leg if leg.toe in pairs else replace(leg, toe=leg.ankle) for leg in legs]
    length = transfer.leg(transfer.one, source=True) or float(np.ptp(transfer.one.positions @ up))
    stands = [foot_contacts(positions, pairs[leg.toe], pairs[leg.ankle], frame_time, length, up) for leg in legs]
    locked = lock_feet(skeleton, legs, stands, translations, rotations, frame_time, up, writer, clean)
    return locked.translations, locked.rotations, locked.reports
