"""Bodies of documents that have none yet, worked out and kept, so that questions find them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from service.clips.bodies import MADE, derive_bodies
from service.clips.read_clip import Skeletons
from service.storage.bodies import StoredBody
from service.storage.columns import Listed
from service.storage.database import Database, Transaction

AUTHOR = "derive"
LOOKED_AT, TOGETHER = 512, 128
"""Documents of which it is asked at once whether they have a body, and whose bodies are derived and kept together."""


def derive_missing(database: Database, told: Callable[[int, int], None]) -> int:
    """Keep the bodies of all documents that have none at their newest revision; answers how many. told: how many
    documents are done, and of how many; may raise to end it: what was done by then stays done."""
    with database.read() as tx:
        documents = tx.columns.documents()
        missing = [
            listed
            for at in range(0, len(documents), LOOKED_AT)
            for listed in _without(tx, documents[at : at + LOOKED_AT])
        ]
    skeletons: Skeletons = {}
    for at in range(0, len(missing), TOGETHER):
        told(at, len(missing))
        some = missing[at : at + TOGETHER]
        with database.read() as tx:
            still = {listed.key for listed in tx.columns.documents([listed.key for listed in some])}
            left = [listed for listed in some if listed.key in still]
            made = list(zip(left, derive_bodies(tx, left, skeletons), strict=True))
        with database.write(AUTHOR) as tx:
            there = {listed.key for listed in tx.columns.documents([listed.key for listed, _ in made])}
            kept = [(listed, body) for listed, body in made if listed.key in there]
            tx.bodies.add([(listed, StoredBody(body.facts(), body.blocks)) for listed, body in kept])
    told(len(missing), len(missing))
    return len(missing)


def _without(tx: Transaction, documents: Sequence[Listed]) -> list[Listed]:
    missing = set(tx.bodies.missing(documents, MADE))
    return [listed for listed in documents if listed.key in missing]
