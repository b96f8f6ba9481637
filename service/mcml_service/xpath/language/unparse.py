"""A tree as an expression again, written out in full."""

from __future__ import annotations

from decimal import Decimal

from mcml_service.xpath.language.tree import (
    LEVELS,
    Call,
    Each,
    Expression,
    Filter,
    For,
    Function,
    If,
    Let,
    Literal,
    Operation,
    Path,
    Quantified,
    Sequence,
    Step,
    Variable,
    Written,
)

_CONTEXT = Path((Step("self", "node()"),))
_PRIMARY = (Filter, Call, Literal, Written, Variable, Sequence, Function)


def unparse(expression: Expression | Step) -> str:
    """An expression, or a step, in the unabbreviated syntax; parsed again, it gives the same tree."""
    if isinstance(expression, Step):
        predicates = "".join(f"[{unparse(predicate)}]" for predicate in expression.predicates)
        return f"{expression.axis}::{expression.name}{predicates}"
    if isinstance(expression, Literal):
        return _literal(expression.value)
    if expression == _CONTEXT:
        return "."
    if isinstance(expression, Path):
        steps = "/".join(unparse(step) for step in expression.steps)
        if expression.start is not None:
            start = _inner(expression.start, LEVELS["/"])
            return f"{start}/{steps}" if steps else start
        return f"/{steps}" if expression.absolute else steps or "."
    if isinstance(expression, Filter):
        predicates = "".join(f"[{unparse(predicate)}]" for predicate in expression.predicates)
        return f"({unparse(expression.operand)}){predicates}"
    if isinstance(expression, Call):
        return f"{expression.function}({', '.join(unparse(argument) for argument in expression.arguments)})"
    if isinstance(expression, Written):
        return expression.text
    if isinstance(expression, Operation):
        return _operation(expression)
    return _later(expression)


def _operation(operation: Operation) -> str:
    level = LEVELS[operation.operator]
    if operation.operator == "negate":
        return "-" + _inner(operation.operands[0], LEVELS["!"])
    first, *others = operation.operands
    # A comparison of a comparison needs parentheses in XPath 2.0, where all bind alike.
    compares = level in (LEVELS["="], LEVELS["<"])
    parts = [_inner(first, LEVELS["||"] if compares else level)]
    parts += [_inner(operand, LEVELS["||"] if compares else level + 1) for operand in others]
    return f" {operation.operator} ".join(parts)


def _later(expression: Expression) -> str:
    if isinstance(expression, Variable):
        return expression.name if expression.name == "." else f"${expression.name}"
    if isinstance(expression, Sequence):
        return f"({', '.join(map(unparse, expression.items))})"
    if isinstance(expression, If):
        parts = unparse(expression.test), unparse(expression.then), unparse(expression.otherwise)
        return "if ({}) then {} else {}".format(*parts)
    if isinstance(expression, Each):
        sign = "/" if expression.is_step else " ! "
        level = LEVELS["/" if expression.is_step else "!"]
        return f"{_inner(expression.source, level)}{sign}{_inner(expression.body, level + 1)}"
    if isinstance(expression, Function):
        return f"function(${expression.variable}) {{ {unparse(expression.body)} }}"
    if isinstance(expression, For | Let | Quantified):
        word = {For: "for", Let: "let"}.get(type(expression), getattr(expression, "quantifier", ""))
        binds = ":=" if isinstance(expression, Let) else "in"
        then = "satisfies" if isinstance(expression, Quantified) else "return"
        source, body = unparse(expression.source), unparse(expression.body)
        place = f" at ${expression.position}" if isinstance(expression, For) and expression.position else ""
        return f"{word} ${expression.variable}{place} {binds} {source} {then} {body}"
    raise TypeError(f"no expression: {expression!r}")


def _inner(expression: Expression, level: int) -> str:
    """An operand, in parentheses where it binds less tightly."""
    text = unparse(expression)
    if isinstance(expression, _PRIMARY) or (isinstance(expression, Path) and level <= LEVELS["/"]):
        return text
    own = 0
    if isinstance(expression, Operation):
        own = LEVELS[expression.operator]
    elif isinstance(expression, Each | Path):
        own = LEVELS["!"] if isinstance(expression, Each) and not expression.is_step else LEVELS["/"]
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
