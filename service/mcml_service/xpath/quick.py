"""Quick expressions: columns answer them in milliseconds per million frames.

A server evaluates them in a place of their own, so that they do not wait behind others. The text alone decides, since
only worker processes look at documents. A quick expression has no loop, pattern, range or function of bodies, and no
condition that looks at other elements than those in the element that it judges.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Final

from mcml.errors import McmlError
from mcml_service.xpath.language.grammar import read
from mcml_service.xpath.language.tree import (
    OF_NODES,
    Call,
    Expression,
    Filter,
    Literal,
    Operation,
    Path,
)

_MOST_LETTERS: Final = 400
_MOST_PARTS: Final = 60
_DEEPEST: Final = 2
"""Conditions within conditions."""
_AXES: Final = frozenset({"child", "attribute", "self", "parent", "descendant", "descendant-or-self"})
_DEEP: Final = frozenset({"descendant", "descendant-or-self"})
_MOST_DEEP: Final = 2
"""Steps of a path on these axes."""
_FUNCTIONS: Final = frozenset({
    "avg", "boolean", "ceiling", "contains", "count", "distinct-values", "empty", "ends-with", "exists", "false",
    "floor", "last", "local-name", "max", "min", "name", "not", "number", "position", "round", "starts-with", "string",
    "string-length", "sum", "true",
})  # fmt: skip
_OPERATORS: Final = frozenset({
    "or", "and", "=", "!=", "<", "<=", ">", ">=", "eq", "ne", "lt", "le", "gt", "ge", "+", "-", "*", "div", "mod",
    "negate", "|",
})  # fmt: skip


@lru_cache(1024)
def is_quick(text: str) -> bool:
    """Whether an expression is quick; False for one that is invalid, or not in the grammar of columns."""
    if len(text) > _MOST_LETTERS:
        return False
    try:
        parts = list(_parts(read(text), 0))
    except (McmlError, RecursionError):
        return False
    return len(parts) <= _MOST_PARTS and all(parts)


def _parts(expression: Expression, depth: int) -> Iterator[bool]:
    """Whether each part of an expression is quick. depth: of conditions around it."""
    inner: list[tuple[Expression, int]] = []
    if isinstance(expression, Literal):
        yield True
    elif isinstance(expression, Path):
        yield depth == 0 or not (expression.absolute or expression.start)
        yield sum(step.axis in _DEEP for step in expression.steps) <= _MOST_DEEP
        inner += [] if expression.start is None else [(expression.start, depth)]
        for step in expression.steps:
            yield step.axis in _AXES
            inner += [(predicate, depth + 1) for predicate in step.predicates]
    elif isinstance(expression, Filter):
        yield depth == 0
        inner = [(expression.operand, depth), *((predicate, depth + 1) for predicate in expression.predicates)]
    elif isinstance(expression, Call):
        yield expression.function in _FUNCTIONS
        inner = [(argument, depth) for argument in expression.arguments]
    elif isinstance(expression, Operation):
        yield expression.operator in _OPERATORS and not (depth and expression.operator in OF_NODES)
        inner = [(operand, depth) for operand in expression.operands]
    else:
        yield False
    for part, deep in inner:
        yield deep <= _DEEPEST
        yield from _parts(part, deep)
