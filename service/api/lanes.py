"""Heavy requests in lanes of their own: some are worked on, some wait in turn, more are sent away.

What is light never stands behind them: they take no thread that others need.
"""

from __future__ import annotations

import asyncio
import ctypes
import sys
from collections.abc import AsyncIterator, Callable
from concurrent.futures import Future
from contextlib import asynccontextmanager
from typing import TypeVar

from anyio import CapacityLimiter, to_thread
from fastapi import Request

from service.errors import BusyError, ShareError
from service.operations.operation import Effect, Operation
from service.processes.turns import Turns
from service.settings import Settings

Value = TypeVar("Value")

LOOK_SECONDS = 0.25
"""How often a request that waits, or is worked on, looks whether its client is still there."""

QUIET_SECONDS = 1.0
"""After so long without heavy requests, memory that nothing uses goes back to the system."""


class Lane:
    """places: how many requests are worked on at a time; one client holds all but one. most: how many may wait, half of
    them of one client. seconds: how long. left: told when one is over."""

    def __init__(self, places: int, most: int, seconds: float, left: Callable[[], None]) -> None:
        self._turns = Turns(places)
        # Who has a place finds a thread.
        self._threads = CapacityLimiter(places)
        self._most = most
        self._seconds = seconds
        self._left = left

    @property
    def is_empty(self) -> bool:
        return not self._turns.held

    @asynccontextmanager
    async def place(self, http: Request, client: str) -> AsyncIterator[CapacityLimiter]:
        """A place while the block lasts, and threads to work in. BusyError or ShareError where none is free in time."""
        waiting = self._turns.waiting
        if waiting[client] >= max(1, self._most // 2):
            raise ShareError(waiting[client])
        if waiting.total() >= self._most:
            raise BusyError(f"{waiting.total()} requests wait already.")
        turn = self._turns.ask(client)
        try:
            await self._come(turn, http)
            yield self._threads
        finally:
            if not turn.cancel():
                self._turns.give(client)
                self._left()

    async def _come(self, turn: Future[None], http: Request) -> None:
        loop = asyncio.get_running_loop()
        end = loop.time() + self._seconds
        while not turn.done():
            await asyncio.wait({asyncio.wrap_future(turn)}, timeout=min(LOOK_SECONDS, end - loop.time()))
            if turn.done():
                return
            if http.app.state.stopping.is_set():
                raise BusyError("The server stops.")
            if loop.time() >= end or await http.is_disconnected():
                raise BusyError(f"No place was free within {self._seconds:g} s.")


class Lanes:
    """One for what reads and one for what writes, which may wait for the store: neither stands behind the other."""

    def __init__(self, settings: Settings) -> None:
        places, most, seconds = settings.heavy_at_once, settings.heavy_waiting, settings.heavy_wait_seconds
        self._reads, self._writes = (Lane(places, most, seconds, self._tidy_soon) for _ in range(2))
        self._tidying: asyncio.TimerHandle | None = None

    def of(self, operation: Operation) -> Lane:
        return self._writes if operation.effect is Effect.WRITES else self._reads

    def _tidy_soon(self) -> None:
        if self._tidying is not None:
            self._tidying.cancel()
        self._tidying = asyncio.get_running_loop().call_later(QUIET_SECONDS, self._tidy)

    def _tidy(self) -> None:
        self._tidying = None
        if self._reads.is_empty and self._writes.is_empty:
            asyncio.get_running_loop().run_in_executor(None, give_memory_back)


async def while_connected(
    http: Request, cancel: Callable[[], None], ask: Callable[[], Value], threads: CapacityLimiter | None = None
) -> Value:
    """Runs something in a thread; cancels it when the client leaves, or the server stops."""
    running = asyncio.ensure_future(to_thread.run_sync(ask, limiter=threads))
    try:
        while not (await asyncio.wait({running}, timeout=LOOK_SECONDS))[0]:
            if await http.is_disconnected():
                cancel()
    except asyncio.CancelledError:
        cancel()
        raise
    return await running


def give_memory_back() -> None:
    """What is free and the C library keeps: of many threads at once it never gives it back by itself."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
    if trim is not None:
        trim(0)
