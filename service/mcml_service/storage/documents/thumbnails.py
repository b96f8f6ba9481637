"""Thumbnails of documents, by the revision that they show. They can be made again at any time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import orjson
from sqlalchemy import and_, delete, select

from mcml_service.storage.core.seals import verify
from mcml_service.storage.core.tables import thumbnail
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.documents.derived_rows import DerivedRows

if TYPE_CHECKING:
    from mcml_service.storage.documents.documents import StoredDocument

_DERIVED = DerivedRows(thumbnail)


@dataclass(frozen=True)
class StoredThumbnail:
    """data: the picture, empty if there is nothing to draw. facts: guesses about the clip."""

    data: bytes
    facts: dict[str, Any]


class Thumbnails:
    def __init__(self, tx: BaseTransaction) -> None:
        self._tx = tx

    def add(self, document_key: int, number: int, data: bytes, facts: dict[str, Any]) -> None:
        """Keep the picture of a revision."""
        row = {"document": document_key, "revision": number, "facts": orjson.dumps(facts).decode(), "data": data}
        self._tx.insert_rows(thumbnail, [row])

    def has(self, document_key: int, number: int) -> bool:
        query = select(thumbnail.c.revision).where(thumbnail.c.document == document_key, thumbnail.c.revision == number)
        return self._tx.fetch_one(query) is not None

    def of(self, documents: Sequence[StoredDocument]) -> dict[int, StoredThumbnail]:
        """Return existing pictures that are valid for these revisions, by the keys of documents: the newest earlier
        picture, if no revision since then has changed the drawing.
        """
        numbers = _DERIVED.of(self._tx, {stored.key: stored.revision for stored in documents})
        # Not pairs of both, for which SQLite would read all pictures of the store.
        near = and_(thumbnail.c.document.in_(numbers), thumbnail.c.revision.in_(set(numbers.values())))
        columns = (thumbnail.c.document, thumbnail.c.revision, thumbnail.c.facts, thumbnail.c.data)
        rows = self._tx.fetch_all(verify(select(*columns).where(near), thumbnail)) if numbers else []
        return {
            key: StoredThumbnail(bytes(data), orjson.loads(facts))
            for key, number, facts, data in rows
            if numbers[key] == number
        }

    def forget(self, document_key: int, before: int) -> None:
        """Remove the pictures of revisions before one."""
        old = and_(thumbnail.c.document == document_key, thumbnail.c.revision < before)
        self._tx.run(delete(thumbnail).where(old))
