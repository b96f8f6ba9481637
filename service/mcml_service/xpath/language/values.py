"""Values as expressions, within a limit of size."""

from __future__ import annotations

import math
from itertools import islice

from mcml.errors import LimitError
from mcml_service.xpath.language.tree import (
    Binder,
    Call,
    Expression,
    Function,
    Let,
    Literal,
    Sequence,
    Variable,
    children,
    walk,
)

MOST_PARTS = 20_000
"""The largest number of subexpressions after substitution."""


def literal(value: float | str | bool) -> Expression:
    """A value as an expression."""
    if isinstance(value, bool):
        return Call("true" if value else "false", ())
    return Literal(value)


def sequence_of(values: list[float | str | bool]) -> Expression:
    """Several values as one."""
    return literal(values[0]) if len(values) == 1 else Sequence(tuple(map(literal, values)))


def to_xpath31(value: Expression, *, is_integer: bool) -> str | None:
    """A number, boolean or nothing as XPath 3.1 with its type; None for other expressions."""
    if isinstance(value, Literal) and isinstance(value.value, float):
        number = value.value
        if is_integer and number.is_integer():
            return str(int(number))
        special = "NaN" if math.isnan(number) else "INF" if number > 0 else "-INF"
        return f"xs:double('{repr(number) if math.isfinite(number) else special}')"
    if isinstance(value, Call) and value.function in ("true", "false"):
        return f"{value.function}()"
    return "()" if value == Sequence(()) else None


def require_room(expression: Let, source: Expression) -> None:
    """Raise LimitError if substituting the variable makes the body too large."""
    name = expression.variable
    uses = _uses(expression.body, name)
    parts = sum(1 for _ in islice(walk(source), MOST_PARTS))
    if uses * parts >= MOST_PARTS:
        raise LimitError(
            f"The expression gets too large: ${name} has the value {parts:,} parts or more, and is used {uses} times.",
            remedy="Use the variable less often, or split the query.",
            code="query-too-large",
        )


def _uses(expression: Expression, name: str) -> int:
    """Count the free occurrences of a variable."""
    if isinstance(expression, Variable):
        return int(expression.name == name)
    if isinstance(expression, Binder | Function) and expression.variable == name:
        return _uses(expression.source, name) if isinstance(expression, Binder) else 0
    return sum(_uses(child, name) for child in children(expression))
