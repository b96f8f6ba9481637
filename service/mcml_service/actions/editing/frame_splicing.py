"""Replace frames by others. Remaining values are not rewritten: only the timeline changes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from mcml.errors import NotFoundError
from mcml.formats.analog_files import analog_part
from mcml.formats.measurements import BEYOND_CAPTURES
from mcml.language.elements import refresh_counts, to_head
from mcml.motion.clip import FrameBlock
from mcml.motion.extremes import check_numbers
from mcml_service.storage.core.schema import CHUNK
from mcml_service.storage.core.tables import timeline
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.encoding import ClipEncoder
from mcml_service.storage.documents.spans import StoredSpan
from mcml_service.storage.documents.tracks import Piece
from mcml_service.storage.transaction import Transaction

COMPRESSORS = 2


def check_range(stored: StoredDocument, first: int, last: int) -> None:
    """NotFoundError unless frames first to last (positions from 1, both included) are in the document."""
    if not 1 <= first <= last <= stored.frames:
        raise NotFoundError(
            f"Frames {first} to {last} are not in a document of {stored.frames} frames.",
            remedy="Frame numbers are positions, from 1, both ends included.",
        )


def counts_up(tx: Transaction, stored: StoredDocument) -> bool:
    """Whether the ids of all frames are whole numbers, each one more than the one before."""
    ids = tx.tracks.frame_ids(stored.key, 1, stored.frames)
    return isinstance(ids, np.ndarray) and len(ids) > 0 and bool((np.diff(ids) == 1).all())


def splice_frames(
    tx: Transaction,
    stored: StoredDocument,
    first: int,
    removed: int,
    blocks: Iterable[FrameBlock] = (),
    *,
    renumber: bool = True,
    same_instants: bool = False,
) -> None:
    """Insert frames before position `first`, replacing the `removed` frames there.

    blocks: their joints are the document's bones, by number; they include motion names. renumber: ids that counted up
    by one before do so again; else the frames keep theirs. Writes no revision.

    Where ids are numbers in the file (`mcml.formats.analog_files.analog_part`) they never count up again, so
    that measurements stay at their frames; new frames then get ids beyond those of any file, unless they are the
    document's own at the same_instants.
    """
    encoder, slot = _store(tx, stored, blocks)
    count = encoder.frames
    behind = first + removed
    pieces = tx.tracks.pieces(stored.key, 1, stored.frames)
    before = [Piece(p.first, p.slot, min(p.count, first - p.first)) for p in pieces if p.first < first]
    after = [_cut(p, behind, count - removed) for p in pieces if p.first + p.count > behind]
    tx.tracks.close(timeline, stored.key)
    new = [Piece(first, slot, count)] if count else []
    tx.tracks.write_timeline(stored.key, _join_pieces([*before, *new, *after]), tx.commit)
    _write_ids(tx, stored, first, behind, encoder, renumber, same_instants)
    _write_spans(tx, stored, first, removed, encoder)
    write_counts(tx, stored, stored.frames - removed + count)


def write_counts(tx: Transaction, stored: StoredDocument, frames: int) -> None:
    """Write the number of frames: in the content, and in the header's own count if it has one."""
    tx.documents.write_content(stored.key, tx.commit, frames=frames, intact=False)
    document = tx.heads.document(stored)
    fresh = refresh_counts(document, frames)
    if fresh.children[0] != document.children[0]:
        tx.heads.write_header(stored.key, fresh.children[0], tx.commit)


