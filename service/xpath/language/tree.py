"""Expressions of XPath 1.0 as a typed tree. Frozen; every node knows its place in the text.

Abbreviations are written out (`@a` is `attribute::a`, `//` is `/descendant-or-self::node()/`), so that equivalent
spellings look alike. Operators that associate hold all their operands: `a or b or c` is one node.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

from service.xpath.language.functions import FUNCTIONS, giving

Span: TypeAlias = tuple[int, int]
"""First and last + 1 character in the text."""

FORWARD_AXES = ("child", "descendant", "descendant-or-self", "self", "attribute", "following", "following-sibling")
REVERSE_AXES = ("parent", "ancestor", "ancestor-or-self", "preceding", "preceding-sibling")
AXES = (*FORWARD_AXES, *REVERSE_AXES, "namespace")
KIND_TESTS = ("node", "text", "comment", "processing-instruction")
LEVELS = {"or": 1, "and": 2, "=": 3, "!=": 3, "<": 4, "<=": 4, ">": 4, ">=": 4, "+": 5, "-": 5}
LEVELS |= {"*": 6, "div": 6, "mod": 6, "negate": 7, "|": 8}
"""How tightly operators bind. XPath 1.0 §3.3 to §3.5."""


@dataclass(frozen=True, slots=True)
class Literal:
    """A string or a number."""

    value: str | float
    span: Span = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Step:
    """`axis::test[predicate]…`. name: of the test, "*" for any, or a kind test such as "node()"."""

    axis: str
    name: str
    predicates: tuple[Expression, ...] = ()
    span: Span = field(default=(0, 0), compare=False)

    def where(self, predicates: tuple[Expression, ...]) -> Step:
        """The same step with other predicates."""
        # Not by `dataclasses.replace`, here and in `with_children`: short questions spent a tenth of their time in it.
        return Step(self.axis, self.name, predicates, self.span) if predicates or self.predicates else self

    def along(self, axis: str) -> Step:
        """The same step on another axis."""
        return Step(axis, self.name, self.predicates, self.span)


@dataclass(frozen=True, slots=True)
class Path:
    """Steps from a start: an expression, the document (absolute), or the context node."""

    steps: tuple[Step, ...]
    absolute: bool = False
    start: Expression | None = None
    span: Span = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Filter:
    """A parenthesised expression with predicates: `(//frame)[3]`."""

    operand: Expression
    predicates: tuple[Expression, ...]
    span: Span = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Call:
    """A function call. A variable, until it is bound, is a call of `$name`."""

    function: str
    arguments: tuple[Expression, ...] = ()
    span: Span = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Operation:
    """operator: or and = != < <= > >= + - * div mod | with two or more operands, or "negate" with one."""

    operator: str
    operands: tuple[Expression, ...]
    span: Span = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Written:
    """A whole expression of XPath 2.0 that only Saxon evaluates, as it is written.

    variables: the values of those that it does not bind itself. function, arguments: of a call that makes one value of
    all documents. nodes: whether its operator gives nodes.
    """

    text: str
    variables: tuple[tuple[str, str | float | bool], ...] = ()
    function: str = ""
    arguments: tuple[str, ...] = ()
    nodes: bool = False
    span: Span = field(default=(0, 0), compare=False)


Expression: TypeAlias = Literal | Path | Filter | Call | Operation | Written

NODES_FUNCTIONS = giving("nodes")
STRING_FUNCTIONS = giving("string")


def type_of(expression: Expression) -> str:
    """Type of the value: "nodes", "number", "string", "boolean" or "strings"; "sequence" where only it can tell."""
    if isinstance(expression, Written):
        return "sequence"
    if isinstance(expression, Literal):
        return "string" if isinstance(expression.value, str) else "number"
    if isinstance(expression, Path | Filter):
        return "nodes"
    if isinstance(expression, Call):
        return FUNCTIONS[expression.function].result
    if expression.operator == "|":
        return "nodes"
    return "number" if expression.operator in ("+", "-", "*", "div", "mod", "negate") else "boolean"


def children(expression: Expression) -> Iterator[Expression]:
    """The expressions directly inside an expression."""
    if isinstance(expression, Path):
        if expression.start is not None:
            yield expression.start
        for step in expression.steps:
            yield from step.predicates
    elif isinstance(expression, Filter):
        yield expression.operand
        yield from expression.predicates
    elif isinstance(expression, Call):
        yield from expression.arguments
    elif isinstance(expression, Operation):
        yield from expression.operands


def with_children(expression: Expression, function: Callable[[Expression], Expression]) -> Expression:
    """The expression with every expression directly inside replaced."""
    if isinstance(expression, Path):
        start = None if expression.start is None else function(expression.start)
        steps = tuple([step.where(tuple(map(function, step.predicates))) for step in expression.steps])
        return Path(steps, expression.absolute, start, expression.span)
    if isinstance(expression, Filter):
        predicates = tuple(map(function, expression.predicates))
        return Filter(function(expression.operand), predicates, expression.span)
    if isinstance(expression, Call):
        if not expression.arguments:
            return expression
        return Call(expression.function, tuple(map(function, expression.arguments)), expression.span)
    if isinstance(expression, Operation):
        return Operation(expression.operator, tuple(map(function, expression.operands)), expression.span)
    return expression


def walk(expression: Expression) -> Iterator[Expression]:
    """The expression and all expressions in it, outer ones first."""
    stack = [expression]
    while stack:
        current = stack.pop()
        yield current
        stack.extend(children(current))


def is_constant(expression: Expression) -> bool:
    """Whether the value is the same in every document: no path, and no function that looks at the context node."""
    return not any(
        isinstance(part, Path | Filter | Written)
        or (
            isinstance(part, Call)
            and (part.function in NODES_FUNCTIONS | {"lang", "position", "last"} or not _given(part))
        )
        for part in walk(expression)
    )


def _given(call: Call) -> bool:
    return bool(call.arguments) or call.function in ("true", "false")


def depends_on_position(expression: Expression) -> bool:
    """Whether position() or last() of the context itself are asked for, not those of predicates inside."""
    if isinstance(expression, Call):
        if expression.function in ("position", "last"):
            return True
        return any(depends_on_position(argument) for argument in expression.arguments)
    if isinstance(expression, Path):
        return expression.start is not None and depends_on_position(expression.start)
    if isinstance(expression, Filter):
        return depends_on_position(expression.operand)
    return isinstance(expression, Operation) and any(depends_on_position(operand) for operand in expression.operands)


def distinct_of(call: Call) -> Expression | None:
    """The nodes of `count(distinct-values(nodes))`, or of `string-join` of them; None for others."""
    inner = call.arguments[0] if call.arguments else None
    is_distinct = isinstance(inner, Call) and inner.function == "distinct-values" and len(inner.arguments) == 1
    takes = call.function in ("count", "string-join")
    return inner.arguments[0] if takes and is_distinct and isinstance(inner, Call) else None
