"""Bodies of documents in space, by revision: the positions of joints, and the calibration of the clip.

They can be derived again at any time; damaged ones are treated as missing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import orjson
from sqlalchemy import BigInteger, and_, bindparam, delete, exists, select

from mcml.errors import DamageError
from mcml_service.storage.core.sql_expressions import OneOf
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import body, content, document, revision
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.validity import there
from mcml_service.storage.documents.derived_rows import DerivedRows, moves

_ROWS = Prepared(
    select(body.c.document, body.c.revision, body.c.block, body.c.facts, body.c.data)
    .where(OneOf(body.c.document, "keys"))
    .order_by(body.c.document, body.c.revision, body.c.block),
    body,
)

_DERIVED = DerivedRows(body)

_KEPT = (
    select(body.c.document)
    .where(body.c.document == document.c.id, body.c.block == 0, body.c.facts.like(bindparam("made")))
    .where(~exists().where(revision.c.document == body.c.document, revision.c.number > body.c.revision, moves()))
    .exists()
)
_WITHOUT = Prepared(select(document.c.id).where(there(), ~_KEPT))


_OF_SKELETON = Prepared(
    select(body.c.facts)
    .join(content, content.c.document == body.c.document)
    .where(content.c.skeleton == bindparam("skeleton", type_=BigInteger), body.c.block == 0)
    .order_by(body.c.document, body.c.revision)
    .limit(bindparam("most", type_=BigInteger))
)


class AtRevision(Protocol):
    """A document at one revision."""

    @property
    def key(self) -> int: ...

    @property
    def revision(self) -> int: ...


@dataclass(frozen=True)
class StoredBody:
    """facts: plain values for JSON. blocks: as `steps.pack` makes them."""

    facts: dict[str, Any]
    blocks: tuple[bytes, ...]


class Bodies:
    def __init__(self, tx: BaseTransaction) -> None:
        self._tx = tx

    def add(self, made: Sequence[tuple[AtRevision, StoredBody]]) -> None:
        """Store bodies of revisions, replacing existing ones."""
        # Another process may derive the same: after waiting for it, its result is used.
        self._tx.order()
        there = _DERIVED.of(self._tx, {revision_of.key: revision_of.revision for revision_of, _ in made})
        for revision_of, _ in made:
            if revision_of.key in there:
                mine = and_(body.c.document == revision_of.key, body.c.revision == revision_of.revision)
                self._tx.run(delete(body).where(mine))
        rows = [
            (revision_of.key, revision_of.revision, place, "" if place else orjson.dumps(derived.facts).decode(), data)
            for revision_of, derived in made
            for place, data in enumerate(derived.blocks)
        ]
        self._tx.insert_tuples(body, ("document", "revision", "block", "facts", "data"), rows)

    def of(self, documents: Sequence[AtRevision]) -> dict[int, StoredBody]:
        """Return existing bodies at these revisions, by the keys of documents."""
        numbers = _DERIVED.of(self._tx, {stored.key: stored.revision for stored in documents})
        if not numbers:
            return {}
        try:
            rows = self._tx.fetch_all(_ROWS, {"keys": list(numbers)})
        except DamageError:
            return {}
        facts: dict[int, dict[str, Any]] = {}
        blocks: dict[int, list[bytes]] = {}
        for key, number, place, told, data in rows:
            if numbers[key] == number and place == len(blocks.setdefault(key, [])):
                blocks[key].append(bytes(data))
                if place == 0:
                    facts[key] = orjson.loads(told)
        whole = [key for key, told in facts.items() if told["blocks"] == len(blocks[key])]
        return {key: StoredBody(facts[key], tuple(blocks[key])) for key in whole}

    def facts_of_skeleton(self, skeleton_key: int, most: int) -> list[dict[str, Any]]:
        """The facts of the first bodies of clips that have, or had, a skeleton."""
        rows = self._tx.fetch_column(_OF_SKELETON, {"skeleton": skeleton_key, "most": most})
        return [orjson.loads(facts) for facts in rows]

    def missing(self, documents: Sequence[AtRevision], made: int) -> list[int]:
        """Return the keys of documents without an undamaged body of the current version."""
        there = self.of(documents)
        return [
            stored.key for stored in documents if stored.key not in there or there[stored.key].facts["made"] != made
        ]

    def without(self, made: int) -> list[int]:
        """The keys of all documents that have none that was made in this way, sound or not."""
        # Their facts end with it (`Body.facts`): each database reads JSON differently.
        return self._tx.fetch_column(_WITHOUT, {"at": self._tx.at, "made": f'%"made":{made}}}'})

    def forget(self, document_key: int, before: int) -> None:
        """Remove the bodies of revisions before one."""
        self._tx.run(delete(body).where(and_(body.c.document == document_key, body.c.revision < before)))