def _store(tx: Transaction, stored: StoredDocument, blocks: Iterable[FrameBlock]) -> tuple[ClipEncoder, int]:
    """Store the frames as rows in new chunks; return their encoder and their first slot."""
    chunk = -(-stored.next_slot // CHUNK)
    names = tx.heads.bone_names(stored.key)
    with ThreadPoolExecutor(COMPRESSORS) as executor:
        encoder = ClipEncoder(executor)
        for block in blocks:
            check_numbers(block, names, encoder.frames + 1)
            for rows in encoder.add(block):
                tx.tracks.write_chunks(stored.key, rows, tx.commit, chunk)
        encoder.close()
        for rows in encoder.rest():
            tx.tracks.write_chunks(stored.key, rows, tx.commit, chunk)
    if encoder.frames:
        numbers = {number: tx.tracks.shape_number(stored.key, shape) for shape, number in encoder.shapes.items()}
        runs = [
            row | {"slot": row["slot"] + chunk * CHUNK, "shape": numbers[row["shape"]]} for row in encoder.shape_rows
        ]
        tx.tracks.write_shape_runs(stored.key, runs, tx.commit)
        tx.documents.set_next_slot(stored.key, chunk * CHUNK + encoder.frames)
    return encoder, chunk * CHUNK


def _cut(piece: Piece, start: int, shift: int) -> Piece:
    """Return the part of a piece from `start` on, moved by `shift` positions."""
    skip = max(0, start - piece.first)
    return Piece(piece.first + skip + shift, piece.slot + skip, piece.count - skip)


def _join_pieces(pieces: Sequence[Piece]) -> list[Piece]:
    """Join pieces with consecutive slots."""
    result: list[Piece] = []
    for piece in pieces:
        last = result[-1] if result else None
        if last is not None and last.slot + last.count == piece.slot and last.first + last.count == piece.first:
            result[-1] = Piece(last.first, last.slot, last.count + piece.count)
        else:
            result.append(piece)
    return result


def _write_ids(
    tx: Transaction,
    stored: StoredDocument,
    first: int,
    behind: int,
    encoder: ClipEncoder,
    renumber: bool,
    same_instants: bool,
) -> None:
    old = tx.tracks.frame_ids(stored.key, 1, stored.frames)
    if analog_part(to_head(tx.heads.document(stored), stored.frame_time)) is not None:
        new = encoder.ids.parts()
        if renumber and not same_instants and isinstance(old, np.ndarray):
            beyond = max(int(old.max(initial=0)), BEYOND_CAPTURES) + 1
            new = [beyond + np.arange(encoder.frames, dtype=np.int64)]
        tx.tracks.rewrite_frame_ids(stored.key, [old[: first - 1], *new, old[behind - 1 :]])
        return
    if renumber and counts_up(tx, stored):
        count = stored.frames - (behind - first) + encoder.frames
        tx.tracks.rewrite_frame_ids(stored.key, [int(old[0]) + np.arange(count, dtype=np.int64)])
        return
    tx.tracks.rewrite_frame_ids(stored.key, [old[: first - 1], *encoder.ids.parts(), old[behind - 1 :]])


def _write_spans(tx: Transaction, stored: StoredDocument, first: int, removed: int, encoder: ClipEncoder) -> None:
    """Write the spans: names of deleted frames are removed, later ones move, those of the new frames are added."""
    behind, shift = first + removed, encoder.frames - removed
    old = tx.spans.of(stored.key)
    rows = [
        {"name": row["name"], "rank": row["rank"], "first": row["first"] + first - 1, "last": row["last"] + first - 1}
        for row in encoder.spans.rows
    ]
    for span in old:
        if span.first < first:
            rows.append(_row(span, span.first, min(span.last, first - 1)))
        if span.last >= behind:
            rows.append(_row(span, max(span.first, behind) + shift, span.last + shift))
    tx.spans.close([span.key for span in old])
    tx.spans.write(stored.key, merge_spans(rows), tx.commit)


def merge_spans(rows: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Spans ({name, rank, first, last}) in their order, those of a name and rank that touch as one."""
    merged: list[dict[str, Any]] = []
    for row in sorted(rows, key=lambda row: (row["rank"], row["name"], row["first"])):
        last = merged[-1] if merged else None
        if last and (last["name"], last["rank"]) == (row["name"], row["rank"]) and last["last"] + 1 == row["first"]:
            last["last"] = row["last"]
        else:
            merged.append(row)
    return sorted(merged, key=lambda row: (row["first"], row["rank"]))


def _row(span: StoredSpan, first: int, last: int) -> dict[str, Any]:
    return {"name": span.name, "rank": span.rank, "first": first, "last": last}
