"""Find the frames that a revision changed: frames with changed samples or names, and new frames."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from sqlalchemy import or_, select

from mcml.motion.skeleton import CHANNELS, Array
from mcml.numerics.runs import find_consecutive
from mcml_service.storage.core.schema import CHUNK
from mcml_service.storage.core.tables import CLOSED_TRACK, span, track
from mcml_service.storage.documents.timelines import common_frames
from mcml_service.storage.undo.differences import find_changed_chunks, missing

if TYPE_CHECKING:
    from mcml_service.storage.transaction import Transaction

MOST_COMPARED = 256
"""Tracks that are compared sample by sample; of a revision that wrote more, all frames of them count as touched."""


def find_changed_frames(
    tx: Transaction, document_key: int, commit: int, before: int, after: int
) -> list[tuple[int, int]]:
    """Ranges (first, last) of frames, as the commit left them. before, after: how many frames there were then and now.

    The commit is not the first of the document.
    """
    old, new = tx.at_commit(commit - 1), tx.at_commit(commit)
    pieces = new.tracks.pieces(document_key, 1, after)
    runs = common_frames(old.tracks.pieces(document_key, 1, before), pieces)
    marked = np.zeros(after + 1, dtype=bool)
    for first, last in missing([(run.after, run.count) for run in runs], after):
        marked[first : last + 1] = True
    chunks = find_changed_chunks(old, new, document_key)
    slots = _slots(tx, document_key, commit, chunks)
    for piece in pieces:
        inside = slots[(slots >= piece.slot) & (slots < piece.slot + piece.count)]
        marked[piece.first + inside - piece.slot] = True
    changed = or_(span.c.from_commit == commit, span.c.to_commit == commit)
    names = select(span.c.first, span.c.last).where(span.c.document == document_key, changed)
    if [run.count for run in runs] == [before] == [after]:
        for first, last in tx.fetch_all(names):
            marked[first : last + 1] = True
    places = np.flatnonzero(marked)
    return [(int(first), int(last)) for first, last in find_consecutive(places)] if len(places) else []


def _slots(tx: Transaction, document_key: int, commit: int, chunks: set[int]) -> Array:
    """Slots in which a sample is another one since a commit."""
    came = track.c.from_commit == commit
    query = select(track.c.chunk, track.c.bone).where(track.c.document == document_key)
    went = query.where(CLOSED_TRACK, track.c.to_commit == commit)
    rows = {(row[0], row[1]) for slots in (query.where(came), went) for row in tx.fetch_all(slots)}
    if len(rows) > MOST_COMPARED:
        return np.concatenate([np.arange(chunk * CHUNK, (chunk + 1) * CHUNK) for chunk in sorted(chunks)])
    old, new = tx.at_commit(commit - 1), tx.at_commit(commit)
    slots = [np.empty(0, np.int64)]
    for chunk, bone in rows:
        before, two = (_whole(state.tracks.chunk(document_key, chunk, bone)) for state in (old, new))
        same = (before == two) | (np.isnan(before) & np.isnan(two))
        slots.append(chunk * CHUNK + np.flatnonzero(~same.all(axis=0)))
    return np.unique(np.concatenate(slots))


def _whole(held: tuple[list[int], Array] | None) -> Array:
    values = np.full((len(CHANNELS), CHUNK), np.nan)
    if held is not None:
        channels, columns = held
        values[channels, : columns.shape[1]] = columns
    return values
