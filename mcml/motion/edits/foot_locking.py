"""Lock planted feet in a range of frames of a clip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.clip import FrameBlock
from mcml.motion.feet.legs import Leg, legs_of
from mcml.motion.feet.locking import Contacts, FootReport, foot_contacts, lock_feet
from mcml.motion.frames import Edited, in_columns, remade
from mcml.motion.hub import HubReader, walked
from mcml.motion.hub_writer import Flags, HubWriter, Known
from mcml.motion.skeleton import Skeleton
from mcml.motion.units import DEGREES, Reading
from mcml.numerics.runs import find_true


@dataclass(frozen=True)
class FeetLocked:
    """edited: the frames. feet: of each leg a report, lengths in leg lengths."""

    edited: Edited
    feet: tuple[tuple[Leg, FootReport], ...]


def lock_clip_feet(
    skeleton: Skeleton,
    block: FrameBlock,
    rows: slice,
    frame_time: float,
    sides: Sequence[str],
    up: str = "Y",
    reading: Reading = DEGREES,
) -> FeetLocked:
    """Lock feet during their contacts that lie in some rows.

    block: all frames of the clip, which tell where the ground is. sides: "left", "right". frame_time: seconds.
    Contacts that go on outside the rows are left alone. Numbers of other joints keep their bits, as do frames
    without a correction. Raises ConversionError for a skeleton without such legs, or whose legs
    have no length.
    """
    legs = [leg for leg in legs_of(skeleton) if leg.side in sides]
    if not legs:
        raise ConversionError(
            f"the skeleton has no {' or '.join(sides)} leg from hip to knee to ankle",
            remedy="Feet are known by MCML's names, such as left_up_leg, left_low_leg and left_foot: map the joints.",
        )
    axis = np.eye(3)["XYZ".index(up.upper())]
    hub = HubReader(skeleton, reading).read(block)
    places = walked(skeleton, hub.translations, hub.rotations)[0]
    size = float(np.mean([leg.length(places) for leg in legs]))
    if not 0 < size < np.inf:
        raise ConversionError(
            "the legs have no length", remedy="Feet are locked where hip, knee and ankle are at known, distinct places."
        )
    contacts = [_inside(foot_contacts(places, leg.toe, leg.ankle, frame_time, size, axis), rows) for leg in legs]
    locked = lock_feet(
        skeleton, legs, contacts, hub.translations, hub.rotations, frame_time, axis, HubWriter(skeleton, reading)
    )
    changed = (locked.rotations != hub.rotations).any(axis=2) | (locked.translations != hub.translations).any(axis=2)
    outside = np.ones(len(block), dtype=bool)
    outside[rows] = False
    changed[outside] = False
    writer = HubWriter(skeleton, reading)
    values = writer.write(locked.translations, locked.rotations, hub.scales, Known(hub.values, ~changed, near=True))
    raw = in_columns(block, skeleton.columns())
    values[np.isnan(raw)] = np.nan
    frames = np.arange(len(block), dtype=np.intp)
    edited = Edited(remade(block, skeleton.columns(), values, frames, block.ids), writer.shortfall)
    reports = tuple((leg, _in_legs(report, size)) for leg, report in zip(legs, locked.reports, strict=True))
    return FeetLocked(edited, reports)


def _inside(contacts: Contacts, rows: slice) -> Contacts:
    """Contacts that lie in the rows from beginning to end, or reach an end of the clip."""
    whole = contacts.any
    keeps: Flags = np.zeros(len(whole), dtype=bool)
    for first, end in find_true(whole).tolist():
        keeps[first:end] = first >= rows.start and end <= rows.stop and (first > rows.start or rows.start == 0)
    return Contacts(contacts.toe & keeps, contacts.ankle & keeps)


def _in_legs(report: FootReport, size: float) -> FootReport:
    return replace(report, before=report.before / size, after=report.after / size)
