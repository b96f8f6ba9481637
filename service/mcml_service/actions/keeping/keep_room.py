"""Free space of a store: delete history, and return unused pages to the disk."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from mcml_service.storage.core.database_errors import translate
from mcml_service.storage.database import Database
from mcml_service.storage.history.pruning import Old


@dataclass(frozen=True)
class Prunable:
    """The effect of a prune: number of documents with deleted revisions, and approximate bytes."""

    documents: int
    revisions: int
    bytes: int


def prune_history(database: Database, days: float, *, do: bool, author: str = "local") -> Prunable:
    """Delete revisions of documents older than their state a number of days ago.

    do: if false, only report the effect. Each document has its own transaction: other work continues, and a crash in
    between leaves each document complete.
    """
    limit = datetime.now(UTC) - timedelta(days=days)
    with database.read() as tx:
        cut = tx.pruning.commit_before(limit.isoformat(timespec="milliseconds").replace("+00:00", "Z"))
        old = tx.pruning.older(cut)
    for revision in old if do else ():
        database.reserve.spend(lambda revision=revision: _forget(database, revision, author))  # type: ignore[misc]
    return Prunable(len(old), sum(revision.revisions for revision in old), sum(revision.bytes for revision in old))


def forget_activity(database: Database, days: int) -> int:
    """Delete events older than a number of days, with their webhook messages; return the number of events."""
    limit = datetime.now(UTC) - timedelta(days=days)
    before = limit.isoformat(timespec="milliseconds").replace("+00:00", "Z")
    with database.write() as tx:
        tx.webhooks.forget(before)
        return tx.activity.forget(before)


def _forget(database: Database, old: Old, author: str) -> None:
    with database.write(author) as tx:
        tx.documents.lock(old.key)
        tx.pruning.forget(old)


def compact_store(database: Database, progress: Callable[[int], None]) -> int:
    """Return unused space to the disk; return the number of bytes. progress: called with the remaining bytes."""
    before = database.size()["total"]
    database.reserve.spend(lambda: _compact(database, progress))
    return max(0, before - database.size()["total"])


def _compact(database: Database, progress: Callable[[int], None]) -> None:
    with translate(database.dialect):
        database.dialect.compact(progress)
