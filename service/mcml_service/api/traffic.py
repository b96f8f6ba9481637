"""Whether somebody is served just now, so that what can wait does."""

from __future__ import annotations

import time

QUIET_SECONDS = 0.5
"""After an answer: who asked often asks again."""
FOLLOWING = "/events"
"""Paths that end so are followed for hours, and take next to nothing."""


class Traffic:
    """The requests of a server. Told by one thread, asked by others."""

    def __init__(self) -> None:
        self._under_way = 0
        self._ended = 0.0

    def begins(self) -> None:
        self._under_way += 1

    def ends(self) -> None:
        self._under_way -= 1
        self._ended = time.monotonic()

    def is_busy(self) -> bool:
        return self._under_way > 0 or time.monotonic() - self._ended < QUIET_SECONDS
