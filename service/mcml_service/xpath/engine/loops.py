"""Features after XPath 1.0, for all contexts together: `for`, `let`, `some`, `every`, `if`, `!`, sequences.

An item of a loop is a separate context inside the loop, with all outer variables; results are assigned back to the
contexts of their items. So each part of a body is evaluated once, for any number of items (loop lifting, Grust, Sakr
and Teubner 2004).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mcml_service.xpath.engine.context import Bound, Context, Value
from mcml_service.xpath.engine.functions import NotOnColumnsError
from mcml_service.xpath.engine.sequences import items_of, sorted_by, value_of
from mcml_service.xpath.language.meaning import ITEM
from mcml_service.xpath.language.tree import (
    Each,
    Expression,
    Filter,
    For,
    Function,
    If,
    Later,
    Let,
    Quantified,
    Sequence,
    Variable,
)
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.items import Items, concatenated, nothing
from mcml_service.xpath.nodes.nodesets import NodeSets, ordered
from mcml_service.xpath.nodes.numbering import Bools, Ints
from mcml_service.xpath.nodes.pairs import MAX_PAIRS, TooWideError
from mcml_service.xpath.nodes.texts import Strings

Evaluate = Callable[[Expression, Context], Value]


class Columns(Protocol):
    """The evaluator of the parts."""

    forest: Forest

    def value(self, expression: Expression, context: Context) -> Value: ...

    def truth(self, expression: Expression, context: Context) -> Bools: ...

    def kept(self, predicate: Expression, context: Context) -> Bools: ...


def later(columns: Columns, expression: Later, context: Context, evaluate: Evaluate) -> Value:
    """The value for each context. evaluate: evaluates what becomes part of it, as a value or as texts."""
    if isinstance(expression, Variable):
        if expression.name not in context.variables:
            raise NotOnColumnsError
        return context.variables[expression.name].now()
    if isinstance(expression, Sequence):
        everywhere = np.arange(len(context))
        parts = [(everywhere, items_of(evaluate(item, context))) for item in expression.items]
        return _together(parts, len(context))
    if isinstance(expression, If):
        return _branches(columns, expression, context, evaluate)
    if isinstance(expression, Let):
        return evaluate(
            expression.body, context.binding(expression.variable, columns.value(expression.source, context))
        )
    if isinstance(expression, Function):
        raise NotOnColumnsError
    items = items_of(columns.value(expression.source, context))
    if len(items) > MAX_PAIRS:
        raise TooWideError(len(items))
    if isinstance(expression, Each):
        found = evaluate(expression.body, as_contexts(items, context))
        return _at_contexts(found, items, in_document_order=expression.is_step)
    inside = context.at(items.groups).binding(expression.variable, value_of(each_alone(items)))
    if isinstance(expression, For) and expression.position:
        inside = inside.binding(expression.position, items.positions()[0])
    if isinstance(expression, For):
        return _at_contexts(evaluate(expression.body, inside), items)
    return _quantified(expression, items, columns.truth(expression.body, inside))


def each_alone(items: Items) -> Items:
    """Make each item a separate context."""
    return Items(np.arange(len(items)), items.column, len(items))


def as_contexts(items: Items, context: Context) -> Context:
    """The items as context, with their positions."""
    positions, sizes = items.positions()
    alone = value_of(each_alone(items))
    if isinstance(alone, NodeSets):
        return Context(alone.nodes, positions, sizes, context.variables_at(items.groups))
    inside = replace(context.at(items.groups), positions=positions, sizes=sizes)
    return replace(inside, variables={**inside.variables, ITEM: Bound(alone)})


def in_parts(items: Items, before: int, size: float) -> Context:
    """Items of one sequence as context, with their positions in it. before: the items before them. size: of all."""
    inside = as_contexts(items, Context(np.zeros(1, np.int64)))
    return replace(inside, positions=places_from(before, len(items)), sizes=np.full(len(items), size))


def places_from(before: int, count: int) -> NDArray[np.float64]:
    """Positions from the one after `before`."""
    return np.arange(before + 1, before + count + 1).astype(np.float64)


def filtered(columns: Columns, expression: Filter, context: Context) -> Value:
    """Apply predicates to a sequence of values, or of nodes in their own order."""
    items = items_of(columns.value(expression.operand, context))
    for predicate in expression.predicates:
        inside = as_contexts(items, context)
        items = items.chosen(columns.kept(predicate, inside))
    return value_of(items)


def sort(columns: Columns, arguments: tuple[Expression, ...], context: Context) -> Value:
    """`sort`: texts by code points, numbers by value, by each item itself or by a key."""
    items = items_of(columns.value(arguments[0], context))
    key: Value = value_of(each_alone(items))
    if len(arguments) == 3:
        function = arguments[2]
        if not isinstance(function, Function):
            raise NotOnColumnsError
        inside = context.at(items.groups).binding(function.variable, key)
        key = columns.value(function.body, inside)
    return sorted_by(columns.forest, items, key)


def _at_contexts(found: Value, outer: Items, *, in_document_order: bool = False) -> Value:
    """Return the results of all items of a loop as sequences of the items' contexts."""
    inner = items_of(found)
    groups = outer.groups[inner.groups]
    column = inner.column
    if in_document_order and inner.kind == "nodes" and not isinstance(column, Strings):
        return ordered(groups, column.astype(np.int64, copy=False), outer.count)
    return value_of(Items(groups, column, outer.count))


def _quantified(expression: Quantified, items: Items, holds: Bools) -> Bools:
    if expression.quantifier == "some":
        return items.sets.any(holds)
    return ~items.sets.any(~holds)


def _branches(columns: Columns, expression: If, context: Context, evaluate: Evaluate) -> Value:
    holds = columns.truth(expression.test, context)
    if holds.all() or not holds.any():
        return evaluate(expression.then if len(holds) and holds[0] else expression.otherwise, context)
    parts: list[tuple[Ints, Items]] = []
    singles: list[tuple[Ints, Value]] = []
    for part, which in ((expression.then, np.flatnonzero(holds)), (expression.otherwise, np.flatnonzero(~holds))):
        found = evaluate(part, context.at(which))
        singles.append((which, found))
        parts.append((which, items_of(found)))
    merged = _together(parts, len(context))
    if isinstance(merged, Items) and not any(isinstance(found, NodeSets | Items) for _, found in singles):
        return merged.column  # type: ignore[return-value]  # one value for each context, and none is a node
    return merged


def _together(parts: list[tuple[Ints, Items]], count: int) -> Value:
    found = concatenated(parts) if parts else nothing(count)
    if found is None:
        # Nodes and values, or values of several kinds.
        raise NotOnColumnsError
    return value_of(replace(found, count=count))
