"""Columns on disk beside the store: computed by a process for groups of documents, for the first queries of the next
one. A part is identified by its sources (documents and their revisions) and marked with the newest commit at that time:
in a store with another history no part is used. The file is optional: invalid, lost or unwritable parts are computed
again.
"""

from __future__ import annotations

import sqlite3
import threading
import time
from collections.abc import Callable, Container, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, TypeVar
from weakref import WeakKeyDictionary

from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.library.disk.packing import Packed
from mcml_service.xpath.library.disk.part_file import FAULTS, checksum_of, opened, remove
from mcml_service.xpath.library.disk.writer import ROOM, Waiting, Writer

DAY = 86_400
"""Precision of the time of use: reads should not write."""

_PART = "SELECT mark, used, checksum, data FROM part WHERE held = ? AND name = ?"
_NAMES = "SELECT name FROM part WHERE held = ?"
_USES = "SELECT name, MAX(used) FROM part GROUP BY name"
_TOTAL = "SELECT COALESCE(SUM(size), 0) FROM part"


class _Sized(Protocol):
    @property
    def nbytes(self) -> int: ...


Made = TypeVar("Made", bound=_Sized)


@dataclass
class _View:
    """The view of a transaction.

    mark: of parts that are made in it, "" if none are stored. known: marks, and whether they belong to its history.
    """

    mark: str
    whole_since: int
    known: dict[str, bool] = field(default_factory=dict)


class Sidecar:
    """path: of the file.

    limit: bytes of all parts. Threads and processes may share it. trouble: the reason if nothing can be stored, else
    "". last_use: returns the time when queries last used a part with a name, for parts built in advance; None: all
    parts are for current queries.
    """

    def __init__(self, path: Path, limit: int) -> None:
        self.path = path
        self.limit = limit
        self.last_use: Callable[[str], int] | None = None
        self.trouble = ""
        self._reader: sqlite3.Connection | None = None
        self._lock = threading.Lock()
        self._views: WeakKeyDictionary[Transaction, _View] = WeakKeyDictionary()
        self._whole_since: int | None = None
        self._writer = Writer(lambda: opened(path), limit, self._failed)

    def part(
        self,
        tx: Transaction,
        key: tuple[bytes, str],
        make: Callable[[], Made],
        stored: Callable[[Made], Mapping[str, Any]],
        restored: Callable[[Packed], Made],
    ) -> Made:
        """Return a part; a missing part is computed and stored.

        key: its sources and its name. stored, restored: convert a part to columns and back.
        """
        found = self.read(tx, key)
        if found is not None:
            return restored(found)
        made = make()
        self.keep(tx, key, lambda: stored(made), made.nbytes)
        return made

    def read(self, tx: Transaction, key: tuple[bytes, str]) -> Packed | None:
        """Return the columns of a part, None if it is missing or invalid."""
        view = self._view(tx)
        row = None if view is None else self._row(key)
        if view is None or row is None:
            return None
        mark, used, checksum, data = row
        try:
            sound = checksum == checksum_of(*key, mark, data) and self._is_of_history(tx, view, mark)
        except (TypeError, ValueError, AttributeError):
            # A bit that flipped changed the type of a value.
            sound = False
        if not sound:
            return None
        if self.last_use is None and time.time() - used > DAY:
            self._writer.touch(key)
        return Packed(data)

    def keep(
        self, tx: Transaction, key: tuple[bytes, str], columns: Callable[[], Mapping[str, Any]], size: int
    ) -> None:
        """Have a part written, some time. columns: gives them, in another thread. size: about how many bytes."""
        view = self._view(tx)
        if view is not None and not self.trouble:
            used = int(time.time()) if self.last_use is None else self.last_use(key[1])
            self._writer.add(key, Waiting(view.mark, view.whole_since, columns, size, used))

    def names(self, held: bytes) -> set[str]:
        """The names of the parts of a group."""
        return {name for (name,) in self._rows(_NAMES, (held,))}

    def last_uses(self) -> dict[str, int]:
        """Return the time when queries last used a part with each name, in seconds since 1970; 0: never."""
        return dict(self._rows(_USES, ()))

    def room(self) -> int:
        """Bytes that can be written before parts that were not used for long go."""
        ((total,),) = self._rows(_TOTAL, ()) or [(0,)]
        return int(self.limit * ROOM) - int(total)

    def forget(self, held: Container[bytes]) -> None:
        """Stop writing data of unused keys. held: first parts of keys in use."""
        self._writer.forget(held)

    def flush(self) -> None:
        """Wait until all that waits is written."""
        self._writer.flush()

    def close(self, seconds: float = 0.0) -> None:
        """End the writer thread. seconds: time limit for waiting data."""
        self._writer.close(seconds)
        with self._lock:
            if self._reader is not None:
                self._reader.close()
                self._reader = None

    def _view(self, tx: Transaction) -> _View | None:
        """Return the view of a transaction; None if it reads the past, which is rarely needed again."""
        view = self._views.get(tx)
        if view is None:
            newest, since = tx.newest_commit(), tx.pruning.whole_since()
            mark = f"{newest} {since} {tx.columns.commit_facts(newest)}" if newest and tx.at >= newest else ""
            view = self._views[tx] = _View(mark, since, {mark: True})
            if mark and self._whole_since != since and not self.trouble:
                # Something was purged or pruned meanwhile, or before this process began.
                self._whole_since = since
                self._writer.since(since)
        return view if view.mark else None

    def _is_of_history(self, tx: Transaction, view: _View, mark: str) -> bool:
        if mark not in view.known:
            number, since, said = mark.split(" ", 2)
            view.known[mark] = int(since) == view.whole_since and said == tx.columns.commit_facts(int(number))
        return view.known[mark]

    def _row(self, key: tuple[bytes, str]) -> Any:
        return next(iter(self._rows(_PART, key)), None)

    def _rows(self, statement: str, arguments: tuple[Any, ...]) -> list[Any]:
        """Return no row where the file is missing or broken."""
        with self._lock:
            try:
                if self._reader is None:
                    if self.trouble or not self.path.exists():
                        return []
                    self._reader = opened(self.path)
                return self._reader.execute(statement, arguments).fetchall()
            except FAULTS as error:
                if self._reader is not None:
                    self._reader.close()
                self._reader = None
                self._failed(error)
                return []

    def _failed(self, error: Exception) -> None:
        """A file that is broken goes. Where there can be none, or it cannot be written, memory alone serves."""
        if isinstance(error, sqlite3.OperationalError | OSError):
            if "locked" not in str(error):
                self.trouble = str(error)
        else:
            with suppress(OSError):
                remove(self.path)
