"""A cache for queries: parts of the store that never change under their keys. Answers are not cached."""

from __future__ import annotations

import random
import threading
from collections import OrderedDict
from collections.abc import Callable, Container, Hashable, Iterator, Mapping, Sequence
from typing import Any, Generic, TypeVar

Key = TypeVar("Key", bound=Hashable)
Entry = TypeVar("Entry")

OVERHEAD = 200
"""Approximate overhead of an entry in bytes."""


ROOM = 15 / 16
"""Share of a full cache of columns that is kept."""


class Cache(Generic[Key, Entry]):
    """Entries by key, up to a total of sizes; the least recently used go first. Threads may share it."""

    def __init__(self, limit: int, size: Callable[[Entry], int]) -> None:
        self._limit = limit
        self._size = size
        self._total = 0
        self._entries: OrderedDict[Key, Entry] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, keys: Sequence[Key], read: Callable[[list[Key]], Mapping[Key, Entry]]) -> list[Entry]:
        """Return the entry of each key. read: reads missing entries."""
        found: dict[Key, Entry] = {}
        with self._lock:
            for key in keys:
                entry = self._entries.get(key)
                if entry is not None:
                    found[key] = entry
                    self._entries.move_to_end(key)
        missing = [key for key in dict.fromkeys(keys) if key not in found]
        if missing:
            new = read(missing)
            found.update(new)
            self._keep(new)
        return [found[key] for key in keys]

    def find(self, key: Key) -> Entry | None:
        """Return the entry of a key, None if it is not kept."""
        with self._lock:
            return self._entries.get(key)

    def holds(self, keys: Sequence[Key]) -> bool:
        """Whether the entries of all keys are kept now."""
        with self._lock:
            return all(key in self._entries for key in keys)

    def values(self) -> list[Entry]:
        """All that is kept now."""
        with self._lock:
            return list(self._entries.values())

    def __iter__(self) -> Iterator[Key]:
        """The keys of all that is kept now."""
        with self._lock:
            return iter(list(self._entries))

    def forget(self, is_held: Callable[[Key], bool]) -> None:
        """Let all other entries go."""
        with self._lock:
            for key in [key for key in self._entries if not is_held(key)]:
                self._total -= self._size(self._entries.pop(key))

    def put(self, key: Key, entry: Entry) -> None:
        """Store an entry, replacing the one under its key."""
        with self._lock:
            old = self._entries.pop(key, None)
            if old is not None:
                self._total -= self._size(old)
        self._keep({key: entry})

    def _keep(self, new: Mapping[Key, Entry]) -> None:
        with self._lock:
            for key, entry in new.items():
                if key not in self._entries:
                    self._entries[key] = entry
                    self._total += self._size(entry)
            while self._total > self._limit:
                self._total -= self._size(self._entries.popitem(last=False)[1])


class ColumnCache:
    """Columns of groups of documents, each under a key, up to a number of bytes. Threads may share it.

    If the cache is full, a random entry is removed: a query reads all groups in turn, so for a library larger than the
    cache the least recently used entry would always be the next one needed.
    """

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self.total = 0
        """The approximate number of bytes."""

        self._groups: dict[Hashable, dict[Hashable, tuple[int, Any]]] = {}
        self._lock = threading.Lock()
        self._random = random.Random(1)

    def get(self, group: Hashable, key: Hashable, make: Callable[[], Entry], size: Callable[[Entry], int]) -> Entry:
        """A column of a group. make: makes it where it is not kept. size: about how many bytes it takes."""
        held = self._groups.get(group, _NONE).get(key)
        if held is not None:
            entry: Entry = held[1]
            return entry
        entry = make()
        self._keep(group, key, entry, size(entry) + OVERHEAD)
        return entry

    def find(self, group: Hashable, key: Hashable) -> Any | None:
        """Return the column, None if it is not cached."""
        held = self._groups.get(group, _NONE).get(key)
        return None if held is None else held[1]

    def holds(self, group: Hashable, key: Hashable) -> bool:
        """Tell whether a column is cached."""
        return key in self._groups.get(group, _NONE)

    def takes(self, size: int) -> bool:
        """Tell whether a column of this size would be cached."""
        return size <= self._limit // 4

    def forget(self, held: Container[Hashable]) -> None:
        """Let the columns of all other groups go."""
        with self._lock:
            for group in [group for group in self._groups if group not in held]:
                self.total -= sum(size for size, _ in self._groups.pop(group).values())

    def _keep(self, group: Hashable, key: Hashable, entry: object, size: int) -> None:
        with self._lock:
            columns = self._groups.setdefault(group, {})
            if key in columns or not self.takes(size):
                return
            columns[key] = size, entry
            self.total += size
            if self.total > self._limit:
                self._make_room()

    def _make_room(self) -> None:
        """Somewhat more than is needed now: to look for it takes longer than to keep a column."""
        kept = [(columns, key) for columns in self._groups.values() for key in columns]
        self._random.shuffle(kept)
        while self.total > self._limit * ROOM:
            columns, key = kept.pop()
            self.total -= columns.pop(key)[0]


_NONE: dict[Hashable, tuple[int, Any]] = {}
