"""Workers on this host: processes of the standard library, each with one job at a time.

A `ProcessPoolExecutor` whose process dies fails all work that it has. So each executor has a single process, and is
replaced when that died.
"""

from __future__ import annotations

import multiprocessing
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any

from mcml_service.jobs.host_process import Kept, call, start, started
from mcml_service.jobs.workers import Workers

_SPAWN = multiprocessing.get_context("spawn")
"""A copy of the server by fork would hold its threads' locks. Not a fork server: that one loads query code."""

ALONE_SECONDS = 2.0
"""How long a job works alone: a helper takes a second to start."""


class HostWorkers(Workers):
    """places: jobs that run at once, by which jobs share the cores. memory: bytes that a process may add to its own.

    kept: values that calls get in place of `Kept`.
    """

    def __init__(self, places: int, memory: int, kept: Sequence[Any] = ()) -> None:
        self.crew = HostCrew(places, memory, ALONE_SECONDS)
        self._running = _SPAWN.RawValue("i", 0)
        self._begun = (memory, self._running, tuple(kept))
        self._idle: list[ProcessPoolExecutor] = []
        self._busy: dict[Future[Any], ProcessPoolExecutor] = {}
        self._is_closed = False
        self._lock = threading.Lock()

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Start at once, in an idle process if there is one, else in a new one."""
        future: Future[Any] = Future()
        future.set_running_or_notify_cancel()
        with self._lock:
            if self._is_closed:
                raise RuntimeError("The workers were closed.")
            inner, worker = self._begin(function, args, kwargs)
            self._busy[future] = worker
            self._running.value = len(self._busy)
        inner.add_done_callback(partial(self._settle, future))
        return future

    def kill(self, future: Future[Any]) -> None:
        with self._lock:
            worker = self._busy.get(future)
        if worker is not None:
            _kill(worker)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Kill all processes."""
        with self._lock:
            self._is_closed = True
            workers, self._idle = [*self._idle, *self._busy.values()], []
        for worker in workers:
            _kill(worker)
        for worker in workers:
            worker.shutdown(wait=wait, cancel_futures=cancel_futures)

    def _begin(self, function: Any, args: Any, kwargs: Any) -> tuple[Future[Any], ProcessPoolExecutor]:
        while self._idle:
            worker = self._idle.pop()
            try:
                return worker.submit(call, function, args, kwargs), worker
            except BrokenExecutor:
                # It died while it was idle.
                worker.shutdown(wait=False)
        worker = ProcessPoolExecutor(1, mp_context=_SPAWN, initializer=start, initargs=self._begun)
        inner = worker.submit(call, function, args, kwargs)
        # The only process has started and has its own end of the pipe for results. With this end open, the executor
        # would wait for ever for the rest of a result whose sender was killed.
        worker._result_queue._writer.close()  # type: ignore[attr-defined]  # of a queue in the standard library
        return inner, worker

    def _settle(self, future: Future[Any], inner: Future[Any]) -> None:
        """Free the process, then notify its waiter, which may have work for it at once."""
        error = BrokenExecutor() if inner.cancelled() else inner.exception()
        is_broken = isinstance(error, BrokenExecutor)
        # Cached data of a process may be incomplete after it ran out of memory.
        is_over = is_broken or isinstance(error, MemoryError)
        with self._lock:
            worker = self._busy.pop(future)
            self._running.value = len(self._busy)
            is_over = is_over or self._is_closed
            if not is_over:
                self._idle.append(worker)
        # An executor that broke ends itself. From Python 3.12 on it calls this with the lock that `shutdown` waits for.
        if is_over and not is_broken:
            worker.shutdown(wait=False)
        if error is None:
            future.set_result(inner.result())
        else:
            future.set_exception(error)


@dataclass(frozen=True)
class HostCrew:
    """Processes that a job's process starts for itself, as many as jobs leave places free."""

    most: int
    memory: int
    alone_seconds: float

    def places(self) -> int:
        """Return this job's share of all places: another job may begin or end at any time."""
        running = 1 if started.running is None else started.running.value
        return max(1, self.most // max(1, running))

    @contextmanager
    def helpers(self, shared: Sequence[Any]) -> Iterator[tuple[Executor, Sequence[Any]]]:
        workers = HostWorkers(1, self.memory, shared)
        try:
            yield workers, [Kept(place) for place in range(len(shared))]
        finally:
            workers.shutdown()


def _kill(worker: ProcessPoolExecutor) -> None:
    # Python 3.14 has `kill_workers` for it.
    for process in list((worker._processes or {}).values()):
        process.kill()
