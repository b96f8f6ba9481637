"""Thumbnails on request: stored ones, and new ones, which are stored."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import suppress

from mcml.errors import ConflictError, McmlError, StoreError
from mcml_service.actions.reading.make_thumbnail import read_thumbnail
from mcml_service.storage.database import Database
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.thumbnails import StoredThumbnail
from mcml_service.storage.transaction import Transaction

LIST_SECONDS = 0.3
"""Time limit for making thumbnails in a list; the next list has the missing ones."""

Pictures = dict[int, StoredThumbnail]
"""By the keys of documents."""


def pictures_of(
    tx: Transaction, documents: Sequence[StoredDocument], seconds: float = LIST_SECONDS
) -> tuple[Pictures, list[tuple[StoredDocument, StoredThumbnail]]]:
    """Return thumbnails of documents, as far as time allows, and those of them that are not stored yet.

    A document that cannot be read has none: further reads of it report the error.
    """
    thumbnails = tx.thumbnails.of(documents)
    made: list[tuple[StoredDocument, StoredThumbnail]] = []
    until = time.monotonic() + seconds
    for stored in documents:
        if stored.key in thumbnails:
            continue
        if time.monotonic() > until:
            break
        with suppress(McmlError):
            picture = picture_of(tx, stored)
            thumbnails[stored.key] = picture
            made.append((stored, picture))
    return thumbnails, made


def picture_of(tx: Transaction, stored: StoredDocument) -> StoredThumbnail:
    """The picture of a document, made now."""
    thumbnail = read_thumbnail(tx, stored)
    return StoredThumbnail(b"", {}) if thumbnail is None else StoredThumbnail(thumbnail.data, thumbnail.facts)


def keep_pictures(database: Database, made: Sequence[tuple[StoredDocument, StoredThumbnail]]) -> None:
    """Keep pictures. Where that cannot be now, they are made again."""
    if not made:
        return
    with suppress(StoreError, ConflictError), database.write() as tx:
        for stored, picture in made:
            if not tx.thumbnails.has(stored.key, stored.revision):
                tx.thumbnails.add(stored.key, stored.revision, picture.data, picture.facts)
