"""The thread that writes parts beside the store: some time after queries, a few at a time, without delaying queries."""

from __future__ import annotations

import os
import sqlite3
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Container, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeAlias

from mcml_service.xpath.library.disk.packing import pack
from mcml_service.xpath.library.disk.part_file import FAULTS, checksum_of, cleared, emptied

AT_ONCE = 16 << 20
"""Bytes that are written in one transaction."""
MOST_WAITING = 512 << 20
"""Limit of waiting columns in bytes; further columns are dropped."""
NICE = 10
REST = 2.0
"""Least waiting time of parts in seconds: while others write to the store, parts become useless soon."""
ROOM = 0.9
"""Share of the limit that parts use after some were removed; SQLite needs a little more."""

Key: TypeAlias = tuple[bytes, str]


@dataclass(frozen=True)
class Waiting:
    """A part to be written.

    mark, whole_since: of the transaction that it was read in. columns: returns them. used: time of the last use by a
    query, in seconds since 1970.
    """

    mark: str
    whole_since: int
    columns: Callable[[], Mapping[str, Any]]
    size: int
    used: int


class Writer:
    """open_: returns a connection.

    limit: bytes of all parts. failed: called with the reason if nothing can be written.
    """

    def __init__(
        self, open_: Callable[[], sqlite3.Connection], limit: int, failed: Callable[[Exception], None]
    ) -> None:
        self._open = open_
        self._limit = limit
        self._failed = failed
        self._waiting: OrderedDict[Key, Waiting] = OrderedDict()
        self._bytes = 0
        self._used: set[Key] = set()
        self._since: int | None = None
        self._changed = threading.Condition()
        self._busy = self._closed = False
        self._flushing = 0
        self._thread: threading.Thread | None = None

    def add(self, key: Key, part: Waiting) -> None:
        """Have a part written."""
        with self._changed:
            if self._bytes + part.size <= MOST_WAITING:
                old = self._waiting.pop(key, None)
                self._waiting[key] = part
                self._bytes += part.size - (old.size if old else 0)
                self._wake()

    def forget(self, held: Container[bytes]) -> None:
        """Write no part any more that is made of something else."""
        with self._changed:
            for key in [key for key in self._waiting if key[0] not in held]:
                self._bytes -= self._waiting.pop(key).size

    def touch(self, key: Key) -> None:
        """Note that a part was used."""
        with self._changed:
            self._used.add(key)
            self._wake()

    def since(self, commit: int) -> None:
        """Set the commit since which the history of the store is complete; parts made with another such commit are
        deleted.
        """
        with self._changed:
            self._since = commit
            self._wake()

    def flush(self, seconds: float | None = None) -> None:
        """Wait until nothing waits."""
        with self._changed:
            self._flushing += 1
            self._changed.notify_all()
            self._changed.wait_for(lambda: not (self._some or self._busy) or self._closed, seconds)
            self._flushing -= 1

    def close(self, seconds: float) -> None:
        """End the writer; unwritten data is dropped after this time."""
        self.flush(seconds)
        with self._changed:
            self._closed = True
            self._changed.notify_all()
            thread = self._thread
        if thread is not None:
            thread.join()

    @property
    def _some(self) -> bool:
        return bool(self._waiting or self._used or self._since is not None)

    def _wake(self) -> None:
        if self._thread is None and not self._closed:
            self._thread = threading.Thread(target=self._run, name="parts", daemon=True)
            self._thread.start()
        self._changed.notify_all()

    def _run(self) -> None:
        with suppress(OSError, AttributeError):
            # Of this thread alone, on Linux; elsewhere it has its turn as others do.
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICE)
        connection: sqlite3.Connection | None = None
        while self._next():
            try:
                if connection is None:
                    connection = self._open()
                self._write(connection)
            except FAULTS as error:
                if connection is not None:
                    connection.close()
                connection = None
                self._failed(error)
                with self._changed:
                    self._waiting.clear()
                    self._used.clear()
                    self._since, self._bytes = None, 0
        if connection is not None:
            connection.close()

    def _next(self) -> bool:
        """Wait for something to do; False at the end."""
        with self._changed:
            self._busy = False
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._some or self._closed)
            self._changed.wait_for(lambda: self._flushing or self._closed, REST)
            self._busy = not self._closed
            return self._busy

    def _write(self, connection: sqlite3.Connection) -> None:
        with self._changed:
            since, self._since = self._since, None
            used, self._used = self._used, set()
        rows = self._packed()
        connection.execute("BEGIN IMMEDIATE")
        try:
            went = since is not None and cleared(connection, since)
            known = connection.execute("SELECT whole_since FROM history").fetchone()
            now = int(time.time())
            update = "UPDATE part SET used = ? WHERE held = ? AND name = ?"
            connection.executemany(update, [(now, *key) for key in used])
            # Data that was read before a purge must not be written after it.
            good = [row for whole_since, row in rows if known == (whole_since,)]
            connection.executemany("INSERT OR REPLACE INTO part VALUES (?, ?, ?, ?, ?, ?, ?)", good)
            self._make_room(connection)
            connection.execute("COMMIT")
            connection.execute("PRAGMA incremental_vacuum").fetchall()
        except BaseException:
            with suppress(sqlite3.Error):
                connection.execute("ROLLBACK")
            raise
        if went:
            emptied(connection)

    def _packed(self) -> list[tuple[int, tuple[bytes, str, str, int, int, bytes, bytes]]]:
        """Return (whole since, row) of some of the waiting data."""
        rows = []
        size = 0
        while size < AT_ONCE:
            with self._changed:
                if not self._waiting or self._closed:
                    break
                (held, name), part = self._waiting.popitem(last=False)
                self._bytes -= part.size
            try:
                data = pack(part.columns())
            except (TypeError, ValueError):
                # Texts that JSON cannot represent.
                continue
            if len(data) <= self._limit // 4:
                checksum = checksum_of(held, name, part.mark, data)
                rows.append((part.whole_since, (held, name, part.mark, part.used, len(data), checksum, data)))
                size += len(data)
        return rows

    def _make_room(self, connection: sqlite3.Connection) -> None:
        """Remove what was not used for longest."""
        (total,) = connection.execute("SELECT COALESCE(SUM(size), 0) FROM part").fetchone()
        if total <= self._limit * ROOM:
            return
        gone = []
        for row, size in connection.execute("SELECT rowid, size FROM part ORDER BY used, rowid"):
            gone.append((row,))
            total -= size
            if total <= self._limit * ROOM * ROOM:
                break
        connection.executemany("DELETE FROM part WHERE rowid = ?", gone)
