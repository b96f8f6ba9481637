"""What queries keep between them: parts of the store that never change under their keys. Answers are not kept."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Generic, TypeVar

Key = TypeVar("Key", bound=Hashable)
Entry = TypeVar("Entry")


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
