"""PostgreSQL: for teams."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import cache, partial
from typing import Any

import psycopg
from sqlalchemy import Column, Connection, Engine, Table, create_engine, event, func, insert, select, text
from sqlalchemy.exc import DBAPIError, InvalidatePoolError
from sqlalchemy.sql.dml import ReturningInsert

from mcml_service.storage.core.dialects.base import Compaction, Dialect
from mcml_service.storage.core.schema import metadata
from mcml_service.storage.core.statements import Prepared, Statements

COMMIT_LOCK = 0x4D434D4C
"""Key of the advisory lock that orders commits: "MCML" in ASCII."""

DISK_FULL = "53100"
CONNECTION = "08"
AWAY = ("53300", "57P01", "57P02", "57P03", "57P05")
"""Too many connections; shut down by an administrator, after a crash, not ready yet; idle for too long."""
CLASHES = ("40001", "40P01")
"""Transactions that cannot be put in an order, or wait for each other; of a replica, replaying that cannot wait for a
read."""
CORRUPTED = ("XX001", "XX002")
"""A page, or an index."""

REST_SECONDS = 1.0
"""Idle time after which a connection is tested before use."""

_ORDER = text("SELECT pg_advisory_xact_lock(:key)")


class PostgreSQL(Dialect):
    """A server, through psycopg 3. Reads are repeatable, writes read committed rows and lock what they change."""

    personal = False

    tracks_by_key = Prepared(
        text(
            "SELECT t.document, t.chunk, t.bone, t.from_commit, t.codec, t.data, t.data_checksum "
            "FROM jsonb_array_elements(CAST(:keys AS jsonb)) AS k JOIN track AS t "
            "ON t.document = CAST(k ->> 0 AS bigint) AND t.chunk = CAST(k ->> 1 AS bigint) "
            "AND t.bone = CAST(k ->> 2 AS bigint) AND t.from_commit = CAST(k ->> 3 AS bigint)"
        )
    )

    tracks_over_chunks = Prepared(
        text(
            "SELECT t.document, t.chunk, t.bone, t.channels, t.count, t.codec, t.data, t.data_checksum "
            "FROM jsonb_array_elements(CAST(:keys AS jsonb)) AS k JOIN track AS t "
            "ON t.document = CAST(k ->> 0 AS bigint) AND t.chunk = CAST(k ->> 1 AS bigint) "
            "WHERE t.from_commit <= :at AND t.to_commit > :at"
        )
    )

    @classmethod
    def create_engine(cls, url: str) -> Engine:
        # Connections used last are used first; the others stay idle, and are tested before they are used again.
        engine = create_engine(url, pool_size=16, max_overflow=32, pool_use_lifo=True)
        event.listen(engine, "checkin", _note_rest)
        event.listen(engine, "checkout", partial(_look_after_rest, engine))
        return engine

    def writing(self) -> AbstractContextManager[Connection]:
        return self._connect()

    def reading(self) -> AbstractContextManager[Connection]:
        return self._connect(isolation_level="REPEATABLE READ", postgresql_readonly=True)

    def looking(self) -> AbstractContextManager[Connection]:
        # Begin and commit would be two more round trips to the server.
        return self._connect(isolation_level="AUTOCOMMIT")

    @contextmanager
    def _connect(self, **options: Any) -> Iterator[Connection]:
        with self.engine.connect().execution_options(**options) as connection:
            try:
                with connection.begin():
                    yield connection
            except (DBAPIError, psycopg.Error) as error:
                if self.is_away(error.orig if isinstance(error, DBAPIError) else error):
                    # The other connections of the pool are lost as well.
                    self.engine.dispose()
                raise

    def order_commits(self, connection: Connection) -> None:
        Statements(connection).fetch_value(_ORDER, {"key": COMMIT_LOCK})

    def insert(
        self, connection: Connection, table: Table, names: tuple[str, ...], rows: Sequence[tuple[Any, ...]]
    ) -> None:
        columns = ", ".join(f'"{name}"' for name in names)
        driver: Any = connection.connection.driver_connection
        with driver.cursor() as cursor, cursor.copy(f'COPY "{table.name}" ({columns}) FROM STDIN') as copy:
            for row in rows:
                copy.write_row(row)

    def insert_one(self, connection: Connection, table: Table, row: dict[str, Any]) -> int:
        return int(Statements(connection).fetch_value(_insertion(table), row))

    def size(self, connection: Connection) -> dict[str, int]:
        store = Statements(connection)
        total = store.fetch_value("SELECT pg_database_size(current_database())")
        uploads = store.fetch_value("SELECT pg_total_relation_size('upload_block')")
        return {"total": int(total), "uploads": int(uploads)}

    def retire_keys(self, connection: Connection) -> None:
        """Nothing to do: sequences do not go back."""

    def erase_what_goes(self, connection: Connection) -> None:
        """Nothing to do: rows that no transaction sees any more go with the next vacuum (`settle`)."""

    def settle(self) -> None:
        with self.engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
            Statements(connection).run("VACUUM")

    def compaction(self) -> Compaction:
        query = "SELECT COALESCE(SUM(n_dead_tup * pg_relation_size(relid) / GREATEST(n_live_tup + n_dead_tup, 1)), 0) "
        with self.engine.connect() as connection:
            dead = Statements(connection).fetch_value(query + "FROM pg_stat_user_tables")
        return Compaction(int(dead))

    def compact(self, progress: Callable[[int], None]) -> None:
        with self.engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
            for table in metadata.sorted_tables:
                progress(self.compaction().bytes)
                Statements(connection).run(f'VACUUM (ANALYZE) "{table.name}"')

    def is_full(self, error: BaseException | None) -> bool:
        return getattr(error, "sqlstate", None) == DISK_FULL

    def is_clash(self, error: BaseException | None) -> bool:
        return getattr(error, "sqlstate", None) in CLASHES

    def is_away(self, error: BaseException | None) -> bool:
        state = getattr(error, "sqlstate", None)
        if state is None:
            # No server answered, or the connection broke.
            return isinstance(error, psycopg.OperationalError | psycopg.InterfaceError)
        return state[:2] == CONNECTION or state in AWAY

    def is_damaged(self, error: BaseException | None) -> bool:
        return getattr(error, "sqlstate", None) in CORRUPTED

    def faults(self, connection: Connection) -> Iterator[str]:
        # The server checks its pages by their checksums, if these were enabled when it was set up.
        store = Statements(connection)
        if store.fetch_value("SHOW data_checksums") == "on":
            query = "SELECT checksum_failures FROM pg_stat_database WHERE datname = current_database()"
            failures = store.fetch_value(query)
            if failures:
                yield f"PostgreSQL: {failures} pages had another checksum"

    def last_keys(self, connection: Connection) -> dict[str, int]:
        store = Statements(connection)
        query = "SELECT COALESCE(pg_sequence_last_value(CAST(CAST(:sequence AS text) AS regclass)), 0)"
        return {
            table.name: int(store.fetch_value(text(query), {"sequence": sequence}))
            for table, _, sequence in _find_sequences(store)
        }

    def after_copy(self, connection: Connection, last: dict[str, int]) -> None:
        store = Statements(connection)
        for table, key, sequence in _find_sequences(store):
            greatest = store.fetch_value(select(func.max(key))) or 0
            newest = max(greatest, last.get(table.name, 0))
            # The third value tells whether the number was used: the first key is 1.
            store.fetch_value(
                text("SELECT setval(CAST(CAST(:sequence AS text) AS regclass), :value, :given)"),
                {"sequence": sequence, "value": max(newest, 1), "given": newest > 0},
            )


def _note_rest(_: Any, record: Any) -> None:
    record.info["rests since"] = time.monotonic()


def _look_after_rest(engine: Engine, connection: Any, record: Any, _: Any) -> None:
    """Test a connection only after an idle time, because each test costs a round trip."""
    since = record.info.get("rests since")
    if since is None or time.monotonic() - since < REST_SECONDS:
        return
    try:
        engine.dialect.do_ping(connection)
    except psycopg.Error as error:
        raise InvalidatePoolError from error


def _find_sequences(store: Statements) -> Iterator[tuple[Table, Column[Any], str]]:
    """Tables whose rows get their keys from a sequence: the table, its key, and the sequence's name."""
    asked = text("SELECT pg_get_serial_sequence(:table, :key)")
    for table in metadata.sorted_tables:
        key = table.autoincrement_column
        if key is not None:
            named = {"table": f'"{table.name}"', "key": key.name}
            sequence = store.fetch_value(asked, named)
            if sequence is not None:
                yield table, key, sequence


@cache
def _insertion(table: Table) -> ReturningInsert[Any]:
    (key,) = table.primary_key.columns
    return insert(table).returning(key)
