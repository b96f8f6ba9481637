"""Where the nodes of an answer come from, and its pages and runs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np

from service.errors import QueryError
from service.xpath.describe import describe_nodes
from service.xpath.forest import Forest
from service.xpath.nodes import Node, Run
from service.xpath.numbering import Ints, documents_of, frames_of
from service.xpath.render import node_values, runs_of


class Source(Protocol):
    """Something that finds nodes: a plan, or an expression on columns."""

    def chunks(self) -> Iterator[tuple[Forest, Ints]]:
        """The nodes of the answer in order, some at a time; each chunk ascending, of one batch of documents."""


def page(source: Source, offset: int, limit: int, max_elements: int) -> list[Node]:
    """Nodes offset … offset + limit - 1."""
    result: list[Node] = []
    for forest, nodes in source.chunks():
        if offset >= len(nodes):
            offset -= len(nodes)
            continue
        some = nodes[offset : offset + limit - len(result)]
        offset = 0
        result += described(forest, some, max_elements)
        if len(result) >= limit:
            break
    return result


def described(forest: Forest, nodes: Ints, max_elements: int) -> list[Node]:
    """Nodes as an answer shows them."""
    texts = node_values(forest, nodes, max_elements)
    places = documents_of(nodes).tolist()
    return [
        Node(kind, forest.documents[place], address, text)
        for place, (kind, address), text in zip(places, describe_nodes(forest, nodes), texts, strict=True)
    ]


def runs(source: Source) -> Iterator[Run]:
    """Maximal ranges of frames that nodes are or lie in. QueryError for a node outside the frames."""
    waiting: Run | None = None
    for forest, nodes in source.chunks():
        outside = np.flatnonzero(frames_of(nodes) == 0)
        if len(outside):
            _, address = next(describe_nodes(forest, nodes[outside[:1]]))
            raise QueryError(
                f"{address} is not in a frame, so it is in no run of frames.",
                remedy="Ask with as=json, or for nodes in frames.",
            )
        for document, first, last in runs_of(nodes):
            stored = forest.documents[document]
            if waiting is not None and waiting.stored.key == stored.key and first <= waiting.last + 1:
                waiting = Run(stored, waiting.first, max(waiting.last, last))
                continue
            if waiting is not None:
                yield waiting
            waiting = Run(stored, first, last)
    if waiting is not None:
        yield waiting


class Nth:
    """Of all nodes of another source, only the nth: `(…)[n]` around a whole expression."""

    def __init__(self, source: Source, nth: int) -> None:
        self.source = source
        self.nth = nth

    def chunks(self) -> Iterator[tuple[Forest, Ints]]:
        left = self.nth - 1
        for forest, nodes in self.source.chunks():
            if left < len(nodes):
                yield forest, nodes[left : left + 1]
                return
            left -= len(nodes)
