"""What queries keep between them: parts of the store that never change under their keys. Answers are not kept."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Generic, TypeVar

Key = TypeVar("Key", bound=Hashable)
Part = TypeVar("Part")


class Kept(Generic[Key, Part]):
    """Parts by key, up to a total of sizes; the least recently used go first. Threads may share it."""

    def __init__(self, limit: int, size: Callable[[Part], int]) -> None:
        self._limit = limit
        self._size = size
        self._total = 0
        self._parts: OrderedDict[Key, Part] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, keys: Sequence[Key], read: Callable[[list[Key]], Mapping[Key, Part]]) -> list[Part]:
        """The part of each key. read: gives those that are not kept."""
        found: dict[Key, Part] = {}
        with self._lock:
            for key in keys:
                part = self._parts.get(key)
                if part is not None:
                    found[key] = part
                    self._parts.move_to_end(key)
        missing = [key for key in dict.fromkeys(keys) if key not in found]
        if missing:
            new = read(missing)
            found.update(new)
            self._keep(new)
        return [found[key] for key in keys]

    def holds(self, keys: Sequence[Key]) -> bool:
        """Whether the parts of all keys are kept now."""
        with self._lock:
            return all(key in self._parts for key in keys)

    def _keep(self, new: Mapping[Key, Part]) -> None:
        with self._lock:
            for key, part in new.items():
                if key not in self._parts:
                    self._parts[key] = part
                    self._total += self._size(part)
            while self._total > self._limit:
                self._total -= self._size(self._parts.popitem(last=False)[1])
