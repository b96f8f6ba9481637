"""Where the nodes of an expression come from."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.numbering import Ints


class Source(Protocol):
    """Something that finds nodes: a plan, or an expression on columns."""

    def chunks(self) -> Iterator[tuple[Forest, Ints]]:
        """The nodes of the answer in order, some at a time; each chunk ascending, of one batch of documents."""


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
