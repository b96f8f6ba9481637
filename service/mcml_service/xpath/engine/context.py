"""The context of an evaluation: context nodes with their positions, and variables with a value for each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from mcml_service.xpath.nodes.items import Items
from mcml_service.xpath.nodes.nodesets import NodeSets
from mcml_service.xpath.nodes.numbering import Bools, Floats, Ints
from mcml_service.xpath.nodes.samples import Samples
from mcml_service.xpath.nodes.texts import Strings

Value: TypeAlias = NodeSets | Samples | Floats | Bools | Strings | Items
"""For each context a node set, a sample or none, one value, or a sequence."""


@dataclass(frozen=True, slots=True)
class Bound:
    """The value of a variable in the contexts where it was bound. rows: which of these each context now came from."""

    value: Value
    rows: Ints | None = None

    def now(self) -> Value:
        """The value for each context."""
        if self.rows is None:
            return self.value
        if isinstance(self.value, NodeSets):
            index = self.rows if self.value.index is None else self.value.index[self.rows]
            return replace(self.value, index=index)
        return self.value.at(self.rows) if isinstance(self.value, Items) else self.value[self.rows]

    def at(self, contexts: Ints) -> Bound:
        return Bound(self.value, contexts if self.rows is None else self.rows[contexts])


@dataclass(frozen=True, slots=True)
class Context:
    """Context nodes, and for each its position and the size of its list, if they are used."""

    nodes: Ints
    positions: Floats | None = None
    sizes: Floats | None = None
    variables: Mapping[str, Bound] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.nodes)

    def part(self, start: int, stop: int) -> Context:
        if self.variables:
            return self.at(np.arange(start, min(stop, len(self))))
        some = slice(start, stop)
        return Context(
            self.nodes[some],
            None if self.positions is None else self.positions[some],
            None if self.sizes is None else self.sizes[some],
        )

    def at(self, which: Ints) -> Context:
        """Some of the contexts, repeated or not."""
        return Context(
            self.nodes[which],
            None if self.positions is None else self.positions[which],
            None if self.sizes is None else self.sizes[which],
            self.variables_at(which),
        )

    def variables_at(self, which: Ints) -> Mapping[str, Bound]:
        """Return the variables in some of the contexts."""
        return {name: bound.at(which) for name, bound in self.variables.items()} if self.variables else {}

    def binding(self, name: str, value: Value) -> Context:
        """The same with one variable more."""
        return replace(self, variables={**self.variables, name: Bound(value)})


def own_set(context: Context) -> NodeSets:
    """Of each context its node."""
    return NodeSets(np.arange(len(context)), context.nodes, len(context))
