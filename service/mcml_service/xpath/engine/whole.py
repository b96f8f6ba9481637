"""A scope as one sequence: functions of sequences, loops and sorting on the nodes of all its documents.

Outside of predicates an absolute path that a function of sequences or a loop takes is the node set of the whole scope.
Such functions are evaluated first, and replaced by their values (`Whole.reduced`); the rest is a constant, a node set,
one value a document (`asks_each`), or a sequence (`Whole.parts`), in parts of one kind.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial
from itertools import chain, groupby
from operator import itemgetter

import numpy as np

from mcml.errors import LimitError
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.engine import aggregates, sequences
from mcml_service.xpath.engine.column_source import ColumnSource
from mcml_service.xpath.engine.columns import Columns
from mcml_service.xpath.engine.context import Bound, Context
from mcml_service.xpath.engine.functions import NotOnColumnsError, as_booleans, as_numbers
from mcml_service.xpath.engine.loops import each_alone, in_parts, places_from
from mcml_service.xpath.engine.nearest_runs import best_runs
from mcml_service.xpath.engine.parts import MOST_ITEMS, Part, Parts, at, gathered, hold_parts, listed, values_of
from mcml_service.xpath.engine.scan import Scan
from mcml_service.xpath.engine.sequences import items_of, value_of
from mcml_service.xpath.engine.source import Nth, Source
from mcml_service.xpath.language.functions import SAFE_FUNCTIONS
from mcml_service.xpath.language.labels import without_index
from mcml_service.xpath.language.meaning import ITEM
from mcml_service.xpath.language.motion_functions import RUNS, TOP
from mcml_service.xpath.language.reach import HeadPart
from mcml_service.xpath.language.rules import normal
from mcml_service.xpath.language.scopes import asks_each, asks_scope, begins_paths, is_node_set, put
from mcml_service.xpath.language.tree import (
    OF_NODES,
    Call,
    Each,
    Expression,
    Filter,
    For,
    Function,
    If,
    Let,
    Operation,
    Path,
    Quantified,
    Sequence,
    Step,
    free_variables,
    walk,
    with_children,
)
from mcml_service.xpath.language.types import distinct_of, type_of
from mcml_service.xpath.language.values import literal, require_room, sequence_of
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.groups import Group
from mcml_service.xpath.library.motion_notes import motion_calls
from mcml_service.xpath.nodes.items import Items, concatenated, nothing
from mcml_service.xpath.nodes.nodesets import one_set
from mcml_service.xpath.nodes.numbering import Ints
from mcml_service.xpath.nodes.pairs import TooWideError
from mcml_service.xpath.nodes.texts import Strings

TOGETHER = 32_768
"""Items of a loop that are looked at together."""
MOST_LITERALS = 10_000
"""Limit of values that replace an expression."""
MOST_SORTED_NODES = 100_000
SINGLE = frozenset({"count", "sum", "min", "max", "avg", "exists", "empty", "string-join"})
"""Functions that make one value of a sequence."""


class Whole:
    """Evaluates over all documents of a scope together. source: where the nodes of an expression come from. is_later:
    numbers become texts as XPath 2.0 writes them. check: called often; raises when time is up."""

    def __init__(
        self,
        tx: Transaction,
        caches: Caches,
        source: Callable[[Expression], Scan | ColumnSource],
        check: Callable[[], None],
        *,
        is_later: bool,
    ) -> None:
        self._source = source
        self._check = check
        self._is_later = is_later
        self.nowhere = Forest(tx, Group([]), caches, head_part=HeadPart.MOTION)

    def nodes(self, expression: Expression) -> Source:
        """The nodes of an expression; `(…)[n]` counts over all documents."""
        tree, nth = without_index(expression)
        source: Source = self._source(tree) if is_node_set(tree) else Parts(self.parts(tree))
        return source if nth is None else Nth(source, nth)

    def constant(self, expression: Expression) -> Items:
        """The sequence that an expression is in every document."""
        columns = self._columns(self.nowhere)
        return items_of(columns.value(expression, _alone(np.zeros(1, np.int64))))

    # -- values replacing functions --------------------------------------------------------------------------

    def reduced(self, expression: Expression) -> Expression:
        """The expression with the values of all functions of sequences of the scope in it."""
        if isinstance(expression, Path | Filter | Function) or not asks_scope(expression):
            return expression
        if isinstance(expression, Let):
            return self.reduced(self._let(expression))
        if free_variables(expression) or asks_each(expression):
            return with_children(expression, self.reduced)
        if isinstance(expression, Quantified):
            return self._truth(expression)
        if isinstance(expression, Call) and expression.function in SINGLE:
            return self._single(expression)
        expression = with_children(expression, self.reduced)
        takes_values = (isinstance(expression, Operation) and expression.operator not in OF_NODES) or (
            isinstance(expression, Call) and not SAFE_FUNCTIONS[expression.function].takes_items
        )
        return with_children(expression, self._literals) if takes_values else expression

    def _single(self, call: Call) -> Expression:
        """Evaluate one of `SINGLE`."""
        inner, *others = (
            argument if place == 0 else self.reduced(argument) for place, argument in enumerate(call.arguments)
        )
        plain = aggregates.aggregated(Call(call.function, (inner, *others)))
        if plain is not None and is_node_set(distinct_of(plain) or inner):
            return self._aggregate(plain)
        found = self.parts(self.reduced(inner))
        if call.function == "count":
            return literal(float(sum(map(len, found))))
        if call.function in aggregates.TRUTH_AGGREGATES:
            return literal(any(map(len, found)) == (call.function == "exists"))
        parts = hold_parts(found)
        as_number = call.function != "string-join"
        joined = self._joined([replace(part, column=values_of(part, as_number=as_number)) for part in parts])
        values = [value_of(joined), *(value_of(self.constant(other)) for other in others)]
        function = sequences.call_on_bodies if motion_calls(call) else sequences.call
        return _sequence(items_of(function(self.nowhere, call.function, values)))

    def _aggregate(self, call: Call) -> Expression:
        found = aggregates.value(call, self._source(distinct_of(call) or call.arguments[0]))
        return Sequence(()) if found is None else literal(found)

    def _truth(self, expression: Quantified) -> Expression:
        test = For(expression.variable, expression.source, Call("boolean", (expression.body,)))
        found = [part.column for part in self.parts(self.reduced(test))]
        holds = np.concatenate([np.asarray(column, bool) for column in found] or [np.empty(0, bool)])
        return literal(bool(holds.any() if expression.quantifier == "some" else holds.all()))

    def _let(self, expression: Let) -> Expression:
        """Replace the variable by its expression; inside predicates by its values."""
        source = self.reduced(expression.source)
        require_room(expression, source)
        values = cache(lambda: self.values(source))
        return normal(put(expression.body, expression.variable, source, values))

    def _literals(self, expression: Expression) -> Expression:
        """Return the values of a sequence of the scope, if values are needed."""
        if type_of(expression) not in ("sequence", "strings") or isinstance(expression, Sequence):
            return expression
        if free_variables(expression) or not asks_scope(expression) or asks_each(expression):
            return expression
        return self.values(expression)

    def values(self, expression: Expression) -> Expression:
        """The values of a sequence, written out."""
        found: list[float | str | bool] = []
        for part in self.parts(self.reduced(expression)):
            found += listed(values_of(part, as_number=False) if part.are_nodes else part.column)
            if len(found) > MOST_LITERALS:
                raise LimitError(
                    f"A sequence inside of an expression has more than {MOST_LITERALS:,} values.",
                    remedy="Narrow it by a predicate, or write distinct-values() around it.",
                    code="query-too-large",
                )
        return sequence_of(found)

    # -- sequences -------------------------------------------------------------------------------------------------

    def parts(self, expression: Expression) -> Iterator[Part]:
        """The items of a reduced expression, some at a time."""
        self._check()
        is_set = is_node_set(expression)
        if isinstance(expression, Path) and expression.start is not None and not is_set:
            yield from self._onward(expression.start, expression.steps)
        elif is_set or (type_of(expression) == "nodes" and without_index(expression)[1] is not None):
            yield from (Part(forest, nodes) for forest, nodes in self.nodes(expression).chunks())
        elif isinstance(expression, Operation) and expression.operator == "|":
            yield from self._onward(Sequence(expression.operands), (Step("self", "node()"),))
        elif isinstance(expression, Sequence):
            for item in expression.items:
                yield from self.parts(item)
        elif isinstance(expression, If):
            holds = bool(as_booleans(value_of(self.constant(expression.test)))[0])
            yield from self.parts(expression.then if holds else expression.otherwise)
        elif not asks_scope(expression):
            yield Part(self.nowhere, self.constant(expression).column)
        elif isinstance(expression, For | Each):
            yield from self._loop(expression)
        elif isinstance(expression, Filter):
            yield from self._filtered(expression)
        elif isinstance(expression, Call):
            yield from self._call(expression)
        else:
            raise NotOnColumnsError

    def _onward(self, start: Expression, steps: tuple[Step, ...]) -> Iterator[Part]:
        """Steps from the nodes of a sequence; they are in document order, as those of all paths."""
        for forest, nodes in gathered(self.parts(start)):
            yield Part(forest, self._columns(forest).steps(one_set(nodes), steps).nodes)

    def _loop(self, expression: For | Each) -> Iterator[Part]:
        variable = expression.variable if isinstance(expression, For) else ITEM
        together = not asks_scope(expression.body)
        if not together and isinstance(expression, For) and expression.position:
            raise NotOnColumnsError
        position = 0
        sized = isinstance(expression, Each) and any(part == Call("last") for part in walk(expression.body))
        total = sum(map(len, self.parts(expression.source))) if sized else None
        for part in self.parts(expression.source):
            if together:
                yield from self._slices(expression, part, position, total)
            else:
                yield from chain.from_iterable(self._one_by_one(expression.body, variable, part))
            position += len(part)

    def _slices(self, expression: For | Each, part: Part, position: int, total: int | None) -> Iterator[Part]:
        """Yield the results of a body for the items of a part, in batches."""
        for start in range(0, len(part), TOGETHER):
            some = part.chosen(np.arange(start, min(start + TOGETHER, len(part))))
            yield from self._slice(expression, some, position + start, total)

    def _slice(self, expression: For | Each, part: Part, position: int, total: int | None) -> Iterator[Part]:
        alone = value_of(each_alone(part.items))
        if isinstance(expression, For):
            nodes = np.asarray(part.column, np.int64) if part.are_nodes else np.zeros(len(part), np.int64)
            inside = replace(_alone(nodes), variables={expression.variable: Bound(alone)})
            if expression.position:
                inside = inside.binding(expression.position, places_from(position, len(part)))
        else:
            inside = in_parts(part.items, position, float(total or 0))
        try:
            found = items_of(self._columns(part.forest).value(expression.body, inside))
        except TooWideError:
            if len(part) < 2:
                raise
            half = len(part) // 2
            yield from self._slice(expression, part.chosen(np.arange(half)), position, total)
            yield from self._slice(expression, part.chosen(np.arange(half, len(part))), position + half, total)
            return
        if len(found):
            of = np.asarray(part.column, np.int64)[found.groups] if part.are_nodes else None
            yield Part(part.forest, found.column, None if found.kind == "nodes" else of)

    def _one_by_one(self, body: Expression, variable: str, part: Part) -> Iterator[list[Part]]:
        """Evaluate a body that queries the scope again for each item, once for each distinct item."""
        if part.are_nodes and begins_paths(body, variable):
            raise NotOnColumnsError
        column = values_of(part, as_number=False) if part.are_nodes else part.column
        known: dict[float | str | bool, list[Part]] = {}
        for item in listed(column):
            if item not in known:
                written = literal(item)
                asked = normal(put(body, variable, written, partial(_same, written)))
                known[item] = list(self.parts(self.reduced(asked)))
            yield known[item]

    def _filtered(self, expression: Filter) -> Iterator[Part]:
        parts = hold_parts(self.parts(expression.operand))
        for predicate in expression.predicates:
            parts = list(self._where(predicate, parts))
        yield from parts

    def _where(self, predicate: Expression, parts: list[Part]) -> Iterator[Part]:
        size = float(sum(map(len, parts)))
        position = 0
        if not any(part.are_nodes for part in parts):
            # Values belong to no document, so a path in a condition on them asks all documents.
            predicate = self.reduced(predicate)
        for part in parts:
            self._check()
            inside = in_parts(part.items, position, size)
            yield part.chosen(self._columns(part.forest).kept(predicate, inside))
            position += len(part)

    def _call(self, call: Call) -> Iterator[Part]:
        """A function that gives a sequence."""
        name, arguments = call.function, call.arguments
        if name == TOP:
            yield from self._top(call)
            return
        if name == RUNS:
            for forest, nodes in gathered(self.parts(arguments[0])):
                yield Part(forest, self._columns(forest).motions.runs(one_set(nodes), arguments[1:]).nodes)
            return
        if name == "distinct-values" and is_node_set(arguments[0]):
            texts = aggregates.distinct(self._source(arguments[0]))
            yield Part(self.nowhere, Strings(np.arange(len(texts)), texts))
            return
        parts = hold_parts(self.parts(arguments[0]))
        if name in ("distinct-values", "data", "index-of"):
            atoms = [replace(p, column=values_of(p, as_number=False)) if p.are_nodes else p for p in parts]
            others = [value_of(self.constant(each)) for each in arguments[1:]]
            found = items_of(sequences.call(self.nowhere, name, [value_of(self._joined(atoms)), *others]))
            yield Part(self.nowhere, found.column)
        elif name == "sort":
            yield from self._sorted(parts, arguments)
        elif SAFE_FUNCTIONS[name].selects:
            # Items are represented by their indices.
            count = sum(map(len, parts))
            places = Items(np.zeros(count, np.int64), np.arange(count).astype(np.float64), 1)
            others = [value_of(self.constant(each)) for each in arguments[1:]]
            chosen = items_of(sequences.call(self.nowhere, name, [places, *others])).column
            yield from at(parts, np.asarray(chosen).astype(np.int64))
        else:
            raise NotOnColumnsError

    def _top(self, call: Call) -> Iterator[Part]:
        """The best runs of all documents, the best one first."""
        wanted, frames, *keys = call.arguments
        count = float(as_numbers(self.nowhere, value_of(self.constant(wanted)))[0])
        runs = best_runs(int(min(count, MOST_ITEMS)) if count >= 1 else 0, keys[0] if keys else None)
        for forest, nodes in self._by_forest(frames):
            runs.add(self._columns(forest), nodes)
        yield from (Part(forest, nodes) for forest, nodes in runs.best())

    def _by_forest(self, expression: Expression) -> Iterator[tuple[Forest, Ints]]:
        """All nodes in document order."""
        if not is_node_set(expression):
            yield from gathered(self.parts(self.reduced(expression)))
            return
        for forest, chunks in groupby(self.nodes(expression).chunks(), itemgetter(0)):
            yield forest, np.concatenate([nodes for _, nodes in chunks])

    def _sorted(self, parts: list[Part], arguments: tuple[Expression, ...]) -> Iterator[Part]:
        keys: list[Part] = []
        count = 0
        # Items without a key come first.
        with_key = [np.zeros(0, np.int64)]
        for part in parts:
            for rows, found in self._keys(part, arguments):
                keys.append(replace(found, column=values_of(found, as_number=False)) if found.are_nodes else found)
                with_key.append(rows + count)
            count += len(part)
        if any(part.are_nodes for part in parts) and count > MOST_SORTED_NODES:
            raise LimitError(f"More than {MOST_SORTED_NODES:,} nodes cannot be sorted.", remedy="Narrow them.")
        places = Items(np.zeros(count, np.int64), np.arange(count).astype(np.float64), 1)
        key_items = Items(np.concatenate(with_key), self._joined(keys).column, count)
        order = items_of(sequences.sorted_by(self.nowhere, places, value_of(key_items))).column
        yield from at(parts, np.asarray(order).astype(np.int64))

    def _keys(self, part: Part, arguments: tuple[Expression, ...]) -> Iterator[tuple[Ints, Part]]:
        """Yield the places of items that have a key to sort by, and these keys."""
        key = each_alone(part.items)
        if len(arguments) == 3:
            function = arguments[2]
            if not isinstance(function, Function):
                raise NotOnColumnsError
            if asks_scope(function.body):
                for place, answer in enumerate(self._one_by_one(function.body, function.variable, part)):
                    some = [found for found in answer if len(found)]
                    if sum(map(len, some)) > 1:
                        raise NotOnColumnsError
                    yield from ((np.array([place]), found) for found in some)
                return
            inside = replace(_alone(np.zeros(len(part), np.int64)), variables={function.variable: Bound(value_of(key))})
            key = items_of(self._columns(part.forest).value(function.body, inside))
            if (np.diff(key.groups) == 0).any():
                raise NotOnColumnsError
        yield key.groups, Part(part.forest, key.column)

    def _joined(self, parts: list[Part]) -> Items:
        """Parts of values as one sequence. NotOnColumnsError where they are of several kinds."""
        found = concatenated([(np.zeros(1, np.int64), part.items) for part in parts]) if parts else nothing(1)
        if found is None:
            raise NotOnColumnsError
        return found

    def _columns(self, forest: Forest) -> Columns:
        return Columns(forest, self._check, is_later=self._is_later)


def _alone(nodes: Ints) -> Context:
    """Context nodes each of which is the only item of its list, as a document is."""
    return Context(nodes, np.ones(len(nodes)), np.ones(len(nodes)))


def _same(value: Expression) -> Expression:
    return value


def _sequence(items: Items) -> Expression:
    return sequence_of(list(listed(items.column)))
