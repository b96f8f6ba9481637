"""The activity log of the repository: rows that are only added, and deleted after some time.

An event is written in the transaction of its action. It first takes the lock that orders commits, so numbers follow
visibility: a reader that has seen one event has missed none before it.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any, Final

from sqlalchemy import (
    Column,
    ColumnElement,
    ForeignKey,
    Integer,
    Select,
    String,
    Table,
    delete,
    func,
    or_,
    select,
    true,
)

from mcml_service.storage.core.identifiers import normalise_name, now
from mcml_service.storage.core.schema import KEY, NAME, metadata
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import document, project
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.views import SCOPES, View, is_seen, may

event = Table(
    "event",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("time", String(32), nullable=False),
    Column("kind", String(16), nullable=False),
    Column("what", String(32), nullable=False),
    Column("author", NAME, nullable=False),
    Column("origin", String(64), nullable=False),
    Column("project", ForeignKey("project.id")),
    Column("about", String(36), index=True),
    Column("revision", Integer),
    Column("subject", NAME, nullable=False),
)
"""`project`: null for events of the whole repository.

`about`: the id of a document, which the event outlives; its name is not kept here, so a purge leaves none. `subject`:
another object of the action.
"""

SERVER: Final = "server"
"""Origin of automatic actions of a server."""

_PLACE: Any = func.coalesce(document.c.project, event.c.project)
"""The current project decides who sees events of a document."""

_TOLD = (
    select(
        *(event.c.id, event.c.time, event.c.kind, event.c.what, event.c.author, event.c.origin),
        *(event.c.about, event.c.revision, event.c.subject, document.c.name.label("document_name")),
        *(_PLACE.label("place"), project.c.name.label("project_name")),
    )
    .select_from(event)
    .outerjoin(document, document.c.uuid == event.c.about)
    .outerjoin(project, project.c.id == _PLACE)
)


@dataclass(frozen=True)
class Event:
    """number: counts up.

    origin: address of the client, None for users who do not manage the project. document, name: the id of the affected
    document, and its current name.
    """

    number: int
    time: str
    kind: str
    what: str
    author: str
    origin: str | None
    project: str | None
    document: str | None
    name: str | None
    revision: int | None
    subject: str


@dataclass(frozen=True)
class EventFilter:
    """None: any. since: a time."""

    project: str | None = None
    document: str | None = None
    author: str | None = None
    kind: str | None = None
    since: str | None = None


class Activity:
    def __init__(self, tx: BaseTransaction) -> None:
        self._tx = tx

    def note(
        self,
        kind: str,
        what: str,
        *,
        project_key: int | None = None,
        document: str | None = None,
        revision: int | None = None,
        subject: str = "",
        author: str | None = None,
    ) -> None:
        """Add an event of now. author: default whose transaction it is."""
        self._tx.order()
        whose = self._tx.author if author is None else author
        row = (now(), kind, what, whose, self._tx.origin[:64], project_key, document, revision, subject)
        self._tx.insert_tuples(event, _NOTED, [row])

    def page(self, wanted: EventFilter, before: int | None, limit: int) -> list[Event]:
        """The newest first, those with numbers below `before`."""
        query = _TOLD.where(_is_shown(self._tx.view)).order_by(event.c.id.desc()).limit(limit)
        if before is not None:
            query = query.where(event.c.id < before)
        if wanted.project is not None:
            query = query.where(project.c.name == normalise_name(wanted.project))
        equal = ((event.c.about, wanted.document), (event.c.author, wanted.author), (event.c.kind, wanted.kind))
        for column, value in equal:
            if value is not None:
                query = query.where(column == normalise_name(value))
        if wanted.since is not None:
            query = query.where(event.c.time >= wanted.since)
        return self._read(query)

    def newest(self) -> int:
        """Return the number of the last event, 0 without events."""
        return int(self._tx.fetch_value(_NEWEST))

    def after(
        self, number: int, limit: int, *, kinds: Collection[str] | None = None, project_key: int | None = None
    ) -> list[Event]:
        """Those behind a number, the oldest first; of some kinds, of a project."""
        query = _TOLD.where(_is_shown(self._tx.view), event.c.id > number).order_by(event.c.id).limit(limit)
        if kinds is not None:
            query = query.where(event.c.kind.in_(kinds))
        if project_key is not None:
            query = query.where(_PLACE.in_([project_key]))
        return self._read(query)

    def forget(self, before: str) -> int:
        """Remove events from before a time; how many. The last one stays, so that no number comes again."""
        old = (event.c.time < before, event.c.id < self.newest())
        return self._tx.run(delete(event).where(*old))

    def _read(self, query: Select[Any]) -> list[Event]:
        view = self._tx.view
        events = []
        for row in self._tx.fetch_all(query):
            decides = may(view.everywhere if row.place is None else view.scope(row.place), "own")
            place = (row.project_name, row.about, row.document_name, row.revision, row.subject)
            fields = (row.id, row.time, row.kind, row.what, row.author)
            events.append(Event(*fields, row.origin if decides else None, *place))
        return events


_NOTED = ("time", "kind", "what", "author", "origin", "project", "about", "revision", "subject")
_NEEDED = {"share": "edit", "webhook": "own"}
"""The scopes that the lists of these need."""
_NEWEST = Prepared(select(func.coalesce(func.max(event.c.id), 0)))


def _is_shown(view: View) -> ColumnElement[bool]:
    """Return the condition for visible events: of visible projects, some kinds only with more rights there; and of
    accounts and tokens for administrators of the repository.
    """
    if may(view.everywhere, SCOPES[-1]):
        return true()
    condition: ColumnElement[bool] = _PLACE.is_not(None) & is_seen(view, _PLACE)
    for kind, needed in _NEEDED.items():
        if not may(view.everywhere, needed):
            places = [key for key, scope in view.projects if may(scope, needed)]
            condition &= or_(event.c.kind != kind, _PLACE.in_(places))
    return condition
