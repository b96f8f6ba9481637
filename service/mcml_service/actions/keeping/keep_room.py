"""Room that a store gives back: history that nobody wants any more, and pages that nothing uses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from mcml_service.storage.core.database_errors import translate
from mcml_service.storage.database import Database
from mcml_service.storage.history.pruning import Old


@dataclass(frozen=True)
class Prunable:
    """What a prune frees: revisions of so many documents, and about how many bytes."""

    documents: int
    revisions: int
    bytes: int


def prune_history(database: Database, days: float, *, do: bool, author: str = "local") -> Prunable:
    """Forget what documents were before the state that they had so many days ago. do: else only say what would go.

    A document a transaction: others go on working, and a kill in between leaves each document whole.
    """
    limit = datetime.now(UTC) - timedelta(days=days)
    with database.read() as tx:
        cut = tx.pruning.commit_before(limit.isoformat(timespec="milliseconds").replace("+00:00", "Z"))
        old = tx.pruning.older(cut)
    for revision in old if do else ():
        database.reserve.spend(lambda revision=revision: _forget(database, revision, author))  # type: ignore[misc]
    return Prunable(len(old), sum(revision.revisions for revision in old), sum(revision.bytes for revision in old))


def forget_activity(database: Database, days: int) -> int:
    """Forget events, and what was sent of them, that are older than so many days; how many events."""
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
    """Give back room that nothing uses; answers how many bytes. progress: gets the bytes that are left to do."""
    before = database.size()["total"]
    database.reserve.spend(lambda: _compact(database, progress))
    return max(0, before - database.size()["total"])


def _compact(database: Database, progress: Callable[[int], None]) -> None:
    with translate(database.dialect):
        database.dialect.compact(progress)
