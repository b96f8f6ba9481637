"""How a program bounds itself, from inside: the system ends it even where nobody watches it any more."""

from __future__ import annotations

import resource
import signal

GRACE_SECONDS = 5.0
"""More than who watches a program gives it: as long as somebody does, it is ended, and told of, by him."""


def bound_memory(kind: int, memory: int) -> None:
    """Refuse this process more than so many bytes, and leave no copy of its memory on the disk when it crashes.

    kind: what counts, resource.RLIMIT_AS or RLIMIT_DATA.
    """
    resource.setrlimit(kind, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def end_after(seconds: float | None) -> None:
    """End this process so many seconds from now, and some; None: no more. It needs nothing of what the process does."""
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, 0 if seconds is None else seconds + GRACE_SECONDS)
