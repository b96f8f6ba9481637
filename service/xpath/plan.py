"""What animators ask most, answered from rows and indexes: frames by motion name, their bones, their numbers.

`plan` recognises such questions on the tree, so every spelling of one has one plan: `//frame[motion_name='X']`,
`/mcml/motion/frame['X'=./motion_name]`, `/descendant::frame[child::motion_name='X']`. All frames are children of the
one motion of a document, which is why `//frame[3]` and `/mcml/motion/frame[3]` are the same. For everything else
`plan` gives None, and the projected document answers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from service.mcml.content import declarations
from service.mcml.vocabulary import FRAME, FRAME_BONE, MCML, MOTION, MOTION_NAME, NAME
from service.xpath.tree import Call, Expression, Filter, Literal, Operation, Path, Step

NODES, COUNT, EXISTS = "nodes", "count", "exists"


@dataclass(frozen=True, slots=True)
class Plan:
    """Frames of every document in scope, or something of them.

    position: only the frame at this position in its document (from 1), taken before the motion names are looked at.
    motion_names: only frames that carry, for every group, one of its names: ((a, b), (c,)) is (a or b) and c.
    nth: of the frames left in a document, only the nth (from 1).
    bones: whether frame_bones are asked for, instead of frames. bone: only that of this name.
    ordinal: only the frame_bone at this position in its frame.
    attribute: the attribute asked for, of the frame_bone or the frame; None for the elements.
    nth_result: of the results of all documents together, only the nth: an outermost `(…)[n]` combines documents.
    aggregate: "nodes", "count" (their number in all documents together) or "exists" (a boolean for each document).
    """

    position: int | None = None
    motion_names: tuple[tuple[str, ...], ...] = ()
    nth: int | None = None
    bones: bool = False
    bone: str | None = None
    ordinal: int | None = None
    attribute: str | None = None
    nth_result: int | None = None
    aggregate: str = NODES


def plan(tree: Expression) -> Plan | None:
    """The plan of an expression, None where there is none."""
    if isinstance(tree, Call) and len(tree.arguments) == 1:
        aggregate = {"count": COUNT, "boolean": EXISTS}.get(tree.function)
        inner = _in_each_document(plan(tree.arguments[0])) if aggregate else None
        return replace(inner, aggregate=aggregate) if inner and aggregate and inner.aggregate == NODES else None
    if isinstance(tree, Filter) and len(tree.predicates) == 1:
        inner, nth = plan(tree.operand), _position(tree.predicates[0])
        if inner is None or nth is None or inner.aggregate != NODES or inner.nth_result is not None:
            return None
        return replace(inner, nth_result=nth)
    if not isinstance(tree, Path):
        return None
    steps = _shorter(tree.steps)
    if tree.start is not None:
        first = _in_each_document(plan(tree.start))
        is_frames = first is not None and not first.bones and first.attribute is None and first.aggregate == NODES
        return _below_frame(first, steps) if first is not None and is_frames else None
    if not tree.absolute:
        return None
    at = 0
    context = ""
    while at < len(steps) and context not in (FRAME, FRAME_BONE):
        step = steps[at]
        context = _next(context, step)
        if not context or (step.predicates and context not in (FRAME, FRAME_BONE)):
            return None
        at += 1
    if context == FRAME:
        framed = _frame_predicates(steps[at - 1].predicates)
        return None if framed is None else _below_frame(framed, steps[at:])
    if context == FRAME_BONE:
        # //frame_bone[2] is the second of every frame, but /descendant::frame_bone[2] the second of all.
        step = steps[at - 1]
        if step.axis != "child" and any(_position(predicate) is not None for predicate in step.predicates):
            return None
        return _below_frame(Plan(), (replace(step, axis="child"), *steps[at:]))
    return None


def _in_each_document(inner: Plan | None) -> Plan | None:
    """The plan of a part of an expression: there, `(…)[n]` counts within each document."""
    if inner is None or inner.nth_result is None:
        return inner
    if inner.bones or inner.nth is not None:
        return None
    return replace(inner, nth=inner.nth_result, nth_result=None)


def _next(context: str, step: Step) -> str:
    """The element type all of whose elements a step reaches from all elements of another; "" if there is none.

    From the document ("") a document has one mcml, with one motion, and all frames are children of that.
    """
    below = {"": (MCML, MOTION, FRAME, FRAME_BONE), MCML: (MOTION, FRAME, FRAME_BONE), MOTION: (FRAME, FRAME_BONE)}
    wanted = below.get(context, ())
    if step.axis == "child":
        return step.name if wanted and step.name == wanted[0] else ""
    if step.axis in ("descendant", "descendant-or-self"):
        return step.name if step.name in wanted else ""
    return ""


def _shorter(steps: tuple[Step, ...]) -> tuple[Step, ...]:
    """Without `self::node()`; `descendant-or-self::node()/child::x` as `descendant::x` where that is the same.

    It is not where a position counts within each parent; of frames, which have one parent, it is anyway.
    """
    result: list[Step] = []
    for step in steps:
        if (step.axis, step.name, step.predicates) == ("self", "node()", ()):
            continue
        before = result[-1] if result else None
        if before is not None and (before.axis, before.name, before.predicates) == ("descendant-or-self", "node()", ()):
            counted = any(_counts(predicate) for predicate in step.predicates)
            if step.axis in ("child", "descendant") and (not counted or step.name == FRAME):
                result[-1] = replace(step, axis="descendant")
                continue
        result.append(step)
    return tuple(result)


def _counts(predicate: Expression) -> bool:
    """Whether a predicate can depend on positions. Only comparisons of paths with strings surely do not."""
    return _any_names(predicate) is None and _named(predicate) is None


def _frame_predicates(predicates: tuple[Expression, ...]) -> Plan | None:
    result = Plan()
    for predicate in predicates:
        position = _position(predicate)
        if position is not None:
            if result.nth is not None or (result.position is not None and not result.motion_names):
                return None
            taken_first = not result.motion_names and result.position is None
            result = replace(result, position=position) if taken_first else replace(result, nth=position)
            continue
        groups = _groups(predicate)
        if groups is None or result.nth is not None:
            return None
        result = replace(result, motion_names=(*result.motion_names, *groups))
    return result


def _groups(predicate: Expression) -> tuple[tuple[str, ...], ...] | None:
    """Groups of motion names, one of each of which a frame must carry."""
    if isinstance(predicate, Operation) and predicate.operator == "and":
        groups = [_groups(operand) for operand in predicate.operands]
        return None if None in groups else tuple(group for found in groups if found for group in found)
    names = _any_names(predicate)
    return None if names is None else (names,)


def _any_names(predicate: Expression) -> tuple[str, ...] | None:
    """The names of `motion_name='a' or motion_name='b'`."""
    if isinstance(predicate, Operation) and predicate.operator == "or":
        names = [_any_names(operand) for operand in predicate.operands]
        return None if None in names else tuple(dict.fromkeys(name for found in names if found for name in found))
    compared = _compared(predicate)
    if compared is not None:
        path, value = compared
        steps = _shorter(path.steps)
        if steps and steps[-1].name == "text()" and steps[-1].axis == "child" and not steps[-1].predicates:
            steps = steps[:-1]
        return (value,) if _is_child(steps, MOTION_NAME) and not steps[0].predicates else None
    if isinstance(predicate, Path) and not predicate.absolute and predicate.start is None:
        # motion_name[.='X'] as a predicate of its own
        steps = _shorter(predicate.steps)
        if _is_child(steps, MOTION_NAME) and len(steps[0].predicates) == 1:
            inner = _compared(steps[0].predicates[0])
            if inner is not None and _shorter(inner[0].steps) in ((), (Step("child", "text()"),)):
                return (inner[1],)
    return None


def _is_child(steps: tuple[Step, ...], name: str) -> bool:
    return len(steps) == 1 and steps[0].axis in ("child", "descendant") and steps[0].name == name


def _below_frame(frames: Plan, steps: tuple[Step, ...]) -> Plan | None:
    """Steps after the frames: a frame_bone, an attribute."""
    result = frames
    if steps and steps[0].axis in ("child", "descendant") and steps[0].name == FRAME_BONE:
        bones = _bone_predicates(replace(frames, bones=True), steps[0].predicates)
        if bones is None:
            return None
        result, steps = bones, steps[1:]
    if not steps:
        return result
    step = steps[0]
    allowed = declarations()[FRAME_BONE if result.bones else FRAME].attributes
    if len(steps) > 1 or step.axis != "attribute" or step.predicates or step.name not in allowed:
        return None
    return replace(result, attribute=step.name)


def _bone_predicates(frames: Plan, predicates: tuple[Expression, ...]) -> Plan | None:
    if not predicates:
        return frames
    if len(predicates) > 1:
        return None
    position, name = _position(predicates[0]), _named(predicates[0])
    if position is not None:
        return replace(frames, ordinal=position)
    return None if name is None else replace(frames, bone=name)


def _named(predicate: Expression) -> str | None:
    """B of `@name='B'`."""
    compared = _compared(predicate)
    if compared is None:
        return None
    steps = _shorter(compared[0].steps)
    is_name = len(steps) == 1 and steps[0].axis == "attribute" and steps[0].name == NAME and not steps[0].predicates
    return compared[1] if is_name else None


def _compared(predicate: Expression) -> tuple[Path, str] | None:
    """Path and string of `path = 'string'` or `'string' = path`, the path from the context node."""
    if not isinstance(predicate, Operation) or predicate.operator != "=" or len(predicate.operands) != 2:
        return None
    for one, other in (predicate.operands, predicate.operands[::-1]):
        is_path = isinstance(one, Path) and not one.absolute and one.start is None
        if is_path and isinstance(one, Path) and isinstance(other, Literal) and isinstance(other.value, str):
            return one, other.value
    return None


def _position(predicate: Expression) -> int | None:
    """N of `N` or `position()=N`, a whole number from 1."""
    value: Expression = predicate
    if isinstance(predicate, Operation) and predicate.operator == "=" and len(predicate.operands) == 2:
        for one, other in (predicate.operands, predicate.operands[::-1]):
            if isinstance(one, Call) and one.function == "position":
                value = other
    if not isinstance(value, Literal) or not isinstance(value.value, float):
        return None
    return int(value.value) if value.value >= 1 and value.value.is_integer() else None
