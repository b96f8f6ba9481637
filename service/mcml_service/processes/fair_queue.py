"""A fair queue: places that clients share, so that a client with many requests does not make others wait."""

from __future__ import annotations

import threading
from collections import Counter, OrderedDict, deque
from concurrent.futures import Future


class FairQueue:
    """A number of places, of which one client may hold all except one.

    Waiting clients are served in turn, each with its oldest request. Threads may share it.
    """

    def __init__(self, places: int) -> None:
        self._free = places
        self._most_each = max(1, places - 1)
        self._held: Counter[str] = Counter()
        self._waiting: OrderedDict[str, deque[Future[None]]] = OrderedDict()
        self._lock = threading.Lock()

    def ask(self, client: str) -> Future[None]:
        """Request a place, granted when the future is done. Cancel it to stop waiting, or give the place back."""
        turn: Future[None] = Future()
        with self._lock:
            self._waiting.setdefault(client, deque()).append(turn)
            self._serve()
        return turn

    def has_place(self, client: str) -> bool:
        """Whether a request of a client would get a place at once."""
        with self._lock:
            return self._free > 0 and self._held[client] < self._most_each

    def take(self, client: str, seconds: float) -> bool:
        """Waits for a place; False where none was free in time."""
        turn = self.ask(client)
        try:
            turn.result(seconds)
        except TimeoutError:
            # It may have come while the wait ended.
            return not turn.cancel()
        return True

    def give(self, client: str) -> None:
        """Lets the place of a client go."""
        with self._lock:
            self._free += 1
            self._held[client] -= 1
            if not self._held[client]:
                del self._held[client]
            self._serve()

    @property
    def held(self) -> int:
        """How many places are taken."""
        with self._lock:
            return self._held.total()

    @property
    def waiting(self) -> Counter[str]:
        """How many requests of each client have no place yet."""
        with self._lock:
            counted = {client: sum(not turn.cancelled() for turn in turns) for client, turns in self._waiting.items()}
        return +Counter(counted)

    def _serve(self) -> None:
        """Gives free places to those who wait, from the client who was served longest ago."""
        for client, turns in list(self._waiting.items()):
            while turns and self._free and self._held[client] < self._most_each:
                turn = turns.popleft()
                # Cancelled requests are skipped.
                if turn.set_running_or_notify_cancel():
                    self._free -= 1
                    self._held[client] += 1
                    turn.set_result(None)
                    self._waiting.move_to_end(client)
                    break
            if not turns:
                del self._waiting[client]
