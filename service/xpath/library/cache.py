"""What queries keep between them: parts of the store that never change under their keys. Answers are not kept."""

from __future__ import annotations

import random
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any, Generic, TypeVar

Key = TypeVar("Key", bound=Hashable)
Entry = TypeVar("Entry")

OVERHEAD = 200
"""About how many bytes an entry takes beside its own."""


class Cache(Generic[Key, Entry]):
    """Entries by key, up to a total of sizes; the least recently used go first. Threads may share it."""

    def __init__(self, limit: int, size: Callable[[Entry], int]) -> None:
        self._limit = limit
        self._size = size
        self._total = 0
        self._entries: OrderedDict[Key, Entry] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, keys: Sequence[Key], read: Callable[[list[Key]], Mapping[Key, Entry]]) -> list[Entry]:
        """The entry of each key. read: gives those that are not kept."""
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

    def holds(self, keys: Sequence[Key]) -> bool:
        """Whether the entries of all keys are kept now."""
        with self._lock:
            return all(key in self._entries for key in keys)

    def _keep(self, new: Mapping[Key, Entry]) -> None:
        with self._lock:
            for key, entry in new.items():
                if key not in self._entries:
                    self._entries[key] = entry
                    self._total += self._size(entry)
            while self._total > self._limit:
                self._total -= self._size(self._entries.popitem(last=False)[1])


class ColumnCache:
    """Columns of groups of documents by key, up to a number of bytes. Threads may share it.

    Any of them goes where there is no room: a question goes through all groups in turn, so that of a library that does
    not fit, the one used least recently would always be the next that is asked for.
    """

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._total = 0
        self._entries: dict[Hashable, tuple[int, Any]] = {}
        self._keys: list[Hashable] = []
        self._lock = threading.Lock()
        self._random = random.Random(1)

    def get(self, key: Hashable, make: Callable[[], Entry], size: Callable[[Entry], int]) -> Entry:
        """The entry of a key. make: makes it where it is not kept. size: about how many bytes it takes."""
        held = self._entries.get(key)
        if held is not None:
            entry: Entry = held[1]
            return entry
        entry = make()
        self._keep(key, entry, size(entry) + OVERHEAD)
        return entry

    def find(self, key: Hashable) -> Any | None:
        """The entry, None where there is none now."""
        held = self._entries.get(key)
        return None if held is None else held[1]

    def holds(self, key: Hashable) -> bool:
        """Whether there is an entry now."""
        return key in self._entries

    def takes(self, size: int) -> bool:
        """Whether an entry of so many bytes is kept."""
        return size <= self._limit // 4

    def _keep(self, key: Hashable, entry: object, size: int) -> None:
        with self._lock:
            if key in self._entries or not self.takes(size):
                return
            self._entries[key] = size, entry
            self._keys.append(key)
            self._total += size
            while self._total > self._limit:
                place = self._random.randrange(len(self._keys))
                self._keys[place], self._keys[-1] = self._keys[-1], self._keys[place]
                self._total -= self._entries.pop(self._keys.pop())[0]
