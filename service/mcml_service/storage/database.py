"""The store as transactions.

    with database.read() as tx: ...
    with database.write("kim") as tx: ...      # committed at the end, or nothing happened

`storage.transaction` has the methods of a transaction.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from copy import copy
from typing import Any, TypeAlias, TypeVar

from sqlalchemy import (
    Connection,
    PoolProxiedConnection,
    inspect,
    make_url,
)
from sqlalchemy.exc import ArgumentError

from mcml.errors import ReplicaError, StoreError
from mcml_service.resources import migrations_path
from mcml_service.storage.core.database_errors import translate
from mcml_service.storage.core.dialects import DIALECTS, find_dialect
from mcml_service.storage.core.replica import Replica
from mcml_service.storage.core.reserve import TO_OPEN, Reserve
from mcml_service.storage.core.statements import Statements, execute_on_driver
from mcml_service.storage.core.transaction import COMMAND_LINE, LATEST
from mcml_service.storage.core.views import WHOLE, View
from mcml_service.storage.layout import refuse_newer, require_layout
from mcml_service.storage.transaction import Transaction

Answer = TypeVar("Answer")
Mend: TypeAlias = Callable[[str, Transaction], None]
"""Given the version that a store had, and a transaction on it with today's tables."""


class _RollBackError(Exception):
    """A signal: nothing of a transaction is to stay."""


