"""Expressions of XPath 1.0 on columns: each part is evaluated once, for all its context nodes together.

This is loop lifting (Grust, Sakr and Teubner 2004, "XQuery on SQL hosts"): an expression inside a predicate gets all
candidates as context nodes at once, and its value is an array with an item for each of them. Paths that cannot depend
on the context node but by its document, or that begin with a step to the parent, are evaluated once for each document
or parent. Candidates are taken in slices, so that memory is bounded by the slice.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from service.mcml.vocabulary import FRAME_BONE
from service.numerics.runs import find_equal
from service.xpath.engine import functions
from service.xpath.engine.axes import REVERSE, are_frames, named_bones, parents, sibling_frames, step
from service.xpath.engine.comparisons import compare
from service.xpath.engine.existence import Beyond
from service.xpath.engine.windows import Windows
from service.xpath.language.labels import named
from service.xpath.language.positions import frame_distance, is_beyond, is_window, window_of
from service.xpath.language.tree import (
    Call,
    Expression,
    Filter,
    Literal,
    Operation,
    Path,
    Step,
    Written,
    depends_on_position,
    type_of,
)
from service.xpath.library.forest import Forest
from service.xpath.nodes.nodesets import NodeSets, ordered
from service.xpath.nodes.numbering import Bools, Floats, Ints, documents_of, first_of_documents
from service.xpath.nodes.pairs import TooWideError, expand
from service.xpath.nodes.texts import Strings, constant

SLICE = 10_000
"""Candidates of a predicate that are looked at together."""

Value: TypeAlias = NodeSets | Floats | Bools | Strings


@dataclass(frozen=True, slots=True)
class Context:
    """Context nodes, and for each its position and the size of its list, where anything asks for them."""

    nodes: Ints
    positions: Floats | None = None
    sizes: Floats | None = None

    def __len__(self) -> int:
        return len(self.nodes)

    def part(self, start: int, stop: int) -> Context:
        some = slice(start, stop)
        return Context(
            self.nodes[some],
            None if self.positions is None else self.positions[some],
            None if self.sizes is None else self.sizes[some],
        )


class Columns:
    """Evaluates expressions over the documents of a forest. check: called often; raises when time is up."""

    def __init__(self, forest: Forest, check: Callable[[], None] = lambda: None) -> None:
        self.forest = forest
        self.check = check
        self._asked: dict[Path, Beyond] = {}
        self._near: dict[Path, Windows] = {}

    def documents(self) -> Context:
        """Every document node as context."""
        nodes = first_of_documents(np.arange(len(self.forest)))
        return Context(nodes, np.ones(len(nodes)), np.ones(len(nodes)))

    def value(self, expression: Expression, context: Context) -> Value:
        """The value for each context node: node sets, numbers, booleans, or strings."""
        self.check()
        if isinstance(expression, Literal):
            if isinstance(expression.value, str):
                return constant(expression.value, len(context))
            return np.broadcast_to(np.float64(expression.value), len(context))
        if isinstance(expression, Written):
            raise functions.NotOnColumnsError
        if isinstance(expression, Path):
            return self._path(expression, context)
        if isinstance(expression, Filter):
            return self._filter(expression, context)
        shared = self._once_a_document(expression, context)
        if shared is not None:
            return shared
        if isinstance(expression, Operation):
            return self._operation(expression, context)
        return self._call(expression, context)

    def nodes(self, expression: Expression, context: Context) -> NodeSets:
        found = self.value(expression, context)
        if not isinstance(found, NodeSets):
            raise TypeError("no node set")
        return found

    def numbers(self, expression: Expression, context: Context) -> Floats:
        return functions.as_numbers(self.forest, self.value(expression, context))

    def strings(self, expression: Expression, context: Context) -> Strings:
        return functions.as_strings(self.forest, self.value(expression, context))

    def truth(self, expression: Expression, context: Context) -> Bools:
        """The value as a boolean; a number is not a position here."""
        if isinstance(expression, Path) and is_beyond(expression):
            return self._beyond(expression, context)
        if isinstance(expression, Path) and is_window(expression) and are_frames(context.nodes):
            return np.asarray(self._window(expression, context) > 0)
        return functions.as_booleans(self.value(expression, context))

    # -- paths -----------------------------------------------------------------------------------------------------

    def _path(self, path: Path, context: Context) -> NodeSets:
        steps = path.steps
        count = len(context)
        if path.absolute:
            documents, index = np.unique(documents_of(context.nodes), return_inverse=True)
            start = first_of_documents(documents)
            found = self.steps(ordered(np.arange(len(start)), start, len(start)), steps)
            if len(start) == count:
                return found
            return NodeSets(found.groups, found.nodes, found.count, index.reshape(-1).astype(np.int64))
        if path.start is not None:
            sets = self.nodes(path.start, context)
            found = self.steps(NodeSets(sets.groups, sets.nodes, sets.count), steps)
            return NodeSets(found.groups, found.nodes, found.count, sets.index)
        if count > 1 and steps and steps[0].axis == "parent" and not steps[0].predicates:
            return self._by_parent(steps, context)
        return self.steps(NodeSets(np.arange(count), context.nodes, count), steps)

    def _by_parent(self, steps: tuple[Step, ...], context: Context) -> NodeSets:
        """The rest of a path is the same for all children of one parent."""
        above, index = np.unique(parents(self.forest, context.nodes), return_inverse=True)
        kept = above >= 0
        groups = np.flatnonzero(kept)
        own = steps[0]
        at_parent = Step("self", own.name, span=own.span)
        found = self.steps(NodeSets(groups, above[kept], len(above)), (at_parent, *steps[1:]))
        return NodeSets(found.groups, found.nodes, found.count, index.reshape(-1).astype(np.int64))

    def steps(self, sets: NodeSets, steps: tuple[Step, ...]) -> NodeSets:
        """Steps from node sets that have a group for each context node."""
        for one in steps:
            self.check()
            predicates = one.predicates
            name = bone_name(one)
            distance = frame_distance(one)
            if name is not None:
                source, reached = named_bones(self.forest, sets.nodes, name)
                predicates = predicates[1:]
            elif distance is not None and are_frames(sets.nodes):
                source, reached = sibling_frames(self.forest, sets.nodes, distance)
                predicates = predicates[1:]
            else:
                source, reached = step(self.forest, sets.nodes, one.axis, one.name)
            for predicate in predicates:
                keep = self._kept(predicate, source, reached, reverse=one.axis in REVERSE)
                source, reached = source[keep], reached[keep]
            sets = ordered(sets.groups[source], reached, sets.count)
        return sets

    def _filter(self, expression: Filter, context: Context) -> NodeSets:
        sets = self.nodes(expression.operand, context)
        groups, nodes = sets.groups, sets.nodes
        for predicate in expression.predicates:
            keep = self._kept(predicate, groups, nodes, reverse=False)
            groups, nodes = groups[keep], nodes[keep]
        return NodeSets(groups, nodes, sets.count, sets.index)

    def filtered(self, groups: Ints, nodes: Ints, predicates: tuple[Expression, ...]) -> Ints:
        """The nodes that predicates keep. groups: whose list each is in, ascending."""
        for predicate in predicates:
            keep = self._kept(predicate, groups, nodes, reverse=False)
            groups, nodes = groups[keep], nodes[keep]
        return nodes

    def _kept(self, predicate: Expression, groups: Ints, nodes: Ints, *, reverse: bool) -> Bools:
        """Which candidates a predicate keeps. groups: whose list each candidate is in, ascending."""
        if not len(nodes):
            return np.zeros(0, bool)
        if type_of(predicate) == "number" or depends_on_position(predicate):
            positions, sizes = _positions(groups, reverse=reverse)
            return self._sliced(predicate, Context(nodes, positions, sizes))
        if (np.diff(nodes) > 0).all():
            return self._sliced(predicate, Context(nodes))
        distinct, inverse = np.unique(nodes, return_inverse=True)
        return self._sliced(predicate, Context(distinct))[inverse.reshape(-1)]

    def _sliced(self, predicate: Expression, context: Context) -> Bools:
        parts = [self._holds(predicate, context.part(at, at + SLICE)) for at in range(0, len(context), SLICE)]
        return parts[0] if len(parts) == 1 else np.concatenate([*parts, np.empty(0, bool)])

    def _holds(self, predicate: Expression, context: Context) -> Bools:
        """A slice of candidates; of those that reach too much together, each half alone."""
        self.check()
        try:
            if type_of(predicate) == "number":
                return np.asarray(self.numbers(predicate, context) == context.positions)
            return self.truth(predicate, context)
        except TooWideError:
            if len(context) < 2:
                raise
        half = len(context) // 2
        first, second = context.part(0, half), context.part(half, len(context))
        return np.concatenate([self._holds(predicate, first), self._holds(predicate, second)])

    # -- operators and functions -----------------------------------------------------------------------------------

    def _once_a_document(self, expression: Expression, context: Context) -> Value | None:
        """The value of what does not depend on the context node but by its document, where that saves anything."""
        if len(context) < 2 or not _by_document(expression):
            return None
        documents, index = np.unique(documents_of(context.nodes), return_inverse=True)
        if len(documents) == len(context):
            return None
        index = index.reshape(-1)
        nodes = first_of_documents(documents)
        found = self.value(expression, Context(nodes, np.ones(len(nodes)), np.ones(len(nodes))))
        if isinstance(found, NodeSets):
            return NodeSets(
                found.groups, found.nodes, found.count, index if found.index is None else found.index[index]
            )
        return found[index]

    def _beyond(self, path: Path, context: Context) -> Bools:
        """Whether a path that begins on a sibling, following or preceding axis reaches anything."""
        first, rest = path.steps[0], path.steps[1:]
        if path not in self._asked:

            def kept(nodes: Ints) -> Bools:
                keep = np.ones(len(nodes), bool)
                for predicate in first.predicates:
                    index = np.flatnonzero(keep)
                    keep[index] = self._sliced(predicate, Context(nodes[index]))
                if rest:
                    index = np.flatnonzero(keep)
                    keep[index] = self._sliced(Path(rest), Context(nodes[index]))
                return keep

            self._asked[path] = Beyond(self.forest, first.axis, first.name, kept)
        return self._asked[path].exists(context.nodes)

    def _window(self, path: Path, context: Context) -> Ints:
        """Of each frame how many frames of a window a path reaches that hold what the rest of the path asks for."""
        first, rest = path.steps[0], path.steps[1:]
        window = window_of(first)
        if path not in self._near and window is not None:
            asked = (*first.predicates[1:], *([Path(rest)] if rest else []))

            def kept(frames: Ints) -> Bools:
                keep = np.ones(len(frames), bool)
                for predicate in asked:
                    index = np.flatnonzero(keep)
                    keep[index] = self._sliced(predicate, Context(frames[index]))
                return keep

            self._near[path] = Windows(self.forest, first, window, kept)
        return self._near[path].counts(context.nodes)

    def _operation(self, operation: Operation, context: Context) -> Value:
        operator, operands = operation.operator, operation.operands
        if operator in ("or", "and"):
            return self._logic(operator, operands, context)
        if operator == "|":
            whole = self.nodes(operands[0], context)
            for operand in operands[1:]:
                self.check()
                whole = _union(whole, self.nodes(operand, context))
            return whole
        if operator == "negate":
            return np.asarray(-self.numbers(operands[0], context))
        if operator in functions.COMPARISONS:
            left: Value = self.value(operands[0], context)
            for operand in operands[1:]:
                right = self.value(operand, context)
                if operator == "!=":
                    _check_something(operands, [left, right])
                left = compare(self.forest, operator, left, right)
            return left
        result = self.numbers(operands[0], context)
        for operand in operands[1:]:
            result = functions.arithmetic(operator, result, self.numbers(operand, context))
        return result

    def _logic(self, operator: str, operands: tuple[Expression, ...], context: Context) -> Bools:
        """Operands one after the other, each only for the candidates that are not decided."""
        result = np.full(len(context), operator == "and")
        open_ = np.arange(len(context))
        for operand in operands:
            if not len(open_):
                break
            some = context if len(open_) == len(context) else _chosen(context, open_)
            found = self.truth(operand, some)
            decided = found if operator == "or" else ~found
            result[open_[decided]] = operator == "or"
            open_ = open_[~decided]
        return result

    def _call(self, call: Call, context: Context) -> Value:
        name, arguments = call.function, call.arguments
        if name in ("position", "last"):
            asked = context.positions if name == "position" else context.sizes
            if asked is None:
                raise TypeError("position() without positions")
            return asked
        if name in ("boolean", "not", "exists", "empty") and isinstance(arguments[0], Path):
            found = self.truth(arguments[0], context)
            return ~found if name in ("not", "empty") else found
        near = arguments[0] if name == "count" and is_window(arguments[0]) else None
        if isinstance(near, Path) and len(near.steps) == 1 and are_frames(context.nodes):
            return self._window(near, context).astype(np.float64)
        if not arguments and name in functions.OF_CONTEXT:
            own: Value = NodeSets(np.arange(len(context)), context.nodes, len(context))
            return functions.call(self.forest, name, [own], len(context))
        values = [self.value(each, context) for each in arguments]
        if name not in _OF_NUMBERS:
            _check_something(arguments, values)
        return functions.call(self.forest, name, values, len(context))


def _union(one: NodeSets, other: NodeSets) -> NodeSets:
    if one.index is not None or other.index is not None:
        one, other = one.flat()[0], other.flat()[0]
    return ordered(np.concatenate([one.groups, other.groups]), np.concatenate([one.nodes, other.nodes]), one.count)


def bone_name(step: Step) -> str | None:
    """B of `child::frame_bone[@name='B'][…]…`: such frame_bones are found without looking at the others."""
    is_bone = step.axis == "child" and step.name == FRAME_BONE and step.predicates
    return named(step.predicates[0]) if is_bone else None


def _chosen(context: Context, which: Ints) -> Context:
    return Context(
        context.nodes[which],
        None if context.positions is None else context.positions[which],
        None if context.sizes is None else context.sizes[which],
    )


def _positions(groups: Ints, *, reverse: bool) -> tuple[Floats, Floats]:
    """Position and size of the list for each candidate; lists are neighbours, in document order."""
    sizes = np.diff(find_equal(groups)).reshape(-1)
    _, within = expand(sizes)
    size = np.repeat(sizes, sizes).astype(np.float64)
    return np.asarray(size - within if reverse else within + 1.0, np.float64), size


_OF_NUMBERS = frozenset({"number", "floor", "ceiling", "round", "abs", "boolean", "not"})
"""Functions to which nothing is what NaN is."""


def _check_something(operands: Sequence[Expression], values: Sequence[Value]) -> None:
    """The least, greatest or mean of nothing is NaN on columns, but nothing in XPath 2.0: no string, different from no
    value. Only Saxon tells them apart."""
    for operand, value in zip(operands, values, strict=False):
        extreme = isinstance(operand, Call) and operand.function in ("min", "max", "avg")
        if extreme and isinstance(value, np.ndarray) and np.isnan(value).any():
            raise functions.NotOnColumnsError


def _by_document(expression: Expression) -> bool:
    """Whether the value depends on nothing but the document of the context node."""
    if isinstance(expression, Literal):
        return True
    if isinstance(expression, Path):
        return expression.absolute or (expression.start is not None and _by_document(expression.start))
    if isinstance(expression, Filter):
        return _by_document(expression.operand)
    if isinstance(expression, Written):
        return False
    if isinstance(expression, Call):
        own = expression.function in ("position", "last", "lang") or (
            not expression.arguments and expression.function in functions.OF_CONTEXT
        )
        return not own and all(_by_document(argument) for argument in expression.arguments)
    return all(_by_document(operand) for operand in expression.operands)
