"""A streaming replica of a PostgreSQL store: reads use it if it has everything that the primary had when they began.

A transaction of PostgreSQL sees a snapshot, `xmin:xmax:in progress`: numbers of transactions. A replica that has
replayed every transaction in the primary's snapshot is as good as the primary, for writes by any user through any
server. So each read asks both for their snapshots; if the replica lacks a transaction, the primary is read.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from sqlalchemy import Connection, make_url, text
from sqlalchemy.exc import ArgumentError, DBAPIError
from sqlalchemy.exc import TimeoutError as PoolTimeout

from mcml.errors import ReplicaError, StoreError
from mcml_service.storage.core.database_errors import translate
from mcml_service.storage.core.dialects import Dialect
from mcml_service.storage.core.statements import Statements

log = logging.getLogger("mcml.replica")

AWAY_SECONDS = 10.0
"""Seconds after which an unreachable replica is tried again."""

PATIENCE = {"connect_timeout": "2", "tcp_user_timeout": "5000"}
"""Timeouts for a machine that does not answer at all: seconds for the connection, milliseconds for the rest."""

_SNAPSHOT = text("SELECT CAST(pg_current_snapshot() AS text)")
_REPLAYED = text("SELECT pg_is_in_recovery(), CAST(pg_current_snapshot() AS text)")
_WRITTEN = text("SELECT CAST(pg_current_wal_insert_lsn() AS text)")
_BEHIND = text("SELECT pg_wal_lsn_diff(CAST(:written AS pg_lsn), pg_last_wal_replay_lsn())")


@dataclass(frozen=True)
class Snapshot:
    """Transactions below `first`, and those below `end` that are not in `open`, have ended."""

    first: int
    end: int
    open: frozenset[int]

    @classmethod
    def of(cls, said: str) -> Snapshot:
        """As PostgreSQL writes it: "725:728:725,727"."""
        first, end, going = said.split(":")
        return cls(int(first), int(end), frozenset(map(int, going.split(",") if going else ())))

    def is_in(self, replayed: Snapshot) -> bool:
        """Whether a replica's snapshot has all that this one has.

        A replica does not say which transactions between its first and its end it has replayed, so each of them counts
        as missing.
        """
        return replayed.end >= self.end and all(number in self.open for number in range(replayed.first, self.end))


class Replica:
    """Of one process. reads: how many were answered by the "replica", and by the "primary" in its place."""

    def __init__(self, url: str, primary: Dialect) -> None:
        if primary.engine.dialect.name != "postgresql":
            raise StoreError(
                "Only a store in PostgreSQL has a replica.",
                remedy="Unset MCML_DATABASE_READ_URL, or set MCML_DATABASE.",
            )
        try:
            address = make_url(url)
        except ArgumentError as error:
            raise StoreError("MCML_DATABASE_READ_URL is no database address.") from error
        self.url = url
        self.reads: Counter[str] = Counter(replica=0, primary=0)
        self._primary = primary
        patient = address.update_query_dict({**PATIENCE, **address.query})
        kind = type(primary)
        self._dialect = kind(kind.create_engine(patient.render_as_string(hide_password=False)))
        self._lock = threading.Lock()
        self._away_until = 0.0

    @contextmanager
    def reading(self) -> Iterator[Connection | None]:
        """A connection to the replica in a read transaction; None where it is behind, or away.

        ReplicaError where it goes away while it is read.
        """
        connection = None
        try:
            with ExitStack() as stack:
                connection = self._connect(stack)
                self.reads["primary" if connection is None else "replica"] += 1
                yield connection
        except self._refusals as error:
            cause = _cause(error)
            if connection is not None and self._dialect.is_away(cause):
                self._leave(cause)
            elif connection is None or not self._dialect.is_clash(cause):
                raise
            raise ReplicaError from error

    def behind(self) -> int | None:
        """Bytes of the log that the replica has not replayed yet, None if it is unreachable."""
        try:
            with translate(self._primary), self._primary.engine.connect() as primary:
                written = Statements(primary).fetch_value(_WRITTEN)
            with translate(self._dialect), self._dialect.reading() as replica:
                lag = Statements(replica).fetch_value(_BEHIND, {"written": written})
        except StoreError:
            return None
        return None if lag is None else max(0, int(lag))

    def close(self) -> None:
        self._dialect.engine.dispose()

    def _connect(self, stack: ExitStack) -> Connection | None:
        """The connection, kept by the stack."""
        if not self._may_try():
            return None
        wanted = self._newest()
        with ExitStack() as trying:
            try:
                connection = trying.enter_context(self._dialect.reading())
                ((is_replica, replayed),) = Statements(connection).fetch_all(_REPLAYED)
            except self._refusals as error:
                self._leave(_cause(error))
                return None
            if not is_replica:
                self._leave("it is no longer a replica")
                return None
            self._come()
            if not wanted.is_in(Snapshot.of(replayed)):
                return None
            stack.push(trying.pop_all())
        return connection

    def _may_try(self) -> bool:
        """Tell whether the replica is reachable, or this read should test it again."""
        if not self._away_until:
            return True
        with self._lock:
            if time.monotonic() < self._away_until:
                return False
            self._away_until = time.monotonic() + AWAY_SECONDS
            return True

    def _newest(self) -> Snapshot:
        with self._primary.engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
            return Snapshot.of(Statements(connection).fetch_value(_SNAPSHOT))

    def _leave(self, why: object) -> None:
        with self._lock:
            first, self._away_until = not self._away_until, time.monotonic() + AWAY_SECONDS
        if first:
            reason = str(why).strip().split("\n")[0]
            log.warning("the replica cannot be read, so the primary is: %s", reason)

    def _come(self) -> None:
        with self._lock:
            was_away, self._away_until = self._away_until, 0.0
        if was_away:
            log.warning("the replica is read again")

    @property
    def _refusals(self) -> tuple[type[Exception], ...]:
        # Some reads use the driver directly, so its errors are not wrapped.
        return DBAPIError, PoolTimeout, self._dialect.engine.dialect.loaded_dbapi.Error


def _cause(error: BaseException) -> BaseException | None:
    return error.orig if isinstance(error, DBAPIError) else error
