"""Expressions on the XML of a document, by libxml2 in processes with limits of time and memory.

A process is used again while it behaves. One that takes too long is killed; the query gets a LimitError.
"""

from __future__ import annotations

import json
import math
import subprocess
import threading
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from mcml.errors import LimitError, QueryError, StoreError
from mcml_service.processes.messages import read_message, write_message
from mcml_service.processes.programs import Watch, end_program, start_program
from mcml_service.processes.turns import Turns
from mcml_service.xpath.language.parse import Query
from mcml_service.xpath.language.reach import may_select_document
from mcml_service.xpath.limits import Limits
from mcml_service.xpath.xml.worker import LAST

SECONDS_OF_SHORT = 1.0
"""After these a query is a long one."""


@dataclass(frozen=True, slots=True)
class Scalar:
    """A number (NaN and infinities among them), string or boolean."""

    value: float | str | bool

    @property
    def type(self) -> str:
        """The XPath type: "number", "string" or "boolean"."""
        if isinstance(self.value, bool):
            return "boolean"
        return "string" if isinstance(self.value, str) else "number"


@dataclass(frozen=True, slots=True)
class Node:
    """A node of a result.

    kind: "element", "attribute", "text", "document" or "namespace". address: the canonical XPath that finds it.
    value: an element as XML, the value of an attribute or text.
    """

    kind: str
    address: str
    value: str


@dataclass(frozen=True, slots=True)
class Nodes:
    """A page of the nodes of a result, in document order. total: how many there are on all pages."""

    items: tuple[Node, ...]
    total: int


class Evaluator:
    """A small pool of processes. Threads may share it; at most `processes` queries run at once, all but one of one
    client; others wait in turn.

    program: the module that a process runs; it takes the memory that it may use as its argument.
    """

    program = "mcml_service.xpath.xml.worker"

    def __init__(self, *, seconds: float = 10.0, memory_bytes: int = 1 << 30, processes: int = 4) -> None:
        self._seconds = seconds
        self._memory = memory_bytes
        self._turns = Turns(processes)
        self._idle: list[subprocess.Popen[bytes]] = []
        self._lock = threading.Lock()

    def evaluate(
        self,
        query: Query,
        document: Iterable[bytes],
        *,
        limit: int = 1000,
        offset: int = 0,
        limits: Limits | None = None,
    ) -> Scalar | Nodes:
        """The value of an expression, the document as context node.

        document: its XML in pieces, without white space between elements (`Layout.COMPACT`), projected or whole.
        limit, offset: the page of nodes. limits: of the whole query; default the seconds of the pool.
        Raises LimitError (details: code "query-timeout" or "query-memory"), QueryError where libxml2 refuses the
        expression, StoreError where it refuses the document.
        """
        request = {
            "expression": query.text,
            "document": may_select_document(query.tree),
            "limit": limit,
            "offset": offset,
        }
        return _read_answer(self.ask(request, document, limits))

    def ask(self, request: dict[str, Any], document: Iterable[bytes], limits: Limits | None) -> Any:
        """What a process answers to a request on a document. Raises LimitError as `evaluate` does."""
        limits = limits or Limits(self._seconds, 0)
        if not self._turns.take(limits.client, limits.seconds_left):
            raise limits.timeout()
        try:
            answer = self._ask(request, document, limits)
        finally:
            self._turns.give(limits.client)
        if answer.get("error") == "memory":
            raise out_of_memory(self._memory)
        return answer

    def close(self) -> None:
        """Ends the idle processes; the pool can be used again."""
        with self._lock:
            idle, self._idle = self._idle, []
        for process in idle:
            end_program(process)

    def _ask(self, request: dict[str, Any], document: Iterable[bytes], limits: Limits) -> Any:
        process = self._take()
        answer = None
        # A process that dies breaks the pipe: what it said before, if anything, decides.
        try:
            with Watch(process, lambda: limits.over, self._memory, SECONDS_OF_SHORT) as watch:
                with suppress(BrokenPipeError):
                    _send(process, {"seconds": limits.seconds_left, **request}, document)
                answer = read_message(process.stdout) if process.stdout is not None else None
        finally:
            if answer is None:
                end_program(process)
        if answer is None:
            limits.check()
            raise out_of_memory(self._memory)
        read = json.loads(answer)
        if read.get("error") in LAST or watch.is_long:
            end_program(process)
            return read
        with self._lock:
            self._idle.append(process)
        return read

    def _take(self) -> subprocess.Popen[bytes]:
        with self._lock:
            while self._idle:
                process = self._idle.pop()
                if process.poll() is None:
                    return process
                end_program(process)
        pipe = subprocess.PIPE
        return start_program(self.program, str(self._memory), stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL)


def _send(process: subprocess.Popen[bytes], request: dict[str, Any], document: Iterable[bytes]) -> None:
    if process.stdin is None:
        raise BrokenPipeError
    write_message(process.stdin, json.dumps(request).encode())
    for piece in document:
        if piece:
            write_message(process.stdin, piece)
    write_message(process.stdin, b"")


def _read_answer(answer: dict[str, Any]) -> Scalar | Nodes:
    if answer.get("error") == "expression":
        raise QueryError(f"libxml2 refuses the expression: {answer['message']}", remedy="Write XPath 1.0.")
    if answer.get("error"):
        raise StoreError(f"The document is not well-formed: {answer['message']}")
    if answer["type"] == "nodes":
        return Nodes(tuple(Node(*item) for item in answer["items"]), answer["total"])
    value = answer["value"]
    special = {"NaN": math.nan, "Infinity": math.inf, "-Infinity": -math.inf}
    return Scalar(special[value] if answer["type"] == "number" and isinstance(value, str) else value)


def out_of_memory(memory: int) -> LimitError:
    """The error of a query that takes more than so many bytes."""
    return LimitError(
        f"The query needs more than {memory >> 20} MiB of memory.",
        remedy="Ask fewer documents, or narrow the expression by motion name, bone or position.",
        code="query-memory",
    )
