"""What runs in a process that evaluates the questions of a server, one after the other (`query_pool`).

The system bounds what a question may take: memory by `RLIMIT_DATA`, time by a clock that interrupts whatever runs. So
no loop has to remember to ask. After a question that ran into either the process ends, for what it kept may be half
made, and another takes its place.
"""

from __future__ import annotations

import signal
import traceback
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, Literal

from service.errors import LimitError, McmlError
from service.processes.bounds import bounded, end_with_parent
from service.settings import Settings
from service.storage.database import Database
from service.storage.views import View
from service.xpath.answer.streams import Answer, GroupNodes
from service.xpath.limits import Limits
from service.xpath.nodes.node import Node
from service.xpath.queries import Queries
from service.xpath.xml.evaluate import out_of_memory

Method = Literal["answer", "stream", "completions"]


@dataclass(frozen=True)
class Asked:
    """A question. kind: which method of `Queries` answers it, with which arguments. view, origin, from_replica: how the
    store is seen. seconds: that it may take."""

    kind: Method
    arguments: tuple[Any, ...]
    view: View
    origin: str
    from_replica: bool
    seconds: float


@dataclass(frozen=True)
class Value:
    """An answer. last: the process ends."""

    value: Any


@dataclass(frozen=True)
class Found:
    """Nodes by number, as `Answer` has them."""

    commit: int
    whole_since: int
    parts: list[GroupNodes]


@dataclass(frozen=True)
class Written:
    """Some nodes that are written out, as `Shown` has them. total: where it is known."""

    nodes: list[Node]
    total: int | None


@dataclass(frozen=True)
class Failed:
    """How a question ended instead. last: the process ends, too."""

    error: Exception
    last: bool


READY = "ready"
"""What a process says first."""
Said = Value | Found | Written | Failed


class _Turn:
    """What is going on now. limits: of the question that is evaluated. is_sending: a message must not be cut off.
    is_forced: the question was ended from outside its own code."""

    def __init__(self) -> None:
        self.limits: Limits | None = None
        self.is_sending = False
        self.is_forced = False

    def cancel(self, _signal: int, _frame: object) -> None:
        if self.limits is not None:
            self.limits.cancel()

    def overdue(self) -> Exception | None:
        """The error of a question that did not end by itself when it had to."""
        error = None if self.limits is None or self.is_sending else self.limits.overdue()
        self.is_forced = error is not None
        return error


def serve(connection: Connection, url: str, read_url: str | None, settings: Settings) -> None:
    """Answer what comes, until the connection ends. SIGUSR1 cancels the question that is evaluated."""
    turn = _Turn()
    end_with_parent()
    # The terminal tells all processes of a server to end; it alone knows when.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGUSR1, turn.cancel)
    queries = Queries(Database(url, read_url), settings, processes=1)
    with suppress(EOFError, OSError):
        connection.send(READY)
        while _answer(queries, connection, connection.recv(), turn):
            pass
    queries.close()


def _answer(queries: Queries, connection: Connection, asked: Asked, turn: _Turn) -> bool:
    """Answer one question. False where the process must end. OSError where whoever asked is gone."""
    turn.limits, turn.is_sending, turn.is_forced = queries.limits(), False, False
    turn.limits.begin(asked.seconds)
    try:
        with bounded(queries.settings.query_memory_mib << 20, turn.overdue):
            for said in _said(queries, asked, turn.limits):
                turn.is_sending = True
                connection.send(said)
                turn.is_sending = False
    except MemoryError:
        failed = Failed(out_of_memory(queries.settings.query_memory_mib << 20), last=True)
    except RecursionError:
        failed = Failed(LimitError("The expression is nested too deeply.", code="query-too-large"), last=True)
    except Exception as error:
        if turn.is_sending and isinstance(error, OSError):
            raise
        is_known = isinstance(error, McmlError)
        if not is_known:
            # Nobody foresaw it: the log of the server tells where it came about.
            error.add_note("".join(traceback.format_exception(error)))
        failed = Failed(error, last=turn.is_forced or not is_known)
    else:
        return True
    finally:
        turn.limits = None
    connection.send(failed)
    return not failed.last


def _said(queries: Queries, asked: Asked, limits: Limits) -> Iterator[Said]:
    """What is said of a question: one answer, or the parts of a stream and then an empty one."""
    there = queries.on(queries.database.for_call(asked.view, asked.origin, from_replica=asked.from_replica))
    if asked.kind == "completions":
        yield Value(there.completions(*asked.arguments))
    elif asked.kind == "answer":
        yield Value(there.answer(asked.arguments[0], limits))
    else:
        found = there.stream(asked.arguments[0], limits)
        if isinstance(found, Answer):
            yield Found(found.commit, found.whole_since, found.parts)
            return
        for nodes in found.nodes():
            yield Written(nodes, found.total)
        yield Written([], found.total)
