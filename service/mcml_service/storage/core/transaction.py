"""A transaction on one connection: statements, rows compared with their checksums, the number of its commit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Final, Self

from sqlalchemy import Connection, Table, func, select
from sqlalchemy.sql import ColumnElement

from mcml.errors import StoreError
from mcml_service.storage.core import tables
from mcml_service.storage.core.dialects import Dialect
from mcml_service.storage.core.identifiers import now
from mcml_service.storage.core.schema import CURRENT
from mcml_service.storage.core.seals import add_checksums
from mcml_service.storage.core.statements import Prepared, Statements
from mcml_service.storage.core.validity import valid
from mcml_service.storage.core.views import WHOLE, View

_NEWEST_COMMIT = Prepared(select(func.coalesce(func.max(tables.commit.c.number), 0)))

LATEST = CURRENT - 1
"""Read at this commit to see the current state."""


COMMAND_LINE: Final = "command line"
"""Origin of a process that opens the store itself."""


class BaseTransaction(Statements):
    """A read or write transaction on one connection.

    at: the commit whose state is read; `LATEST` by default, and always in write transactions. view: the visible
    documents and rights of the user. author: author of changes. origin: address of the client. is_trial: whether all
    writes are rolled back at the end, so that they need no right.
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
        super().__init__(connection)
        self.dialect = dialect
        self.at = at
        self.view = view
        self.origin = origin
        self.is_trial = False
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
        """The number of this write transaction, assigned on first use; later writers wait from then on."""
        # Not a cached_property: before Python 3.12 that holds one lock for all transactions while it computes, and a
        # thread waiting in it for the database's lock would block the transaction that has the lock, forever.
        if self._commit is not None:
            return self._commit
        author = self.author
        self.order()
        newest = self.newest_commit()
        row = (newest + 1, now(), author)
        self.dialect.insert(
            self.connection, tables.commit, *add_checksums(tables.commit, ("number", "time", "author"), [row])
        )
        self._commit = newest + 1
        return self._commit

    def newest_commit(self) -> int:
        """The number of the last commit that this transaction sees, 0 in an empty store."""
        # The state that a read transaction sees does not change.
        if self._newest is None or self._author is not None:
            self._newest = int(self.fetch_value(_NEWEST_COMMIT))
        return self._newest

    def valid(self, table: Table) -> ColumnElement[bool]:
        """The condition that a row of a table with `from_commit` and `to_commit` is valid at `self.at`."""
        return valid(table, self.at)

    def at_commit(self, commit: int) -> Self:
        """The same transaction, reading the state of an earlier commit."""
        return type(self)(self.connection, self.dialect, commit, self._author, self.view, self.origin)

    @contextmanager
    def savepoint(self) -> Iterator[None]:
        """Undo the writes of the block if it raises, and continue the transaction."""
        with self.connection.begin_nested():
            yield

    def insert_row(self, table: Table, **values: Any) -> int:
        """Insert one row and answer the key it got."""
        names, rows = add_checksums(table, tuple(values), [tuple(values.values())])
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
            self.dialect.insert(self.connection, table, *add_checksums(table, names, rows))
        else:
            self._gathered.setdefault((table, names), []).extend(rows)

    @contextmanager
    def gathering(self) -> Iterator[None]:
        """Collect inserted rows and write them at the end, with one statement for each table.

        A statement takes as long as some ten rows. Until then reads do not see these rows. `insert_row` inserts at
        once, so that they can refer to its keys.
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
            self.dialect.insert(self.connection, table, *add_checksums(table, names, rows))
