"""Sequences over a scope in parts: nodes of one group of documents, or values of one kind."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from mcml.errors import LimitError, QueryError
from mcml_service.xpath.engine import sequences
from mcml_service.xpath.engine.values import numbers
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.groups import Group
from mcml_service.xpath.nodes.items import Column, Items
from mcml_service.xpath.nodes.numbering import Ints
from mcml_service.xpath.nodes.texts import Strings

MOST_ITEMS = 10_000_000


@dataclass(frozen=True, slots=True)
class Part:
    """Items one after the other: nodes of a forest, or values. of: of values, the nodes that they are of, where they
    are of nodes."""

    forest: Forest
    column: Column
    of: Ints | None = None

    def __len__(self) -> int:
        return len(self.column)

    @property
    def items(self) -> Items:
        """As the sequence of one context."""
        return Items(np.zeros(len(self.column), np.int64), self.column, 1)

    @property
    def are_nodes(self) -> bool:
        return self.items.kind == "nodes"

    def values(self) -> Iterable[float | str | bool]:
        """The values; nodes as texts."""
        column = sequences.texts(self.forest, self.items) if self.are_nodes else self.column
        return column.list() if isinstance(column, Strings) else column.tolist()

    def chosen(self, which: np.ndarray) -> Part:
        return replace(self, column=self.column[which], of=None if self.of is None else self.of[which])


class Parts:
    """Parts as a source of nodes. QueryError for values among them."""

    def __init__(self, parts: Iterable[Part]) -> None:
        self._parts = parts

    def chunks(self) -> Iterator[tuple[Forest, Ints]]:
        for part in self._parts:
            if not part.are_nodes and len(part):
                raise QueryError("The result contains values, not only nodes.", remedy="Ask for it with as=json.")
            yield part.forest, np.asarray(part.column, np.int64)


def values_of(part: Part, *, as_number: bool) -> Column:
    """The values of a part: nodes as numbers or as texts; other items unchanged, or as texts."""
    if part.are_nodes and as_number:
        return numbers(part.forest, np.asarray(part.column, np.int64))
    return part.column if as_number else sequences.texts(part.forest, part.items)


def at(parts: list[Part], places: np.ndarray) -> Iterator[Part]:
    """The items at some places of all parts, in the order of the places."""
    if not len(places):
        return
    ends = np.cumsum([len(part) for part in parts])
    owner = np.searchsorted(ends, places, side="right")
    edges = [0, *(np.flatnonzero(np.diff(owner)) + 1).tolist(), len(places)]
    for start, stop in pairwise(edges):
        part = parts[int(owner[start])]
        first = int(ends[owner[start]]) - len(part)
        yield part.chosen(places[start:stop] - first)


def listed(column: Column) -> Iterable[float | str | bool]:
    return column.list() if isinstance(column, Strings) else column.tolist()


def rank_of(forest: Forest) -> tuple[str, int]:
    """Return the sort key of the documents of a forest."""
    return (forest.documents[0].name, forest.documents[0].key) if len(forest) else ("", 0)


def gathered(parts: Iterable[Part]) -> Iterator[tuple[Forest, Ints]]:
    """All nodes of a sequence in document order, a forest after the other. QueryError for values among them."""
    forests: dict[Group, tuple[Forest, list[Ints]]] = {}
    for part in parts:
        if len(part) and not part.are_nodes:
            raise QueryError("A path begins at a value here.", remedy="Begin it with nodes.")
        forests.setdefault(part.forest.documents, (part.forest, []))[1].append(np.asarray(part.column, np.int64))
    for forest, found in sorted(forests.values(), key=lambda each: rank_of(each[0])):
        yield forest, np.unique(np.concatenate(found))


def hold_parts(parts: Iterator[Part]) -> list[Part]:
    """All of them that hold anything. LimitError for more items than are held at once."""
    found: list[Part] = []
    count = 0
    for part in parts:
        count += len(part)
        if count > MOST_ITEMS:
            raise LimitError(f"A sequence has more than {MOST_ITEMS:,} items.", remedy="Narrow it by a predicate.")
        found += [part] if len(part) else []
    return found
