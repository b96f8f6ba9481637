"""A pool of worker processes that evaluate the queries of a server (`query_worker`).

A query uses the memory and the processor time of its worker process, so the server answers other requests meanwhile.
The pool kills a process whose query exceeds a limit or has lost its client, unless the query ends by itself.
"""

from __future__ import annotations

import itertools
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from multiprocessing.context import ForkServerContext
from typing import Any

from mcml.errors import BusyError
from mcml_schemas.querying.queries import QueryAnswer, QueryRequest
from mcml_service.processes.fair_queue import FairQueue
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.answer.streams import Answer, Shown
from mcml_service.xpath.language.complete import Completion
from mcml_service.xpath.limits import Limits, Running, no_such_question
from mcml_service.xpath.nodes.node import Node
from mcml_service.xpath.queries import Queries
from mcml_service.xpath.query_worker import (
    READY,
    Failure,
    Message,
    Method,
    NodeNumbers,
    NodeTexts,
    QueryCall,
    Value,
    serve,
)
from mcml_service.xpath.trees.evaluate import out_of_memory

LOOK_SECONDS = 0.05
START_SECONDS = 60.0
GRACE_SECONDS = 1.5
"""The pool kills a process that runs this long past the limit. The process checks earlier (`limits.PATIENCE`)."""


class _Lane:
    """Places for queries. turns: the queue for them. idle: processes without a query, the one used last at the end."""

    def __init__(self, places: int) -> None:
        self.turns = FairQueue(places)
        self.idle: list[_Worker] = []


class QueryPool:
    """A fixed number of worker processes, and one more for quick queries. Thread-safe.

    One client can use all except one of them. Quick queries (`quick`) never wait behind others, and use no
    process that a heavy query has used, which may have filled its caches or been killed.
    """

    def __init__(self, database: Database, settings: Settings, processes: int) -> None:
        self._database = database
        self._settings = settings
        self._heavy, self._quick = _Lane(processes), _Lane(1)
        self._running: dict[int, Running] = {}
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()
        self._is_closed = False
        self._context = fork_context()

    def begin(self) -> None:
        """Start a process before the first query."""
        with self._worker(self._heavy) as worker:
            worker.is_free = True

    def running(self) -> list[Running]:
        """Return the running queries, oldest first."""
        with self._lock:
            return list(self._running.values())

    def end(self, number: int) -> None:
        """Cancel a query. Raise NotFoundError if it is not running."""
        with self._lock:
            found = self._running.get(number)
        if found is None:
            raise no_such_question(number)
        found.limits.cancel()

    def ask(self, call: QueryCall, text: str, limits: Limits, seconds: float) -> Generator[Message]:
        """Yield the messages of a worker process for one call. seconds: the longest time between two messages.

        Raises the error of the evaluation, LimitError if the query exceeded a limit.
        """
        lane = self._quick if limits.is_quick else self._heavy
        if not lane.turns.take(limits.client, limits.seconds_left):
            raise limits.timeout()
        try:
            with self._registered(text, limits), self._worker(lane) as worker:
                worker.send(call)
                while True:
                    message = worker.receive(limits, seconds, self._settings.query_memory_mib << 20)
                    if isinstance(message, Failure):
                        worker.is_free = not message.last
                        raise message.error
                    worker.is_free = not (isinstance(message, NodeTexts) and message.nodes)
                    yield message
                    if worker.is_free:
                        return
        finally:
            lane.turns.give(limits.client)

    def close(self) -> None:
        """End the idle processes and cancel the running queries."""
        with self._lock:
            self._is_closed = True
            idle = [worker for lane in (self._heavy, self._quick) for worker in lane.idle]
            self._heavy.idle, self._quick.idle = [], []
            running = list(self._running.values())
        for one in running:
            one.limits.cancel()
        for worker in idle:
            worker.end()

    @contextmanager
    def _registered(self, text: str, limits: Limits) -> Iterator[None]:
        number = next(self._numbers)
        with self._lock:
            self._running[number] = Running(number, text, limits)
        try:
            yield
        finally:
            with self._lock:
                del self._running[number]

    @contextmanager
    def _worker(self, lane: _Lane) -> Iterator[_Worker]:
        """Take the process that was used last, because its caches are the warmest."""
        worker = None
        with self._lock:
            while lane.idle and worker is None:
                worker = lane.idle.pop()
                if not worker.is_alive:
                    worker.end()
                    worker = None
        worker = worker or _Worker(self._context, self._database, self._settings)
        try:
            yield worker
        finally:
            with self._lock:
                is_kept = worker.is_free and not self._is_closed
                if is_kept:
                    lane.idle.append(worker)
            if not is_kept:
                worker.end()


