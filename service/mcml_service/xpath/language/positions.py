"""Positions in predicates and steps, if they are a number, a distance or a window."""

from __future__ import annotations

import math

from mcml.language.vocabulary import FRAME
from mcml_service.xpath.language.tree import (
    TURNED,
    Call,
    Expression,
    Literal,
    Operation,
    Path,
    Step,
)
from mcml_service.xpath.language.types import depends_on_position, type_of

FAR = 2**38
"""A position beyond the end of every list, as all greater ones are. It can be part of the number of a node."""

BEFORE, AFTER = "preceding-sibling", "following-sibling"
Window = tuple[int, int]
"""First and last position, counted from 1 in the direction of the axis."""

BEYOND = frozenset({BEFORE, AFTER, "following", "preceding"})


def counts(step: Step) -> bool:
    """Whether a predicate of the step depends on positions."""
    return any(map(_counts, step.predicates))


def _counts(predicate: Expression) -> bool:
    return type_of(predicate) == "number" or depends_on_position(predicate)


def position_of(predicate: Expression) -> int | None:
    """N of `N` or `position()=N`, a whole number from 1."""
    value: Expression = predicate
    if isinstance(predicate, Operation) and predicate.operator == "=" and len(predicate.operands) == 2:
        for one, other in (predicate.operands, predicate.operands[::-1]):
            if isinstance(one, Call) and one.function == "position":
                value = other
    if not isinstance(value, Literal) or not isinstance(value.value, float):
        return None
    # Infinity is no integer, and NaN is not at least 1.
    return int(min(value.value, FAR)) if value.value >= 1 and value.value.is_integer() else None


def frame_distance(step: Step) -> int | None:
    """N of `following-sibling::frame[N]…`, -N of `preceding-sibling::frame[N]…`, None for other steps."""
    if step.axis not in (BEFORE, AFTER) or step.name != FRAME or not step.predicates:
        return None
    position = position_of(step.predicates[0])
    return position if position is None or step.axis == AFTER else -position


def frame_place(step: Step) -> int | None:
    """N of `child::frame[N]…`, None for other steps."""
    if step.axis != "child" or step.name != FRAME or not step.predicates:
        return None
    return position_of(step.predicates[0])


def is_beyond(path: Path) -> bool:
    """Tell whether a path from the context node begins with all nodes before or after it."""
    first = None if path.absolute or path.start is not None or not path.steps else path.steps[0]
    return first is not None and first.axis in BEYOND and not counts(first)


def is_window(expression: Expression) -> bool:
    """Whether a path from the context node begins with a window of frames."""
    if not isinstance(expression, Path) or expression.absolute or expression.start is not None or not expression.steps:
        return False
    return window_of(expression.steps[0]) is not None


def window_of(step: Step) -> Window | None:
    """Of `following-sibling::frame[position() <= 120][…]`, or of preceding ones, the window. None for other steps, and
    where positions are counted behind it."""
    if step.axis not in (BEFORE, AFTER) or step.name != FRAME or not step.predicates:
        return None
    first, *others = step.predicates
    return None if any(map(_counts, others)) else _window(first)


def _window(predicate: Expression) -> Window | None:
    if not isinstance(predicate, Operation) or len(predicate.operands) < 2:
        return None
    if predicate.operator == "and":
        parts = [_window(operand) for operand in predicate.operands]
        found = [part for part in parts if part is not None]
        return (max(low for low, _ in found), min(high for _, high in found)) if len(found) == len(parts) else None
    if predicate.operator not in TURNED or predicate.operator == "!=" or len(predicate.operands) > 2:
        return None
    one, other = predicate.operands
    operator = predicate.operator
    if isinstance(one, Literal):
        one, other, operator = other, one, TURNED[operator]
    if not isinstance(one, Call) or one.function != "position" or not isinstance(other, Literal):
        return None
    bound = other.value
    if isinstance(bound, str) or math.isnan(bound):
        return None
    bound = max(-FAR, min(FAR, bound))
    if operator == "=":
        return (int(bound), int(bound)) if bound == int(bound) else (1, 0)
    if operator in (">", ">="):
        low = math.floor(bound) + 1 if operator == ">" else math.ceil(bound)
        return max(1, low), FAR
    return 1, math.ceil(bound) - 1 if operator == "<" else math.floor(bound)
