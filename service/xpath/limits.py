"""When a query must end."""

from __future__ import annotations

import threading
import time

from service.errors import LimitError


class Limits:
    """seconds: how long the query may take, from now on. max_elements: how many elements it may look at, or answer, as
    XML. client: who asks; those who ask share the evaluating processes fairly."""

    def __init__(self, seconds: float, max_elements: int, client: str = "") -> None:
        self.max_elements = max_elements
        self.client = client
        self._seconds = seconds
        self._end = time.monotonic() + seconds
        self._cancelled = threading.Event()

    @property
    def seconds_left(self) -> float:
        return max(0.0, self._end - time.monotonic())

    def extend(self, seconds: float) -> None:
        """Give the query so many seconds from now on, where that is more than it has."""
        if time.monotonic() + seconds > self._end:
            self._seconds, self._end = seconds, time.monotonic() + seconds

    def cancel(self) -> None:
        """Nobody waits for the answer any more."""
        self._cancelled.set()

    def check(self) -> None:
        """LimitError once the time is up or the query was cancelled."""
        if self._cancelled.is_set():
            raise LimitError("The query was cancelled.", code="query-cancelled")
        if time.monotonic() > self._end:
            raise self.timeout()

    @property
    def over(self) -> bool:
        """Whether the query must end."""
        return self._cancelled.is_set() or time.monotonic() > self._end

    def timeout(self) -> LimitError:
        """The error of a query whose time is up."""
        return LimitError(
            f"The query took longer than {self._seconds:g} s, the limit.",
            remedy="Ask fewer documents, or narrow the expression by motion name, bone or position.",
            code="query-timeout",
        )
