"""Hints on probable mistakes in a valid expression that finds nothing."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from typing import Literal

from mcml.language.content import declarations
from mcml.language.vocabulary import FRAME, FRAME_BONE, MOTION_NAME, NAME, ROOT
from mcml.motion.bodies.quantities import is_foot
from mcml_service.xpath.language.motion_functions import (
    ANGLE,
    JOINT_OR_SIDE,
    JOINTS,
    KNOWN,
    MOTION_FUNCTIONS,
    OF_DOCUMENT,
    OF_FRAME_SETS,
    TOP,
)
from mcml_service.xpath.language.reach import DOCUMENT, Types, types_of
from mcml_service.xpath.language.rules import after
from mcml_service.xpath.language.tree import (
    Call,
    Each,
    Expression,
    Filter,
    For,
    Let,
    Operation,
    Path,
    Quantified,
    Step,
    Written,
    children,
    walk,
)
from mcml_service.xpath.language.tree import Literal as Text

Kind = Literal["bone", "span"]
_NAMED = {"bone": "bone here is named", "span": "motion name here is"}
IN_FRAMES = frozenset({FRAME, FRAME_BONE, MOTION_NAME})
_IS_MOTION_NAME = frozenset({MOTION_NAME, f"#{MOTION_NAME}"})
_IS_BONE_NAME = frozenset({NAME, f"#{NAME}"})
_HAS_BONE_NAME = frozenset({f"@{FRAME_BONE}", f"@{ROOT}"})


def hints(tree: Expression) -> list[str]:
    """Return all hints, except those that depend on the content of a store."""
    return [*unknown_names(tree), *lost_contexts(tree)]


def unknown_names(tree: Expression) -> list[str]:
    """For each step that can reach nothing in any document, why, and the nearest name that could."""
    found: list[str] = []
    for expression, context in _with_contexts(tree, frozenset({DOCUMENT})):
        if isinstance(expression, Path):
            types = _before(expression, context)
            for step in expression.steps:
                reached = after(types, step)
                if types and not reached:
                    found += _hint(types, step)
                types = reached
    return list(dict.fromkeys(found))


def lost_contexts(tree: Expression) -> list[str]:
    """Return a hint for each function of a frame's body that is called for a whole document, which is not in a
    frame.
    """
    bound = [
        part.variable
        for part in walk(tree)
        if isinstance(part, For | Let | Quantified) and types_of(part.source, frozenset({DOCUMENT})) & IN_FRAMES
    ]
    found = [
        f"{call.function} is evaluated for a document, not for a frame, so it is NaN; write "
        f"{f'${bound[0]}' if bound else '//frame'}/{call.function}(…)"
        for call, context in _with_contexts(tree, frozenset({DOCUMENT}))
        if isinstance(call, Call)
        and call.function in MOTION_FUNCTIONS.keys() - OF_DOCUMENT - OF_FRAME_SETS - {KNOWN}
        and context == {DOCUMENT}
    ]
    return list(dict.fromkeys(found))


def compared_names(tree: Expression) -> list[tuple[Kind, str]]:
    """The texts that names of bones, and motion names, are compared with."""
    found: list[tuple[Kind, str]] = []
    for expression, context in _with_contexts(tree, frozenset({DOCUMENT})):
        if isinstance(expression, Call) and expression.function in MOTION_FUNCTIONS:
            found += [("bone", name) for name in _joints_named(expression)]
        if isinstance(expression, Operation) and expression.operator in ("=", "!="):
            for one, other in (expression.operands, expression.operands[::-1]):
                if isinstance(one, Path) and isinstance(other, Text) and isinstance(other.value, str):
                    found += [(kind, other.value) for kind in _kind_of(one, types_of(one, context))]
    return list(dict.fromkeys(found))


def _joints_named(call: Call) -> Iterator[str]:
    """Yield the joints that a function of bodies in motion gets by name."""
    parameters = MOTION_FUNCTIONS[call.function].parameters
    if call.function == ANGLE and len(call.arguments) == 1:
        return
    for parameter, argument in zip(parameters, call.arguments, strict=False):
        if not isinstance(argument, Text) or not isinstance(argument.value, str) or parameter.rstrip("?") not in JOINTS:
            continue
        if parameter != JOINT_OR_SIDE or not is_foot(argument.value):
            yield argument.value


def _kind_of(path: Path, types: Types) -> Iterator[Kind]:
    if not types:
        return
    if types <= _IS_MOTION_NAME:
        yield "span"
    elif types <= _IS_BONE_NAME or (types <= _HAS_BONE_NAME and path.steps[-1:] and path.steps[-1].name == NAME):
        yield "bone"


def not_found(kind: Kind, said: str, names: Iterable[str]) -> str:
    """Return the hint that no bone or frame has a name. names: existing ones; the hint suggests the nearest."""
    known = {_plain(name): name for name in names}
    near = [_plain(said)] if _plain(said) in known else get_close_matches(_plain(said), list(known), 1, 0.6)
    return f"no {_NAMED[kind]} {said!r}" + (f"; did you mean {known[near[0]]!r}?" if near else "")


def _plain(name: str) -> str:
    """Return a name without the differences between rigs: `LeftUpLeg` and `left_up_leg` are one."""
    return "".join(letter for letter in name.casefold() if letter.isalnum()) or name


def _with_contexts(expression: Expression, context: Types) -> Iterator[tuple[Expression, Types]]:
    """The expression and all expressions in it, each with the types of its context node."""
    yield expression, context
    if isinstance(expression, Path):
        types = _before(expression, context)
        if expression.start is not None:
            yield from _with_contexts(expression.start, context)
        for step in expression.steps:
            types = after(types, step)
            for predicate in step.predicates:
                yield from _with_contexts(predicate, types)
    elif isinstance(expression, Filter):
        yield from _with_contexts(expression.operand, context)
        for predicate in expression.predicates:
            yield from _with_contexts(predicate, types_of(expression.operand, context))
    elif isinstance(expression, Each):
        yield from _with_contexts(expression.source, context)
        yield from _with_contexts(expression.body, types_of(expression.source, context))
    elif isinstance(expression, Call) and expression.function == TOP:
        for place, argument in enumerate(expression.arguments):
            yield from _with_contexts(argument, frozenset({FRAME}) if place == 2 else context)
    else:
        # The context of the parts of an unparsed expression is unknown.
        context = frozenset() if isinstance(expression, Written) else context
        for inner in children(expression):
            yield from _with_contexts(inner, context)


def _before(path: Path, context: Types) -> Types:
    """Types of the nodes from which the first step of a path leads."""
    if path.start is not None:
        return types_of(path.start, context)
    return frozenset({DOCUMENT}) if path.absolute else context


def _hint(types: Types, step: Step) -> Iterator[str]:
    is_attribute = step.axis == "attribute"
    if step.name in ("*", "node()") or step.name.endswith(")"):
        return
    said = f"@{step.name}" if is_attribute else step.name
    owners = {name: declared.attributes for name, declared in declarations().items()}
    attributes = {name for held in owners.values() for name in held}
    known, others = (attributes, set(owners)) if is_attribute else (set(owners), attributes)
    if step.name not in known and step.name in others:
        other = "an element: leave the @ out" if is_attribute else f"an attribute: write @{step.name}"
        yield f"{step.name} is {other}"
        return
    if step.name not in known:
        near = _by_letters(step.name, known) or get_close_matches(step.name, sorted(known), 1, 0.5)
        what = "attribute" if is_attribute else "element"
        yield f"MCML has no {what} {said}" + (f"; did you mean {'@' * is_attribute}{near[0]}?" if near else "")
        return
    places = " or ".join(sorted(name for name in types if name[0] not in "#@")) or "there"
    if is_attribute:
        holders = ", ".join(sorted(name for name, held in owners.items() if step.name in held))
        yield f"{places} has no attribute {said}; it is one of {holders}"
    elif step.axis in ("child", "descendant"):
        holders = ", ".join(sorted(name for name, declared in declarations().items() if _holds(declared.steps, step)))
        yield f"{places} holds no {said}" + (f"; it is in {holders}" if holders else "")


def _by_letters(name: str, known: set[str]) -> list[str]:
    """The same name in other letters: `Frame_Bone`, `rx`."""
    return [other for other in sorted(known) if other.lower() == name.lower()]


def _holds(steps: object, step: Step) -> bool:
    return any(step.name in state for state in steps)  # type: ignore[attr-defined]  # an automaton
