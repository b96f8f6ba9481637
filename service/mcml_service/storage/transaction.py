"""A transaction on the store: one small repository class for each kind of thing, `tx.documents`, `tx.tracks`, …."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from typing import Any

from sqlalchemy import (
    ClauseElement,
    Connection,
    CursorResult,
    Table,
    func,
    select,
)
from sqlalchemy.sql import ColumnElement

from mcml.errors import StoreError
from mcml_service.storage import tables
from mcml_service.storage.accounts import Accounts
from mcml_service.storage.activity import COMMAND_LINE, Activity
from mcml_service.storage.aliases import Aliases
from mcml_service.storage.attempts import Attempts
from mcml_service.storage.bodies import Bodies
from mcml_service.storage.columns import Columns
from mcml_service.storage.comments import Comments
from mcml_service.storage.damage import describe_damage
from mcml_service.storage.dialects import Dialect
from mcml_service.storage.documents import Documents
from mcml_service.storage.heads import Heads
from mcml_service.storage.identifiers import now
from mcml_service.storage.jobs import Jobs
from mcml_service.storage.mappings import Mappings
from mcml_service.storage.media import MediaOfDocuments
from mcml_service.storage.members import Members
from mcml_service.storage.moments import valid
from mcml_service.storage.presence import Presence
from mcml_service.storage.projects import Projects
from mcml_service.storage.pruning import Pruning
from mcml_service.storage.purging import Purging
from mcml_service.storage.results import Results
from mcml_service.storage.revisions import Revisions
from mcml_service.storage.saved import Saved
from mcml_service.storage.schema import CURRENT
from mcml_service.storage.seals import Checked, sealed
from mcml_service.storage.shares import Shares
from mcml_service.storage.spans import Spans
from mcml_service.storage.terms import ProjectTerms
from mcml_service.storage.thumbnails import Thumbnails
from mcml_service.storage.tokens import Tokens
from mcml_service.storage.tracks import Tracks
from mcml_service.storage.uploads import Uploads
from mcml_service.storage.views import WHOLE, View
from mcml_service.storage.visits import Requests, Sessions
from mcml_service.storage.webhooks import Webhooks

_NEWEST_COMMIT = select(func.coalesce(func.max(tables.commit.c.number), 0))

MOST_KNOWN = 10_000
"""Answers of which it is kept that they were compared."""

LATEST = CURRENT - 1
"""Read at this commit to see what is current."""


class Transaction:
    """A read or write transaction on one connection.

    at: the commit whose state is read; `LATEST` by default, and always in write transactions. view: what whoever has it
    sees and may change. author: whose changes they are. origin: from where they come.
    """

    def __init__(
        self,
        connection: Connection,
        dialect: Dialect,
        at: int = LATEST,
        author: str | None = None,
        view: View = WHOLE,
        origin: str = COMMAND_LINE,
    ) -> None:
        self.connection = connection
        self.dialect = dialect
        self.at = at
        self.view = view
        self.origin = origin
        self._author = author
        self._commit: int | None = None
        self._newest: int | None = None
        self._ordered = False
        self._gathered: dict[tuple[Table, tuple[str, ...]], list[tuple[Any, ...]]] | None = None

    @property
    def author(self) -> str:
        """StoreError in a read transaction."""
        if self._author is None:
            raise StoreError("A read transaction cannot write.")
        return self._author

    def order(self) -> None:
        """Let no other writer number anything until this transaction has ended."""
        if not self._ordered:
            self.dialect.order_commits(self.connection)
            self._ordered = True

    @property
    def commit(self) -> int:
        """The number of this write transaction, taken when first asked for; later writers wait from then on."""
        # Not a cached_property: before Python 3.12 that holds one lock for all transactions while it computes, and
        # who waits in it for the database's lock would stop the transaction that has it, for ever.
        if self._commit is not None:
            return self._commit
        author = self.author
        self.order()
        newest = self.newest_commit()
        row = (newest + 1, now(), author)
        self.dialect.insert(self.connection, tables.commit, *sealed(tables.commit, ("number", "time", "author"), [row]))
        self._commit = newest + 1
        return self._commit

    def newest_commit(self) -> int:
        """The number of the last commit that this transaction sees, 0 in an empty store."""
        # What a transaction that reads sees does not change.
        if self._newest is None or self._author is not None:
            self._newest = int(self.rows(_NEWEST_COMMIT)[0][0])
        return self._newest

    def valid(self, table: Table) -> ColumnElement[bool]:
        """The condition that a row of a table with `from_commit` and `to_commit` is valid at `self.at`."""
        return valid(table, self.at)

    def at_commit(self, commit: int) -> Transaction:
        """The same transaction, reading the state of an earlier commit."""
        return Transaction(self.connection, self.dialect, commit, self._author, self.view, self.origin)

    def run(self, statement: ClauseElement, values: dict[str, Any] | None = None) -> CursorResult[Any]:
        """Execute a statement that the program makes once. Lists among the values are for `OneOf`."""
        return self.dialect.run(self.connection, statement, values or {})

    def rows(self, statement: ClauseElement, values: dict[str, Any] | None = None) -> list[tuple[Any, ...]]:
        """What a statement that the program makes once reads. Lists among the values are for `OneOf`."""
        return self.dialect.rows(self.connection, statement, values or {})

    def checked(self, statement: Checked, values: dict[str, Any]) -> Sequence[tuple[Any, ...]]:
        """As `rows`, each row compared with its checksum. DamageError for the first that has another."""
        found, damaged = statement.check(self.rows(statement.statement, values))
        if damaged is not None:
            raise describe_damage(self, *damaged)
        return found

    def checked_again(self, statement: Checked, values: dict[str, Any]) -> Sequence[tuple[Any, ...]]:
        """As `checked`, for a statement that is often asked and reads the same many rows: what this process has
        compared before is not compared again."""
        rows = self.rows(statement.plain, values)
        mark = hash((id(statement), tuple(rows)))
        known = self.dialect.known_sound
        if mark not in known:
            rows = list(self.checked(statement, values))
            if len(known) >= MOST_KNOWN:
                known.clear()
            known.add(mark)
        return rows

    def checked_once(self, statement: Checked, values: dict[str, Any] | None = None) -> Sequence[tuple[Any, ...]]:
        """As `checked`, for a statement that is not made once."""
        found, damaged = statement.check([tuple(row) for row in self.connection.execute(statement.statement, values)])
        if damaged is not None:
            raise describe_damage(self, *damaged)
        return found

    def insert_row(self, table: Table, **values: Any) -> int:
        """Insert one row and answer the key it got."""
        names, rows = sealed(table, tuple(values), [tuple(values.values())])
        return self.dialect.insert_one(self.connection, table, dict(zip(names, rows[0], strict=True)))

    def insert_rows(self, table: Table, rows: list[dict[str, Any]]) -> None:
        """Insert rows that have the same columns."""
        if rows:
            names = tuple(rows[0])
            self.insert_tuples(table, names, [tuple(row[name] for name in names) for row in rows])

    def insert_tuples(self, table: Table, names: tuple[str, ...], rows: Sequence[tuple[Any, ...]]) -> None:
        """Insert rows that hold the values of these columns."""
        if not rows:
            return
        if self._gathered is None:
            self.dialect.insert(self.connection, table, *sealed(table, names, rows))
        else:
            self._gathered.setdefault((table, names), []).extend(rows)

    @contextmanager
    def gathering(self) -> Iterator[None]:
        """What many rows are given meanwhile is written at the end, one statement a table.

        A statement takes as long as some ten rows. Until then nothing that is read holds these rows; `insert_row`
        inserts at once, so that they may refer to its keys.
        """
        self._gathered = {}
        try:
            yield
            self.write_gathered()
        finally:
            self._gathered = None

    def write_gathered(self) -> None:
        """Write what waits, for a read that must see it."""
        waiting, self._gathered = self._gathered or {}, None if self._gathered is None else {}
        for (table, names), rows in waiting.items():
            self.dialect.insert(self.connection, table, *sealed(table, names, rows))

    @cached_property
    def documents(self) -> Documents:
        return Documents(self)

    @cached_property
    def revisions(self) -> Revisions:
        return Revisions(self)

    @cached_property
    def heads(self) -> Heads:
        return Heads(self)

    @cached_property
    def tracks(self) -> Tracks:
        return Tracks(self)

    @cached_property
    def columns(self) -> Columns:
        return Columns(self)

    @cached_property
    def spans(self) -> Spans:
        return Spans(self)

    @cached_property
    def thumbnails(self) -> Thumbnails:
        return Thumbnails(self)

    @cached_property
    def bodies(self) -> Bodies:
        return Bodies(self)

    @cached_property
    def uploads(self) -> Uploads:
        return Uploads(self)

    @cached_property
    def projects(self) -> Projects:
        return Projects(self)

    @cached_property
    def terms(self) -> ProjectTerms:
        return ProjectTerms(self)

    @cached_property
    def jobs(self) -> Jobs:
        return Jobs(self)

    @cached_property
    def results(self) -> Results:
        return Results(self)

    @cached_property
    def aliases(self) -> Aliases:
        return Aliases(self)

    @cached_property
    def pruning(self) -> Pruning:
        return Pruning(self)

    @cached_property
    def purging(self) -> Purging:
        return Purging(self)

    @cached_property
    def mappings(self) -> Mappings:
        return Mappings(self)

    @cached_property
    def media(self) -> MediaOfDocuments:
        return MediaOfDocuments(self)

    @cached_property
    def comments(self) -> Comments:
        return Comments(self)

    @cached_property
    def presence(self) -> Presence:
        return Presence(self)

    @cached_property
    def activity(self) -> Activity:
        return Activity(self)

    @cached_property
    def webhooks(self) -> Webhooks:
        return Webhooks(self)

    @cached_property
    def saved(self) -> Saved:
        return Saved(self)

    @cached_property
    def accounts(self) -> Accounts:
        return Accounts(self)

    @cached_property
    def members(self) -> Members:
        return Members(self)

    @cached_property
    def tokens(self) -> Tokens:
        return Tokens(self)

    @cached_property
    def shares(self) -> Shares:
        return Shares(self)

    @cached_property
    def sessions(self) -> Sessions:
        return Sessions(self)

    @cached_property
    def attempts(self) -> Attempts:
        return Attempts(self)

    @cached_property
    def requests(self) -> Requests:
        return Requests(self)
