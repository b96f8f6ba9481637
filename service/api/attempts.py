"""How often somebody may try to log in: a bound for each address, and one for each name.

Each process counts for itself, so that of several servers each allows as much.
"""

from __future__ import annotations

import math
import time

from limits import RateLimitItem, parse
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter

from service.errors import AttemptsError

BY_ADDRESS, BY_NAME = "10/minute", "30/hour"
"""Of those that failed; who gets in begins anew."""


class Attempts:
    """Of one process. Threads may share it."""

    def __init__(self) -> None:
        self._limiter = MovingWindowRateLimiter(MemoryStorage())
        self._limits: list[tuple[RateLimitItem, str]] = [(parse(BY_ADDRESS), "address"), (parse(BY_NAME), "name")]

    def require(self, address: str, name: str) -> None:
        """AttemptsError where there were too many. Counts one more."""
        for limit, kind, what in self._of(address, name):
            if not self._limiter.hit(limit, kind, what):
                reset = self._limiter.get_window_stats(limit, kind, what).reset_time
                raise AttemptsError(max(1, math.ceil(reset - time.time())))

    def forget(self, address: str, name: str) -> None:
        """Somebody got in."""
        for limit, kind, what in self._of(address, name):
            self._limiter.clear(limit, kind, what)

    def _of(self, address: str, name: str) -> list[tuple[RateLimitItem, str, str]]:
        """The limits that an attempt counts for: tokens and links have no name, and lock nobody else out."""
        kinds = {"address": address, "name": name}
        return [(limit, kind, kinds[kind]) for limit, kind in self._limits if kinds[kind] or kind == "address"]
