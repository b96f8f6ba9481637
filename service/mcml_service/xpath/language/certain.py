"""Three-valued conditions about bodies in motion: true, false or unknown.

XPath has two values. A comparison with NaN is false, so its negation is true, and a frame with a missing joint would
count as a frame in which the joint is slow. This module rewrites conditions to their certain cases (Kleene's strong
logic of indeterminacy): `not(mo:speed('x') > 1)` becomes `mo:speed('x') <= 1`, and `not(mo:contact('x'))` becomes
`not(mo:contact('x')) and mo:known(mo:contact('x'))`. It rewrites predicates, the test of `if`, and the conditions of
`some` and `every`. Conditions without motion functions, and arguments of `mo:known`, keep their two values.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from mcml.errors import Place, QueryError
from mcml_service.xpath.language.calls import argument_spans, written_calls
from mcml_service.xpath.language.motion_functions import KNOWN, MOTION_FUNCTIONS
from mcml_service.xpath.language.tree import (
    Call,
    Each,
    Expression,
    Filter,
    If,
    Operation,
    Path,
    Quantified,
    Variable,
    Written,
    children,
    predicates_of,
    walk,
    with_children,
)
from mcml_service.xpath.language.tree import Sequence as Items
from mcml_service.xpath.language.types import item_type, type_of

_OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "=": "!=", "!=": "="}
_OPPOSITE |= {"lt": "ge", "le": "gt", "gt": "le", "ge": "lt", "eq": "ne", "ne": "eq"}
NOTHING = Items(())
_QUOTED = re.compile(r"""'[^']*'|"[^"]*\"""")
_NOT = re.compile(r"(?<![\w.$:-])(?:fn:)?not\s*(?=\()")
_CONDITION = re.compile(r"\b(not|if|some|every|empty|exists|boolean)\b")
_UNCERTAIN = re.compile(r"(!=|(?<![\w.$:/@-])ne(?![\w.:(-]))|(?<![\w.$:-])(if)\s*(?=\()")
_ITEM = "known"
"""The name of a variable that no expression of a user binds."""


def certain(expression: Expression) -> Expression:
    """Rewrite all conditions about bodies."""
    if not any(isinstance(part, Call) and part.function in MOTION_FUNCTIONS for part in walk(expression)):
        return expression
    return _within(expression)


def _within(expression: Expression) -> Expression:
    """Rewrite the conditions inside an expression that is not a condition."""
    if isinstance(expression, Path):
        start = None if expression.start is None else _within(expression.start)
        steps = tuple(step.where(tuple(map(_predicate, step.predicates))) for step in expression.steps)
        return Path(steps, expression.absolute, start, expression.span)
    if isinstance(expression, Filter):
        predicates = tuple(map(_predicate, expression.predicates))
        return Filter(_within(expression.operand), predicates, expression.span)
    if isinstance(expression, If):
        return _chosen(expression)
    if isinstance(expression, Quantified | Operation) and type_of(expression) == "boolean":
        return _sure(expression, True)
    if isinstance(expression, Call) and expression.function in ("not", "boolean"):
        return _sure(expression, True)
    return with_children(expression, _within)


def _chosen(expression: If) -> Expression:
    """Rewrite `if`: an unknown test gives an empty sequence."""
    then, otherwise = _within(expression.then), _within(expression.otherwise)
    test = _sure(expression.test, True)
    if _asks_body(expression.test):
        otherwise = If(_sure(expression.test, False), otherwise, NOTHING, expression.span)
    return If(test, then, otherwise, expression.span)


def _predicate(predicate: Expression) -> Expression:
    # A number is a position.
    return _within(predicate) if type_of(predicate) == "number" else _sure(predicate, True)


