"""A worker process of this host. It sets the number of threads before it imports mathematics."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from mcml.processes.bounds import bound_growth, end_with_starter

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Processes share the cores, not threads. Sums in another order would also change the last digits of results."""


@dataclass(frozen=True)
class Kept:
    """A reference to a start parameter of the process, by its index."""

    place: int


class Started:
    """The start parameters of this process, if it is a worker. running: the number of jobs on this host."""

    running: Any = None
    kept: tuple[Any, ...] = ()


started = Started()


def start(memory: int, running: Any, kept: tuple[Any, ...]) -> None:
    """Prepare this process. memory: bytes that its work may take."""
    # A terminal sends SIGINT to all processes of a server; the server ends its workers itself.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_starter()
    os.environ.update(ONE_THREAD)
    # Modules for all jobs are loaded before the memory of the jobs is counted.
    import mcml_service.jobs.worker  # noqa: F401

    started.running, started.kept = running, kept
    bound_growth(memory)


def call(function: Callable[..., Any], args: Sequence[Any], kwargs: dict[str, Any]) -> Any:
    """Do one piece of work."""
    arguments = [started.kept[value.place] if isinstance(value, Kept) else value for value in args]
    return function(*arguments, **kwargs)
