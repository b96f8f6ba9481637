"""Split an expression into parts for the whole scope and parts for each document.

Outside of predicates, an absolute path that a function of sequences or a loop takes is the node set of all documents
together; if one value of it is needed, as in `string(/mcml/header/filename)`, every document has its own value.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from mcml_service.xpath.language.functions import SAFE_FUNCTIONS
from mcml_service.xpath.language.meaning import ITEM
from mcml_service.xpath.language.motion_functions import MOTION_FUNCTIONS, OF_FRAME_SETS, RUNS, TOP
from mcml_service.xpath.language.tree import (
    OF_NODES,
    Binder,
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
    Variable,
    Written,
    children,
    free_variables,
    names_of,
    walk,
    with_children,
)
from mcml_service.xpath.language.types import depends_on_position, item_type, type_of


def asks_scope(expression: Expression) -> bool:
    """Whether it holds an absolute path, outside of predicates on nodes."""
    if isinstance(expression, Written):
        return True
    if isinstance(expression, Path):
        return expression.absolute or (expression.start is not None and asks_scope(expression.start))
    if isinstance(expression, Filter):
        # Nodes have a document, in which conditions ask; values have none.
        of_values = expression.predicates if type_of(expression.operand) != "nodes" else ()
        return asks_scope(expression.operand) or any(map(asks_scope, of_values))
    return any(map(asks_scope, children(expression)))


def is_node_set(expression: Expression) -> bool:
    """Whether its nodes are those of each document alone: it has no position behind parentheses, which counts over all
    documents, and no function of sequences.
    """
    if type_of(expression) != "nodes" or begins_with_top(expression):
        return False
    if isinstance(expression, Path):
        return expression.start is None or is_node_set(expression.start)
    if isinstance(expression, Filter):
        return is_node_set(expression.operand) and not any(map(_may_count, expression.predicates))
    if isinstance(expression, Operation):
        return all(map(_are_node_sets, expression.operands))
    if isinstance(expression, If):
        return is_node_set(expression.then) and is_node_set(expression.otherwise)
    return True


def _are_node_sets(operand: Expression) -> bool:
    return all(map(_are_node_sets, operand.items)) if isinstance(operand, Sequence) else is_node_set(operand)


def _may_count(predicate: Expression) -> bool:
    """Whether the truth of a predicate may depend on the position of an item."""
    is_number = type_of(predicate) == "number" or (
        type_of(predicate) == "sequence" and item_type(predicate) in ("number", "any")
    )
    return is_number or depends_on_position(predicate)


def begins_with_top(expression: Expression) -> bool:
    """Tell whether it is, or starts from, the best runs of all documents, or the runs of a sequence."""
    if isinstance(expression, Path | Filter):
        inner = expression.start if isinstance(expression, Path) else expression.operand
        return inner is not None and begins_with_top(inner)
    if isinstance(expression, Call) and expression.function == RUNS:
        return not is_node_set(expression.arguments[0])
    return isinstance(expression, Call) and expression.function == TOP


def asks_each(expression: Expression, *, in_sequence: bool = True, at_document: bool = True) -> bool:
    """Tell whether every document has its own answer: an absolute path occurs where one value is needed, or a function
    of bodies in motion is evaluated for the document. in_sequence: any number of items is allowed at the expression.
    at_document: its context is the document.
    """
    asks = partial(asks_each, at_document=at_document)
    if isinstance(expression, Path):
        if expression.start is not None:
            return asks(expression.start, in_sequence=in_sequence)
        return expression.absolute and not in_sequence
    if isinstance(expression, Filter):
        return asks(expression.operand, in_sequence=in_sequence)
    if isinstance(expression, Call):
        if at_document and expression.function in MOTION_FUNCTIONS and expression.function not in OF_FRAME_SETS:
            return True
        signature = SAFE_FUNCTIONS[expression.function]
        taken = signature.place if signature.takes_items else None
        # The key of the best runs is evaluated for frames.
        asked = expression.arguments[: 2 if expression.function == TOP else None]
        return any(asks(argument, in_sequence=place == taken) for place, argument in enumerate(asked))
    if isinstance(expression, Operation):
        inside = in_sequence and expression.operator in OF_NODES
        return any(asks(operand, in_sequence=inside) for operand in expression.operands)
    if isinstance(expression, For | Let | Each | Quantified):
        within = in_sequence and not isinstance(expression, Quantified)
        inside = at_document and not isinstance(expression, Each)
        return asks(expression.source) or asks_each(expression.body, in_sequence=within, at_document=inside)
    if isinstance(expression, If):
        branches = (expression.then, expression.otherwise)
        return asks(expression.test, in_sequence=False) or any(
            asks(branch, in_sequence=in_sequence) for branch in branches
        )
    if isinstance(expression, Function):
        return asks_each(expression.body, in_sequence=False, at_document=False)
    if isinstance(expression, Sequence):
        return any(asks(item, in_sequence=in_sequence) for item in expression.items)
    return isinstance(expression, Written)


def put(expression: Expression, variable: str, outside: Expression, inside: Callable[[], Expression]) -> Expression:
    """Replace a variable in an expression.

    inside: returns the replacement in predicates, where an absolute path would start at the context node's document.
    """
    if variable not in free_variables(expression):
        return expression
    if isinstance(expression, Variable):
        return outside
    if isinstance(expression, Binder) and variable in names_of(expression):
        return replace(expression, source=put(expression.source, variable, outside, inside))
    if isinstance(expression, Each) and variable == ITEM:
        return replace(expression, source=put(expression.source, variable, outside, inside))
    if isinstance(expression, Path):
        start = None if expression.start is None else put(expression.start, variable, outside, inside)
        steps = tuple(step.where(_put_inside(step.predicates, variable, inside)) for step in expression.steps)
        if isinstance(start, Path) and start.start is None:
            return Path((*start.steps, *steps), start.absolute, None, expression.span)
        return Path(steps, expression.absolute, start, expression.span)
    if isinstance(expression, Filter):
        predicates = expression.predicates if variable == ITEM else _put_inside(expression.predicates, variable, inside)
        return Filter(put(expression.operand, variable, outside, inside), predicates, expression.span)
    return with_children(expression, lambda part: put(part, variable, outside, inside))


def _put_inside(
    predicates: tuple[Expression, ...], variable: str, inside: Callable[[], Expression]
) -> tuple[Expression, ...]:
    if not any(variable in free_variables(each) for each in predicates):
        return predicates
    values = inside()
    return tuple(put(each, variable, values, inside) for each in predicates)


def begins_paths(expression: Expression, variable: str) -> bool:
    """Whether a path begins at a variable."""
    return any(
        isinstance(part, Path) and isinstance(part.start, Variable) and part.start.name == variable
        for part in walk(expression)
    )
