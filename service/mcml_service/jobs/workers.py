"""Executors of jobs: executors of the standard library whose work can be killed."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from concurrent.futures import Executor, Future
from contextlib import AbstractContextManager
from typing import Any, Protocol

from mcml.errors import McmlError


class InterruptionError(McmlError):
    """The executor of a job ended before the job began, not because of the job."""


class Crew(Protocol):
    """Processes that help a job with pieces of its work. It is made by the server and used by the job's process.

    alone_seconds: how long the job works alone before it asks for help, because helpers take time to start.
    """

    @property
    def alone_seconds(self) -> float: ...

    def places(self) -> int:
        """Return the number of pieces that this job may have done at once now."""
        ...

    def helpers(self, shared: Sequence[Any]) -> AbstractContextManager[tuple[Executor, Sequence[Any]]]:
        """Return an executor, and the replacements of the shared values for its calls. Each value is sent only once."""
        ...


class Workers(Executor):
    """Processes that run jobs. The caller decides how many run at once.

    A future raises BrokenExecutor if the process died, MemoryError if the job needed more memory than it may have,
    InterruptionError if all processes are gone. `submit` raises OSError or RuntimeError if no process can be started.
    """

    crew: Crew

    @abstractmethod
    def kill(self, future: Future[Any]) -> None:
        """Kill the process of this work."""
