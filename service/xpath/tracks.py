"""Tracks as arrays, the ones decoded last kept in memory."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Sequence
from typing import Any

from service.motion.skeleton import Array
from service.storage.database import Transaction
from service.storage.encoding import channels_of, decompress

Key = tuple[int, int, int, int]
"""(document, chunk, bone, from_commit): under a key a track never changes."""


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
        missing: dict[int, list[Key]] = {}
        for key in keys:
            if key not in found:
                missing.setdefault(key[2], []).append(key)
        for bone, wanted in missing.items():
            documents = list(dict.fromkeys(key[0] for key in wanted))
            chunks = [key[1] for key in wanted]
            asked = set(wanted)
            for row in tx.columns.track_data(documents, [bone], (min(chunks), max(chunks))):
                key = (row[0], row[1], row[2], row[3])
                if key in asked:
                    found[key] = decompress(row[6], len(channels_of(row[4])), row[5])
        self._keep({key: found[key] for wanted in missing.values() for key in wanted})
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
