"""Expressions of XPath 1.0 on columns: each part is evaluated once, for all its context nodes together.

This is loop lifting (Grust, Sakr and Teubner 2004, "XQuery on SQL hosts"): an expression inside a predicate gets all
candidates as context nodes at once, and its value is an array with an item for each of them. Paths that cannot depend
on the context node but by its document, or that begin with a step to the parent, are evaluated once for each document
or parent. Candidates are taken in slices, so that memory is bounded by the slice.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial, reduce
from types import MappingProxyType

import numpy as np

from mcml_service.xpath.engine import functions, loops, sequences
from mcml_service.xpath.engine.axes import REVERSE, are_frames, frames_at, named_bones, parents, sibling_frames, step
from mcml_service.xpath.engine.comparisons import compare, compare_items
from mcml_service.xpath.engine.context import Bound, Context, Value, own_set
from mcml_service.xpath.engine.motion.motion_windows import MotionWindows
from mcml_service.xpath.engine.motion.motions import Motions
from mcml_service.xpath.engine.motion.neighbours import Neighbours
from mcml_service.xpath.engine.samples.frame_bones import FrameBones, start_of
from mcml_service.xpath.engine.sequences import items_of, texts
from mcml_service.xpath.language.functions import OF_CONTEXT, SAFE_FUNCTIONS
from mcml_service.xpath.language.labels import bone_name
from mcml_service.xpath.language.motion_functions import MOTION_FUNCTIONS
from mcml_service.xpath.language.positions import frame_distance, frame_place, is_beyond, is_window
from mcml_service.xpath.language.tree import (
    VALUE_COMPARISONS,
    Call,
    Expression,
    Filter,
    Later,
    Literal,
    Operation,
    Path,
    Quantified,
    Step,
    Variable,
    Written,
    free_variables,
    predicates_of,
)
from mcml_service.xpath.language.types import (
    depends_on_position,
    is_integer,
    is_of_document,
    is_of_variables,
    item_type,
    type_of,
)
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.motion_notes import motion_calls
from mcml_service.xpath.nodes.items import Items
from mcml_service.xpath.nodes.nodesets import NodeSets, ordered, positions_of, shared_nodes, union
from mcml_service.xpath.nodes.numbering import Bools, Floats, Ints, documents_of, first_of_documents
from mcml_service.xpath.nodes.pairs import TooWideError
from mcml_service.xpath.nodes.texts import Strings, constant, of_numbers, to_later_text

SLICE = 32_768
"""Candidates of a predicate that are looked at together."""


class Columns:
    """Evaluates expressions over the documents of a forest; without one, absolute paths have no answer here.

    check: called often; raises when time is up. is_later: numbers become texts as XPath 2.0 writes them.
    """

    def __init__(self, forest: Forest, check: Callable[[], None] = lambda: None, *, is_later: bool = False) -> None:
        self.forest = forest
        self.check = check
        self._is_later = is_later
        self._neighbours = Neighbours(self)
        self._bones = FrameBones(self)
        self.motions = Motions(self)
        self._windows = MotionWindows(self, self.motions)

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
        if isinstance(expression, Path):
            return self._path(expression, context)
        if isinstance(expression, Filter):
            return self._filter(expression, context)
        shared = self._once_a_document(expression, context)
        if shared is not None:
            return shared
        start = start_of(expression) if context.variables else None
        frames = None if start is None else self.nodes(start, context)
        together = self._bones.value(expression, context, frames, partial(self.value, expression))
        if together is not None:
            return together
        if isinstance(expression, Operation):
            return self._operation(expression, context)
        if isinstance(expression, Call):
            return self._call(expression, context)
        if isinstance(expression, Written):
            raise functions.NotOnColumnsError
        return loops.later(self, expression, context, self.value)

    def nodes(self, expression: Expression, context: Context) -> NodeSets:
        found = self.value(expression, context)
        if not isinstance(found, NodeSets):
            # Expressions that may give nodes or values are decided here: an empty sequence is not a node set either.
            items = items_of(found)
            if len(items):
                raise functions.NotOnColumnsError
            return NodeSets(items.groups, items.groups, items.count)
        return found

    def numbers(self, expression: Expression, context: Context) -> Floats:
        return functions.as_numbers(self.forest, self.value(expression, context))

    def strings(self, expression: Expression, context: Context) -> Strings:
        return functions.as_strings(self.forest, self._written(expression, self.value(expression, context)))

    def texts(self, expression: Expression, context: Context) -> Value:
        """The items of a sequence as texts, nodes and values side by side."""
        if isinstance(expression, Later) and not isinstance(expression, Variable | Quantified):
            return loops.later(self, expression, context, self.texts)
        items = items_of(self._written(expression, self.value(expression, context)))
        return Items(items.groups, texts(self.forest, items), items.count)

    def _written(self, expression: Expression, value: Value) -> Value:
        """Numbers as texts, where XPath 2.0 writes them otherwise."""
        numbers = value.column if isinstance(value, Items) else value
        if not self._is_later or not isinstance(numbers, np.ndarray) or numbers.dtype.kind != "f":
            return value
        found = of_numbers(numbers.astype(np.float64), partial(to_later_text, is_integer=is_integer(expression)))
        return Items(value.groups, found, value.count) if isinstance(value, Items) else found

    def truth(self, expression: Expression, context: Context) -> Bools:
        """The value as a boolean; a number is not a position here."""
        shared = not context.variables or not free_variables(expression)
        if shared and isinstance(expression, Path) and is_beyond(expression):
            return self._neighbours.beyond(expression, context.nodes)
        if shared and isinstance(expression, Path) and is_window(expression) and are_frames(context.nodes):
            return np.asarray(self._neighbours.window(expression, context.nodes) > 0)
        around = self._windows.counts(expression, context) if isinstance(expression, Path | Filter | Call) else None
        if around is not None:
            return np.asarray(around > 0)
        if shared and isinstance(expression, Path) and expression.start is None:
            together = self._bones.value(expression, context, None, partial(self.truth, expression))
            if together is not None:
                return functions.as_booleans(together)
        return functions.as_booleans(self.value(expression, context))

    # -- paths -----------------------------------------------------------------------------------------------------

    def _path(self, path: Path, context: Context) -> NodeSets:
        steps = path.steps
        count = len(context)
        if path.absolute and not len(self.forest):
            raise functions.NotOnColumnsError
        if path.absolute and context.variables and free_variables(path):
            own = first_of_documents(documents_of(context.nodes))
            return self.steps(NodeSets(np.arange(count), own, count), steps, context)
        if path.absolute:
            documents, index = np.unique(documents_of(context.nodes), return_inverse=True)
            start = first_of_documents(documents)
            found = self.steps(ordered(np.arange(len(start)), start, len(start)), steps)
            if len(start) == count:
                return found
            return NodeSets(found.groups, found.nodes, found.count, index.reshape(-1).astype(np.int64))
        if path.start is not None:
            sets = self.nodes(path.start, context)
            if not isinstance(path.start, Path):  # Nodes of a sequence keep the order of the sequence.
                sets = replace(ordered(sets.groups, sets.nodes, sets.count), index=sets.index)
            if context.variables and any(map(free_variables, predicates_of(steps))):
                return self.steps(sets.flat()[0], steps, context)
            found = self.steps(NodeSets(sets.groups, sets.nodes, sets.count), steps)
            return NodeSets(found.groups, found.nodes, found.count, sets.index)
        alone = own_set(context)
        if context.variables and free_variables(path):
            return self.steps(alone, steps, context)
        if count > 1 and steps and steps[0].axis == "parent" and not steps[0].predicates:
            return self._by_parent(steps, context)
        return self.steps(alone, steps)

    def _by_parent(self, steps: tuple[Step, ...], context: Context) -> NodeSets:
        """The rest of a path is the same for all children of one parent."""
        above, index = np.unique(parents(self.forest, context.nodes), return_inverse=True)
        kept = above >= 0
        groups = np.flatnonzero(kept)
        own = steps[0]
        at_parent = Step("self", own.name, span=own.span)
        found = self.steps(NodeSets(groups, above[kept], len(above)), (at_parent, *steps[1:]))
        return NodeSets(found.groups, found.nodes, found.count, index.reshape(-1).astype(np.int64))

    def steps(
        self, sets: NodeSets, steps: tuple[Step, ...], context: Context = Context(np.empty(0, np.int64))
    ) -> NodeSets:
        """Steps from node sets that have a group for each context node.

        context: the contexts of these groups, if predicates use variables.
        """
        for one in steps:
            self.check()
            predicates = one.predicates
            name = bone_name(one)
            distance, place = frame_distance(one), frame_place(one)
            if name is not None:
                source, reached = named_bones(self.forest, sets.nodes, name)
                predicates = predicates[1:]
            elif distance is not None and are_frames(sets.nodes):
                source, reached = sibling_frames(self.forest, sets.nodes, distance)
                predicates = predicates[1:]
            elif place is not None:
                source, reached = frames_at(self.forest, sets.nodes, place)
                predicates = predicates[1:]
            else:
                source, reached = step(self.forest, sets.nodes, one.axis, one.name)
            for predicate in predicates:
                variables = {} if context is None else context.variables_at(sets.groups[source])
                keep = self._kept(predicate, source, reached, reverse=one.axis in REVERSE, variables=variables)
                source, reached = source[keep], reached[keep]
            sets = ordered(sets.groups[source], reached, sets.count)
        return sets

    def _filter(self, expression: Filter, context: Context) -> Value:
        if type_of(expression.operand) != "nodes":
            return loops.filtered(self, expression, context)
        sets = self.nodes(expression.operand, context)
        if context.variables and any(map(free_variables, expression.predicates)):
            sets = sets.flat()[0]
        groups, nodes = sets.groups, sets.nodes
        for predicate in expression.predicates:
            variables = context.variables_at(groups) if free_variables(predicate) else {}
            keep = self._kept(predicate, groups, nodes, reverse=False, variables=variables)
            groups, nodes = groups[keep], nodes[keep]
        return NodeSets(groups, nodes, sets.count, sets.index)

    def filtered(self, groups: Ints, nodes: Ints, predicates: tuple[Expression, ...]) -> Ints:
        """The nodes that predicates keep. groups: whose list each is in, ascending."""
        for predicate in predicates:
            keep = self._kept(predicate, groups, nodes, reverse=False)
            groups, nodes = groups[keep], nodes[keep]
        return nodes

    def _kept(
        self,
        predicate: Expression,
        groups: Ints,
        nodes: Ints,
        *,
        reverse: bool,
        variables: Mapping[str, Bound] = MappingProxyType({}),
    ) -> Bools:
        """Tell which candidates a predicate keeps.

        groups: the list of each candidate, ascending. variables: those that it uses, for each candidate.
        """
        if not len(nodes):
            return np.zeros(0, bool)
        if type_of(predicate) == "number" or depends_on_position(predicate):
            positions, sizes = positions_of(groups, reverse=reverse)
            return self.kept(predicate, Context(nodes, positions, sizes, variables))
        if variables:
            return self.kept(predicate, Context(nodes, variables=variables))
        if (np.diff(nodes) > 0).all():
            return self.kept(predicate, Context(nodes))
        distinct, inverse = np.unique(nodes, return_inverse=True)
        return self.kept(predicate, Context(distinct))[inverse.reshape(-1)]

    def kept(self, predicate: Expression, context: Context) -> Bools:
        """Tell which items of a sequence a predicate keeps, by their positions or by its value."""
        if type_of(predicate) == "sequence" and item_type(predicate) in ("number", "any"):
            raise functions.NotOnColumnsError  # A number selects a position, other values are converted to booleans.
        return self.sliced(predicate, context)

    def sliced(self, predicate: Expression, context: Context) -> Bools:
        parts = [self._holds(predicate, context.part(at, at + SLICE)) for at in range(0, len(context), SLICE)]
        return parts[0] if len(parts) == 1 else np.concatenate([*parts, np.empty(0, bool)])

    def _holds(self, predicate: Expression, context: Context) -> Bools:
        """Evaluate a slice of candidates; if they reach too many nodes together, each half separately."""
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
        """Evaluate an expression once for each document, if it depends on the context node only through its document
        and this saves work.
        """
        if len(context) < 2 or isinstance(expression, Literal | Variable) or not is_of_document(expression):
            return None
        if is_of_variables(expression):
            return Bound(self.value(expression, context.part(0, 1)), np.zeros(len(context), np.int64)).now()
        documents, index = np.unique(documents_of(context.nodes), return_inverse=True)
        if len(documents) == len(context):
            return None
        index = index.reshape(-1)
        nodes = first_of_documents(documents)
        found = self.value(expression, Context(nodes, np.ones(len(nodes)), np.ones(len(nodes))))
        return Bound(found, index).now()

    def _operation(self, operation: Operation, context: Context) -> Value:
        operator, operands = operation.operator, operation.operands
        if operator in ("or", "and"):
            return self._logic(operator, operands, context)
        if operator == "|":
            whole = self.nodes(operands[0], context)
            for operand in operands[1:]:
                self.check()
                whole = union(whole, self.nodes(operand, context))
            return whole
        if operator == "negate":
            return np.asarray(-self.numbers(operands[0], context))
        if operator in ("intersect", "except"):
            return shared_nodes(*(self.nodes(operand, context) for operand in operands), wanted=operator == "intersect")
        if operator == "to":
            return sequences.ranges(*(self.numbers(operand, context) for operand in operands))
        if operator in VALUE_COMPARISONS:
            sides = [self.value(operand, context) for operand in operands]
            return compare_items(self.forest, VALUE_COMPARISONS[operator], *sides)
        if operator in functions.COMPARISONS:
            left: Value = self.value(operands[0], context)
            for operand in operands[1:]:
                left = compare(self.forest, operator, left, self.value(operand, context))
            return left
        result = self.numbers(operands[0], context)
        for operand in operands[1:]:
            result = functions.arithmetic(operator, result, self.numbers(operand, context))
        return result

    def _logic(self, operator: str, operands: tuple[Expression, ...], context: Context) -> Bools:
        """Operands one after the other, each only for the candidates that are not decided."""
        if all(map(is_of_variables, operands)):
            # Selecting among cached values takes longer than using all of them.
            combine = np.logical_and if operator == "and" else np.logical_or
            return reduce(combine, [self.truth(operand, context) for operand in operands])
        result = np.full(len(context), operator == "and")
        open_ = np.arange(len(context))
        for operand in operands:
            if not len(open_):
                break
            some = context if len(open_) == len(context) else context.at(open_)
            found = self.truth(operand, some)
            decided = found if operator == "or" else ~found
            result[open_[decided]] = operator == "or"
            open_ = open_[~decided]
        return result

    def _call(self, call: Call, context: Context) -> Value:
        name, arguments = call.function, call.arguments
        if name in ("position", "last"):
            if context.positions is None or context.sizes is None:
                raise TypeError("position() without positions")
            return context.positions if name == "position" else context.sizes
        if name in ("boolean", "not", "exists", "empty") and isinstance(arguments[0], Path):
            found = self.truth(arguments[0], context)
            return ~found if name in ("not", "empty") else found
        if name == "count" and isinstance(arguments[0], Path):
            known = self._neighbours.counted(arguments[0], context)
            if known is not None:
                return known
        if name in MOTION_FUNCTIONS:
            return self.motions.value(call, context)
        around = self._windows.value(call, context)
        if around is not None:
            return around
        if not arguments and name in OF_CONTEXT:
            return functions.call(self.forest, name, [own_set(context)], len(context))
        if name == "sort":
            return loops.sort(self, arguments, context)
        if name == "string-join":
            joins = [self.texts(arguments[0], context), *(self.strings(each, context) for each in arguments[1:])]
            return sequences.call(self.forest, name, joins)
        values = [self.value(each, context) for each in arguments]
        if sequences.takes(name):
            function = sequences.call_on_bodies if motion_calls(call) else sequences.call
            return function(self.forest, name, values)
        if name == "tokenize" or SAFE_FUNCTIONS[name].of_texts is not None or name in ("string", "substring"):
            values = [self._written(each, value) for each, value in zip(arguments, values, strict=True)]
        if name == "tokenize":
            return sequences.tokens(self.forest, values, self.check)
        return functions.call(self.forest, name, values, len(context), self.check)