def _sure(condition: Expression, wanted: bool) -> Expression:
    """Return an expression that is true if and only if the condition is certainly `wanted`."""
    if not _asks_body(condition):
        inner = with_children(condition, _within)
        return inner if wanted else Call("not", (inner,), condition.span)
    if isinstance(condition, Operation) and condition.operator in ("and", "or"):
        operator = condition.operator if wanted else {"and": "or", "or": "and"}[condition.operator]
        return Operation(operator, tuple(_sure(each, wanted) for each in condition.operands), condition.span)
    if isinstance(condition, Call) and condition.function in ("not", "boolean"):
        return _sure(condition.arguments[0], wanted == (condition.function == "boolean"))
    if isinstance(condition, Quantified):
        quantifier = condition.quantifier if wanted else {"some": "every", "every": "some"}[condition.quantifier]
        body = _sure(condition.body, wanted)
        return replace(condition, quantifier=quantifier, source=_within(condition.source), body=body)
    if isinstance(condition, If):
        then, otherwise = _sure(condition.then, wanted), _sure(condition.otherwise, wanted)
        branches = (_both(_sure(condition.test, True), then), _both(_sure(condition.test, False), otherwise))
        return Operation("or", branches, condition.span)
    if isinstance(condition, Operation):
        return _compared(condition, wanted)
    inner = with_children(condition, _within)
    if type_of(condition) == "number":
        return inner if wanted else Operation("=", (inner, Call("number", (Call("false"),))), condition.span)
    return inner if wanted else _both(Call("not", (inner,), condition.span), *_known(inner))


def _compared(condition: Operation, wanted: bool) -> Expression:
    """Rewrite a comparison. With NaN, only `!=` is true."""
    operands = tuple(map(_within, condition.operands))
    inner = Operation(condition.operator, operands, condition.span)
    if condition.operator in _OPPOSITE and len(operands) == 2 and all(map(_is_number, operands)):
        operator = condition.operator if wanted else _OPPOSITE[condition.operator]
        sides = {"!=": ("<", ">"), "ne": ("lt", "gt")}.get(operator, (operator,))
        found = tuple(Operation(side, operands, condition.span) for side in sides)
        return found[0] if len(found) == 1 else Operation("or", found, condition.span)
    if wanted and condition.operator not in ("!=", "ne"):
        return inner
    known = [part for each in operands for part in _known(each)]
    return _both(inner if wanted else Call("not", (inner,), condition.span), *known)


def _is_number(expression: Expression) -> bool:
    """Whether the value is exactly one number."""
    if isinstance(expression, Operation):
        return type_of(expression) == "number" and all(map(_is_number, expression.operands))
    is_maybe_none = isinstance(expression, Call) and expression.function in ("min", "max", "avg")
    return type_of(expression) == "number" and not is_maybe_none


def _known(expression: Expression) -> list[Expression]:
    """Return conditions: each motion function of the expression, in its own context, has a known value."""
    if not _asks_body(expression):
        return []
    if isinstance(expression, Call) and expression.function in MOTION_FUNCTIONS:
        return [Call(KNOWN, (expression,))] if type_of(expression) in ("number", "boolean") else []
    if isinstance(expression, Each) and not _asks_body(expression.body):
        # Frames of a window are known, whatever is read from them.
        return _known(expression.source)
    if isinstance(expression, Each):
        item = Variable(_ITEM, item_type(expression))
        return [Quantified("every", _ITEM, expression, Operation("=", (item, item)))]
    return [part for child in children(expression) for part in _known(child)]


def _both(*conditions: Expression) -> Expression:
    return conditions[0] if len(conditions) == 1 else Operation("and", conditions)


def _asks_body(expression: Expression) -> bool:
    """Whether the value depends on motion functions outside of predicates."""
    if isinstance(expression, Call) and expression.function in MOTION_FUNCTIONS:
        return expression.function != KNOWN
    if isinstance(expression, Path):
        return expression.start is not None and _asks_body(expression.start)
    if isinstance(expression, Filter):
        return _asks_body(expression.operand)
    return any(map(_asks_body, children(expression)))


