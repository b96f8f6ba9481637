"""Predicates on samples, compiled to arithmetic on whole tracks.

A predicate such as `frame_bone[@name='Hips']/@Ty > 90 and @Rx < @Ry` is the same arithmetic in every frame. Compiled,
it is a function of a block: for each sample that it names, an array over many frames, NaN where a frame has none.
Only predicates that some sample decides are compiled, those that no frame without it can fulfil: they alone may be
answered from the tracks of that sample. The same arithmetic on the ends of zone maps (`intervals`) says beforehand in
which tracks no frame fulfils a predicate, and in which each does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from service.mcml.vocabulary import FRAME, FRAME_BONE
from service.motion.skeleton import CHANNEL_INDEX
from service.xpath.engine.functions import arithmetic
from service.xpath.language.functions import round_half_up
from service.xpath.language.labels import named, without_self
from service.xpath.language.tree import (
    Call,
    Expression,
    Literal,
    Operation,
    Path,
    Step,
)
from service.xpath.library import intervals
from service.xpath.library.intervals import Interval, Verdict
from service.xpath.nodes.numbering import Bools, Floats

Sample: TypeAlias = tuple[str | None, int]
"""Name of the bone (None: the frame_bone that is asked for) and number of the channel."""
Own: TypeAlias = str | Sample | None
Block: TypeAlias = Mapping[Sample, Floats]
Ends: TypeAlias = Mapping[Sample, Interval]
"""Of each sample, by the zone maps of some tracks."""

CONDITIONS = (Path, Operation, Call)
"""What a predicate that is no constant is made of."""
RELATIONS = {"<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal, "=": np.equal}
TURNED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "=": "=", "!=": "!="}
_ROUNDING: dict[str, Callable[[Floats], Floats]] = {
    "floor": np.floor, "ceiling": np.ceil, "round": round_half_up, "number": np.asarray,
}  # fmt: skip
"""Functions that never make the greater of two numbers the smaller."""


@dataclass(frozen=True)
class Condition:
    """holds: which frames of a block fulfil the predicate. judge: what zone maps say of that. samples: all that it
    reads. strict: samples without which no frame fulfils it. bounds: (sample, operator, number): no frame fulfils it
    otherwise."""

    holds: Callable[[Block], Bools]
    judge: Callable[[Ends], Verdict]
    samples: frozenset[Sample]
    strict: frozenset[Sample]
    bounds: tuple[tuple[Sample, str, float], ...] = ()
    is_presence: bool = False
    """Whether it only asks that a frame has a sample."""
    is_bound: bool = False
    """Whether it is the one bound, no more and no less."""
    logic: str = ""
    """"and", "or" or "not", of the parts."""
    parts: tuple[Condition, ...] = ()


@dataclass(frozen=True)
class _Number:
    """value: of each frame. ends: of each track. sample: the one node that it is, if it is a node and no computed
    number."""

    value: Callable[[Block], Floats]
    ends: Callable[[Ends], Interval]
    samples: frozenset[Sample] = field(default_factory=frozenset)
    sample: Sample | None = None
    constant: float | None = None


def condition(predicate: Expression, context: str, own: Own = None) -> Condition | None:
    """A predicate compiled, None where it cannot be.

    context: "frame", "frame_bone" or "@frame_bone", the type of the context node. own: the name of that frame_bone, if
    it is stated; of a channel, its sample.
    """
    if isinstance(predicate, Operation) and predicate.operator in ("and", "or"):
        return _logic(predicate, context, own)
    if isinstance(predicate, Operation) and predicate.operator in TURNED and len(predicate.operands) == 2:
        left, right = (_number(operand, context, own) for operand in predicate.operands)
        return None if left is None or right is None else _comparison(predicate.operator, left, right)
    if isinstance(predicate, Call) and predicate.function == "boolean":
        inner = predicate.arguments[0]
        return condition(inner, context, own) if isinstance(inner, Path | Operation) else None
    if isinstance(predicate, Call) and predicate.function == "not" and isinstance(predicate.arguments[0], CONDITIONS):
        return _negated(condition(predicate.arguments[0], context, own))
    if isinstance(predicate, Path):
        return _existence(predicate, context, own)
    return None


def _negated(part: Condition | None) -> Condition | None:
    """The opposite, which holds of a frame_bone without samples, too: other conditions must ask for these."""
    if part is None:
        return None

    def judge(ends: Ends) -> Verdict:
        verdict = part.judge(ends)
        return Verdict(~verdict.must, ~verdict.may)

    return Condition(lambda block: ~part.holds(block), judge, part.samples, frozenset(), logic="not", parts=(part,))


def _logic(predicate: Operation, context: str, own: Own) -> Condition | None:
    parts = [condition(operand, context, own) for operand in predicate.operands]
    if any(part is None for part in parts):
        return None
    found = [part for part in parts if part is not None]
    return conjunction(found) if predicate.operator == "and" else _any(found)


def _all(parts: object) -> Bools:
    return np.logical_and.reduce(list(parts))  # type: ignore[call-overload,no-any-return]


def _comparison(operator: str, left: _Number, right: _Number) -> Condition | None:
    samples = left.samples | right.samples
    if not samples:
        return None
    if operator == "!=":
        return _unequal(left, right)

    def judge(ends: Ends) -> Verdict:
        return intervals.compared(operator, left.ends(ends), right.ends(ends))

    if operator == "=" and left.sample is not None and right.sample is not None:
        # Two nodes are equal as strings: 0.0 and -0.0 are not.
        def same(block: Block) -> Bools:
            one, other = left.value(block), right.value(block)
            return np.asarray((one == other) & (np.signbit(one) == np.signbit(other)))

        return Condition(same, judge, samples, samples)
    bounds = []
    for one, other, said in ((left, right, operator), (right, left, TURNED[operator])):
        if one.sample is not None and other.constant is not None and not math.isnan(other.constant):
            bounds.append((one.sample, said, other.constant))
    relation = RELATIONS[operator]
    return Condition(
        lambda block: np.asarray(relation(left.value(block), right.value(block))),
        judge,
        samples,
        samples,
        tuple(bounds),
        is_bound=len(bounds) == 1,
    )


def _unequal(left: _Number, right: _Number) -> Condition | None:
    """A node that is not there is unequal to nothing, a number that is NaN to everything."""
    nodes = [side.sample for side in (left, right) if side.sample is not None]
    if not nodes or (left.sample is not None and right.sample is not None):
        return None

    def differ(block: Block) -> Bools:
        there = _all(~np.isnan(block[node]) for node in nodes)
        return np.asarray(there & (left.value(block) != right.value(block)))

    return Condition(
        differ, lambda ends: intervals.unknown(ends[nodes[0]]), left.samples | right.samples, frozenset(nodes)
    )


def _number(expression: Expression, context: str, own: Own) -> _Number | None:
    if isinstance(expression, Literal):
        if isinstance(expression.value, str):
            return None
        return _constant(expression.value)
    if isinstance(expression, Path):
        sample = _sample(expression, context, own)
        if sample is None:
            return None
        return _of_sample(sample)
    if isinstance(expression, Call) and expression.function in _ROUNDING and len(expression.arguments) == 1:
        inner = _number(expression.arguments[0], context, own)
        if inner is None:
            return None
        function = _ROUNDING[expression.function]
        return _computed(function, lambda ends: intervals.monotonic(function, ends), inner)
    if isinstance(expression, Call) and expression.function == "abs":
        inner = _number(expression.arguments[0], context, own)
        return None if inner is None else _computed(np.abs, intervals.magnitude, inner)
    if not isinstance(expression, Operation) or expression.operator not in ("+", "-", "*", "div", "mod", "negate"):
        return None
    parts = [_number(operand, context, own) for operand in expression.operands]
    found = [part for part in parts if part is not None]
    if len(found) < len(parts):
        return None
    if expression.operator == "negate":
        return _computed(np.negative, intervals.negative, found[0])
    result = found[0]
    for part in found[1:]:
        result = _joined(expression.operator, result, part)
    return result


def _of_sample(sample: Sample) -> _Number:
    return _Number(lambda block: block[sample], lambda ends: ends[sample], frozenset({sample}), sample)


def _constant(value: float) -> _Number:
    return _Number(lambda block: np.asarray(value), lambda ends: intervals.exactly(value), constant=value)


def _computed(function: Callable[[Floats], Floats], of_ends: Callable[[Interval], Interval], inner: _Number) -> _Number:
    if inner.constant is not None:
        return _constant(float(function(np.asarray(inner.constant))))
    return _Number(lambda block: function(inner.value(block)), lambda ends: of_ends(inner.ends(ends)), inner.samples)


def _joined(operator: str, left: _Number, right: _Number) -> _Number:
    if left.constant is not None and right.constant is not None:
        return _constant(float(arithmetic(operator, np.asarray(left.constant), np.asarray(right.constant))))
    return _Number(
        lambda block: arithmetic(operator, left.value(block), right.value(block)),
        lambda ends: intervals.computed(operator, left.ends(ends), right.ends(ends)),
        left.samples | right.samples,
    )


def _sample(path: Path, context: str, own: Own) -> Sample | None:
    """The sample that a path leads to: `@Rx`, `frame_bone[@name='B']/@Rx`, `../frame_bone[@name='B']/@Rx`; `.`."""
    if path.absolute or path.start is not None:
        return None
    if isinstance(own, tuple):
        return own if not without_self(path.steps) else None
    if not path.steps:
        return None
    *steps, last = path.steps
    if last.axis != "attribute" or last.name not in CHANNEL_INDEX or last.predicates:
        return None
    channel = CHANNEL_INDEX[last.name]
    if context == FRAME_BONE:
        if not steps:
            return own, channel
        if steps[0].axis != "parent" or steps[0].predicates or steps[0].name not in ("node()", "frame", "*"):
            return None
        steps = steps[1:]
    name = bone_named(steps[0]) if len(steps) == 1 else None
    return None if name is None else (name, channel)


def present(sample: Sample) -> Condition:
    """That a frame has the sample."""
    own = frozenset({sample})
    return Condition(
        lambda block: ~np.isnan(block[sample]), lambda ends: intervals.present(ends[sample]), own, own, is_presence=True
    )


def _existence(path: Path, context: str, own: Own) -> Condition | None:
    """`@Rx`, or `frame_bone[@name='B'][@Rx > 45]`, as a predicate."""
    sample = _sample(path, context, own)
    if sample is not None:
        return present(sample)
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


def any_bone_condition(predicate: Expression) -> Condition | None:
    """A predicate of frames that one of their frame_bones must fulfil, whichever: `frame_bone/@Rx > 45`,
    `frame_bone[@Rx > @Ry]`, or one of several such; as a condition on that frame_bone. None for others.

    A comparison with a node set asks for any of its nodes, but a function or arithmetic takes the first one.
    """
    if isinstance(predicate, Operation) and predicate.operator == "or":
        parts = [any_bone_condition(operand) for operand in predicate.operands]
        return None if None in parts else _any([part for part in parts if part is not None])
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
            if found is None or found[0] is None or number is None or number.constant is None:
                continue
            compared = _comparison(operator, _of_sample(found[0]), number)
            return None if compared is None else conjunction([*found[1], compared])
    return None


def _own_bone(path: Path) -> tuple[Sample | None, list[Condition]] | None:
    """Of `frame_bone[…]/@Rx`, the sample of that frame_bone (None without the attribute) and its predicates."""
    if path.absolute or path.start is not None or not 1 <= len(path.steps) <= 2:
        return None
    bone = bone_conditions(path.steps[0])
    if bone is None or bone[0] is not None:
        return None
    if len(path.steps) == 1:
        return (None, bone[1]) if bone[1] else None
    sample = _sample(Path((path.steps[1],)), FRAME_BONE, None)
    return None if sample is None else (sample, bone[1])


def _any(parts: list[Condition]) -> Condition:
    """One of them."""
    return Condition(
        lambda block: ~_all(~part.holds(block) for part in parts),
        lambda ends: intervals.any_of([part.judge(ends) for part in parts]),
        frozenset[Sample]().union(*(part.samples for part in parts)),
        frozenset.intersection(*(part.strict for part in parts)),
        logic="or",
        parts=tuple(parts),
    )


def attribute_conditions(step: Step, bone: str | None) -> tuple[str, list[Condition]] | None:
    """Of `@Rx[. > 45]…`, the name and the predicates compiled."""
    if step.axis != "attribute" or step.name in ("*", "node()") or step.name.endswith(")"):
        return None
    sample = (bone, CHANNEL_INDEX[step.name]) if step.name in CHANNEL_INDEX else None
    parts = [condition(predicate, "@frame_bone", sample) if sample else None for predicate in step.predicates]
    return None if None in parts else (step.name, [part for part in parts if part is not None])


def conjunction(parts: list[Condition]) -> Condition:
    """All of them."""
    if len(parts) == 1:
        return parts[0]
    return Condition(
        lambda block: _all(part.holds(block) for part in parts),
        lambda ends: intervals.all_of([part.judge(ends) for part in parts]),
        frozenset[Sample]().union(*(part.samples for part in parts)),
        frozenset[Sample]().union(*(part.strict for part in parts)),
        tuple(bound for part in parts for bound in part.bounds),
        logic="and",
        parts=tuple(parts),
    )


def bone_conditions(step: Step) -> tuple[str | None, list[Condition]] | None:
    """Of `frame_bone[@name='B'][…]…`, the name and the other predicates compiled."""
    if step.axis != "child" or step.name != FRAME_BONE:
        return None
    names = [named(predicate) for predicate in step.predicates]
    name = next((found for found in names if found is not None), None)
    parts = [
        condition(predicate, FRAME_BONE, name)
        for predicate, found in zip(step.predicates, names, strict=True)
        if found is None or found != name
    ]
    if any(part is None for part in parts):
        return None
    return name, [part for part in parts if part is not None]


def bone_named(step: Step) -> str | None:
    """B of `frame_bone[@name='B']`."""
    if step.axis == "child" and step.name == FRAME_BONE and len(step.predicates) == 1:
        return named(step.predicates[0])
    return None
