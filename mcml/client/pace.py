"""How fast an import is, and how long what is left of it will take."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

LOOKED_BACK = 15.0
"""Seconds over which the rate is taken: files that are stored already go by much faster than others."""

FEWEST_SECONDS = 0.5
"""Time before a rate is shown: workers start first, and the first files wait for them."""


class Pace:
    """Reports progress as a number of finished things out of a total. things: their name. clock: seconds."""

    def __init__(self, things: str = "files", clock: Callable[[], float] = time.monotonic) -> None:
        self._things = things
        self._clock = clock
        self._told: deque[tuple[float, int]] = deque()
        self._of = 0

    def tell(self, done: int, of: int) -> None:
        """Report the number of finished files, and the total."""
        now = self._clock()
        self._of = of
        self._told.append((now, done))
        # An older one is kept, so that there is a rate while a long file is read.
        while len(self._told) > 2 and self._told[1][0] <= now - LOOKED_BACK:
            self._told.popleft()

    @property
    def rate(self) -> float | None:
        """Files a second, None before that is known."""
        if not self._told:
            return None
        (first, before), (_, done) = self._told[0], self._told[-1]
        seconds = self._clock() - first
        return (done - before) / seconds if seconds >= FEWEST_SECONDS and done > before else None

    @property
    def left(self) -> float | None:
        """Seconds until all are done, None before that is known."""
        rate = self.rate
        return None if rate is None else (self._of - self._told[-1][1]) / rate

    def __str__(self) -> str:
        """Such as `289 files/s, 0:08 left`; empty before that is known."""
        rate, left = self.rate, self.left
        if rate is None or left is None:
            return ""
        shown = (
            f"{rate:.0f} {self._things}/s"
            if rate >= 10
            else f"{rate:.1f} {self._things}/s"
            if rate >= 0.1
            else f"{60 * rate:.1f} a minute"
        )
        minutes, seconds = divmod(round(left), 60)
        hours, minutes = divmod(minutes, 60)
        time_left = f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"
        return f"{shown}, {time_left} left"
