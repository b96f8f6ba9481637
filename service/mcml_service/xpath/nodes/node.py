"""Results of queries."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from mcml.errors import QueryError
from mcml_service.storage.documents.columns import Listed


@dataclass(frozen=True, slots=True)
class Node:
    """A node of a result. value: an element as XML, else the text."""

    kind: str
    stored: Listed
    address: str
    value: str


@dataclass(frozen=True, slots=True)
class Run:
    """Frames first to last of a document."""

    stored: Listed
    first: int
    last: int


def join_runs(runs: Iterable[Run]) -> Iterator[Run]:
    """Join consecutive runs in their order.

    An answer may have its own order (`mo:top`, a sequence): a run before the previous one is separate.
    """
    waiting: Run | None = None
    for run in runs:
        is_same = waiting is not None and waiting.stored.key == run.stored.key
        if waiting is not None and is_same and waiting.last <= run.first <= waiting.last + 1:
            waiting = Run(run.stored, waiting.first, run.last)
            continue
        if waiting is not None:
            yield waiting
        waiting = run
    if waiting is not None:
        yield waiting


def in_no_frame(address: str) -> QueryError:
    """The error of a node that no run of frames can hold."""
    return QueryError(
        f"{address} is not in a frame, so it is in no run of frames.",
        remedy="Ask with as=json, or for nodes in frames.",
    )