class _Worker:
    """A worker process. is_free: it has answered its last call."""

    def __init__(self, context: ForkServerContext, database: Database, settings: Settings) -> None:
        self.is_free = False
        self._connection, theirs = context.Pipe()
        self._process = context.Process(
            target=serve, args=(theirs, database.url, database.read_url, settings), name="query", daemon=True
        )
        self._process.start()
        theirs.close()
        # The start does not count against the time limit of a query: it takes seconds on a busy machine.
        if not self._connection.poll(START_SECONDS) or not self._is_ready():
            self.end()
            raise BusyError("The server could not start a process for the query.")

    def _is_ready(self) -> bool:
        with suppress(EOFError, OSError):
            return bool(self._connection.recv() == READY)
        return False

    @property
    def is_alive(self) -> bool:
        return self._process.is_alive()

    def send(self, call: QueryCall) -> None:
        self.is_free = False
        # `receive` raises if the process has died.
        with suppress(OSError):
            self._connection.send(call)

    def receive(self, limits: Limits, seconds: float, memory: int) -> Message:
        """Return the next message. Raise LimitError if the process was killed or died."""
        end = time.monotonic() + seconds + GRACE_SECONDS
        told = False
        while not self._connection.poll(LOOK_SECONDS):
            now = time.monotonic()
            if limits.is_cancelled and not told:
                told, end = True, min(end, now + GRACE_SECONDS)
                self._cancel()
            if now > end:
                self._process.kill()
                raise limits.error() if limits.over else limits.timeout()
        try:
            message: Message = self._connection.recv()
        except (EOFError, OSError):
            # Native code that gets no memory aborts the process without a message.
            raise out_of_memory(memory) from None
        return message

    def end(self) -> None:
        """Kill the process."""
        self._connection.close()
        self._process.kill()
        self._process.join()
        self._process.close()

    def _cancel(self) -> None:
        if self._process.pid is not None and self._process.is_alive():
            with suppress(ProcessLookupError):
                os.kill(self._process.pid, signal.SIGUSR1)


class PooledQueries(Queries):
    """The query engine of a server: worker processes evaluate the queries."""

    def __init__(self, database: Database, settings: Settings) -> None:
        super().__init__(database, settings)
        self.pool = QueryPool(database, settings, settings.heavy_at_once)

    def begin(self) -> None:
        """Start a worker process before the first query."""
        self.pool.begin()

    def close(self) -> None:
        self.pool.close()
        super().close()

    def answer(self, request: QueryRequest, limits: Limits | None = None) -> QueryAnswer:
        value: QueryAnswer = self._value("answer", (request,), request.q, limits or self.limits())
        return value

    def stream(self, request: QueryRequest, limits: Limits | None = None) -> Answer | Shown:
        limits = limits or self.limits()
        messages = self._ask("stream", (request,), request.q, limits, limits.seconds_left)
        first = next(messages)
        if isinstance(first, NodeNumbers):
            messages.close()
            group = self.caches.listing.group
            parts = [replace(part, documents=group(list(part.documents))) for part in first.parts]
            return Answer(self.database, self.caches, first.commit, first.whole_since, parts)
        return Shown(_nodes(first, messages), first.total if isinstance(first, NodeTexts) else None)

    def completions(
        self, text: str, at: int, documents: Sequence[str], project: str | None
    ) -> tuple[int, list[Completion]]:
        arguments = (text, at, documents, project)
        found: tuple[int, list[Completion]] = self._value("completions", arguments, text, self.limits())
        return found

    def running(self) -> list[Running]:
        return self.pool.running()

    def end(self, number: int) -> None:
        self.pool.end(number)

    def _value(self, kind: Method, arguments: tuple[Any, ...], text: str, limits: Limits) -> Any:
        (message,) = self._ask(kind, arguments, text, limits, limits.seconds_left)
        return message.value if isinstance(message, Value) else None

    def _ask(
        self, kind: Method, arguments: tuple[Any, ...], text: str, limits: Limits, seconds: float
    ) -> Generator[Message]:
        there = self.database
        call = QueryCall(kind, arguments, there.view, there.origin, there.from_replica, limits.seconds_left)
        return self.pool.ask(call, text, limits, seconds)


def _nodes(first: Message, others: Iterator[Message]) -> Iterator[list[Node]]:
    for message in itertools.chain([first], others):
        if isinstance(message, NodeTexts):
            yield message.nodes


def fork_context() -> ForkServerContext:
    """Fork processes from a process that has imported the code and has no threads."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([serve.__module__])
    return context
