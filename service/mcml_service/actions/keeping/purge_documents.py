"""Remove documents permanently, with all data that only they need: preview and purge."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from mcml.errors import NotFoundError
from mcml_service.storage.core.database_errors import translate
from mcml_service.storage.database import Database
from mcml_service.xpath.library.disk.part_file import forget


@dataclass(frozen=True)
class Purgeable:
    """A document that a purge can remove.

    bytes: approximate freed bytes. deleted: time of deletion, None for a document that is not deleted. clips, results:
    (uuid, name) of objects made from it and from others: these stay, and contain its motion. own_results: number of
    results made only from it.
    """

    uuid: str
    name: str
    project: str
    revisions: int
    bytes: int
    deleted: str | None
    clips: tuple[tuple[str, str], ...]
    results: tuple[tuple[str, str], ...]
    own_results: int


def purgeable(database: Database, uuids: Sequence[str], deleted_days: float | None = None) -> list[Purgeable]:
    """Return the documents with these full ids, and those deleted at least this number of days ago.

    Raises NotFoundError.
    """
    with database.read() as tx:
        wanted = list(uuids)
        if deleted_days is not None:
            limit = datetime.now(UTC) - timedelta(days=deleted_days)
            wanted += tx.purging.find_deleted_before(limit.isoformat(timespec="milliseconds").replace("+00:00", "Z"))
        documents = []
        for uuid in dict.fromkeys(wanted):
            stored = tx.documents.find(uuid, deleted=True)
            if stored is None:
                raise NotFoundError(
                    f"There is no document {uuid}.", remedy="Name full ids; `mcml ls --deleted` lists deleted ones."
                )
            held = tx.purging.measure(stored.key)
            clips, results, own = tx.purging.find_made_from(uuid)
            facts = (held.revisions, held.bytes, held.deleted, tuple(clips), tuple(results), len(own))
            documents.append(Purgeable(uuid, stored.name, stored.project, *facts))
        return documents


def purge_documents(
    database: Database,
    uuids: Sequence[str],
    author: str = "local",
    progress: Callable[[str], None] | None = None,
    cache_dir: str = "",
) -> int:
    """Remove documents permanently, and those whose purge was interrupted; return their number.

    Raises NotFoundError. cache_dir: the folder of query columns on disk, from the settings; columns of purged documents
    are removed too. Each step is a short transaction, so other work continues. A crash in between leaves a document
    that is invisible to reads; the next purge, or the next server that starts, completes it.
    """
    for uuid in uuids:
        database.reserve.spend(lambda uuid=uuid: _begin(database, uuid, author))  # type: ignore[misc]
    return finish_purges(database, author, progress, cache_dir)


def _begin(database: Database, uuid: str, author: str) -> None:
    with database.write(author) as tx:
        stored = tx.documents.get(uuid, deleted=True)
        tx.documents.lock(stored.key)
        tx.purging.begin(stored)


def finish_purges(
    database: Database,
    author: str = "local",
    progress: Callable[[str], None] | None = None,
    cache_dir: str = "",
) -> int:
    """Remove what is left of documents that are being purged; answers how many there were."""
    with database.read() as tx:
        begun = tx.purging.find_unfinished()
    for key, uuid in begun:
        while database.reserve.spend(lambda key=key: _remove_tracks(database, key, author)):  # type: ignore[misc]
            pass
        database.reserve.spend(lambda key=key, uuid=uuid: _finish(database, key, uuid, author))  # type: ignore[misc]
        if progress is not None:
            progress(uuid)
    if begun:
        database.reserve.spend(lambda: _settle(database))
        database.reserve.keep()
        forget(database, cache_dir)
    return len(begun)


def _remove_tracks(database: Database, key: int, author: str) -> bool:
    with database.write(author) as tx:
        tx.purging.erase_what_goes()
        return tx.purging.remove_tracks(key)


def _finish(database: Database, key: int, uuid: str, author: str) -> None:
    with database.write(author) as tx:
        tx.purging.erase_what_goes()
        tx.purging.finish(key, uuid)


def _settle(database: Database) -> None:
    with translate(database.dialect):
        database.dialect.settle()
