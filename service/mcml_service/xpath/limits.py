"""When a query must end."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

from mcml.errors import LimitError, NotFoundError

PATIENCE = 0.5
"""Seconds in which a query should end by itself."""
QUICK_SECONDS = 1.0
"""Time limit of a query that is expected to be quick, in the place for such queries."""


class Limits:
    """Limits of a query.

    seconds: time limit, from now on. max_elements: limit of elements that it may read or return as XML. client: key of
    the client; clients share the evaluating processes fairly. author: name of the user. is_quick: the query is expected
    to be quick, and has a place that only such queries have.
    """

    def __init__(self, seconds: float, max_elements: int, client: str = "", author: str = "") -> None:
        self.author = author
        self.max_elements = max_elements
        self.client = client
        self.is_quick = False
        self._seconds = seconds
        self._end = time.monotonic() + seconds
        self._left: float | None = None

    def begin(self, left: float) -> None:
        """Continue with the remaining time, in another process."""
        self._end = time.monotonic() + left

    @property
    def seconds_left(self) -> float:
        return max(0.0, self._end - time.monotonic())

    def extend(self, seconds: float) -> None:
        """Extend the time limit of the query to at least this many seconds from now."""
        if time.monotonic() + seconds > self._end:
            self._seconds, self._end = seconds, time.monotonic() + seconds

    def hurry(self) -> None:
        """Let the query be quick: it has less time."""
        self.is_quick = True
        self._end = min(self._end, time.monotonic() + QUICK_SECONDS)

    def overdue(self) -> LimitError | None:
        """Return the error of a query that did not end in time, None while it may continue."""
        end = self._end if self._left is None else min(self._left, self._end)
        return self.error() if time.monotonic() > end + PATIENCE else None

    def cancel(self) -> None:
        """Cancel the query: its client has disconnected."""
        if self._left is None:
            self._left = time.monotonic()

    def check(self) -> None:
        """LimitError once the time is up or the query was cancelled."""
        if self.over:
            raise self.error()

    def error(self) -> LimitError:
        """Return the error of a query that must end: its client has disconnected, or its time is up."""
        if self.is_cancelled:
            return LimitError("The query was cancelled.", code="query-cancelled")
        return self.timeout()

    @property
    def over(self) -> bool:
        """Whether the query must end."""
        return self.is_cancelled or time.monotonic() > self._end

    @property
    def is_cancelled(self) -> bool:
        return self._left is not None

    def timeout(self) -> LimitError:
        """The error of a query whose time is up."""
        return LimitError(
            f"The query took longer than {self._seconds:g} s, the limit.",
            remedy="Ask fewer documents, or narrow the expression by motion name, bone or position.",
            code="query-timeout",
        )


@dataclass
class Running:
    """A running query. limits: for cancelling it."""

    id: int
    text: str
    limits: Limits
    began: float = field(default_factory=time.monotonic)

    @property
    def seconds(self) -> float:
        """For how long."""
        return time.monotonic() - self.began


def no_such_question(number: int) -> NotFoundError:
    """Return the error for a query that has ended, or never began."""
    return NotFoundError(f"No question {number} is running.", remedy="List those that are.")
