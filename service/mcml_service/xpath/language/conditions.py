"""Predicates of frames and frame_bones as conditions on samples: the same expression, with a sample wherever a path
leads to one.

`frame_bone[@name='Hips']/@Ty > 90 and not(frame_bone[@name='Hips'][@Rx < @Ry])` reads only three samples of each frame:
`Hips/@Ty > 90 and not(Hips/@Rx < Hips/@Ry)`. A sample is a node set of one node or none, so the meaning of the
expression is unchanged, and the evaluator of expressions evaluates conditions. Only predicates that require a sample
become conditions: no frame without the sample can fulfil them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from mcml.language.vocabulary import FRAME, FRAME_BONE
from mcml.motion.skeleton import CHANNEL_INDEX, CHANNELS
from mcml_service.xpath.language.labels import named, without_self
from mcml_service.xpath.language.tree import (
    TURNED,
    Call,
    Expression,
    Literal,
    Operation,
    Path,
    Step,
    Variable,
    walk,
)


@dataclass(frozen=True, slots=True)
class Sample(Variable):
    """The sample of a channel in a frame, or none.

    bone: name of its bone, None for the queried frame_bone. channel: its number.
    """

    bone: str | None = None
    channel: int = 0


Own: TypeAlias = str | Sample | None

COMBINED = (Path, Operation, Call)
"""Kinds of expressions in a predicate that is not a constant."""
ARITHMETIC = ("+", "-", "*", "div", "mod", "negate")
OF_ONE_NUMBER = frozenset({"floor", "ceiling", "round", "number", "abs"})
"""Functions that give NaN for NaN, and for that alone."""


def sample(bone: str | None, channel: int) -> Sample:
    """The sample of a channel of a bone."""
    return Sample(f"{bone or ''} {CHANNELS[channel]}", "nodes", bone=bone, channel=channel)


def samples_of(condition: Expression) -> frozenset[Sample]:
    """All that a condition reads."""
    return frozenset(part for part in walk(condition) if isinstance(part, Sample))


def condition(predicate: Expression, context: str, own: Own = None) -> Expression | None:
    """Convert a predicate to a condition, None if that is impossible.

    context: "frame", "frame_bone" or "@frame_bone", the type of the context node. own: the name of that frame_bone, if
    it is stated; of a channel, its sample.
    """
    if isinstance(predicate, Operation) and predicate.operator in ("and", "or"):
        return _combined(predicate.operator, [condition(operand, context, own) for operand in predicate.operands])
    if isinstance(predicate, Operation) and predicate.operator in TURNED and len(predicate.operands) == 2:
        left, right = (_number(operand, context, own) for operand in predicate.operands)
        return None if left is None or right is None else _comparison(predicate.operator, left, right)
    if isinstance(predicate, Call) and predicate.function == "boolean":
        inner = predicate.arguments[0]
        return condition(inner, context, own) if isinstance(inner, Path | Operation) else None
    if isinstance(predicate, Call) and predicate.function == "not" and isinstance(predicate.arguments[0], COMBINED):
        found = condition(predicate.arguments[0], context, own)
        return None if found is None else Call("not", (found,))
    if isinstance(predicate, Path):
        return _existence(predicate, context, own)
    return None


def conjunction(parts: list[Expression]) -> Expression:
    """All of some conditions."""
    return parts[0] if len(parts) == 1 else Operation("and", tuple(parts))


def present(own: Sample) -> Expression:
    """That a frame has the sample."""
    return Call("boolean", (own,))


def any_bone_condition(predicate: Expression) -> Expression | None:
    """Return a predicate of frames that any one of their frame_bones must fulfil: `frame_bone/@Rx > 45`,
    `frame_bone[@Rx > @Ry]`, or one of several such; as a condition on that frame_bone. None for others.

    A comparison with a node set is true for any of its nodes, but a function or arithmetic takes the first one.
    """
    if isinstance(predicate, Operation) and predicate.operator == "or":
        return _combined("or", [any_bone_condition(operand) for operand in predicate.operands])
    if isinstance(predicate, Call) and predicate.function == "boolean":
        return any_bone_condition(predicate.arguments[0]) if isinstance(predicate.arguments[0], Path) else None
    if isinstance(predicate, Path):
        found = _own_bone(predicate)
        return None if found is None else conjunction([*found[1], *([present(found[0])] if found[0] else [])])
    if isinstance(predicate, Operation) and predicate.operator in TURNED and len(predicate.operands) == 2:
        for operator, one, other in (
            (predicate.operator, *predicate.operands), (TURNED[predicate.operator], *predicate.operands[::-1]),
        ):  # fmt: skip
            found = _own_bone(one) if isinstance(one, Path) else None
            number = _number(other, FRAME, None)
            if found is None or found[0] is None or number is None or samples_of(number):
                continue
            return conjunction([*found[1], Operation(operator, (found[0], number))])
    return None


def attribute_conditions(step: Step, bone: str | None) -> tuple[str, list[Expression]] | None:
    """Of `@Rx[. > 45]…`, the name, and the predicates as conditions."""
    if step.axis != "attribute" or step.name in ("*", "node()") or step.name.endswith(")"):
        return None
    own = sample(bone, CHANNEL_INDEX[step.name]) if step.name in CHANNEL_INDEX else None
    parts = [condition(predicate, "@frame_bone", own) if own else None for predicate in step.predicates]
    return None if None in parts else (step.name, [part for part in parts if part is not None])


def bone_conditions(step: Step) -> tuple[str | None, list[Expression]] | None:
    """Of `frame_bone[@name='B'][…]…`, the name, and the other predicates as conditions."""
    if step.axis != "child" or step.name != FRAME_BONE:
        return None
    names = [named(predicate) for predicate in step.predicates]
    name = next((found for found in names if found is not None), None)
    parts = [
        condition(predicate, FRAME_BONE, name)
        for predicate, found in zip(step.predicates, names, strict=True)
        if found is None or found != name
    ]
    return None if None in parts else (name, [part for part in parts if part is not None])


def _combined(operator: str, parts: list[Expression | None]) -> Expression | None:
    return None if None in parts else Operation(operator, tuple(part for part in parts if part is not None))


def _comparison(operator: str, left: Expression, right: Expression) -> Expression | None:
    found = Operation(operator, (left, right))
    if operator == "!=":
        # A missing node is unequal to nothing, but NaN is unequal to everything.
        return found if isinstance(left, Sample) or isinstance(right, Sample) else None
    return found if samples_of(found) else None


def _number(expression: Expression, context: str, own: Own) -> Expression | None:
    """A number made of samples and constants, NaN where a frame lacks one of the samples."""
    if isinstance(expression, Literal):
        return None if isinstance(expression.value, str) else expression
    if isinstance(expression, Path):
        return _sample(expression, context, own)
    if isinstance(expression, Call) and expression.function in OF_ONE_NUMBER and len(expression.arguments) == 1:
        inner = _number(expression.arguments[0], context, own)
        return None if inner is None else Call(expression.function, (inner,))
    if not isinstance(expression, Operation) or expression.operator not in ARITHMETIC:
        return None
    return _combined(expression.operator, [_number(operand, context, own) for operand in expression.operands])


def _sample(path: Path, context: str, own: Own) -> Sample | None:
    """The sample that a path leads to: `@Rx`, `frame_bone[@name='B']/@Rx`, `../frame_bone[@name='B']/@Rx`; `.`."""
    if path.absolute or path.start is not None:
        return None
    if isinstance(own, Sample):
        return own if not without_self(path.steps) else None
    if not path.steps:
        return None
    *steps, last = path.steps
    if last.axis != "attribute" or last.name not in CHANNEL_INDEX or last.predicates:
        return None
    channel = CHANNEL_INDEX[last.name]
    if context == FRAME_BONE:
        if not steps:
            return sample(own, channel)
        if steps[0].axis != "parent" or steps[0].predicates or steps[0].name not in ("node()", "frame", "*"):
            return None
        steps = steps[1:]
    name = _bone_named(steps[0]) if len(steps) == 1 else None
    return None if name is None else sample(name, channel)


def _existence(path: Path, context: str, own: Own) -> Expression | None:
    """`@Rx`, or `frame_bone[@name='B'][@Rx > 45]`, as a predicate."""
    found = _sample(path, context, own)
    if found is not None:
        return present(found)
    if context == FRAME_BONE or path.absolute or path.start is not None or len(path.steps) not in (1, 2):
        return None
    bone = bone_conditions(path.steps[0])
    if bone is None or bone[0] is None:
        return None
    parts = list(bone[1])
    if len(path.steps) == 2:
        inner = _existence(Path((path.steps[1],)), FRAME_BONE, bone[0])
        if inner is None:
            return None
        parts.append(inner)
    return conjunction(parts) if parts else None


def _own_bone(path: Path) -> tuple[Sample | None, list[Expression]] | None:
    """Of `frame_bone[…]/@Rx`, the sample of that frame_bone (None without the attribute) and its predicates."""
    if path.absolute or path.start is not None or not 1 <= len(path.steps) <= 2:
        return None
    bone = bone_conditions(path.steps[0])
    if bone is None or bone[0] is not None:
        return None
    if len(path.steps) == 1:
        return (None, bone[1]) if bone[1] else None
    found = _sample(Path((path.steps[1],)), FRAME_BONE, None)
    return None if found is None else (found, bone[1])


def _bone_named(step: Step) -> str | None:
    """B of `frame_bone[@name='B']`."""
    if step.axis == "child" and step.name == FRAME_BONE and len(step.predicates) == 1:
        return named(step.predicates[0])
    return None
