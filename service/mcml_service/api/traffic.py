"""Tracks whether requests are being served, so that background work can wait."""

from __future__ import annotations

import time

QUIET_SECONDS = 0.5
"""Time after an answer in which another request is likely."""
FOLLOWING = "/events"
"""Paths that end so are followed for hours, and take next to nothing."""


class Traffic:
    """The requests of a server. Written by one thread, read by others."""

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
