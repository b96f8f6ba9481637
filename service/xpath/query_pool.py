"""Questions of a server, each evaluated in a process of its own while it lasts (`query_worker`).

Whatever a question takes, it takes there: the server answers others meanwhile. A question that exceeds its memory or
its time, or that nobody waits for any more, is ended by the system if it does not end by itself.
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

from schemas.queries import QueryAnswer, QueryRequest
from service.errors import BusyError
from service.processes.turns import Turns
from service.settings import Settings
from service.storage.database import Database
from service.xpath.answer.streams import Answer, Shown
from service.xpath.language.complete import Completion
from service.xpath.limits import Limits, Running, no_such_question
from service.xpath.nodes.node import Node
from service.xpath.queries import Queries
from service.xpath.query_worker import READY, Asked, Failed, Found, Method, Said, Value, Written, serve
from service.xpath.xml.evaluate import out_of_memory

LOOK_SECONDS = 0.05
START_SECONDS = 60.0
GRACE_SECONDS = 1.5
"""After these a process is killed whose question should have ended. It looks itself sooner (`limits.PATIENCE`)."""


class QueryPool:
    """So many processes, of which one client may hold all but one. Threads may share it."""

    def __init__(self, database: Database, settings: Settings, processes: int) -> None:
        self._database = database
        self._settings = settings
        self._turns = Turns(processes)
        self._idle: list[_Worker] = []
        self._running: dict[int, Running] = {}
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()
        self._is_closed = False
        self._context = _context()

    def begin(self) -> None:
        """Have a process ready before the first question comes."""
        with self._worker() as worker:
            worker.is_free = True

    def running(self) -> list[Running]:
        """The questions that are evaluated now, oldest first."""
        with self._lock:
            return list(self._running.values())

    def end(self, number: int) -> None:
        """End a question, as if whoever asks it had left. NotFoundError where it has ended."""
        with self._lock:
            found = self._running.get(number)
        if found is None:
            raise no_such_question(number)
        found.limits.cancel()

    def ask(self, asked: Asked, text: str, limits: Limits, seconds: float) -> Generator[Said]:
        """What a process says of a question, while the caller goes on with it. seconds: most that one message may take.

        Raises what the evaluation raised, LimitError where it was ended.
        """
        if not self._turns.take(limits.client, limits.seconds_left):
            raise limits.timeout()
        try:
            with self._noted(text, limits), self._worker() as worker:
                worker.send(asked)
                while True:
                    said = worker.receive(limits, seconds, self._settings.query_memory_mib << 20)
                    if isinstance(said, Failed):
                        worker.is_free = not said.last
                        raise said.error
                    worker.is_free = not (isinstance(said, Written) and said.nodes)
                    yield said
                    if worker.is_free:
                        return
        finally:
            self._turns.give(limits.client)

    def close(self) -> None:
        """End the processes; those that evaluate end with their questions."""
        with self._lock:
            self._is_closed = True
            idle, self._idle = self._idle, []
            running = list(self._running.values())
        for one in running:
            one.limits.cancel()
        for worker in idle:
            worker.end()

    @contextmanager
    def _noted(self, text: str, limits: Limits) -> Iterator[None]:
        number = next(self._numbers)
        with self._lock:
            self._running[number] = Running(number, text, limits)
        try:
            yield
        finally:
            with self._lock:
                del self._running[number]

    @contextmanager
    def _worker(self) -> Iterator[_Worker]:
        """A process, the one that was used last: it keeps most of what the next question needs."""
        worker = None
        with self._lock:
            while self._idle and worker is None:
                worker = self._idle.pop()
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
                    self._idle.append(worker)
            if not is_kept:
                worker.end()


class _Worker:
    """A process that evaluates. is_free: it has said all of its last question."""

    def __init__(self, context: ForkServerContext, database: Database, settings: Settings) -> None:
        self.is_free = False
        self._connection, theirs = context.Pipe()
        self._process = context.Process(
            target=serve, args=(theirs, database.url, database.read_url, settings), name="query", daemon=True
        )
        self._process.start()
        theirs.close()
        # To start is no part of a question's time: where a machine is busy it takes seconds.
        if not self._connection.poll(START_SECONDS) or not self._is_ready():
            self.end()
            raise BusyError("No process could be started that evaluates the question.")

    def _is_ready(self) -> bool:
        with suppress(EOFError, OSError):
            return bool(self._connection.recv() == READY)
        return False

    @property
    def is_alive(self) -> bool:
        return self._process.is_alive()

    def send(self, asked: Asked) -> None:
        self.is_free = False
        # Where it has died, to receive tells.
        with suppress(OSError):
            self._connection.send(asked)

    def receive(self, limits: Limits, seconds: float, memory: int) -> Said:
        """The next message. LimitError where the process was ended, or ended without a word."""
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
            said: Said = self._connection.recv()
        except (EOFError, OSError):
            # The system gives it no more memory, and what asks is no code that could say so.
            raise out_of_memory(memory) from None
        return said

    def end(self) -> None:
        """End the process at once, whatever it does."""
        self._connection.close()
        self._process.kill()
        self._process.join()
        self._process.close()

    def _cancel(self) -> None:
        if self._process.pid is not None and self._process.is_alive():
            with suppress(ProcessLookupError):
                os.kill(self._process.pid, signal.SIGUSR1)


class PooledQueries(Queries):
    """The query engine of a server: it evaluates nothing itself, but what others read its caches for."""

    def __init__(self, database: Database, settings: Settings) -> None:
        super().__init__(database, settings)
        self.pool = QueryPool(database, settings, settings.heavy_at_once)

    def begin(self) -> None:
        """Get ready before the first question comes."""
        self.pool.begin()

    def close(self) -> None:
        self.pool.close()
        super().close()

    def answer(self, request: QueryRequest, limits: Limits | None = None) -> QueryAnswer:
        value: QueryAnswer = self._value("answer", (request,), request.q, limits or self.limits())
        return value

    def stream(self, request: QueryRequest, limits: Limits | None = None) -> Answer | Shown:
        limits = limits or self.limits()
        # One by one, documents may be asked for as long as Saxon may take.
        said = self._ask("stream", (request,), request.q, limits, max(limits.seconds_left, self.settings.saxon_seconds))
        first = next(said)
        if isinstance(first, Found):
            said.close()
            group = self.caches.listing.group
            parts = [replace(part, documents=group(list(part.documents))) for part in first.parts]
            return Answer(self.database, self.caches, first.commit, first.whole_since, parts)
        return Shown(_nodes(first, said), first.total if isinstance(first, Written) else None)

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
        (said,) = self._ask(kind, arguments, text, limits, limits.seconds_left)
        return said.value if isinstance(said, Value) else None

    def _ask(
        self, kind: Method, arguments: tuple[Any, ...], text: str, limits: Limits, seconds: float
    ) -> Generator[Said]:
        there = self.database
        asked = Asked(kind, arguments, there.view, there.origin, there.from_replica, limits.seconds_left)
        return self.pool.ask(asked, text, limits, seconds)


def _nodes(first: Said, others: Iterator[Said]) -> Iterator[list[Node]]:
    for said in itertools.chain([first], others):
        if isinstance(said, Written):
            yield said.nodes


def _context() -> ForkServerContext:
    """How processes are started: as copies of one that has read the code and has no threads."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([serve.__module__])
    return context
