"""Whose turn it is: places that clients share, so that one who asks much does not make the others wait."""

from __future__ import annotations

import threading
from collections import Counter, OrderedDict, deque


class Turns:
    """So many places, of which one client may hold all but one.

    Clients who wait are served in turn, each with its oldest request. Threads may share it.
    """

    def __init__(self, places: int) -> None:
        self._free = places
        self._most_each = max(1, places - 1)
        self._held: Counter[str] = Counter()
        self._waiting: OrderedDict[str, deque[threading.Event]] = OrderedDict()
        self._lock = threading.Lock()

    def take(self, client: str, seconds: float) -> bool:
        """Waits for a place; False where none was free in time."""
        turn = threading.Event()
        with self._lock:
            self._waiting.setdefault(client, deque()).append(turn)
            self._serve()
        if turn.wait(seconds):
            return True
        with self._lock:
            # It may have come while the wait ended.
            if turn.is_set():
                return True
            self._waiting[client].remove(turn)
            if not self._waiting[client]:
                del self._waiting[client]
            return False

    def give(self, client: str) -> None:
        """Lets the place of a client go."""
        with self._lock:
            self._free += 1
            self._held[client] -= 1
            if not self._held[client]:
                del self._held[client]
            self._serve()

    @property
    def waiting(self) -> int:
        """How many requests have no place yet."""
        with self._lock:
            return sum(map(len, self._waiting.values()))

    def _serve(self) -> None:
        """Gives free places to those who wait, from the client who was served longest ago."""
        for client in list(self._waiting):
            if self._free and self._held[client] < self._most_each:
                self._free -= 1
                self._held[client] += 1
                self._waiting[client].popleft().set()
                if self._waiting[client]:
                    self._waiting.move_to_end(client)
                else:
                    del self._waiting[client]
