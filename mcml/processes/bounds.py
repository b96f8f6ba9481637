"""Limits that a program sets for itself: the system ends it even without a watcher."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import resource
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

GRACE_SECONDS = 5.0
"""Time beyond the watcher's limit: as long as there is a watcher, it ends the program and reports it."""


def bound_growth(memory: int) -> None:
    """Limit the memory that this process can allocate from now on, on Linux only; and disable core dumps."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if sys.platform == "linux":
        hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
        resource.setrlimit(resource.RLIMIT_DATA, (_at_most(_count_held_bytes() + memory, hard), hard))


def end_after(seconds: float | None) -> None:
    """End this process after this time plus GRACE_SECONDS; None: cancel the timer.

    Works independently of the process's own code.
    """
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, 0 if seconds is None else seconds + GRACE_SECONDS)


def end_with_parent() -> None:
    """Kill this process when its parent ends. On Linux only."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def end_with_starter() -> None:
    """End this process when the one that started it through `multiprocessing` ends, on every system.

    For processes that threads start: to `end_with_parent` the end of that thread is the end of the parent.
    """
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: multiprocessing.process.BaseProcess) -> None:
    parent.join()
    os._exit(0)


PR_SET_PDEATHSIG = 1
"""As prctl.h of Linux has it."""

LOOK_SECONDS = 0.25
"""The interval in which a limited block checks its time."""

_SIZES = Path("/proc/self/statm")
_DATA = 5
"""The place in it of the pages that `resource.RLIMIT_DATA` counts."""


@contextmanager
def bounded(memory: int, late: Callable[[], Exception | None]) -> Iterator[None]:
    """Limit the memory and the time of a block.

    memory: bytes beyond those that the process holds now; MemoryError beyond that, on Linux only. late: returns the
    error to raise, or None; called every 0.25 s.

    For the main thread. The limits hold for all code without its help, except during a single call into C. An error may
    leave caches incomplete, so the process should end soon.
    """

    def look(_signal: int, _frame: object) -> None:
        error = late()
        if error is not None:
            raise error

    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    before = signal.signal(signal.SIGALRM, look)
    if sys.platform == "linux":
        resource.setrlimit(resource.RLIMIT_DATA, (_at_most(_count_held_bytes() + memory, hard), hard))
    signal.setitimer(signal.ITIMER_REAL, LOOK_SECONDS, LOOK_SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        with suppress(ValueError):
            resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))


def _at_most(limit: int, hard: int) -> int:
    return limit if hard == resource.RLIM_INFINITY else min(limit, hard)


def _count_held_bytes() -> int:
    """Return the bytes that `resource.RLIMIT_DATA` counts."""
    return int(_SIZES.read_text().split()[_DATA]) * resource.getpagesize()
