"""Edits of frame ranges as one revision, or a dry run of them with curves before and after."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from mcml.errors import RequestError
from mcml.motion.bodies.quantities import AskedQuantity, asked_quantity
from mcml.motion.skeleton import Array
from mcml_schemas.frames import CurveSamples, EditedCurve, FrameEdits, FramesEdited, ReplacedSamples
from mcml_schemas.revisions import FrameRange, KeptFrames
from mcml_service.actions.editing.edit_report import EditReport
from mcml_service.actions.editing.frame_ranges import ComparedRanges, ranges_to_compare
from mcml_service.actions.editing.frame_ranges import edit_frames as apply_edits
from mcml_service.actions.reading.preview_motion import preview_motion
from mcml_service.actions.reading.read_curves import Curve, read_curves
from mcml_service.actions.reviewing.apply_proposal import Proposed, apply_proposed
from mcml_service.clips.read_clip import read_clip
from mcml_service.operations.arguments import DocumentId, IfMatch, Shown, find_for_write, tag
from mcml_service.operations.call import Call
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.timelines import Run
from mcml_service.storage.transaction import Transaction

MOST_CURVES = 8
MOST_RANGES = 2000
"""Most ranges of new samples in an answer."""
MOST_POINTS = 2000
"""Most frame ranges of a curve in an answer."""


@dataclass(frozen=True)
class Compared:
    """Curves that a preview compares before and after the edits."""

    column: Annotated[
        list[str] | None,
        Field(
            max_length=MOST_CURVES,
            description="Preview: BONE.CHANNEL of each curve to compare",
            examples=[["left_up_leg.Rx"]],
        ),
    ] = None
    quantity: Annotated[
        list[str] | None,
        Field(
            max_length=MOST_CURVES,
            description="Preview: quantities of the body to compare, NAME:JOINT,JOINT or angle:NAME",
            examples=[["speed:right_hand,Root"]],
        ),
    ] = None
    pixels: Annotated[
        int, Field(ge=1, le=MOST_POINTS, description="Maximum number of frame ranges in a curve", examples=[800])
    ] = 1000

    def parse(self) -> tuple[list[str], list[AskedQuantity]]:
        """Return columns and quantities, each once. Raises RequestError for too many."""
        columns = list(dict.fromkeys(self.column or ()))
        quantities = [asked_quantity(text) for text in dict.fromkeys(self.quantity or ())]
        asked = len(columns) + len(quantities)
        if asked > MOST_CURVES:
            raise RequestError(f"{asked} curves are requested.", remedy=f"Request at most {MOST_CURVES} at once.")
        return columns, quantities


def edit_frames(
    call: Call,
    id: DocumentId,
    edits: FrameEdits,
    shown: Shown,
    compared: Compared,
    dry_run: Annotated[bool, Field(description="Preview the notes and curves without changing anything")] = False,
    if_match: IfMatch = None,
) -> FramesEdited:
    """The whole list becomes one revision, or nothing changes.

    Remaining frames are not written again. Positions in a later edit refer to the result of the earlier ones.

    With `dry_run`, `curves` has each `column`, then each `quantity`, before and after the edits: over the frames of
    edits that keep the number of frames, else over the whole document. With `dry_run` and `positions`, `motion` has
    the positions of the edited document.
    """
    if dry_run:
        with call.database.trial(call.author) as tx:
            stored = find_for_write(tx, id, if_match)
            return preview_edits(tx, stored, Proposed(edits, None), shown, compared)
    if any(compared.parse()):
        raise RequestError("Only a dry run compares curves.", remedy="Add dry_run=true, or leave the curves out.")
    if shown.window is not None:
        raise RequestError("Only a dry run previews positions.", remedy="Add dry_run=true, or leave `positions` out.")
    report = EditReport()
    with call.database.write(call.author) as tx:
        changed = apply_edits(tx, find_for_write(tx, id, if_match), edits, report)
    call.tag = tag(changed)
    return _describe(changed.revision, changed.frames, report, [])


def preview_edits(
    tx: Transaction, stored: StoredDocument, proposed: Proposed, shown: Shown, compared: Compared
) -> FramesEdited:
    """Apply a change in a trial; return its notes, curves and positions, and the frames that it keeps."""
    columns, quantities = compared.parse()
    report = EditReport(kept=[Run(1, 1, stored.frames)])

    def read(document: StoredDocument, frames: tuple[int, int]) -> list[Curve]:
        return read_curves(tx, document, columns, quantities, frames, compared.pixels)

    ranges = ComparedRanges((1, stored.frames), None)
    if proposed.edits is not None:
        ranges = ranges_to_compare(stored, proposed.edits.edits)
    before = read(stored, ranges.before)
    changed = apply_proposed(tx, stored, proposed, report, "")
    after = read(changed, ranges.after or (1, changed.frames))
    answer = _describe(
        stored.revision, changed.frames, report, [_compare(*pair) for pair in zip(before, after, strict=True)]
    )
    answer.kept = [KeptFrames(**vars(run)) for run in report.kept or ()]
    if shown.window is not None:
        clip = read_clip(tx, changed).clip
        answer.motion = preview_motion(clip.head, clip.blocks(), shown.window, clip.head.seconds_per_frame())
    return answer


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


def _compare(before: Curve, after: Curve) -> EditedCurve:
    return EditedCurve(name=before.name, unit=before.unit, before=_samples(before), after=_samples(after))


def _samples(curve: Curve) -> CurveSamples:
    minimum, maximum = (_to_json(curve.values[:, end]) for end in (0, 1))
    return CurveSamples(first=curve.first, step=curve.step, minimum=minimum, maximum=maximum)


def _to_json(values: Array) -> list[float | None]:
    return [None if math.isnan(value) else value for value in values.tolist()]
