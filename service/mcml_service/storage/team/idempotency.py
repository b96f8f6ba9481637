"""Requests with an idempotency key, each done only once. Their rows are temporary, so they have no checksum."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import timedelta

from sqlalchemy import and_, delete, insert, select, update
from sqlalchemy.exc import IntegrityError
from sqlalchemy.sql import ColumnElement

from mcml_service.storage.core.identifiers import now
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.team.tables import request

KEY_HOURS = 24


@dataclass(frozen=True)
class Remembered:
    """A request that was sent before. status: None where it is not known to have ended."""

    operation: str
    digest: str
    status: int | None
    location: str | None
    answer: str | None


class Requests:
    """Requests with a key of their client's, each of which is done once."""

    def __init__(self, tx: BaseTransaction) -> None:
        self._tx = tx

    def begin(self, author: str, key: str, operation: str, digest: str) -> Remembered | None:
        """Record a request; return None, or the record of an earlier request with this key."""
        self._tx.run(delete(request).where(request.c.created < now(-timedelta(hours=KEY_HOURS))))
        values = {"author": author, "key": key, "operation": operation, "digest": digest, "created": now()}
        try:
            with self._tx.savepoint():
                self._tx.run(insert(request).values(**values))
        except IntegrityError:
            (row,) = self._tx.fetch_all(select(request).where(_is_named(author, key)))
            return Remembered(row.operation, row.digest, row.status, row.location, row.answer)
        return None

    def end(self, author: str, key: str, status: int, location: str | None, answer: str) -> None:
        """Keep what was answered."""
        values = {"status": status, "location": location, "answer": answer}
        self._tx.run(update(request).where(_is_named(author, key)).values(**values))

    def forget(self, author: str, key: str) -> None:
        """The request failed: nothing was done, and it may be sent again."""
        self._tx.run(delete(request).where(_is_named(author, key)))


def _is_named(author: str, key: str) -> ColumnElement[bool]:
    return and_(request.c.author == author, request.c.key == key)
