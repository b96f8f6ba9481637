"""Rewrite equivalent expressions to the same tree, in the fastest form.

Each rule holds for every document that is valid against `mcml.dtd`; it relies on the element types that a step can
reach (`projection.reach`). Rules, in the order in which they are tried:

1. `self::node()` is left out.
2. `descendant-or-self::node()/child::x[p]` is `descendant::x[p]` where p does not count positions.
3. Where it does, and all x have parents of one type: `descendant-or-self::parent/child::x[p]`.
4. `descendant-or-self::node()/attribute::a` is `descendant-or-self::e/attribute::a` where only e has the attribute.
5. `descendant::x` where all x are children of frames is `descendant-or-self::frame/child::x`.
6. All frames are children of the one motion of the one `mcml`: from the document they are
   `/child::mcml/child::motion/child::frame`, positions and all.
7. `x[p and q]` is `x[p][q]` where p and q neither are numbers nor count positions.
8. `following-sibling::x/y = 'k'`, for a comparison with a constant, is `boolean(following-sibling::x[y = 'k'])`; so
   for the other sibling axes, `following` and `preceding`, and where the first predicate of x is a window of frames
   (`positions.window_of`). The same operand of a union is evaluated once.
9. `mo:window(a, b)/y = 'k'` is `boolean(mo:window(a, b)[y = 'k'])`, in the same way.
10. Features after XPath 1.0: see `later.py`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

from mcml.language.content import declarations
from mcml.language.vocabulary import FRAME, FRAME_BONE, MCML, MOTION, MOTION_NAME
from mcml_service.xpath.language.later import of_later
from mcml_service.xpath.language.motion_functions import WINDOW
from mcml_service.xpath.language.positions import BEYOND, counts, window_of
from mcml_service.xpath.language.reach import DOCUMENT, Types, parent_types, reach, types_of
from mcml_service.xpath.language.tree import (
    Call,
    Each,
    Expression,
    Filter,
    For,
    Function,
    Let,
    Literal,
    Operation,
    Path,
    Quantified,
    Step,
    Variable,
    free_variables,
    names_of,
    with_children,
)
from mcml_service.xpath.language.types import depends_on_position, type_of

COMPARISONS = ("=", "!=", "<", "<=", ">", ">=")
ANY = ("descendant-or-self", "node()")
_WAY = {DOCUMENT: (MCML, MOTION, FRAME), MCML: (MOTION, FRAME), MOTION: (FRAME,)}
"""From each of these the one way down to all frames."""


def normal(expression: Expression, context: Types = frozenset({DOCUMENT})) -> Expression:
    """The expression rewritten. context: types of its context node."""
    if isinstance(expression, Path):
        start = None if expression.start is None else normal(expression.start, context)
        types = frozenset({DOCUMENT}) if expression.absolute else context
        if expression.start is not None:
            types = types_of(expression.start, context)
        return Path(_steps(expression.steps, types), expression.absolute, start, expression.span)
    if isinstance(expression, Filter):
        types = types_of(expression.operand, context)
        predicates = tuple(normal(predicate, types) for predicate in expression.predicates)
        return Filter(normal(expression.operand, context), predicates, expression.span)
    if isinstance(expression, Call):
        arguments = [normal(each, context) for each in expression.arguments]
        if expression.function == "sort" and len(arguments) == 3 and isinstance(arguments[2], Function):
            key = arguments[2]
            typed = _typed(key.body, key.variable, types_of(arguments[0], context))
            arguments[2] = replace(key, body=normal(typed, context))
        return Call(expression.function, tuple(arguments), expression.span)
    if isinstance(expression, Operation):
        simpler = of_later(expression)
        if simpler is not expression:
            return normal(simpler, context)
        return _operation(expression, context)
    return _later(expression, context)


def _later(expression: Expression, context: Types) -> Expression:
    """Rewrite expressions that bind variables: these get the types of their possible nodes."""
    if isinstance(expression, Quantified):
        simpler = of_later(expression)
        if simpler is not expression:
            return normal(simpler, context)
    if isinstance(expression, For | Let | Quantified):
        source = normal(expression.source, context)
        body = _typed(expression.body, expression.variable, types_of(source, context))
        return replace(expression, source=source, body=normal(body, context))
    if isinstance(expression, Each):
        source = normal(expression.source, context)
        return replace(expression, source=source, body=normal(expression.body, types_of(source, context)))
    return with_children(expression, lambda part: normal(part, context))


def _typed(expression: Expression, variable: str, types: Types) -> Expression:
    """Set the types of a variable's possible nodes."""
    if isinstance(expression, Variable):
        return replace(expression, reached=types) if expression.name == variable else expression
    if variable not in free_variables(expression):
        return expression
    if isinstance(expression, For | Let | Quantified) and variable in names_of(expression):
        return replace(expression, source=_typed(expression.source, variable, types))
    return with_children(expression, lambda part: _typed(part, variable, types))


