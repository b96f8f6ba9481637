"""Reference media of a document in step with its motion when an edit puts frames earlier or later."""

from __future__ import annotations

from sqlalchemy import bindparam, delete, select

from mcml_service.storage.core.seals import verify
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import document_media, timeline
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.validity import valid
from mcml_service.storage.documents.timelines import common_frames
from mcml_service.storage.documents.tracks import Piece

_MEDIA = Prepared(
    select(*(document_media.c[name] for name in ("upload", "file_name", "media_type", "offset"))).where(
        document_media.c.document == bindparam("key")
    ),
    document_media,
)


def follow_frames(tx: BaseTransaction, key: int, frame_time: float | None) -> None:
    """Move the offset of a document's media so that its first frame from before this commit stays at its moment.

    frame_time: seconds. Without a frame in common, or a frame time, the offset stays.
    """
    rows = tx.fetch_all(_MEDIA, {"key": key})
    if not rows or frame_time is None:
        return
    shared = common_frames(*(_pieces(tx, key, commit) for commit in (tx.commit - 1, tx.commit)))
    if shared and shared[0].before != shared[0].after:
        upload, file_name, media_type, offset = rows[0]
        row = {"document": key, "upload": upload, "file_name": file_name, "media_type": media_type}
        tx.run(delete(document_media).where(document_media.c.document == key))
        tx.insert_rows(document_media, [row | {"offset": offset + (shared[0].before - shared[0].after) * frame_time}])


def _pieces(tx: BaseTransaction, key: int, commit: int) -> list[Piece]:
    columns = timeline.c
    query = select(columns.first, columns.slot, columns.count).where(columns.document == key, valid(timeline, commit))
    return [Piece(*row[:3]) for row in tx.fetch_all(verify(query, timeline))]
