"""The store as transactions.

    with database.read() as tx: ...
    with database.write("kim") as tx: ...      # committed at the end, or nothing happened

A transaction offers one small repository class for each kind of thing: `tx.documents`, `tx.tracks`, `tx.jobs`, ….
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from typing import Any

from sqlalchemy import (
    ClauseElement,
    Connection,
    CursorResult,
    PoolProxiedConnection,
    Table,
    func,
    inspect,
    make_url,
    select,
    text,
)
from sqlalchemy.exc import ArgumentError
from sqlalchemy.sql import ColumnElement

from service.errors import StoreError
from service.resources import migrations_path
from service.storage import tables
from service.storage.accounts import Accounts
from service.storage.aliases import Aliases
from service.storage.bodies import Bodies
from service.storage.columns import Columns
from service.storage.damage import describe_damage
from service.storage.dialects import DIALECTS, Dialect, find_dialect
from service.storage.documents import Documents
from service.storage.heads import Heads
from service.storage.identifiers import now
from service.storage.jobs import Jobs
from service.storage.layout import refuse_newer, require_layout
from service.storage.mappings import Mappings
from service.storage.media import MediaOfDocuments
from service.storage.moments import valid
from service.storage.projects import Projects
from service.storage.pruning import Pruning
from service.storage.purging import Purging
from service.storage.reserve import TO_OPEN, Reserve
from service.storage.results import Results
from service.storage.saved import Saved
from service.storage.schema import CURRENT
from service.storage.seals import Checked, sealed
from service.storage.spans import Spans
from service.storage.thumbnails import Thumbnails
from service.storage.tokens import Tokens
from service.storage.tracks import Tracks
from service.storage.uploads import Uploads
from service.storage.visits import Requests, Sessions
from service.storage.words import in_words

_NEWEST_COMMIT = select(func.coalesce(func.max(tables.commit.c.number), 0))

MOST_KNOWN = 10_000
"""Answers of which it is kept that they were compared."""

LATEST = CURRENT - 1
"""Read at this commit to see what is current."""


class Transaction:
    """A read or write transaction on one connection.

    at: the commit whose state is read; `LATEST` by default, and always in write transactions.
    """

    def __init__(self, connection: Connection, dialect: Dialect, at: int = LATEST, author: str | None = None) -> None:
        self.connection = connection
        self.dialect = dialect
        self.at = at
        self._author = author
        self._commit: int | None = None
        self._gathered: dict[tuple[Table, tuple[str, ...]], list[tuple[Any, ...]]] | None = None

    @property
    def commit(self) -> int:
        """The number of this write transaction, taken when first asked for; later writers wait from then on."""
        # Not a cached_property: before Python 3.12 that holds one lock for all transactions while it computes, and
        # who waits in it for the database's lock would stop the transaction that has it, for ever.
        if self._commit is not None:
            return self._commit
        if self._author is None:
            raise StoreError("A read transaction cannot write.")
        self.dialect.order_commits(self.connection)
        newest = self.newest_commit()
        row = (newest + 1, now(), self._author)
        self.dialect.insert(self.connection, tables.commit, *sealed(tables.commit, ("number", "time", "author"), [row]))
        self._commit = newest + 1
        return self._commit

    def newest_commit(self) -> int:
        """The number of the last commit that this transaction sees, 0 in an empty store."""
        return int(self.rows(_NEWEST_COMMIT)[0][0])

    def valid(self, table: Table) -> ColumnElement[bool]:
        """The condition that a row of a table with `from_commit` and `to_commit` is valid at `self.at`."""
        return valid(table, self.at)

    def at_commit(self, commit: int) -> Transaction:
        """The same transaction, reading the state of an earlier commit."""
        return Transaction(self.connection, self.dialect, commit, self._author)

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
    def saved(self) -> Saved:
        return Saved(self)

    @cached_property
    def accounts(self) -> Accounts:
        return Accounts(self)

    @cached_property
    def tokens(self) -> Tokens:
        return Tokens(self)

    @cached_property
    def sessions(self) -> Sessions:
        return Sessions(self)

    @cached_property
    def requests(self) -> Requests:
        return Requests(self)


class Database:
    """A store by its SQLAlchemy URL: `sqlite:///path` or `postgresql+psycopg://…`."""

    def __init__(self, url: str) -> None:
        try:
            parsed = make_url(url)
        except ArgumentError as error:
            raise StoreError(
                f"{url!r} is not a database address.",
                remedy="Write sqlite:///path/to/file.db or postgresql+psycopg://user:password@host/name.",
            ) from error
        name = parsed.get_backend_name()
        if name not in DIALECTS:
            raise StoreError(f"Unknown kind of database {name!r}.", remedy=f"Use one of: {', '.join(DIALECTS)}.")
        self.url = url
        kind = find_dialect(name)
        self.dialect = kind(kind.create_engine(url))
        self.reserve = Reserve(self.dialect.file)
        self._watch: PoolProxiedConnection | None = None

    @property
    def name(self) -> str:
        """The kind of database: "sqlite" or "postgresql"."""
        return self.dialect.engine.dialect.name

    @contextmanager
    def read(self, at: int = LATEST) -> Iterator[Transaction]:
        """A snapshot: what other transactions commit meanwhile is not seen."""
        with in_words(self.dialect), self.dialect.reading() as connection:
            yield Transaction(connection, self.dialect, at)

    @contextmanager
    def write(self, author: str = "local") -> Iterator[Transaction]:
        """A write transaction: committed when the block ends, rolled back when it raises."""
        with in_words(self.dialect), self.dialect.writing() as connection:
            yield Transaction(connection, self.dialect, author=author)

    def migrate(self) -> None:
        """Bring the schema to this program's version (a new store gets it whole)."""
        found, wanted = self.schema_versions()
        if found == wanted:
            # Reading commands need no write lock, and work while another process writes.
            self._require_layout()
            return
        refuse_newer(found, wanted)
        # Imported late: it takes as long as all else that a short command needs.
        from alembic import command
        from alembic.config import Config

        with in_words(self.dialect), self.dialect.writing() as connection:
            self.dialect.order_commits(connection)
            config = Config()
            config.set_main_option("script_location", str(migrations_path()))
            config.attributes["connection"] = connection
            command.upgrade(config, "head")

    def schema_versions(self) -> tuple[str | None, str | None]:
        """(the store's schema version, this program's)."""
        # A store on a full disk has to be opened before it can be emptied.
        found = self.reserve.spend(self._schema_version, TO_OPEN)
        # Migrations have numbers, and go forward only: the last one is the newest.
        return found, max(path.name[:4] for path in (migrations_path() / "versions").glob("[0-9][0-9][0-9][0-9]_*.py"))

    def _schema_version(self) -> str | None:
        with in_words(self.dialect), self.dialect.reading() as connection:
            known = inspect(connection).has_table("alembic_version")
            return connection.execute(text("SELECT version_num FROM alembic_version")).scalar() if known else None

    def require_schema(self) -> None:
        """StoreError unless the schema is this program's."""
        found, wanted = self.schema_versions()
        if found != wanted:
            refuse_newer(found, wanted)
            raise StoreError(
                f"The store's schema is {found or 'empty'}, this program needs {wanted}.",
                remedy="Run `mcml db upgrade`.",
            )
        self._require_layout()

    def _require_layout(self) -> None:
        with in_words(self.dialect), self.dialect.reading() as connection:
            require_layout(connection)

    def sweep(self, lease_before: float | None = None) -> int:
        """Remove what broken imports left behind; returns the number of documents removed.

        lease_before: imports whose lease ended before this time (seconds since 1970; default now) are broken.
        """
        limit = time.time() if lease_before is None else lease_before
        with self.write() as tx:
            removed = tx.documents.remove_broken_imports(limit)
            tx.uploads.remove_orphans(limit)
            return removed

    def check(self, *, past: bool = False) -> list[str]:
        """Faults found in the store, in words; empty when it is sound. past: in all past revisions too."""
        from service.storage.checks import faults

        with self.read() as tx:
            return faults(tx, past=past)

    def size(self) -> dict[str, int]:
        with in_words(self.dialect), self.dialect.reading() as connection:
            return self.dialect.size(connection)

    def has_token(self) -> bool:
        """Whether there is any token or account, of an SQLite file, in microseconds: asked before every request to an
        open one. For one thread, over a connection that nothing else uses, so it waits for no other request."""
        with in_words(self.dialect):
            if self._watch is None:
                self._watch = self.dialect.engine.raw_connection()
                self._watch.detach()
            driver: Any = self._watch.dbapi_connection
            return bool(driver.execute("SELECT 1 FROM token UNION SELECT 1 FROM account LIMIT 1").fetchall())

    def close(self) -> None:
        if self._watch is not None:
            self._watch.close()
            self._watch = None
        self.dialect.engine.dispose()
