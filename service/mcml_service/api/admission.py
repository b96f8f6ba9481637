"""Admission of requests that take long: a server works on some, some wait in a queue, more are refused.

Other requests never wait behind them: they take no thread that others need.
"""

from __future__ import annotations

import asyncio
import ctypes
import sys
from collections.abc import AsyncIterator, Callable, Coroutine
from concurrent.futures import Future
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import Any, TypeVar

from anyio import CapacityLimiter, to_thread
from fastapi import Request

from mcml.errors import BusyError, ShareError
from mcml_service.operations.operation import Effect, Operation
from mcml_service.processes.fair_queue import FairQueue
from mcml_service.settings import Settings

Value = TypeVar("Value")

M_ARENA_MAX, M_MMAP_THRESHOLD = -8, -3
"""As malloc.h of glibc has them."""

HEAPS = 2

APART_BYTES = 1 << 18
"""Memory blocks from this size on are allocated outside heaps: they return to the system when freed.

By default the C library raises this limit up to 32 MiB, and heaps fragment.
"""

LOOK_SECONDS = 0.25
"""After so long, a request that is worked on ends when its client leaves; most are done before."""

QUIET_SECONDS = 1.0
"""After so long without heavy requests, memory that nothing uses goes back to the system."""

BUSY_SECONDS = 10.0
"""And at least so often where they never cease."""


class AdmissionQueue:
    """A queue of heavy requests.

    places: number of requests that run at a time; one client holds all except one. most: limit of waiting requests,
    half of them of one client. seconds: limit of the waiting time. left: called when a request ends.
    """

    def __init__(self, places: int, most: int, seconds: float, left: Callable[[], None]) -> None:
        self._queue = FairQueue(places)
        # Requests with a place always get a thread.
        self._threads = CapacityLimiter(places)
        self._most = most
        self._seconds = seconds
        self._left = left

    @property
    def is_empty(self) -> bool:
        return not self._queue.held

    def has_place(self, client: str) -> bool:
        """Whether a request of a client would get a place at once."""
        return self._queue.has_place(client)

    @asynccontextmanager
    async def place(self, http: Request, client: str) -> AsyncIterator[CapacityLimiter]:
        """A place while the block lasts, and threads to work in. BusyError or ShareError where none is free in time."""
        waiting = self._queue.waiting
        if waiting[client] >= max(1, self._most // 2):
            raise ShareError(waiting[client])
        if waiting.total() >= self._most:
            raise BusyError(f"{waiting.total()} requests wait already.")
        turn = self._queue.ask(client)
        try:
            await self._come(turn, http)
            yield self._threads
        finally:
            if not turn.cancel():
                self._queue.give(client)
                self._left()

    async def _come(self, turn: Future[None], http: Request) -> None:
        if turn.done():
            return
        coming = asyncio.wrap_future(turn)
        async with _leaving(http) as leaving, _ending(http.app.state.stopping.wait()) as stopping:
            await asyncio.wait({coming, leaving, stopping}, timeout=self._seconds, return_when=asyncio.FIRST_COMPLETED)
        if turn.done():
            return
        if http.app.state.stopping.is_set():
            raise BusyError("The server stops.")
        raise BusyError(f"No place was free within {self._seconds:g} s.")


class Admission:
    """Admission of heavy requests, with one queue for reads and one for writes, which may wait for the store:
    neither delays the other. quick: a queue for those that are expected to be quick, if they find no place.
    """

    def __init__(self, settings: Settings) -> None:
        places, most, seconds = settings.heavy_at_once, settings.heavy_waiting, settings.heavy_wait_seconds
        self._reads, self._writes = (AdmissionQueue(places, most, seconds, self._tidy_soon) for _ in range(2))
        self.quick = AdmissionQueue(1, most, seconds, self._tidy_soon)
        self._tidying: asyncio.TimerHandle | None = None
        self._tidied = 0.0

    def of(self, operation: Operation) -> AdmissionQueue:
        return self._writes if operation.effect is Effect.WRITES else self._reads

    def _tidy_soon(self) -> None:
        loop = asyncio.get_running_loop()
        if self._tidying is not None:
            self._tidying.cancel()
        self._tidying = loop.call_at(min(loop.time() + QUIET_SECONDS, self._tidied + BUSY_SECONDS), self._tidy)

    def _tidy(self) -> None:
        loop = asyncio.get_running_loop()
        self._tidying = None
        if (self._reads.is_empty and self._writes.is_empty) or loop.time() >= self._tidied + BUSY_SECONDS:
            self._tidied = loop.time()
            loop.run_in_executor(None, give_memory_back)


async def while_connected(
    http: Request, cancel: Callable[[], None], ask: Callable[[], Value], threads: CapacityLimiter | None = None
) -> Value:
    """Runs something in a thread; cancels it when the client leaves, or the server stops."""
    running = asyncio.ensure_future(to_thread.run_sync(ask, limiter=threads))
    try:
        await asyncio.wait({running}, timeout=LOOK_SECONDS)
        if not running.done():
            async with _leaving(http) as leaving:
                await asyncio.wait({running, leaving}, return_when=asyncio.FIRST_COMPLETED)
            if not running.done():
                cancel()
    except asyncio.CancelledError:
        cancel()
        raise
    return await running


def _leaving(http: Request) -> AbstractAsyncContextManager[asyncio.Task[None]]:
    """Return a task that ends when the client disconnects. Its request must have been read."""

    async def wait_for_disconnect() -> None:
        while (await http.receive())["type"] != "http.disconnect":
            pass

    return _ending(wait_for_disconnect())


@asynccontextmanager
async def _ending(waiting: Coroutine[Any, Any, Any]) -> AsyncIterator[asyncio.Task[Any]]:
    """A task that ends with the block."""
    task = asyncio.ensure_future(waiting)
    try:
        yield task
    finally:
        task.cancel()


def give_memory_back() -> None:
    """Return free memory that the C library keeps: with many threads, it does not do so itself."""
    trim = _of_c("malloc_trim")
    if trim is not None:
        trim(0)


def share_heaps() -> None:
    """Make threads share heaps.

    Call this before any thread starts: otherwise each thread keeps freed memory in its own heap while others request
    more from the system.
    """
    option = _of_c("mallopt")
    if option is not None:
        option(M_ARENA_MAX, HEAPS)
        option(M_MMAP_THRESHOLD, APART_BYTES)


def _of_c(name: str) -> Any:
    """A function of the C library, None where it has none."""
    return getattr(ctypes.CDLL(None), name, None) if sys.platform == "linux" else None
