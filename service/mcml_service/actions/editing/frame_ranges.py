"""Edit whole ranges of frames: delete, keep, copy, move, insert, reverse, and set their numbers as arrays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mcml.errors import DocumentError
from mcml.formats.analog_files import analog_part
from mcml.language.elements import to_head
from mcml.motion.clip import FrameBlock
from mcml.motion.edits.looping import close_loop
from mcml.motion.frames import reversed_frames
from mcml.motion.skeleton import CHANNEL_INDEX, Array
from mcml_schemas.frames import (
    DeleteFrames,
    FrameEdit,
    FrameEdits,
    InPlaceFrames,
    InsertFrames,
    KeepFrames,
    LoopFrames,
    MoveFrames,
    ResampleFrames,
    ReverseFrames,
    SpeedFrames,
    UnrollFrames,
)
from mcml_service.actions.checking.check_timed import seconds_of
from mcml_service.actions.editing.edit_report import EditReport
from mcml_service.actions.editing.frame_splicing import (
    check_range,
    counts_up,
    merge_spans,
    splice_frames,
    write_counts,
)
from mcml_service.actions.editing.motion_processing import number_bones, read_whole, reshape
from mcml_service.storage.core.schema import CHUNK
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.motion_names import names_of_frames
from mcml_service.storage.documents.spans import StoredSpan
from mcml_service.storage.transaction import Transaction

_MOVING = DeleteFrames | KeepFrames | MoveFrames | InsertFrames | ResampleFrames | SpeedFrames | LoopFrames
"""Edits after which frames are at other positions."""


def edit_frames(
    tx: Transaction, stored: StoredDocument, request: FrameEdits, report: EditReport | None = None
) -> StoredDocument:
    """The edits of a request, one after the other, as one revision.

    report: gets decisions and replaced samples of the edits.
    """
    done = []
    report = EditReport() if report is None else report
    for edit in request.edits:
        current = tx.documents.get(stored.uuid)
        pieces = [] if report.kept is None else tx.tracks.pieces(stored.key, 1, current.frames)
        if isinstance(edit, DeleteFrames):
            delete_frames(tx, current, edit.first, edit.last, renumber=request.renumber)
        elif isinstance(edit, KeepFrames):
            trim(tx, current, edit.first, edit.last, renumber=request.renumber)
            report.first_kept = edit.first
        elif isinstance(edit, ReverseFrames):
            reverse(tx, current, edit.first, edit.last)
        elif isinstance(edit, MoveFrames):
            move_frames(tx, current, edit.first, edit.last, edit.to, renumber=request.renumber)
        elif isinstance(edit, InsertFrames):
            source = current if edit.document is None else tx.documents.get(edit.document)
            insert_frames(tx, current, edit.at, source, edit.first, edit.last, renumber=request.renumber)
        elif isinstance(edit, LoopFrames):
            loop_frames(tx, current, edit, report, renumber=request.renumber)
        else:
            reshape(tx, current, edit, report)
        if report.kept is not None:
            frames = tx.documents.get(stored.uuid).frames
            report.follow(pieces, tx.tracks.pieces(stored.key, 1, frames), loop=isinstance(edit, LoopFrames))
        done.append(_summarise(edit))
    if len(request.edits) > 1:
        report.first_kept = None
    tx.documents.add_revision(stored, "frames", request.message or ", ".join(done)[:200])
    return tx.documents.get(stored.uuid)


@dataclass(frozen=True)
class ComparedRanges:
    """Frames (first, last) in which a document before and after edits is compared. after: None for all."""

    before: tuple[int, int]
    after: tuple[int, int] | None


def ranges_to_compare(stored: StoredDocument, edits: Sequence[FrameEdit]) -> ComparedRanges:
    """Return the frames of edits that leave all frames in place, else all frames. stored: the document before.

    Raises NotFoundError for ranges outside the document.
    """
    whole = (1, stored.frames)
    ranged: list[tuple[int, int]] = []
    for edit in edits:
        if isinstance(edit, UnrollFrames):
            ranged.append((1, stored.frames))
        elif isinstance(edit, _MOVING):
            return ComparedRanges(whole, None)
        else:
            check_range(stored, edit.first, edit.last)
            ranged.append((edit.first, stored.frames if isinstance(edit, InPlaceFrames) else edit.last))
    both = min(first for first, _ in ranged), max(last for _, last in ranged)
    return ComparedRanges(both, both)


def _summarise(edit: FrameEdit) -> str:
    if isinstance(edit, ResampleFrames):
        return f"{edit.do} {edit.rate:g} Hz"
    return edit.do if isinstance(edit, UnrollFrames) else f"{edit.do} {edit.first}-{edit.last}"


def loop_frames(
    tx: Transaction, stored: StoredDocument, edit: LoopFrames, report: EditReport, *, renumber: bool = True
) -> None:
    """Keep a loop of a range."""
    check_range(stored, edit.first, edit.last)
    whole = read_whole(tx, stored, edit.first, edit.last)
    made = close_loop(
        whole.head.skeleton,
        whole.block,
        seconds_of(stored),
        edit.seconds,
        edit.search,
        lock_feet=edit.lock_feet,
        in_place=edit.in_place,
        up=whole.up,
        reading=whole.reading,
    )
    first, last = edit.first + made.first, edit.first + made.last
    blocks = [number_bones(tx, stored, whole, made.block)]
    trim(tx, stored, first, last, renumber=renumber)
    current = tx.documents.get(stored.uuid)
    splice_frames(tx, current, 1, current.frames, blocks, renumber=False, same_instants=True)
    held = " and ".join(made.locked)
    report.first_kept = first
    report.notes.append(
        f"frames {first:,} to {last:,} are the loop: the largest step from its end to its beginning is {made.jump:.2f} "
        f"of those inside, and it turns by {np.degrees(made.turn):.1f} degrees a round"
        + (f"; {held} foot held at its end" if held else "")
    )


def delete_frames(tx: Transaction, stored: StoredDocument, first: int, last: int, *, renumber: bool = True) -> None:
    """Take frames first to last out."""
    check_range(stored, first, last)
    splice_frames(tx, stored, first, last - first + 1, renumber=renumber)


def trim(tx: Transaction, stored: StoredDocument, first: int, last: int, *, renumber: bool = True) -> None:
    """Keep frames first to last alone."""
    check_range(stored, first, last)
    # As the ids were before the first of the two steps.
    renumber = renumber and counts_up(tx, stored)
    if last < stored.frames:
        splice_frames(tx, stored, last + 1, stored.frames - last, renumber=renumber)
    if first > 1:
        splice_frames(tx, tx.documents.get(stored.uuid), 1, first - 1, renumber=renumber)


def insert_frames(
    tx: Transaction,
    stored: StoredDocument,
    at: int,
    source: StoredDocument,
    first: int,
    last: int,
    *,
    renumber: bool = True,
) -> None:
    """Insert frames first to last of this or another document before the frame at position `at`.

    Both documents need the same bones, by name, with the same skeleton; otherwise raises DocumentError with a remedy.
    """
    check_range(source, first, last)
    if not 1 <= at <= stored.frames + 1:
        raise DocumentError(
            f"Frames cannot be put before frame {at} of {stored.frames}.",
            remedy=f"Give a position from 1 to {stored.frames + 1}; that one puts them at the end.",
        )
    blocks = list(_frames(tx, source, first, last))
    if source.key != stored.key:
        blocks = [_renumber_bones(tx, stored, source, block) for block in blocks]
    splice_frames(tx, stored, at, 0, blocks, renumber=renumber)


def move_frames(tx: Transaction, stored: StoredDocument, first: int, last: int, to: int, *, renumber: bool) -> None:
    """Take frames first to last out and put them before the frame that is at position `to` now."""
    check_range(stored, first, last)
    if first <= to <= last + 1:
        return
    blocks = list(_frames(tx, stored, first, last))
    renumber = renumber and counts_up(tx, stored)
    count = last - first + 1
    splice_frames(tx, stored, first, count, renumber=renumber)
    at = to - count if to > last else to
    splice_frames(tx, tx.documents.get(stored.uuid), at, 0, blocks, renumber=renumber, same_instants=True)


def reverse(tx: Transaction, stored: StoredDocument, first: int, last: int) -> None:
    """Let frames first to last run backwards. Motion names go with their frames; ids stay at their places, unless they
    are numbers in the file."""
    check_range(stored, first, last)
    spans = tx.spans.of(stored.key)
    ids = tx.tracks.frame_ids(stored.key, first, last)
    if analog_part(to_head(tx.heads.document(stored), stored.frame_time)) is not None:
        ids = ids[::-1]
    at, turned = 0, []
    for block in reversed(list(tx.tracks.blocks(stored.key, first, last))):
        end = at + len(block)
        turned.append(replace(reversed_frames(block), ids=ids[at:end]))
        at = end
    splice_frames(tx, stored, first, last - first + 1, turned, renumber=False, same_instants=True)
    # As spans, not frame by frame: each stays one label, with its rank.
    rows = [row for span in spans for row in _reverse_span(span, first, last)]
    tx.spans.close([span.key for span in tx.spans.of(stored.key)])
    tx.spans.write(stored.key, merge_spans(rows), tx.commit)


def _reverse_span(span: StoredSpan, first: int, last: int) -> list[dict[str, Any]]:
    """Split a span for reversed frames first to last: the parts before, inside, and after them."""
    inside = first + last - min(span.last, last), first + last - max(span.first, first)
    parts = [(span.first, min(span.last, first - 1)), inside, (max(span.first, last + 1), span.last)]
    return [{"name": span.name, "rank": span.rank, "first": a, "last": b} for a, b in parts if a <= b]


def write_values(
    tx: Transaction,
    stored: StoredDocument,
    first: int,
    columns: list[tuple[str, str]],
    values: Array,
    *,
    some: bool = False,
) -> int:
    """Set channels of consecutive frames; only their tracks are written. Returns the number of tracks.

    columns: (bone, channel) of each column of values, (n, D). Frames that lack such a channel are refused: the document
    decides which samples exist. some: NaN values keep the samples.
    """
    count = len(values)
    check_range(stored, first, first + count - 1)
    wrong = np.isinf(values) if some else ~np.isfinite(values)
    if wrong.any():
        row, column = np.argwhere(wrong)[0]
        raise DocumentError(
            f"Frame {first + int(row)}, {'.'.join(columns[int(column)])}: not a finite number.",
            remedy="Delete the attribute of that frame to say that a sample is missing.",
        )
    numbers = {name: number for number, name in tx.heads.bone_names(stored.key).items()}
    wanted: dict[int, dict[int, int]] = {}
    for index, (name, channel) in enumerate(columns):
        if name not in numbers:
            raise DocumentError(f"The document has no bone {name!r}.", remedy=f"It has: {', '.join(numbers)}."[:400])
        if channel not in CHANNEL_INDEX:
            raise DocumentError(f"There is no channel {channel!r}.", remedy=f"There are: {', '.join(CHANNEL_INDEX)}.")
        wanted.setdefault(numbers[name], {})[CHANNEL_INDEX[channel]] = index
    written = 0
    for piece in tx.tracks.pieces(stored.key, first, first + count - 1):
        for chunk in range(piece.slot // CHUNK, (piece.slot + piece.count - 1) // CHUNK + 1):
            start = max(piece.slot, chunk * CHUNK)
            end = min(piece.slot + piece.count, (chunk + 1) * CHUNK)
            rows = values[piece.first + start - piece.slot - first :][: end - start]
            for bone, channels in wanted.items():
                written += _write_track(tx, stored, chunk, bone, start - chunk * CHUNK, channels, rows)
    if written:
        write_counts(tx, stored, stored.frames)
    return written


def _write_track(
    tx: Transaction, stored: StoredDocument, chunk: int, bone: int, offset: int, wanted: dict[int, int], rows: Array
) -> bool:
    """Set channels of one bone in one chunk; False where they had these values already."""
    channels, columns = tx.tracks.chunk(stored.key, chunk, bone) or ([], np.empty((0, 0)))
    place = slice(offset, offset + len(rows))
    changed = False
    for channel, index in wanted.items():
        stated = ~np.isnan(rows[:, index])
        if not stated.any():
            continue
        here = columns[channels.index(channel), place] if channel in channels else np.full(len(rows), np.nan)
        if np.isnan(here[stated]).any():
            raise DocumentError(
                "Some of these frames have no such sample.", remedy="Add the attribute to their frame_bone first."
            )
        new = np.where(stated, rows[:, index], here)
        if not np.array_equal(here.view(np.int64), np.ascontiguousarray(new).view(np.int64)):
            columns[channels.index(channel), place] = new
            changed = True
    if changed:
        tx.tracks.rewrite_chunk(stored.key, chunk, bone, channels, columns)
    return changed


def _frames(tx: Transaction, stored: StoredDocument, first: int, last: int) -> Iterator[FrameBlock]:
    """Frames with their motion names; joints are bones by number."""
    position = first
    for block in tx.tracks.blocks(stored.key, first, last):
        end = position + len(block)
        names = names_of_frames(tx.spans.of(stored.key, position, end - 1), range(position, end))
        yield replace(block, motion_names=names)
        position = end


def _renumber_bones(tx: Transaction, stored: StoredDocument, source: StoredDocument, block: FrameBlock) -> FrameBlock:
    """A block of another document with the bones as this one numbers them."""
    here = {name: number for number, name in tx.heads.bone_names(stored.key).items()}
    there = tx.heads.bone_names(source.key)
    used = {bone for shape in block.shapes for bone, _ in shape}
    lacking = [there[bone] for bone in sorted(used) if there[bone] not in here]
    if lacking or (source.skeleton != stored.skeleton and _poses(tx, source) != _poses(tx, stored)):
        reason = f"Bone {lacking[0]!r} is not in this document." if lacking else "The skeletons differ."
        raise DocumentError(reason, remedy="Retarget the motion onto this document's skeleton first.")
    number = {bone: here[there[bone]] for bone in used}
    return replace(
        block,
        columns=tuple((number[bone], channel) for bone, channel in block.columns if bone in number),
        values=block.values[:, [bone in number for bone, _ in block.columns]],
        shapes=tuple(tuple((number[bone], bits) for bone, bits in shape) for shape in block.shapes),
    )


def _poses(tx: Transaction, stored: StoredDocument) -> list[object]:
    """Return the properties that decide the poses of a skeleton's channels."""
    joints = to_head(tx.heads.document(stored), stored.frame_time).skeleton.joints
    return [
        (joint.name, joint.parent, joint.convention, joint.channels, joint.rotation_order, joint.offset, joint.axis,
         joint.direction, joint.length, joint.translation)
        for joint in joints
    ]  # fmt: skip
