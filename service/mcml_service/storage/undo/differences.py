"""Find the differences between two commits' states of a document, by rows, so that equal parts are not read."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from sqlalchemy import Column, Table, select

from mcml_service.storage.core.schema import CHUNK
from mcml_service.storage.core.tables import CLOSED_TRACK, shape_run, track
from mcml_service.storage.documents.timelines import Run
from mcml_service.storage.documents.tracks import Piece

if TYPE_CHECKING:
    from mcml_service.storage.transaction import Transaction


def missing(runs: list[tuple[int, int]], frames: int) -> list[tuple[int, int]]:
    """The ranges (first, last) of 1 … frames that no run (first, count) covers."""
    result, following = [], 1
    for first, count in sorted(runs):
        if first > following:
            result.append((following, first - 1))
        following = max(following, first + count)
    if following <= frames:
        result.append((following, frames))
    return result


def find_changed_chunks(before: Transaction, after: Transaction, document_key: int) -> set[int]:
    """Chunks of which some row, a track's or a shape's, is not the same in two states of the document."""
    first, last = sorted((before.at, after.at))

    def differing(table: Table, *columns: Column[int]) -> Iterator[Any]:
        """Rows that came between the two and stayed, and rows that were there and went."""
        of_document = select(*columns).where(table.c.document == document_key)
        came = (table.c.from_commit > first, table.c.from_commit <= last, table.c.to_commit > last)
        went = (table.c.to_commit > first, table.c.to_commit <= last, table.c.from_commit <= first)
        closed = (CLOSED_TRACK,) if table is track else ()
        yield from after.fetch_all(of_document.where(*came).distinct())
        yield from after.fetch_all(of_document.where(*closed, *went).distinct())

    chunks = {row[0] for row in differing(track, track.c.chunk)}
    for slot, count in differing(shape_run, shape_run.c.slot, shape_run.c.count):
        chunks |= set(range(slot // CHUNK, (slot + count - 1) // CHUNK + 1))
    return chunks


def within_chunks(runs: list[Run], slots: list[Piece], chunks: set[int]) -> list[Run]:
    """Return the parts of runs with slots in the chunks. slots: the timeline of the later state."""
    result: list[Run] = []
    for run in runs:
        piece = next(p for p in slots if p.first <= run.after < p.first + p.count)
        slot = piece.slot + run.after - piece.first
        for chunk in range(slot // CHUNK, (slot + run.count - 1) // CHUNK + 1):
            if chunk in chunks:
                start, end = max(slot, chunk * CHUNK), min(slot + run.count, (chunk + 1) * CHUNK)
                result.append(Run(run.before + start - slot, run.after + start - slot, end - start))
    return result
