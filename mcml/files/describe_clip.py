"""Receipts of imports: the content of a file, guesses with their reasons, and repairs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mcml.errors import Notice
from mcml.language.joint_names import NamingReport
from mcml.motion.clip import ClipHead
from mcml.motion.guesses import FEWEST_NAMED, likely_units
from mcml.motion.kinematics import rest_positions
from mcml.motion.skeleton import Array, Convention, Skeleton
from mcml.motion.units import metres_of

_NO_POSE, _SMALLEST, _LARGEST = 0.01, 0.3, 4.0
"""Metres of the rest pose of a person along its longest side; arms may be raised, and children are small. Files without
a rest pose have all joints at one point."""


def unit_facts(head: ClipHead, extent: Array) -> dict[str, Any]:
    """Return {value, stated, why}: the length unit that the clip states, or None and a guess from its size.

    extent: of the rest pose along X, Y, Z.
    """
    unit = head.fields.get("calibration_unit")
    if unit:
        return {"value": unit, "stated": True, "why": "the header says so"}
    length = head.fields.get("units_length")
    if length:
        return {
            "value": None,
            "stated": False,
            "why": f"the ASF states the factor `length {length}`, not a unit; values divided by it are local units "
            "(inches in CMU and HDM05 files)",
        }
    height = float(extent[1] if extent[1] >= 0.5 * extent.max() else extent.max())
    likely = likely_units(height)
    looks = f", which would be a person in {' or '.join(likely)}" if likely else ""
    return {"value": None, "stated": False, "why": f"the file names no unit; the rest pose is {height:.4g} tall{looks}"}


def _check_size(head: ClipHead, names: NamingReport | None, extent: Array) -> list[Notice]:
    """A warning if the stated unit makes a person of a size that no person has."""
    metres = metres_of(head)
    if metres is None or names is None or names.refused or len(names.named) < FEWEST_NAMED:
        return []
    size = float(extent.max()) * metres
    if not _NO_POSE < size < _SMALLEST and not size > _LARGEST:
        return []
    unit = head.fields["calibration_unit"]
    what = f"in {unit}, this person measures {size:.3g} m: if that is wrong, import with another unit"
    return [Notice("warning", what)]


def rate_facts(head: ClipHead) -> dict[str, Any]:
    """{seconds, frames_per_second, stated, why}."""
    seconds = head.seconds_per_frame()
    if seconds is None:
        return {
            "seconds": None,
            "frames_per_second": None,
            "stated": False,
            "why": "the file states no frame time; say it with frame_time (CMU and HDM05 record at 120 a second)",
        }
    why = "Frame time as the file writes it" if head.frame_time is not None else "the header's frame rate"
    return {"seconds": seconds, "frames_per_second": 1.0 / seconds, "stated": True, "why": why}


def up_facts(head: ClipHead, extent: Array) -> dict[str, Any]:
    """{value, stated, why}: the axis that points up."""
    axis = head.fields.get("global_axis_of_gravity")
    if axis:
        return {"value": axis.upper(), "stated": True, "why": "the header says so"}
    if not extent.any():
        why = "the file names no up axis; the calibration guesses it from the frames"
        return {"value": None, "stated": False, "why": why}
    axis = "XYZ"[int(np.argmax(extent))]
    return {"value": None, "stated": False, "why": f"the file names no up axis; the rest pose is longest along {axis}"}


@dataclass(frozen=True)
class SkeletonFacts:
    """The facts about a skeleton in a receipt.

    extent: of its rest pose along X, Y, Z. orders: number of joints for each rotation order.
    """

    extent: Array
    channels: int
    orders: Mapping[str, int]
    conventions: frozenset[Convention]
    translations: tuple[str, ...]


def skeleton_facts(skeleton: Skeleton) -> SkeletonFacts:
    positions = rest_positions(skeleton)
    turning = [joint for joint in skeleton.joints if any(channel.startswith("R") for channel in joint.channels)]
    return SkeletonFacts(
        extent=np.ptp(positions, axis=0) if len(positions) else np.zeros(3),
        channels=len(skeleton.columns()),
        orders=Counter(joint.rotation_order for joint in turning if joint.rotation_order),
        conventions=frozenset(joint.convention for joint in skeleton.joints),
        translations=tuple(sorted({joint.translation for joint in skeleton.joints if joint.translation})),
    )


def receipt(
    head: ClipHead, facts: SkeletonFacts, frames: int, names: NamingReport | None, notices: list[Notice]
) -> dict[str, Any]:
    """The whole receipt as plain JSON values. facts: of the head's skeleton."""
    return {
        "format": head.format,
        "frames": frames,
        "joints": len(head.skeleton),
        "channels": facts.channels,
        "naming": None
        if names is None
        else {
            "rig": names.kind,
            "mapped": names.mapped,
            "joints": [
                {"source": each.source, "name": each.name, "confidence": each.confidence, "how": each.how}
                for each in names.named
            ],
            "landmarks": dict(names.landmarks),
            "unmapped": [{"source": source, "name": name, "why": why} for source, name, why in names.unmapped],
        },
        "unit": unit_facts(head, facts.extent),
        "frame_rate": rate_facts(head),
        "up_axis": up_facts(head, facts.extent),
        "rotation_orders": dict(facts.orders),
        "conventions": sorted(convention.value for convention in facts.conventions),
        "translation": list(facts.translations),
        "encoding": {part.part: part.encoding for part in head.sources},
        "number_style": head.number_style,
        "markers": Convention.MARKER in facts.conventions,
        "notices": [
            {"kind": notice.kind, "what": notice.what, "at": None if notice.at is None else str(notice.at)}
            for notice in (
                *notices,
                *_check_size(head, names, facts.extent),
                *(() if names is None else names.notices()),
            )
        ],
        "twins": [],
    }
