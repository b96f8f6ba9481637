"""Reference media of a document in step with its motion when an edit puts frames earlier or later."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from sqlalchemy import bindparam, delete, select

from mcml_service.storage.core.seals import verify
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import document_media, timeline
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.validity import valid

_MEDIA = Prepared(
    select(*(document_media.c[name] for name in ("upload", "file_name", "media_type", "offset"))).where(
        document_media.c.document == bindparam("key")
    ),
    document_media,
)

Stretch: TypeAlias = tuple[int, int, int]
"""(first, slot, count): frames at positions from `first` on, from 1, are in slots from `slot` on."""


def follow_frames(tx: BaseTransaction, key: int, frame_time: float | None) -> None:
    """Move the offset of a document's media so that its first frame from before this commit stays at its moment.

    frame_time: seconds. Without a frame in common, or a frame time, the offset stays.
    """
    rows = tx.fetch_all(_MEDIA, {"key": key})
    if not rows or frame_time is None:
        return
    before, after = (_stretches(tx, key, commit) for commit in (tx.commit - 1, tx.commit))
    shared = None if before == after else first_shared(before, after)
    if shared is not None and shared[0] != shared[1]:
        upload, file_name, media_type, offset = rows[0]
        row = {"document": key, "upload": upload, "file_name": file_name, "media_type": media_type}
        tx.run(delete(document_media).where(document_media.c.document == key))
        tx.insert_rows(document_media, [row | {"offset": offset + (shared[0] - shared[1]) * frame_time}])


def first_shared(before: Sequence[Stretch], after: Sequence[Stretch]) -> tuple[int, int] | None:
    """The positions, before and after, of the first later frame that was there before; None without one."""
    for first, slot, count in sorted(after):
        found = []
        for earlier, other, size in before:
            start = max(slot, other)
            if start < min(slot + count, other + size):
                found.append((first + start - slot, earlier + start - other))
        if found:
            later, earlier = min(found)
            return earlier, later
    return None


def _stretches(tx: BaseTransaction, key: int, commit: int) -> list[Stretch]:
    columns = timeline.c
    query = select(columns.first, columns.slot, columns.count).where(columns.document == key, valid(timeline, commit))
    return [(first, slot, count) for first, slot, count in tx.fetch_all(verify(query, timeline))]
