"""Sequences of XPath 2.0 for many contexts at once: nodes or values of one kind, each with its context."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from mcml_service.xpath.nodes.nodesets import NodeSets
from mcml_service.xpath.nodes.numbering import Bools, Floats, Ints
from mcml_service.xpath.nodes.pairs import bounded
from mcml_service.xpath.nodes.texts import Strings, joined

Column: TypeAlias = Ints | Floats | Bools | Strings


@dataclass(frozen=True, slots=True)
class Items:
    """groups: the context of each item, ascending. column: the items, those of one context in their order; numbers of
    nodes are integers, other numbers are not. count: of contexts."""

    groups: Ints
    column: Column
    count: int

    def __len__(self) -> int:
        return len(self.groups)

    @property
    def kind(self) -> str:
        """ "nodes", "number", "string" or "boolean"."""
        if isinstance(self.column, Strings):
            return "string"
        return {"b": "boolean", "i": "nodes"}.get(self.column.dtype.kind, "number")

    @property
    def sets(self) -> NodeSets:
        """Their places as if they were nodes, to count and compare them by."""
        return NodeSets(self.groups, np.arange(len(self.groups)), self.count)

    def chosen(self, which: Ints | Bools) -> Items:
        """Some of the items, or all in another order; contexts stay together."""
        return Items(self.groups[which], self.column[which], self.count)

    def at(self, rows: Ints) -> Items:
        """The items of some contexts, repeated or not, as those of contexts 0, 1, …."""
        begin = np.searchsorted(self.groups, rows, "left")
        source, within = bounded(np.searchsorted(self.groups, rows, "right") - begin)
        return Items(source, self.column[begin[source] + within], len(rows))

    def first(self) -> tuple[Ints, Column]:
        """(contexts that have any item, the first one of each)."""
        found, place = np.unique(self.groups, return_index=True)
        return found, self.column[place]

    def positions(self) -> tuple[Floats, Floats]:
        """Return for each item its position in its sequence, from 1, and the size of the sequence."""
        counts = np.bincount(self.groups, minlength=self.count)
        within = np.arange(len(self)) - np.repeat(np.cumsum(counts) - counts, counts)
        return np.asarray(within + 1.0, np.float64), counts[self.groups].astype(np.float64)


def nothing(count: int) -> Items:
    """Empty sequences."""
    return Items(np.empty(0, np.int64), np.empty(0), count)


def concatenated(parts: list[tuple[Ints, Items]]) -> Items | None:
    """Sequences one after the other: of each part the contexts that its own are, and the items. None where they are of
    several kinds."""
    count = max((int(contexts.max(initial=-1)) + 1 for contexts, _ in parts), default=0)
    filled = [(contexts, items) for contexts, items in parts if len(items)]
    if len({items.kind for _, items in filled}) > 1:
        return None
    if not filled:
        return nothing(count)
    groups = np.concatenate([contexts[items.groups] for contexts, items in filled])
    columns = [items.column for _, items in filled]
    strings = [column for column in columns if isinstance(column, Strings)]
    column: Column = joined(strings) if strings else np.concatenate([c for c in columns if not isinstance(c, Strings)])
    found = Items(groups, column, count)
    if len(filled) == 1 or (np.diff(groups) >= 0).all():
        return found
    return found.chosen(np.argsort(groups, kind="stable"))