class Database:
    """A store by its SQLAlchemy URL: `sqlite:///path` or `postgresql+psycopg://…`. read_url: of a replica of it."""

    def __init__(self, url: str, read_url: str | None = None) -> None:
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
        self.url, self.read_url = url, read_url
        kind = find_dialect(name)
        self.dialect = kind(kind.create_engine(url))
        self.reserve = Reserve(self.dialect.file)
        self.replica = Replica(read_url, self.dialect) if read_url else None
        self.view = WHOLE
        self.writes = 0
        """Write transactions that were committed."""
        self.from_replica = False
        self.origin = COMMAND_LINE
        self._watch: PoolProxiedConnection | None = None

    @property
    def name(self) -> str:
        """The kind of database: "sqlite" or "postgresql"."""
        return self.dialect.engine.dialect.name

    def for_call(self, view: View, origin: str | None = None, *, from_replica: bool = False) -> Database:
        """Return the same store for one call, which counts its own writes.

        view: the access of the user. origin: address of the client, None: unchanged. from_replica: read the replica, if
        there is one with everything committed before; callers must handle ReplicaError.
        """
        other = copy(self)
        other.view, other.from_replica, other.writes = view, from_replica, 0
        other.origin = self.origin if origin is None else origin
        return other

    @contextmanager
    def read(self, at: int = LATEST) -> Iterator[Transaction]:
        """A snapshot: later commits of other transactions are invisible."""
        with translate(self.dialect), self._reading() as connection:
            yield Transaction(connection, self.dialect, at, view=self.view)

    @contextmanager
    def look(self) -> Iterator[Transaction]:
        """Read the current state, for callers that often run a single statement: two statements may see different
        states.
        """
        with translate(self.dialect), self.dialect.looking() as connection:
            yield Transaction(connection, self.dialect, view=self.view)

    @contextmanager
    def _reading(self) -> Iterator[Connection]:
        if self.from_replica and self.replica is not None:
            with self.replica.reading() as replica:
                if replica is not None:
                    yield replica
                    return
        with self.dialect.reading() as connection:
            yield connection

    def ask(self, question: Callable[[Transaction], Answer], at: int = LATEST) -> Answer:
        """Run a function in a read transaction and return its result; run it again if the replica becomes
        unreachable meanwhile.
        """
        try:
            with self.read(at) as tx:
                return question(tx)
        except ReplicaError:
            with self.for_call(self.view).read(at) as tx:
                return question(tx)

    @contextmanager
    def write(self, author: str = "local") -> Iterator[Transaction]:
        """A write transaction: committed when the block ends, rolled back when it raises."""
        with translate(self.dialect), self.dialect.writing() as connection:
            yield Transaction(connection, self.dialect, author=author, view=self.view, origin=self.origin)
        self.writes += 1

    @contextmanager
    def trial(self, author: str = "local") -> Iterator[Transaction]:
        """A write transaction that is always rolled back: changes are tried in it, also by users who may only read."""
        try:
            with self.write(author) as tx:
                tx.is_trial = True
                yield tx
                raise _RollBackError
        except _RollBackError:
            return

    def migrate(self, mend: Mend | None = None) -> None:
        """Bring the schema to this program's version (a new store gets it whole).

        mend: fills in data that rows of an older store lack, in the same transaction. Raises StoreError for an older
        store without it.
        """
        version, wanted = self.schema_versions()
        if version == wanted:
            # Reading commands need no write lock, and work while another process writes.
            self._require_layout()
            return
        refuse_newer(version, wanted)
        if version is not None and mend is None:
            self.require_schema()
        # Imported late: it takes as long as all else that a short command needs.
        from alembic import command
        from alembic.config import Config

        with translate(self.dialect), self.dialect.writing() as connection:
            self.dialect.order_commits(connection)
            config = Config()
            config.set_main_option("script_location", str(migrations_path()))
            config.attributes["connection"] = connection
            command.upgrade(config, "head")
            if version is not None and mend is not None:
                mend(version, Transaction(connection, self.dialect))

    def make_or_require(self) -> None:
        """Create a new store, or check an existing one. Raises StoreError if its schema is not this program's."""
        if self.schema_versions()[0] is None:
            self.migrate()
        else:
            self.require_schema()

    def schema_versions(self) -> tuple[str | None, str | None]:
        """(the store's schema version, this program's)."""
        # A store on a full disk has to be opened before it can be emptied.
        version = self.reserve.spend(self._schema_version, TO_OPEN)
        # Migrations have numbers, and go forward only: the last one is the newest.
        return version, max(
            path.name[:4] for path in (migrations_path() / "versions").glob("[0-9][0-9][0-9][0-9]_*.py")
        )

    def _schema_version(self) -> str | None:
        with translate(self.dialect), self.dialect.reading() as connection:
            known = inspect(connection).has_table("alembic_version")
            return Statements(connection).fetch_value("SELECT version_num FROM alembic_version") if known else None

    def require_schema(self) -> None:
        """StoreError unless the schema is this program's."""
        version, wanted = self.schema_versions()
        if version != wanted:
            refuse_newer(version, wanted)
            raise StoreError(
                f"The store's schema is {version or 'empty'}, this program needs {wanted}.",
                remedy="Run `mcml db upgrade` or `mcml serve`; an SQLite store is backed up beside itself first.",
            )
        self._require_layout()

    def _require_layout(self) -> None:
        with translate(self.dialect), self.dialect.reading() as connection:
            require_layout(Statements(connection))

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
        from mcml_service.storage.upkeep.checks import faults

        with self.read() as tx:
            return faults(tx, past=past)

    def size(self) -> dict[str, int]:
        with translate(self.dialect), self.dialect.reading() as connection:
            return self.dialect.size(connection)

    def has_token(self) -> bool:
        """Tell whether an SQLite file has any token or account, in microseconds: called before every anonymous request.

        For one thread, over a separate connection, so it waits for no other request.
        """
        with translate(self.dialect):
            if self._watch is None:
                self._watch = self.dialect.engine.raw_connection()
                self._watch.detach()
            driver: Any = self._watch.dbapi_connection
            rows = execute_on_driver(driver, "SELECT 1 FROM token UNION SELECT 1 FROM account LIMIT 1").fetchall()
            return bool(rows)

    def close(self) -> None:
        if self._watch is not None:
            self._watch.close()
            self._watch = None
        if self.replica is not None:
            self.replica.close()
        self.dialect.engine.dispose()