def _operation(operation: Operation, context: Types) -> Expression:
    """Rule 8."""
    operands = tuple(normal(each, context) for each in operation.operands)
    if operation.operator == "|":
        operands = tuple(dict.fromkeys(operands))
        return operands[0] if len(operands) == 1 else Operation("|", operands, operation.span)
    if operation.operator in COMPARISONS and len(operands) == 2:
        for place, path in enumerate(operands):
            other = operands[1 - place]
            if not isinstance(other, Literal):
                continue
            in_window = _in_window(operation, path, other, place)
            if in_window is not None:
                return Call("boolean", (in_window,), operation.span)
            if not isinstance(path, Path) or path.absolute or path.start is not None:
                continue
            first, rest = path.steps[0] if path.steps else None, path.steps[1:]
            if first is None or first.axis not in BEYOND or (counts(first) and window_of(first) is None):
                continue
            inner = Path(rest or (Step("self", "node()"),))
            sides = (inner, other) if place == 0 else (other, inner)
            held = first.where((*first.predicates, Operation(operation.operator, sides)))
            return Call("boolean", (Path((held,)),), operation.span)
    return Operation(operation.operator, operands, operation.span)


def _in_window(operation: Operation, path: Expression, other: Expression, place: int) -> Expression | None:
    """Rule 9: the window with the comparison as predicate."""
    if isinstance(path, Path) and path.start is not None and path.steps:
        start: Expression = path.start
        inner: Expression = Path(path.steps)
    elif isinstance(path, Each) and path.is_step and not free_variables(path.body):
        start, inner = path.source, path.body
    else:
        return None
    window = start.operand if isinstance(start, Filter) else start
    if not isinstance(window, Call) or window.function != WINDOW or depends_on_position(inner):
        return None
    if type_of(inner) not in ("nodes", "number", "boolean", "string"):
        return None
    sides = (inner, other) if place == 0 else (other, inner)
    asked = Operation(operation.operator, sides)
    if isinstance(start, Filter):
        return Filter(start.operand, (*start.predicates, asked), start.span)
    return Filter(start, (asked,), start.span)


def after(types: Types, step: Step) -> Types:
    """Types of the nodes that a step can reach."""
    return frozenset[str]().union(*(reach(source, step) for source in types))


def _steps(steps: Sequence[Step], types: Types) -> tuple[Step, ...]:
    waiting = [step for step in steps if (step.axis, step.name, step.predicates) != ("self", "node()", ())]
    waiting.reverse()
    result: list[Step] = []
    while waiting:
        step = waiting.pop()
        rewritten = _any_depth(step, waiting[-1] if waiting else None)
        if rewritten is not None:
            waiting.pop()
            waiting.extend(reversed(rewritten))
            continue
        rewritten = _to_frames(step, types)
        if rewritten is not None:
            waiting.extend(reversed(rewritten))
            continue
        reached = after(types, step)
        predicates = tuple(normal(each, reached) for predicate in step.predicates for each in _parts(predicate))
        result.append(step.where(predicates))
        types = reached
    return tuple(result)


def _parts(predicate: Expression) -> tuple[Expression, ...]:
    """Rule 7: the operands of an `and`."""
    if not isinstance(predicate, Operation) or predicate.operator != "and":
        return (predicate,)
    if any(type_of(each) == "number" or depends_on_position(each) for each in predicate.operands):
        return (predicate,)
    return tuple(part for operand in predicate.operands for part in _parts(operand))


def _any_depth(step: Step, following: Step | None) -> list[Step] | None:
    """Apply rules 2 to 4 to `descendant-or-self::node()` and the step after it."""
    if following is None or (step.axis, step.name) != ANY or step.predicates:
        return None
    if following.axis in ("child", "descendant") and not counts(following):
        return [following.along("descendant")]
    if following.axis == "child":
        above = frozenset(holder for source in _types_named(following) for holder in parent_types(source))
        holder = next(iter(above)) if len(above) == 1 else ""
        return [Step("descendant-or-self", holder), following] if holder in declarations() else None
    if following.axis == "attribute":
        owners = [name for name, declared in declarations().items() if following.name in declared.attributes]
        return [Step("descendant-or-self", owners[0]), following] if len(owners) == 1 else None
    return None


def _to_frames(step: Step, types: Types) -> list[Step] | None:
    """Apply rules 5 and 6 to steps to frames, and to nodes that exist only in frames."""
    if step.axis not in ("descendant", "descendant-or-self"):
        return None
    if step.name in (FRAME_BONE, MOTION_NAME) and not counts(step) and step.name not in types:
        return [Step("descendant-or-self", FRAME), step.along("child")]
    holder = next(iter(types)) if len(types) == 1 else ""
    if holder in _WAY and step.name in _WAY[holder]:
        between = _WAY[holder][: _WAY[holder].index(step.name)]
        return [*(Step("child", name) for name in between), step.along("child")]
    return None


@cache
def _types_named(step: Step) -> Types:
    """All types that a step of this name can reach from anywhere."""
    return frozenset({step.name}) if step.name in declarations() else frozenset()
