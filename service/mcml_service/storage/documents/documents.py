"""Documents and their revisions: existence, times, states."""

from __future__ import annotations

import time
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import zstandard
from sqlalchemy import bindparam, delete, func, select, update

from mcml.errors import NotFoundError
from mcml.motion.clip import seconds_from
from mcml_service.storage.core.identifiers import new_uuid, normalise_name
from mcml_service.storage.core.schema import CURRENT, metadata
from mcml_service.storage.core.seals import SEALS, closing, damage, verify
from mcml_service.storage.core.sql_expressions import OneOf
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import content, document, property_, revision
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.validity import is_imported, there
from mcml_service.storage.core.views import is_seen
from mcml_service.storage.documents.damage import name_document
from mcml_service.storage.documents.document_statements import CONTENT, all_documents, one_document
from mcml_service.storage.documents.media_offsets import follow_frames
from mcml_service.storage.documents.uploads import LEASE_SECONDS
from mcml_service.storage.lists.filtering import DocumentFilter, select_wanted
from mcml_service.storage.lists.orders import Order, Place, order_rows, value_in
from mcml_service.storage.projects.activity import Activity
from mcml_service.storage.projects.quotas import Quotas

# Made once: to build a statement takes four times as long as to run it.
_WHOLE = Prepared(
    select(*(document.c[name] for name in SEALS[document].columns)).where(document.c.id == bindparam("key")), document
)
_IMPORTING = update(document).where(document.c.id == bindparam("key"), document.c.state == "importing")
_RENEW = Prepared(_IMPORTING.values(lease=bindparam("until")))
_MADE = ("document", "number", "commit", "parent", "operation", "message")
_BEGUN = Prepared(select(document.c.uuid, document.c.name, document.c.format).where(document.c.id == bindparam("key")))
_COUNT = Prepared(select(func.count()).select_from(document).where(there()))
_PROJECT = Prepared(select(document.c.project).where(document.c.id == bindparam("key")))
_NAMED = Prepared(select(document.c.name, document.c.project).where(document.c.id == bindparam("key")))
_PUBLISH = Prepared(
    _IMPORTING.values(
        state="ready",
        lease=None,
        created_commit=bindparam("commit"),
        next_slot=bindparam("slot"),
        receipt=bindparam("packed"),
        checksum=bindparam("sum"),
    )
)


_COLUMNS = tuple(all_documents(past=False).selected_columns.keys())
_CONTENT = [content.c[name] for name in CONTENT]

FEW = 1000
"""Documents that are looked for one by one; of more, all are read."""


@dataclass(frozen=True)
class StoredDocument:
    """A document at one revision.

    key: its number inside the store; uuid: its name outside. frame_time: seconds a frame, as written.
    data_rate: frames a second, where the header states them.
    """

    key: int
    uuid: str
    project: str
    project_key: int
    name: str
    format: str
    version: str
    skeleton: int
    frames: int
    frame_time: str | None
    data_rate: str | None
    intact: bool
    revision: int
    created: str
    modified: str
    next_slot: int

    @property
    def seconds_per_frame(self) -> float | None:
        """From the frame time, else from the header's rate; None if neither has a usable value."""
        return seconds_from(self.frame_time, self.data_rate)


