"""The worker process that evaluates the queries of a server, one at a time (`query_pool`).

The operating system limits each query: its memory by `RLIMIT_DATA`, its time by a timer that interrupts any Python
code. No loop has to check a limit. A query that exceeds a limit ends its process, because its caches may be incomplete;
the pool starts another process.
"""

from __future__ import annotations

import signal
import traceback
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, Literal

from mcml.errors import LimitError, McmlError
from mcml.processes.bounds import bounded, end_with_parent
from mcml_service.settings import Settings
from mcml_service.storage.core.views import View
from mcml_service.storage.database import Database
from mcml_service.xpath.answer.streams import Answer, GroupNodes
from mcml_service.xpath.limits import Limits
from mcml_service.xpath.nodes.node import Node
from mcml_service.xpath.queries import Queries
from mcml_service.xpath.trees.evaluate import out_of_memory

Method = Literal["answer", "stream", "completions"]


@dataclass(frozen=True)
class QueryCall:
    """A call of a method of `Queries`.

    view, origin, from_replica: as `Database.for_call` takes them. seconds: the time limit.
    """

    kind: Method
    arguments: tuple[Any, ...]
    view: View
    origin: str
    from_replica: bool
    seconds: float


@dataclass(frozen=True)
class Value:
    """The answer of a query that is not a stream."""

    value: Any


@dataclass(frozen=True)
class NodeNumbers:
    """Nodes by number, as `Answer` has them."""

    commit: int
    whole_since: int
    parts: list[GroupNodes]


@dataclass(frozen=True)
class NodeTexts:
    """A part of the nodes of `Shown`, as text; the last part is empty. total: None if unknown."""

    nodes: list[Node]
    total: int | None


@dataclass(frozen=True)
class Failure:
    """The error of a query. last: the worker process ends."""

    error: Exception
    last: bool


READY = "ready"
"""The first message of a worker process."""
Message = Value | NodeNumbers | NodeTexts | Failure


class _State:
    """The state of the worker process.

    limits: those of the current query, None between queries. is_sending: a message is being written and must not be
    interrupted. is_forced: the timer ended the current query.
    """

    def __init__(self) -> None:
        self.limits: Limits | None = None
        self.is_sending = False
        self.is_forced = False

    def cancel(self, _signal: int, _frame: object) -> None:
        if self.limits is not None:
            self.limits.cancel()

    def overdue(self) -> Exception | None:
        """Return the error of a query that is past its time limit, None before that."""
        error = None if self.limits is None or self.is_sending else self.limits.overdue()
        self.is_forced = error is not None
        return error


def serve(connection: Connection, url: str, read_url: str | None, settings: Settings) -> None:
    """Answer calls until the connection closes. SIGUSR1 cancels the current query."""
    state = _State()
    end_with_parent()
    # A terminal sends SIGINT to all processes of a server; the server closes its workers itself.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGUSR1, state.cancel)
    queries = Queries(Database(url, read_url), settings)
    with suppress(EOFError, OSError):
        connection.send(READY)
        while _answer(queries, connection, connection.recv(), state):
            pass
    queries.close()


def _answer(queries: Queries, connection: Connection, call: QueryCall, state: _State) -> bool:
    """Answer one call. Return False if the process must end; raise OSError if the server is gone."""
    state.limits, state.is_sending, state.is_forced = queries.limits(), False, False
    state.limits.begin(call.seconds)
    try:
        with bounded(queries.settings.query_memory_mib << 20, state.overdue):
            for message in _messages(queries, call, state.limits):
                state.is_sending = True
                connection.send(message)
                state.is_sending = False
    except MemoryError:
        failed = Failure(out_of_memory(queries.settings.query_memory_mib << 20), last=True)
    except RecursionError:
        failed = Failure(LimitError("The expression is nested too deeply.", code="query-too-large"), last=True)
    except Exception as error:
        if state.is_sending and isinstance(error, OSError):
            raise
        is_known = isinstance(error, McmlError)
        if not is_known:
            error = _portable(error)
        failed = Failure(error, last=state.is_forced or not is_known)
    else:
        return True
    finally:
        state.limits = None
    connection.send(failed)
    return not failed.last


def _portable(error: Exception) -> Exception:
    """An unexpected error in a form that every process can read: the log of the server shows where it was raised.

    Errors of libraries may hold objects that cannot be sent.
    """
    told = RuntimeError(f"{type(error).__name__}: {error}")
    told.add_note("".join(traceback.format_exception(error)))
    return told


def _messages(queries: Queries, call: QueryCall, limits: Limits) -> Iterator[Message]:
    """Yield the answer, or the parts of a stream."""
    there = queries.on(queries.database.for_call(call.view, call.origin, from_replica=call.from_replica))
    if call.kind == "completions":
        yield Value(there.completions(*call.arguments))
    elif call.kind == "answer":
        yield Value(there.answer(call.arguments[0], limits))
    else:
        found = there.stream(call.arguments[0], limits)
        if isinstance(found, Answer):
            yield NodeNumbers(found.commit, found.whole_since, found.parts)
            return
        for nodes in found.nodes():
            yield NodeTexts(nodes, found.total)
        yield NodeTexts([], found.total)
