"""SQLite: the embedded default. Write-ahead log, full synchronisation, one writer at a time."""

from __future__ import annotations

import os
import sqlite3
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Engine, Table, create_engine, event, text
from sqlalchemy.pool import QueuePool

from mcml_service.storage.core.dialects.base import Compaction, Dialect
from mcml_service.storage.core.statements import Prepared, Statements, execute_on_driver

BUSY_SECONDS = 60
INCREMENTAL = 2
"""The value of `auto_vacuum` under which pages can be given back some at a time."""
PAGE_BYTES = 8192
PAGES_AT_A_TIME = 1000
RETIRING = ("document", "skeleton")
"""Tables whose keys are never given again."""
LAST = "last key of "
PRIVATE = 0o600
"""The mode of a store's files: captures are of people."""


class SQLite(Dialect):
    """One file. Writers of one process queue on a lock, writers of several on SQLite's own."""

    personal = True

    # Of a cross join SQLite keeps the order: for each key, look for its track.
    tracks_by_key = Prepared(
        text(
            "SELECT t.document, t.chunk, t.bone, t.from_commit, t.codec, t.data, t.data_checksum "
            "FROM json_each(:keys) AS k CROSS JOIN track AS t "
            "WHERE t.document = json_extract(k.value, '$[0]') AND t.chunk = json_extract(k.value, '$[1]') "
            "AND t.bone = json_extract(k.value, '$[2]') AND t.from_commit = json_extract(k.value, '$[3]')"
        )
    )

    tracks_over_chunks = Prepared(
        text(
            "SELECT t.document, t.chunk, t.bone, t.channels, t.count, t.codec, t.data, t.data_checksum "
            "FROM json_each(:keys) AS k CROSS JOIN track AS t "
            "WHERE t.document = json_extract(k.value, '$[0]') AND t.chunk = json_extract(k.value, '$[1]') "
            "AND t.from_commit <= :at AND t.to_commit > :at"
        )
    )

    def __init__(self, engine: Engine) -> None:
        super().__init__(engine)
        self._writer = threading.Lock()

    @classmethod
    def create_engine(cls, url: str) -> Engine:
        engine = create_engine(
            url,
            poolclass=QueuePool,
            pool_size=16,
            max_overflow=48,
            # The connection used last has its pages and statements cached.
            pool_use_lifo=True,
            connect_args={"timeout": BUSY_SECONDS, "check_same_thread": False},
        )

        @event.listens_for(engine, "do_connect")
        def _keep_private(_dialect: Any, _record: Any, given: list[Any], _named: Any) -> None:
            _make_private(given[0])

        @event.listens_for(engine, "connect")
        def _configure(connection: sqlite3.Connection, _record: Any) -> None:
            # The driver's own transaction handling would begin deferred transactions, which cannot be upgraded safely.
            connection.isolation_level = None
            if execute_on_driver(connection, "PRAGMA page_count").fetchone() == (0,):
                # Freed pages can be returned to the disk. This must be set before anything is written; later it is a
                # write.
                execute_on_driver(connection, f"PRAGMA page_size={PAGE_BYTES}")
                execute_on_driver(connection, "PRAGMA auto_vacuum=INCREMENTAL")
            for pragma in (
                "journal_mode=WAL",
                "synchronous=FULL",
                "foreign_keys=ON",
                "cache_size=-16384",
                "temp_store=MEMORY",
                "journal_size_limit=67108864",
            ):
                execute_on_driver(connection, f"PRAGMA {pragma}")

        @event.listens_for(engine, "begin")
        def _begin(connection: Connection) -> None:
            writes = connection.get_execution_options().get("writes", False)
            Statements(connection).run("BEGIN IMMEDIATE" if writes else "BEGIN")

        return engine

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        with self._writer, self.engine.connect().execution_options(writes=True) as connection, connection.begin():
            yield connection

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        with self.engine.connect() as connection, connection.begin():
            yield connection

    def order_commits(self, connection: Connection) -> None:
        """Nothing to do: BEGIN IMMEDIATE already holds the one write lock."""

    def insert(
        self, connection: Connection, table: Table, names: tuple[str, ...], rows: Sequence[tuple[Any, ...]]
    ) -> None:
        # The driver's own executemany: SQLAlchemy's handling of parameters takes three times as long as SQLite.
        Statements(connection).run(_insertion(table.name, names), rows)

    def insert_one(self, connection: Connection, table: Table, row: dict[str, Any]) -> int:
        # The driver itself, as above.
        driver: Any = connection.connection.driver_connection
        if table.name in RETIRING:
            row = {"id": execute_on_driver(driver, _next_key(table.name)).fetchone()[0], **row}
        cursor = execute_on_driver(driver, _insertion(table.name, tuple(row)), tuple(row.values()))
        return int(cursor.lastrowid)

    def retire_keys(self, connection: Connection) -> None:
        for table in RETIRING:
            # SQLite uses the number after the highest existing one.
            last = f"SELECT '{LAST}{table}', ({_next_key(table)}) - 1"
            Statements(connection).run(f"INSERT OR REPLACE INTO store (name, value) {last}")

    def size(self, connection: Connection) -> dict[str, int]:
        store = Statements(connection)
        total = store.fetch_value("SELECT page_count * page_size FROM pragma_page_count, pragma_page_size")
        uploads = store.fetch_value(
            "SELECT COALESCE(SUM(pgsize), 0) FROM dbstat WHERE name = 'upload_block'"
            if "ENABLE_DBSTAT_VTAB" in store.fetch_column("PRAGMA compile_options")
            else "SELECT COALESCE(SUM(LENGTH(data)), 0) FROM upload_block"
        )
        return {"total": int(total), "uploads": int(uploads)}

    def erase_what_goes(self, connection: Connection) -> None:
        # It holds for the connection, whose next user loses nothing by it but a little time.
        Statements(connection).run("PRAGMA secure_delete=ON")

    def settle(self) -> None:
        # The log holds pages as they were: it is emptied, unless a reader uses an old state.
        with self.engine.connect() as connection:
            driver: Any = connection.connection.driver_connection
            execute_on_driver(driver, "PRAGMA wal_checkpoint(TRUNCATE)").fetchall()

    @property
    def file(self) -> Path | None:
        name = self.engine.url.database
        return Path(name) if name and name != ":memory:" else None

    def compaction(self) -> Compaction:
        with self.engine.connect() as connection:
            size, free, pages, kind = (
                int(Statements(connection).fetch_value(f"PRAGMA {name}"))
                for name in ("page_size", "freelist_count", "page_count", "auto_vacuum")
            )
        whole = kind != INCREMENTAL
        return Compaction(size * free, size * (pages - free) * 2 if whole else 0, whole)

    def compact(self, progress: Callable[[int], None]) -> None:
        if self.compaction().stops_writers:
            with self._writer, self.engine.connect() as connection:
                driver: Any = connection.connection.driver_connection
                # From then on, pages can be given back some at a time.
                execute_on_driver(driver, "PRAGMA auto_vacuum=INCREMENTAL")
                execute_on_driver(driver, "VACUUM")
        else:
            while free := self.compaction().bytes:
                progress(free)
                with self.writing() as connection:
                    driver = connection.connection.driver_connection
                    # Of several pages the driver would free the first one alone.
                    for _ in range(min(PAGES_AT_A_TIME, free // PAGE_BYTES + 1)):
                        execute_on_driver(driver, "PRAGMA incremental_vacuum(1)")
        self.settle()

    def is_full(self, error: BaseException | None) -> bool:
        # The second occurs when a store is opened: the file that connections share cannot grow.
        code = getattr(error, "sqlite_errorcode", None)
        return isinstance(error, sqlite3.Error) and code in (sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR_SHMSIZE)

    def is_clash(self, error: BaseException | None) -> bool:
        # SQLite allows one writer at a time.
        return False

    def is_away(self, error: BaseException | None) -> bool:
        # Another process writes for longer than anybody waits. The low byte is the kind.
        code = getattr(error, "sqlite_errorcode", None) or 0
        return isinstance(error, sqlite3.Error) and code & 0xFF in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED)

    def is_damaged(self, error: BaseException | None) -> bool:
        code = getattr(error, "sqlite_errorcode", None)
        return isinstance(error, sqlite3.Error) and code in (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)

    def faults(self, connection: Connection) -> Iterator[str]:
        store = Statements(connection)
        for message in store.fetch_column("PRAGMA integrity_check"):
            if message != "ok":
                yield f"SQLite: {message}"
        for table in store.fetch_column("PRAGMA foreign_key_check"):
            yield f"SQLite: a row of {table} refers to one that is not there"

    def last_keys(self, connection: Connection) -> dict[str, int]:
        return {table: Statements(connection).fetch_value(f"{_next_key(table)} - 1") for table in RETIRING}

    def after_copy(self, connection: Connection, last: dict[str, int]) -> None:
        # SQLite continues from the greatest key automatically.
        for table in RETIRING:
            key = (f"{LAST}{table}", str(last.get(table, 0)))
            Statements(connection).run("INSERT OR REPLACE INTO store (name, value) VALUES (?, ?)", key)


def copy_file(source: Path, target: Path) -> None:
    """Copy a store into an empty file while others use it. Raises sqlite3.Error."""
    with closing(sqlite3.connect(source)) as old, closing(sqlite3.connect(target)) as new:
        old.backup(new)
    fold_log(target)


def fold_log(path: Path) -> None:
    """Merge the log into the file of an unused store, so that the single file can be moved."""
    with closing(sqlite3.connect(path)) as connection:
        execute_on_driver(connection, "PRAGMA journal_mode=DELETE")


def _make_private(path: str) -> None:
    """Let only their owner read the files of a store. The log and its index get the mode of the store."""
    if not path or path == ":memory:" or path.startswith("file:"):
        return
    # Before SQLite opens it: there is no moment at which others can. A file that is there must not be opened here: to
    # close it again would let go of the locks that SQLite holds on it in this process.
    with suppress(OSError):
        os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_RDWR, PRIVATE))
    with suppress(OSError):
        for name in (path, f"{path}-wal", f"{path}-shm"):
            if os.path.exists(name) and os.stat(name).st_mode & 0o077:
                os.chmod(name, PRIVATE)


@cache
def _next_key(table: str) -> str:
    retired = f"SELECT CAST(value AS INTEGER) FROM store WHERE name = '{LAST}{table}'"
    return f"SELECT MAX(COALESCE((SELECT MAX(id) FROM {table}), 0), COALESCE(({retired}), 0)) + 1"


@cache
def _insertion(table: str, names: tuple[str, ...]) -> str:
    places = ", ".join("?" * len(names))
    quoted = ", ".join(f'"{name}"' for name in names)
    return f'INSERT INTO "{table}" ({quoted}) VALUES ({places})'
