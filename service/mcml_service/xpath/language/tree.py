"""Expressions of XPath 1.0, and of the supported parts of 2.0 and 3.1, as a typed tree.

Frozen; every node has its position.

Abbreviations are written out (`@a` is `attribute::a`, `//` is `/descendant-or-self::node()/`), so that equivalent
spellings look alike. Operators that associate hold all their operands: `a or b or c` is one node.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import TypeAlias

Atomic: TypeAlias = int | float | str | bool
"""A value that is no node, as requests and answers have it."""
Span: TypeAlias = tuple[int, int]
"""First and last + 1 character in the text."""

FORWARD_AXES = ("child", "descendant", "descendant-or-self", "self", "attribute", "following", "following-sibling")
REVERSE_AXES = ("parent", "ancestor", "ancestor-or-self", "preceding", "preceding-sibling")
AXES = (*FORWARD_AXES, *REVERSE_AXES, "namespace")
KIND_TESTS = ("node", "text", "comment", "processing-instruction")
VALUE_COMPARISONS = {"eq": "=", "ne": "!=", "lt": "<", "le": "<=", "gt": ">", "ge": ">="}
"""Comparisons of one value with another, XPath 2.0 §3.5.1, and those of sequences that they resemble."""
LEVELS = {"or": 1, "and": 2, "=": 3, "!=": 3, "<": 4, "<=": 4, ">": 4, ">=": 4, **dict.fromkeys(VALUE_COMPARISONS, 4)}
LEVELS |= {"||": 5, "to": 6, "+": 7, "-": 7, "*": 8, "div": 8, "idiv": 8, "mod": 8, "negate": 9}
LEVELS |= {"|": 10, "intersect": 11, "except": 11, "!": 12, "/": 13}
"""How tightly operators bind. XPath 1.0 §3.3 to §3.5, 3.1 appendix A.4; a minus sign is one of a union, as in 1.0."""
TURNED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "=": "=", "!=": "!="}
"""Comparisons with their sides exchanged."""
OF_NODES = frozenset({"|", "intersect", "except"})
"""Operators that give nodes."""


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
        # Not by `dataclasses.replace`, here and in `with_children`: short queries spent a tenth of their time in it.
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
    """A function call."""

    function: str
    arguments: tuple[Expression, ...] = ()
    span: Span = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Operation:
    """operator: one of `LEVELS` with two or more operands, or "negate" with one."""

    operator: str
    operands: tuple[Expression, ...]
    span: Span = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Variable:
    """`$name`, bound by the request (until `meaning.bind` replaces it by its value) or by an enclosing expression.

    type: of its items, as of `type_of`; "" until it is bound. "." is a context item that is not a node. is_integer:
    whether XPath treats the number as an integer. reached: the types of its nodes (`reach.types_of`), set by
    `rules.normal`.
    """

    name: str
    type: str = ""
    is_integer: bool = False
    reached: frozenset[str] = frozenset()
    span: Span = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Sequence:
    """`(a, b, c)`, items one after the other; `()` has none."""

    items: tuple[Expression, ...]
    span: Span = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class For:
    """`for $variable at $position in source return body`; several variables are nested, one in the body of the other.

    position: name of the variable for the place of an item, from 1; "" without one.
    """

    variable: str
    source: Expression
    body: Expression
    span: Span = field(default=(0, 0), compare=False)
    position: str = ""


@dataclass(frozen=True, slots=True)
class Let:
    """`let $variable := source return body`."""

    variable: str
    source: Expression
    body: Expression
    span: Span = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Quantified:
    """`some $variable in source satisfies body`, or `every`."""

    quantifier: str
    variable: str
    source: Expression
    body: Expression
    span: Span = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class If:
    """`if (test) then … else …`."""

    test: Expression
    then: Expression
    otherwise: Expression
    span: Span = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Each:
    """`source ! body`, the body with each item as context. is_step: `source/body`, where the body is no step."""

    source: Expression
    body: Expression
    is_step: bool = False
    span: Span = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Function:
    """`function($variable) { body }`, the key of `sort`."""

    variable: str
    body: Expression
    span: Span = field(default=(0, 0), compare=False)


@dataclass(frozen=True, slots=True)
class Written:
    """A whole XPath 3.1 expression without columns, as written.

    variables: the values of free variables. function, arguments: of a call that makes one value from all documents.
    nodes: whether its operator gives nodes. motion: the calls of functions of bodies in motion in it. constant: whether
    its value is independent of documents.
    """

    text: str
    variables: tuple[tuple[str, Atomic], ...] = ()
    function: str = ""
    arguments: tuple[str, ...] = ()
    nodes: bool = False
    motion: tuple[Call, ...] = ()
    constant: bool = False
    span: Span = field(default=(0, 0), compare=False)


Binder: TypeAlias = For | Let | Quantified
Later: TypeAlias = Variable | Sequence | Binder | If | Each | Function
"""Expressions after XPath 1.0."""
Expression: TypeAlias = Literal | Path | Filter | Call | Operation | Later | Written
_PARTS: dict[type, tuple[str, ...]] = {
    For: ("source", "body"), Let: ("source", "body"), Quantified: ("source", "body"), Each: ("source", "body"),
    If: ("test", "then", "otherwise"), Function: ("body",),
}  # fmt: skip


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
    elif isinstance(expression, Sequence):
        yield from expression.items
    elif isinstance(expression, Written):
        yield from expression.motion
    else:
        for name in _PARTS.get(type(expression), ()):
            yield getattr(expression, name)


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
    if isinstance(expression, Sequence):
        return Sequence(tuple(map(function, expression.items)), expression.span)
    if isinstance(expression, For | Let | Quantified | Each | If | Function):
        parts = {name: function(getattr(expression, name)) for name in _PARTS[type(expression)]}
        return replace(expression, **parts)  # type: ignore[arg-type]  # it cannot tell the names of fields
    return expression


def walk(expression: Expression) -> Iterator[Expression]:
    """The expression and all expressions in it, outer ones first."""
    stack = [expression]
    while stack:
        current = stack.pop()
        yield current
        stack.extend(children(current))


def names_of(binder: Binder) -> frozenset[str]:
    """Names of the variables that it binds in its body."""
    return frozenset({binder.variable, binder.position} if isinstance(binder, For) else {binder.variable})


@lru_cache(maxsize=4096)
def free_variables(expression: Expression) -> frozenset[str]:
    """Names of variables that are bound outside of an expression."""
    if isinstance(expression, Variable):
        return frozenset({expression.name})
    if isinstance(expression, Binder):
        return free_variables(expression.source) | (free_variables(expression.body) - names_of(expression))
    if isinstance(expression, Function):
        return free_variables(expression.body) - {expression.variable}
    if isinstance(expression, Each):
        return free_variables(expression.source) | (free_variables(expression.body) - {"."})
    found = frozenset[str]().union(*map(free_variables, children(expression)))
    if isinstance(expression, Filter):
        inner = frozenset[str]().union(*map(free_variables, expression.predicates))
        return free_variables(expression.operand) | (inner - {"."})
    return found


def predicates_of(steps: Iterable[Step]) -> list[Expression]:
    """All predicates of some steps."""
    return [predicate for step in steps for predicate in step.predicates]
