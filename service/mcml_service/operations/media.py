"""Reference video and audio of documents: stored, served in ranges, shifted in time, deleted."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from mcml.answers import Content
from mcml.errors import NotFoundError
from mcml.formats.format import SourceFile
from mcml_schemas.media import MediaChange, MediaInfo
from mcml_service.actions.importing import keep_media as keeping
from mcml_service.actions.importing.keep_media import TYPES
from mcml_service.actions.reading.describe_document import media_info
from mcml_service.operations.arguments import DocumentId
from mcml_service.operations.call import Call
from mcml_service.operations.operation import Upload, gives
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.media import StoredMedia
from mcml_service.storage.transaction import Transaction


def put_media(
    call: Call,
    id: DocumentId,
    file: Annotated[
        SourceFile, Upload(), Field(description="MP4, WebM, Ogg, WAV, FLAC or MP3", examples=["take 3.mp4"])
    ],
    offset: Annotated[
        float, Field(ge=-86_400, le=86_400, description="Seconds in it at the first frame", examples=[1.25])
    ] = 0.0,
) -> MediaInfo:
    """Replaces an existing file. Makes no revision: the file belongs to the document in all revisions."""
    return media_info(keeping.keep_media(call.database, id, file, offset, call.author))


@gives("The video or audio, or the bytes of it that `Range` asks for", dict.fromkeys(TYPES))
def get_media(call: Call, id: DocumentId) -> Content:
    tx = call.read()
    media = _media(tx, tx.documents.get(id))
    call.set_tag(f"{media.sha256[:32]}-media")
    return Content(
        tx.media.read(media),
        media.media_type,
        media.file_name,
        size=media.size,
        shown=True,
        seek=lambda start: tx.media.read(media, start),
    )


def change_media(call: Call, id: DocumentId, change: MediaChange) -> MediaInfo:
    with call.database.write(call.author) as tx:
        stored = tx.documents.get(id)
        media = _media(tx, stored)
        tx.media.put(stored.key, media.key, media.file_name, media.media_type, change.offset)
        return media_info(_media(tx, stored))


def delete_media(call: Call, id: DocumentId) -> None:
    with call.database.write(call.author) as tx:
        stored = tx.documents.get(id)
        _media(tx, stored)
        tx.media.remove(stored.key)


def _media(tx: Transaction, stored: StoredDocument) -> StoredMedia:
    media = tx.media.of(stored.key)
    if media is None:
        raise NotFoundError(f"{stored.name!r} carries no video or audio.", remedy="Put some.")
    return media
