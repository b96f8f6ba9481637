"""Streams of whole answers.

The query is first evaluated in one short transaction, as numbers of nodes, which takes eight bytes a node. The nodes
are then read and sent in batches, each in a separate transaction at the same commit. So a slow client blocks no writer,
and every limit is checked before the first byte is sent.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TypeVar

import numpy as np

from mcml.errors import LimitError
from mcml_service.storage.database import Database
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.answer.render import holds_frames
from mcml_service.xpath.engine.source import Source
from mcml_service.xpath.language.reach import HeadPart
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.groups import Group
from mcml_service.xpath.nodes.node import Node
from mcml_service.xpath.nodes.numbering import Ints

Form = TypeVar("Form")

MAX_NODES = 10_000_000
AT_A_TIME = 1000
"""Nodes that are read and written together."""


@dataclass(frozen=True)
class GroupNodes:
    """Nodes of one group of documents."""

    documents: Group
    nodes: Ints
    head_part: HeadPart


class Answer:
    """The nodes of an answer.

    total: their number. commit: the state of the store. whole_since: the commit since which the history was complete at
    that time.
    """

    def __init__(
        self, database: Database, caches: Caches, commit: int, whole_since: int, parts: list[GroupNodes]
    ) -> None:
        self.total = sum(len(part.nodes) for part in parts)
        self._database = database
        self._caches = caches
        self.commit = commit
        self.whole_since = whole_since
        self.parts = parts

    def read(self) -> AbstractContextManager[Transaction]:
        """Open a transaction at the commit of the query, on the primary store: its data is sent while it is read."""
        return self._database.for_call(self._database.view).read(self.commit)

    def shown(self, show: Callable[[Forest, Ints], Form]) -> Iterator[Form]:
        """Yield the results of a function on the nodes of some documents, in batches; a whole document is a separate
        batch.
        """
        for part in self.parts:
            for some in _slices(part.nodes):
                # Not within the transaction: a slow reader would keep it open.
                yield self._database.ask(partial(self._made, part, some, show), self.commit)

    def _made(self, part: GroupNodes, some: Ints, show: Callable[[Forest, Ints], Form], tx: Transaction) -> Form:
        tx.pruning.require_whole_since(self.whole_since)
        return show(Forest(tx, part.documents, self._caches, head_part=part.head_part), some)


class Shown:
    """Nodes that are written out already, as an evaluation on XML gives them, some at a time. total: where it is known.

    The first of them are made at once: so an error before them is one before the first byte.
    """

    def __init__(self, found: Iterable[list[Node]], total: int | None = None) -> None:
        self.total = total
        self._found = iter(found)
        self._first = next((some for some in self._found if some), [])

    def nodes(self) -> Iterator[list[Node]]:
        yield self._first
        yield from self._found


def collect(source: Source, limit: int | None) -> list[GroupNodes]:
    """The nodes of a source, at most `limit`. LimitError for more than can be held."""
    parts: list[GroupNodes] = []
    left = MAX_NODES + 1 if limit is None else limit
    for forest, nodes in source.chunks():
        some = nodes[:left]
        left -= len(some)
        parts.append(GroupNodes(forest.documents, some, forest.head_part))
        if left <= 0:
            break
    if limit is None and left <= 0:
        raise LimitError(f"The result has more than {MAX_NODES:,} nodes.", remedy="Narrow the query.")
    return parts


def _slices(nodes: Ints) -> Iterator[Ints]:
    """Nodes in slices that fit into memory when they are written out; a whole document comes alone."""
    alone = np.flatnonzero(holds_frames(nodes))
    edges = sorted({0, len(nodes), *alone.tolist(), *(alone + 1).tolist()})
    for start, stop in pairwise(edges):
        for at in range(start, stop, AT_A_TIME):
            yield nodes[at : min(stop, at + AT_A_TIME)]
