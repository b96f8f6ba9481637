"""Tokens of elementpath to our own tree."""

from __future__ import annotations

from typing import Any

from service.errors import Place, QueryError
from service.xpath.tree import AXES, KIND_TESTS, Call, Expression, Filter, Literal, Operation, Path, Span, Step

OPERATORS = ("or", "and", "=", "!=", "<", "<=", ">", ">=", "+", "-", "*", "div", "mod", "|")
ANY_NODE = Step("descendant-or-self", "node()")


def expression(token: Any) -> Expression:
    """The tree of a token and of all that hangs from it. QueryError for what is no XPath 1.0."""
    symbol, operands = token.symbol, list(token)
    span = _span(token)
    if symbol in ("/", "//"):
        return _path(token)
    if symbol == "[":
        return _filter(token)
    if symbol == "(" and len(operands) == 1:
        return expression(operands[0])
    if _is_step(token):
        return Path((_step(token),), span=span)
    if symbol == "(string)":
        return Literal(str(token.value), span)
    if symbol in ("(integer)", "(decimal)", "(float)"):
        return Literal(float(token.value), span)
    if symbol in ("-", "+") and len(operands) == 1:
        if symbol == "+":
            raise QueryError("XPath has no unary plus", at=Place(column=span[0] + 1), remedy="Leave it out.")
        return Operation("negate", (expression(operands[0]),), span)
    if symbol in OPERATORS and len(operands) == 2:
        return _operation(token)
    if token.label in ("function", "constructor function") or symbol == "id":
        return Call(symbol, tuple(expression(operand) for operand in operands), span)
    if symbol == "$":
        return Call(f"${token[0].value}", (), span)
    raise QueryError(f"{symbol!r} cannot be used here", at=Place(column=span[0] + 1))


def _operation(token: Any) -> Operation:
    """An operator with all operands it joins from the left: `1 + 2 + 3` is one node, without recursion."""
    symbol = token.symbol
    operands = []
    current = token
    while current.symbol == symbol and len(current) == 2:
        operands.append(expression(current[1]))
        current = current[0]
    operands.append(expression(current))
    first = operands[-1]
    if symbol == "|" and isinstance(first, Operation) and first.operator == "negate" and current.symbol == "-":
        # XPath 1.0 binds | more tightly than a minus sign, later versions do not.
        union = Operation("|", (*first.operands, *reversed(operands[:-1])), _span(token))
        return Operation("negate", (union,), _span(token))
    return Operation(symbol, tuple(reversed(operands)), _span(token))


def _path(token: Any) -> Path:
    """Steps from right to left, without recursion."""
    span = _span(token)
    steps: list[Step] = []
    current = token
    while current.symbol in ("/", "//"):
        operands = list(current)
        if operands:
            steps.extend(reversed(_steps(operands[-1])))
        if current.symbol == "//":
            steps.append(ANY_NODE)
        if len(operands) < 2:
            return Path(tuple(reversed(steps)), absolute=True, span=span)
        current = operands[0]
    start = expression(current)
    if isinstance(start, Path) and start.start is None:
        return Path((*start.steps, *reversed(steps)), start.absolute, span=span)
    return Path(tuple(reversed(steps)), start=start, span=span)


def _steps(token: Any) -> list[Step]:
    """The right side of a slash."""
    predicates: list[Expression] = []
    current = token
    while current.symbol == "[":
        predicates.append(expression(current[1]))
        current = current[0]
    if not _is_step(current):
        raise QueryError(
            f"{current.symbol!r} cannot follow a slash",
            at=Place(column=_span(current)[0] + 1),
            remedy="A path goes on with steps such as frame or @Rx.",
        )
    step = _step(current)
    return [Step(step.axis, step.name, tuple(reversed(predicates)), _span(token))]


def _filter(token: Any) -> Expression:
    predicates: list[Expression] = []
    current = token
    while current.symbol == "[":
        predicates.append(expression(current[1]))
        current = current[0]
    if _is_step(current):
        return Path(tuple(_steps(token)), span=_span(token))
    return Filter(expression(current), tuple(reversed(predicates)), _span(token))


def _is_step(token: Any) -> bool:
    symbol = token.symbol
    is_name = symbol == "(name)" or (symbol == "*" and not len(token))
    return is_name or symbol in (".", "..", "@", *KIND_TESTS) or (symbol in AXES and len(token) == 1)


def _step(token: Any) -> Step:
    span = _span(token)
    symbol = token.symbol
    if symbol == ".":
        return Step("self", "node()", span=span)
    if symbol == "..":
        return Step("parent", "node()", span=span)
    if symbol == "@":
        return Step("attribute", _test(token[0]), span=span)
    if symbol in AXES and len(token) == 1:
        return Step(symbol, _test(token[0]), span=span)
    return Step("child", _test(token), span=span)


def _test(token: Any) -> str:
    if token.symbol == "(name)":
        return str(token.value)
    if token.symbol in KIND_TESTS:
        inner = f"'{token[0].value}'" if len(token) else ""
        return f"{token.symbol}({inner})"
    if token.symbol == "*" and not len(token):
        return "*"
    raise QueryError(f"{token.symbol!r} is no node test", at=Place(column=_span(token)[0] + 1))


def _span(token: Any) -> Span:
    """From the first character of the whole expression to the last of the token that joins it."""
    # Noted on each token: a long sum leans to the left, and all its parts begin where it does.
    below: list[Any] = []
    current = token
    while "first_character" not in current.__dict__:
        below.append(current)
        if not len(current):
            break
        current = current[0]
    first = current.__dict__.get("first_character", current.span[0])
    for part in reversed(below):
        first = min(first, int(part.span[0]))
        part.first_character = first
    return first, int(token.span[1])
