"""Video or audio that documents carry for reference. It belongs to a document, not to a revision."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from sqlalchemy import delete, select

from mcml_service.storage.core.seals import verify
from mcml_service.storage.core.tables import document_media, upload
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.documents.documents import Documents
from mcml_service.storage.documents.uploads import BLOCK_BYTES, Uploads


@dataclass(frozen=True)
class StoredMedia:
    """offset: seconds in the medium at the first frame. key: of the upload with its bytes."""

    file_name: str
    media_type: str
    offset: float
    size: int
    sha256: str
    key: int


class MediaOfDocuments:
    def __init__(self, tx: BaseTransaction, documents: Documents, uploads: Uploads) -> None:
        self._tx = tx
        self._documents = documents
        self._uploads = uploads

    def of(self, document_key: int) -> StoredMedia | None:
        """Return the reference file of a document, None if it has none."""
        own = document_media.c
        query = (
            select(own.file_name, own.media_type, own.offset, upload.c.size, upload.c.sha256, own.upload)
            .join(upload, upload.c.id == own.upload)
            .where(own.document == document_key, upload.c.complete)
        )
        rows = self._tx.fetch_all(verify(query, document_media))
        return StoredMedia(*rows[0]) if rows else None

    def put(self, document_key: int, key: int, file_name: str, media_type: str, offset: float) -> None:
        """Attach an upload to a document, replacing an existing file. Raises AccessError."""
        self._remove(document_key)
        row = {"document": document_key, "upload": key, "file_name": file_name, "media_type": media_type}
        self._tx.insert_rows(document_media, [row | {"offset": offset}])
        self._documents.require_room(document_key)
        self._uploads.remove_orphans(0)

    def remove(self, document_key: int) -> None:
        """AccessError."""
        self._remove(document_key)
        self._uploads.remove_orphans(0)

    def _remove(self, document_key: int) -> None:
        self._documents.require(document_key)
        self._tx.run(delete(document_media).where(document_media.c.document == document_key))

    def read(self, media: StoredMedia, start: int = 0) -> Iterator[bytes]:
        """Its bytes from one on, in blocks. DamageError where they are damaged."""
        skip = start % BLOCK_BYTES
        for block in self._uploads.blocks(media.key, start // BLOCK_BYTES):
            yield block[skip:]
            skip = 0
