"""Tracks as arrays, the ones decoded last kept in memory."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from typing import Any

from service.motion.skeleton import Array
from service.storage.database import Transaction
from service.storage.encoding import channels_of, decompress

Key = tuple[int, int, int, int]
"""(document, chunk, bone, from_commit): under a key a track never changes."""


MOST_UNASKED = 4
"""How many times as many tracks as are asked for one statement may reach."""


class Tracks:
    """Decoded tracks up to a number of bytes; the least recently used go first. Threads may share it.

    What is kept are the store's own numbers, as a database keeps pages: no answer is kept.
    """

    def __init__(self, limit: int = 48 << 20) -> None:
        self._limit = limit
        self._bytes = 0
        self._kept: OrderedDict[Key, Array] = OrderedDict()
        self._lock = threading.Lock()

    def read(self, tx: Transaction, rows: Sequence[Any]) -> list[Array]:
        """The (channels, frames) array of each row (document, chunk, bone, from_commit, channels)."""
        keys: list[Key] = [(row[0], row[1], row[2], row[3]) for row in rows]
        with self._lock:
            found = {key: self._kept[key] for key in keys if key in self._kept}
            for key in found:
                self._kept.move_to_end(key)
        missing = [key for key in dict.fromkeys(keys) if key not in found]
        for row in _fetch(tx, missing):
            found[row[0], row[1], row[2], row[3]] = decompress(row[6], len(channels_of(row[4])), row[5])
        self._keep({key: found[key] for key in missing})
        return [found[key] for key in keys]

    def _keep(self, tracks: dict[Key, Array]) -> None:
        if not tracks:
            return
        with self._lock:
            for key, values in tracks.items():
                if key not in self._kept:
                    self._kept[key] = values
                    self._bytes += values.nbytes
            while self._bytes > self._limit:
                self._bytes -= self._kept.popitem(last=False)[1].nbytes


def _fetch(tx: Transaction, keys: Sequence[Key]) -> Iterator[Any]:
    """The rows of tracks. One statement reads all tracks of some documents, bones and a range of chunks; where too many
    of those are not asked for, some documents or bones at a time."""
    if not keys:
        return
    asked = set(keys)
    documents, bones = ({key[place]: None for key in keys} for place in (0, 2))
    low, high = min(key[1] for key in keys), max(key[1] for key in keys)
    everything = len(documents) * len(bones) * (high - low + 1)
    if len(documents) == 1 or len(bones) == 1 or everything <= MOST_UNASKED * len(keys):
        for row in tx.columns.track_data(list(documents), list(bones), (low, high)):
            if (row[0], row[1], row[2], row[3]) in asked:
                yield row
        return
    place = 0 if len(documents) < len(bones) else 2
    for value in documents if place == 0 else bones:
        yield from _fetch(tx, [key for key in keys if key[place] == value])
