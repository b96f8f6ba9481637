"""The history of documents: operation, time and author of each revision."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import select

from mcml_service.storage.core.seals import verify
from mcml_service.storage.core.tables import commit, document, project, revision
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.views import is_seen

_REVISION = (
    *(revision.c[name] for name in ("number", "commit", "parent", "operation", "message", "name")),
    *(project.c.name, commit.c.time, commit.c.author),
)
"""The columns of a StoredRevision."""


@dataclass(frozen=True)
class StoredRevision:
    number: int
    commit: int
    parent: int | None
    operation: str
    message: str
    name: str
    project: str
    time: str
    author: str


class Revisions:
    def __init__(self, tx: BaseTransaction) -> None:
        self._tx = tx

    def of(self, key: int, *, before: int | None = None, limit: int = 100) -> list[StoredRevision]:
        """Newest first, those with numbers below `before`."""
        query = (
            select(*_REVISION)
            .join(commit, commit.c.number == revision.c.commit)
            .join(project, project.c.id == revision.c.project)
            .where(revision.c.document == key)
            .order_by(revision.c.number.desc())
            .limit(limit)
        )
        if before is not None:
            query = query.where(revision.c.number < before)
        return [StoredRevision(*row) for row in self._tx.fetch_all(verify(query, revision, commit))]

    def since(self, number: int, limit: int) -> list[tuple[int, tuple[str, StoredRevision]]]:
        """(commit, (uuid of the document, revision)) after a commit, the oldest first; all or none of one commit."""
        query = (
            select(revision.c.commit, document.c.uuid, *_REVISION)
            .join(commit, commit.c.number == revision.c.commit)
            .join(project, project.c.id == revision.c.project)
            .join(document, document.c.id == revision.c.document)
            .where(revision.c.commit > number, document.c.state == "ready", is_seen(self._tx.view))
            .order_by(revision.c.commit, revision.c.document)
        )
        rows = self._tx.fetch_all(verify(query.limit(limit), revision, commit))
        if len(rows) == limit:
            last = rows[-1][0]
            whole = query.where(revision.c.commit == last)
            rows = [row for row in rows if row[0] < last] + [*self._tx.fetch_all(verify(whole, revision, commit))]
        return [(row[0], (row[1], StoredRevision(*row[2:]))) for row in rows]
