"""Derive and store missing bodies of documents for queries."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import TypeAlias

from mcml.errors import DamageError, StoreError
from mcml_service.clips.bodies import MADE, derive_bodies
from mcml_service.clips.read_clip import Skeletons
from mcml_service.storage.database import Database
from mcml_service.storage.documents.bodies import StoredBody
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction

AUTHOR = "derive"
LOOKED_AT, TOGETHER = 512, 128
"""Number of documents that are checked at once for a body, and whose bodies are derived and stored together."""

Failed: TypeAlias = Callable[[Listed, Exception], None]
"""Called with a document whose body cannot be computed, and the error; other documents continue."""


def _refuse(_listed: Listed, error: Exception) -> None:
    raise error


def derive_missing(
    database: Database,
    told: Callable[[int, int], None],
    failed: Failed = _refuse,
    only: Collection[str] | None = None,
) -> int:
    """Derive and store the bodies of all documents that have none at their newest revision; return their number.

    told: called with the number of finished documents and the total; may raise to stop: finished bodies stay. only:
    documents with these ids.
    """
    with database.read() as tx:
        documents = [listed for listed in tx.columns.documents() if only is None or listed.uuid in only]
        missing = [
            listed
            for at in range(0, len(documents), LOOKED_AT)
            for listed in _without(tx, documents[at : at + LOOKED_AT])
        ]
    skeletons: Skeletons = {}
    done = 0
    for at in range(0, len(missing), TOGETHER):
        told(at, len(missing))
        done += keep_bodies(database, missing[at : at + TOGETHER], skeletons, failed)
    told(len(missing), len(missing))
    return done


def keep_bodies(database: Database, documents: Sequence[Listed], skeletons: Skeletons, failed: Failed) -> int:
    """Work out the bodies of some documents and keep them, as far as these are still there and have none; answers how
    many. skeletons: as `read_clip` takes them."""
    try:
        with database.read() as tx:
            # They may have changed since, or another process was faster.
            missing = _without(tx, tx.columns.documents([listed.key for listed in documents]))
            made = list(zip(missing, derive_bodies(tx, missing, skeletons), strict=True))
    except Exception as error:
        if isinstance(error, StoreError) and not isinstance(error, DamageError):
            # That is no document's fault.
            raise
        if len(documents) == 1:
            failed(documents[0], error)
            return 0
        return sum(keep_bodies(database, [document], skeletons, failed) for document in documents)
    if not made:
        return 0
    with database.write(AUTHOR) as tx:
        there = {listed.key for listed in tx.columns.documents([listed.key for listed, _ in made])}
        kept = [(listed, body) for listed, body in made if listed.key in there]
        tx.bodies.add([(listed, StoredBody(body.facts(), body.blocks)) for listed, body in kept])
    return len(kept)


def _without(tx: Transaction, documents: Sequence[Listed]) -> list[Listed]:
    missing = set(tx.bodies.missing(documents, MADE))
    return [listed for listed in documents if listed.key in missing]
