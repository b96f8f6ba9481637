"""A tree as an expression again, written out in full."""

from __future__ import annotations

from decimal import Decimal

from service.xpath.language.tree import LEVELS, Call, Expression, Filter, Literal, Path, Step, Written


def unparse(expression: Expression | Step) -> str:
    """An expression, or a step, in the unabbreviated syntax; parsed again, it gives the same tree."""
    if isinstance(expression, Step):
        predicates = "".join(f"[{unparse(predicate)}]" for predicate in expression.predicates)
        return f"{expression.axis}::{expression.name}{predicates}"
    if isinstance(expression, Literal):
        return _literal(expression.value)
    if isinstance(expression, Path):
        steps = "/".join(unparse(step) for step in expression.steps)
        if expression.start is not None:
            return f"{_inner(expression.start, 9)}/{steps}" if steps else _inner(expression.start, 9)
        return f"/{steps}" if expression.absolute else steps or "."
    if isinstance(expression, Filter):
        predicates = "".join(f"[{unparse(predicate)}]" for predicate in expression.predicates)
        return f"({unparse(expression.operand)}){predicates}"
    if isinstance(expression, Call):
        if expression.function.startswith("$"):
            return expression.function
        return f"{expression.function}({', '.join(unparse(argument) for argument in expression.arguments)})"
    if isinstance(expression, Written):
        return expression.text
    level = LEVELS[expression.operator]
    if expression.operator == "negate":
        return "-" + _inner(expression.operands[0], level)
    first, *others = expression.operands
    # A comparison of a comparison needs parentheses in XPath 2.0.
    parts = [_inner(first, level + (3 <= level <= 4)), *(_inner(operand, level + 1) for operand in others)]
    return f" {expression.operator} ".join(parts)


def _inner(expression: Expression, level: int) -> str:
    """An operand, in parentheses where it binds less tightly."""
    text = unparse(expression)
    if isinstance(expression, Filter | Call | Literal | Written) or (isinstance(expression, Path) and level < 9):
        return text
    own = 0 if isinstance(expression, Path) else LEVELS[expression.operator]
    return f"({text})" if own < level else text


def _literal(value: str | float) -> str:
    if isinstance(value, float):
        text = format(Decimal(value), "f") if value == value and abs(value) != float("inf") else "(0 div 0)"
        return text.removesuffix(".0")
    if "'" not in value:
        return f"'{value}'"
    if '"' not in value:
        return f'"{value}"'
    pieces = "', \"'\", '".join(value.split("'"))
    return f"concat('{pieces}')"