def conditions(expression: Expression) -> list[Call]:
    """Return the calls of motion functions in conditions.

    Conditions are predicates, tests of `if`, and the conditions of `some` and `every`. In an expression that has
    no columns, all calls in brackets count, or all calls if it has other conditions.
    """
    found: list[Call] = []
    waiting = [(expression, False)]
    while waiting:
        part, is_asked = waiting.pop()
        if isinstance(part, Written):
            found += _written(part)
            continue
        if isinstance(part, Call) and part.function == KNOWN:
            continue
        if is_asked and isinstance(part, Call) and part.function in MOTION_FUNCTIONS:
            found.append(part)
        asked = set(map(id, _tests(part)))
        waiting += [(child, is_asked or id(child) in asked) for child in children(part)]
    return list(dict.fromkeys(reversed(found)))


def _tests(expression: Expression) -> Sequence[Expression]:
    """The parts directly inside that are conditions."""
    if isinstance(expression, Path):
        return predicates_of(expression.steps)
    if isinstance(expression, Filter):
        return expression.predicates
    if isinstance(expression, If):
        return (expression.test,)
    return (expression.body,) if isinstance(expression, Quantified) else ()


def _written(part: Written) -> list[Call]:
    text = _QUOTED.sub(lambda found: " " * len(found[0]), part.text)
    has_others = _CONDITION.search(text) is not None
    found = []
    for call in part.motion:
        if has_others or text.count("[", 0, call.span[0]) > text.count("]", 0, call.span[0]):
            found.append(call)
        found += conditions(call)
    return [call for call in found if call.function != KNOWN]


def certain_text(text: str) -> str:
    """Rewrite `not(…)` in an expression that elementpath reads. Calls in other contexts, behind a slash or in brackets,
    are not considered."""
    plain = _QUOTED.sub(lambda found: " " * len(found[0]), text)
    result, end = "", 0
    for match in _NOT.finditer(plain):
        spans, after = argument_spans(text, match.end() + 1)
        if match.start() < end or len(spans) != 1:
            continue
        start, stop = spans[0]
        known = [
            f"mo:known({text[slice(*one.span)]})"
            for one in written_calls(" " * start + text[start:stop], {})
            if plain.count("[", start, one.span[0]) == plain.count("]", start, one.span[0])
            and plain[start : one.span[0]].rstrip()[-1:] not in ("/", "!")
            and type_of(one.call) in ("number", "boolean")
            and one.call.function != KNOWN
        ]
        if known:
            inside = certain_text(text[start:stop])
            result += f"{text[end : match.start()]}(not({inside}) and {' and '.join(known)})"
            end = after
    return result + text[end:]


def require_certain(text: str) -> None:
    """Raise QueryError for a condition that elementpath reads, about a body, which an unknown value would make true:
    with `!=` or `ne`, or chosen by `if`. The text is that of `certain_text`."""
    plain = _QUOTED.sub(lambda found: " " * len(found[0]), text)
    if not any(type_of(one.call) in ("number", "boolean") for one in written_calls(text, {})):
        return
    for match in _UNCERTAIN.finditer(plain):
        first, end = _bracket(plain, match.start())
        asked = [one for one in written_calls(" " * first + text[first:end], {}) if one.call.function != KNOWN]
        if asked and "mo:known" not in plain[first:end]:
            call = text[slice(*asked[0].span)]
            raise QueryError(
                f"{match[1] or match[2]!r} beside {call} would take what is unknown as known here.",
                at=Place(column=match.start() + 1),
                remedy="Write not(a = b) for a != b, and `and` or `or` for if, or add mo:known(…).",
            )


def _bracket(plain: str, place: int) -> tuple[int, int]:
    """The innermost predicate around a place, or all of the text."""
    depth, first = 0, 0
    for at in range(place - 1, -1, -1):
        depth += (plain[at] == "]") - (plain[at] == "[")
        if depth < 0:
            first = at + 1
            break
    depth = 0
    for at in range(place, len(plain)):
        depth += (plain[at] == "[") - (plain[at] == "]")
        if depth < 0:
            return first, at
    return first, len(plain)