class Documents:
    def __init__(self, tx: BaseTransaction, activity: Activity, quotas: Quotas) -> None:
        self._tx = tx
        self._activity = activity
        self._quotas = quotas
        self._reviewed: set[int] = set()

    def at(self, commit: int) -> Documents:
        """Return the documents at an earlier commit."""
        return Documents(self._tx.at_commit(commit), self._activity, self._quotas)

    def with_property(self, name: str, beginning: str) -> list[tuple[str, str]]:
        """(uuid, first 80 characters of the text) of documents with a property whose text begins so."""
        start = func.substr(property_.c.text, 1, 80)
        query = select(document.c.uuid, start).join(property_, property_.c.document == document.c.id)
        having = query.where(
            is_seen(self._tx.view), property_.c.name == name, start.startswith(beginning, autoescape=True)
        )
        return [(row[0], row[1]) for row in self._tx.fetch_all(having)]

    def begin(self, project_key: int, name: str, format_name: str) -> tuple[int, str]:
        """A document in state "importing", which no read sees. Returns (key, uuid). AccessError."""
        self._quotas.require(project_key)
        uuid = new_uuid()
        row = {
            "uuid": uuid,
            "project": project_key,
            "state": "importing",
            "lease": time.time() + LEASE_SECONDS,
            "name": normalise_name(name),
            "format": format_name,
            "deleted_commit": CURRENT,
            "next_slot": 0,
            "receipt": b"",
        }
        return self._tx.insert_row(document, **row), uuid

    def renew_lease(self, key: int) -> None:
        """Renew the lease of an import; raises NotFoundError if its rows were deleted."""
        if self._tx.run(_RENEW, {"key": key, "until": time.time() + LEASE_SECONDS}) != 1:
            raise _make_swept_error()

    def publish(self, key: int, name: str, project_key: int, *, next_slot: int, receipt: str, message: str) -> None:
        """Make an imported document visible, as revision 1 of this transaction's commit. name, project_key: its own."""
        number = self._tx.commit
        begun = self._tx.fetch_all(_BEGUN, {"key": key})
        if not begun:
            raise _make_swept_error()
        uuid, begun_as, format_name = begun[0]
        row = (uuid, project_key, "ready", begun_as, format_name, number, CURRENT, next_slot)
        values = {"key": key, "commit": number, "slot": next_slot, "packed": _pack(receipt)}
        values["sum"] = SEALS[document].of(row)
        if self._tx.run(_PUBLISH, values) != 1:
            raise _make_swept_error()
        made = (key, 1, number, None, "import", message, normalise_name(name), project_key)
        self._tx.insert_tuples(revision, (*_MADE, "name", "project"), [made])
        self._activity.note("document", "import", project_key=project_key, document=uuid, revision=1)
        self._quotas.require_room(project_key)

    def write_content(self, key: int, from_commit: int, **given: Any) -> None:
        """Set values of a revision, by the columns of `content`; others do not change.

        The last call in a transaction wins, and equal values are not written again: an edit of one value after another
        touches three pages less. given: all values if `from_commit` is 0, for an import.
        """
        if from_commit:
            current = (content.c.document == key, content.c.to_commit == CURRENT)
            (row,) = self._tx.fetch_all(select(*_CONTENT).where(*current))
            held = row._mapping
            if all(held[name] == value for name, value in given.items()):
                return
            given = {**held, **given}
            self._tx.run(delete(content).where(*current, content.c.from_commit == from_commit))
            self._tx.run(update(content).where(*current).values(closing(content, from_commit)))
        self._tx.insert_rows(content, [{"document": key, "from_commit": from_commit, "to_commit": CURRENT, **given}])

    def add_revision(self, stored: StoredDocument, operation: str, message: str = "") -> int:
        """Record a revision made by this transaction; return its number.

        The caller has checked that `stored` is the newest. Raises AccessError without the right to change the document,
        ConflictError where changes need a review and this is none that `allow_reviewed` has announced.
        """
        (named,) = self._tx.fetch_all(_NAMED, {"key": stored.key})
        self._quotas.require(named[1])
        if stored.key not in self._reviewed:
            # A document that moves changes in the project that it leaves.
            self._quotas.require_direct(stored.project_key, operation)
        number = stored.revision + 1
        values = (stored.key, number, self._tx.commit, stored.revision, operation, message)
        self._tx.insert_tuples(revision, (*_MADE, "name", "project"), [(*values, *named)])
        follow_frames(self._tx, stored.key, stored.seconds_per_frame)
        about = {"project_key": named[1], "document": stored.uuid, "revision": number}
        self._activity.note("document", operation, **about)
        return number

    def allow_reviewed(self, key: int) -> None:
        """Let this transaction make a revision of a document whose changes need a review: it has been approved."""
        self._reviewed.add(key)

    def require(self, key: int) -> None:
        """Check the right to change a document. Raises AccessError."""
        self._quotas.require(self._project(key))

    def require_room(self, key: int) -> None:
        """ConflictError where the project of a document holds more than it may."""
        self._quotas.require_room(self._project(key))

    def _project(self, key: int) -> int:
        """The project that a document is in now."""
        return int(self._tx.fetch_value(_PROJECT, {"key": key}))

    def seen(self) -> frozenset[int] | None:
        """Keys of the documents that are seen, None for all."""
        if self._tx.view.is_whole:
            return None
        return frozenset(self._tx.fetch_column(select(document.c.id).where(is_seen(self._tx.view))))

    def lock(self, key: int) -> None:
        """Let no other transaction change this document until this one ends."""
        self._tx.fetch_value(select(document.c.id).where(document.c.id == key).with_for_update())

    def find(self, uuid: str, *, deleted: bool = False) -> StoredDocument | None:
        """Return the document at the transaction's commit; `deleted` includes deleted ones."""
        statement = one_document(past=self._past, deleted=deleted)
        row = self._tx.fetch_one(statement, {"uuid": uuid, "at": self._tx.at})
        stored = None if row is None else _to_document(row)
        if stored is None or self._tx.view.is_whole:
            return stored
        # Of the past too it is the project of now that decides.
        return stored if self._tx.view.shows(uuid, self._project(stored.key)) else None

    def get(self, uuid: str, *, deleted: bool = False) -> StoredDocument:
        """As `find`, but raises NotFoundError if there is none."""
        stored = self.find(uuid, deleted=deleted)
        if stored is None:
            raise NotFoundError(f"There is no document {uuid}.", remedy="List the documents to see their ids.")
        return stored

    @property
    def _past(self) -> bool:
        """Whether a state before the newest is read."""
        return self._tx.at < CURRENT - 1

    def page(
        self,
        wanted: DocumentFilter,
        *,
        after: Place | None = None,
        limit: int,
        order: Order = Order(),  # frozen
        offset: int = 0,
    ) -> list[StoredDocument]:
        """Documents in an order, those behind a place, without the first `offset`."""
        return self.get_many([place.key for place in self.places(wanted, order, after, limit, offset)])

    def places(self, wanted: DocumentFilter, order: Order, after: Place | None, limit: int, offset: int) -> list[Place]:
        """Return the positions of the same documents."""
        # Select the documents first: reading facts of all documents before sorting takes most of the time.
        value = value_in(order.column, self._tx)
        query = order_rows(select_wanted(value, wanted, self._tx), value, order, after)
        query = query.add_columns(document.c.name, document.c.id).limit(limit).offset(offset)
        return [Place(*row) for row in self._tx.fetch_all(query)]

    def get_many(self, keys: list[int]) -> list[StoredDocument]:
        """Return facts of documents, in this order; including deleted ones."""
        rows = self._tx.fetch_all(_prepare_summaries(past=self._past), {"at": self._tx.at, "keys": keys})
        place = {key: number for number, key in enumerate(keys)}
        return sorted(map(_to_document, rows), key=lambda stored: place[stored.key])

    def count(self, wanted: DocumentFilter) -> int:
        if wanted == DocumentFilter() and self._tx.view.is_whole:
            # An index alone answers this one.
            return int(self._tx.fetch_value(_COUNT, {"at": self._tx.at}))
        return int(self._tx.fetch_value(select_wanted(func.count(), wanted, self._tx)))

    def everything(self) -> list[tuple[int, str, str]]:
        """(key, uuid, name) of all documents whose import was complete, deleted ones too."""
        query = select(document.c.id, document.c.uuid, document.c.name).where(
            is_imported(self._tx.at), is_seen(self._tx.view)
        )
        return [(key, uuid, name) for key, uuid, name in self._tx.fetch_all(query.order_by(document.c.id))]

    def uuids(self, wanted: DocumentFilter) -> list[str]:
        """Of documents, by name and key."""
        query = select_wanted(document.c.uuid, wanted, self._tx).order_by(document.c.name, document.c.id)
        return self._tx.fetch_column(query)

    def keys_of(self, uuids: Collection[str]) -> list[int]:
        """Keys of documents whose import was complete, deleted ones too."""
        if len(uuids) > FEW:
            return [key for key, uuid, _ in self.everything() if uuid in uuids]
        query = select(document.c.id).where(
            document.c.uuid.in_(uuids), is_imported(self._tx.at), is_seen(self._tx.view)
        )
        return sorted(self._tx.fetch_column(query))

    def receipt(self, key: int) -> str:
        packed = self._tx.fetch_value(select(document.c.receipt).where(document.c.id == key))
        try:
            return zstandard.ZstdDecompressor().decompress(packed).decode()
        except (zstandard.ZstdError, UnicodeDecodeError):
            raise damage(name_document(self._tx, key), "its receipt") from None

    def rename(self, key: int, name: str) -> None:
        self._change(key, name=normalise_name(name))

    def move(self, key: int, project_key: int) -> None:
        self.require(key)
        self._quotas.require(project_key)
        self._change(key, project=project_key)
        self._quotas.require_room(project_key)

    def set_next_slot(self, key: int, slot: int) -> None:
        self._change(key, next_slot=slot)

    def delete(self, key: int) -> None:
        """Hide the document from this transaction's commit on; nothing is lost."""
        self._set_deleted(key, self._tx.commit)

    def undelete(self, key: int) -> None:
        self._set_deleted(key, CURRENT)
        self.require_room(key)

    def _set_deleted(self, key: int, number: int) -> None:
        self._change(key, deleted_commit=number)

    def _change(self, key: int, **values: Any) -> None:
        """Change values in the row of a document. Raises DamageError if it is damaged."""
        (held,) = self._tx.fetch_all(_WHOLE, {"key": key})
        row = dict(zip(SEALS[document].columns, held, strict=True)) | values
        self._tx.run(
            update(document).where(document.c.id == key).values(**values, checksum=SEALS[document].of((*row.values(),)))
        )

    def commit_of(self, key: int, number: int) -> int:
        """The commit that made a revision; NotFoundError."""
        query = select(revision.c.commit).where(revision.c.document == key, revision.c.number == number)
        rows = self._tx.fetch_all(verify(query, revision))
        if not rows:
            oldest = self._tx.fetch_value(select(func.min(revision.c.number)).where(revision.c.document == key))
            pruned = oldest is not None and 1 <= number < oldest
            pruned_text = f"Revision {number} was pruned: those from {oldest} on are kept."
            raise NotFoundError(
                pruned_text if pruned else f"The document has no revision {number}.", remedy="List its revisions."
            )
        return int(rows[0][0])

    def remove_broken_imports(self, lease_before: float) -> int:
        """Delete all rows of imports that never became visible and whose lease has ended."""
        query = select(document.c.id).where(document.c.state == "importing", document.c.lease < lease_before)
        keys = self._tx.fetch_column(query)
        self._remove(keys)
        return len(keys)

    def set_state(self, key: int, state: str) -> None:
        self._change(key, state=state)

    def remove_purged(self, key: int) -> None:
        """Delete all rows of a document that is being purged."""
        query = select(document.c.id).where(document.c.state == "purging", document.c.id == key)
        self._remove(self._tx.fetch_column(query))

    def remove_import(self, key: int) -> None:
        """Delete all rows of an import that failed; those of a document that is ready stay."""
        query = select(document.c.id).where(document.c.state == "importing", document.c.id == key)
        self._remove(self._tx.fetch_column(query))

    def _remove(self, keys: list[int]) -> None:
        for key in keys:
            for table in reversed(metadata.sorted_tables):
                if "document" in table.c and table is not document:
                    self._tx.run(delete(table).where(table.c.document == key))
            self._tx.run(delete(document).where(document.c.id == key))


@cache
def _prepare_summaries(*, past: bool) -> Prepared:
    return Prepared(all_documents(past=past).where(OneOf(document.c.id, "keys")), document, content)


def _make_swept_error() -> NotFoundError:
    return NotFoundError("The import took too long and was swept away.", remedy="Import the file again.")


def _pack(receipt: str) -> bytes:
    return zstandard.ZstdCompressor(level=3, write_checksum=True).compress(receipt.encode())


def _to_document(row: Sequence[Any]) -> StoredDocument:
    values = dict(zip(_COLUMNS, row, strict=True))
    # SQLite has no separate type for it.
    return StoredDocument(**(values | {"intact": bool(values["intact"])}))
