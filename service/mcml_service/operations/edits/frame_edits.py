"""Edits of frame ranges as one revision, or a dry run of them with curves before and after."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated

from pydantic import Field

from mcml.errors import RequestError
from mcml.motion.bodies.quantities import AskedQuantity, asked_quantity
from mcml.motion.skeleton import Array
from mcml_schemas.frames import CurveSamples, EditedCurve, FrameEdits, FramesEdited, PreviewMotion, ReplacedSamples
from mcml_schemas.revisions import FrameRange
from mcml_service.actions.editing.edit_report import EditReport
from mcml_service.actions.editing.frame_ranges import edit_frames as apply_edits
from mcml_service.actions.editing.frame_ranges import ranges_to_compare
from mcml_service.actions.reading.preview_motion import preview_motion
from mcml_service.actions.reading.read_curves import Curve, read_curves
from mcml_service.clips.read_clip import read_clip
from mcml_service.operations.arguments import DocumentId, IfMatch, Shown, find_for_write, tag
from mcml_service.operations.call import Call
from mcml_service.operations.edits.changes import UndoneError
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

MOST_CURVES = 8
MOST_RANGES = 2000
"""Most ranges of new samples in an answer."""
MOST_POINTS = 2000
"""Most frame ranges of a curve in an answer."""


def edit_frames(
    call: Call,
    id: DocumentId,
    edits: FrameEdits,
    shown: Shown,
    dry_run: Annotated[bool, Field(description="Preview the notes and curves without changing anything")] = False,
    column: Annotated[
        list[str] | None,
        Field(
            max_length=MOST_CURVES,
            description="With `dry_run`: BONE.CHANNEL of each curve to compare",
            examples=[["left_up_leg.Rx"]],
        ),
    ] = None,
    quantity: Annotated[
        list[str] | None,
        Field(
            max_length=MOST_CURVES,
            description="With `dry_run`: quantities of the body to compare, NAME:JOINT,JOINT or angle:NAME",
            examples=[["speed:right_hand,Root"]],
        ),
    ] = None,
    pixels: Annotated[
        int, Field(ge=1, le=MOST_POINTS, description="Maximum number of frame ranges in a curve", examples=[800])
    ] = 1000,
    if_match: IfMatch = None,
) -> FramesEdited:
    """The whole list becomes one revision, or nothing changes.

    Remaining frames are not written again. Positions in a later edit refer to the result of the earlier ones.

    With `dry_run`, `curves` has each `column`, then each `quantity`, before and after the edits: over the frames of
    edits that keep the number of frames, else over the whole document. With `dry_run` and `positions`, `motion` has
    the positions of the edited document.
    """
    columns, quantities = _parse_curves(column, quantity, dry_run=dry_run)
    if shown.window is not None and not dry_run:
        raise RequestError("Only a dry run previews positions.", remedy="Add dry_run=true, or leave `positions` out.")
    report = EditReport()
    curves: list[EditedCurve] = []
    motion: PreviewMotion | None = None

    def read(tx: Transaction, document: StoredDocument, frames: tuple[int, int]) -> list[Curve]:
        return read_curves(tx, document, columns, quantities, frames, pixels)

    try:
        with call.database.write(call.author) as tx:
            stored = find_for_write(tx, id, if_match)
            ranges = ranges_to_compare(stored, edits.edits)
            before = read(tx, stored, ranges.before)
            changed = apply_edits(tx, stored, edits, report)
            if dry_run:
                after = read(tx, changed, ranges.after or (1, changed.frames))
                curves = [_compare(*pair) for pair in zip(before, after, strict=True)]
                if shown.window is not None:
                    clip = read_clip(tx, changed).clip
                    motion = preview_motion(clip.head, clip.blocks(), shown.window, clip.head.seconds_per_frame())
                raise UndoneError
    except UndoneError:
        return _describe(stored.revision, changed.frames, report, curves).model_copy(update={"motion": motion})
    call.tag = tag(changed)
    return _describe(changed.revision, changed.frames, report, [])


def _describe(revision: int, frames: int, report: EditReport, curves: list[EditedCurve]) -> FramesEdited:
    """replaced: bones with the most new samples first, as many frame ranges as an answer may have."""
    left = MOST_RANGES
    replaced: list[ReplacedSamples] = []
    for bone, found in sorted(report.replaced.items(), key=lambda item: -item[1].frames):
        shown = [FrameRange(first=first, last=last) for first, last in found.ranges[:left]]
        left -= len(shown)
        if shown:
            replaced.append(ReplacedSamples(bone=bone, channels=found.channels, frames=found.frames, ranges=shown))
    notes = list(report.notes)
    total = sum(len(found.ranges) for found in report.replaced.values())
    if total > MOST_RANGES:
        notes.append(f"{total:,} ranges of new samples, of which {MOST_RANGES:,} are listed")
    return FramesEdited(
        revision=revision,
        frames=frames,
        notes=notes,
        curves=curves,
        replaced=replaced,
        first_kept=report.first_kept,
    )


def _parse_curves(
    column: Sequence[str] | None, quantity: Sequence[str] | None, *, dry_run: bool
) -> tuple[list[str], list[AskedQuantity]]:
    columns = list(dict.fromkeys(column or ()))
    quantities = [asked_quantity(text) for text in dict.fromkeys(quantity or ())]
    asked = len(columns) + len(quantities)
    if asked and not dry_run:
        raise RequestError("Only a dry run compares curves.", remedy="Add dry_run=true, or leave the curves out.")
    if asked > MOST_CURVES:
        raise RequestError(f"{asked} curves are requested.", remedy=f"Request at most {MOST_CURVES} at once.")
    return columns, quantities


def _compare(before: Curve, after: Curve) -> EditedCurve:
    return EditedCurve(name=before.name, unit=before.unit, before=_samples(before), after=_samples(after))


def _samples(curve: Curve) -> CurveSamples:
    minimum, maximum = (_to_json(curve.values[:, end]) for end in (0, 1))
    return CurveSamples(first=curve.first, step=curve.step, minimum=minimum, maximum=maximum)


def _to_json(values: Array) -> list[float | None]:
    return [None if math.isnan(value) else value for value in values.tolist()]
