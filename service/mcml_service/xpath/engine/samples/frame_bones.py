"""Aggregates over all frame_bones of each of many frames: whether any fulfils a condition, their number, sum and
extremes.

`frame[count(frame_bone[@Rx > 20]) >= 5]` and `frame[not(frame_bone[@Rx > 20])]` read every bone of every frame. The
samples are stacked in arrays (`stacked`), so that no node is made for any of them. This works for frames with the same
frame_bones, in the same order, with the same channels as their neighbours; others are evaluated node by node.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mcml.language.vocabulary import FRAME_BONE
from mcml.motion.skeleton import CHANNEL_INDEX
from mcml_service.xpath.engine.axes import are_frames
from mcml_service.xpath.engine.context import Context, Value
from mcml_service.xpath.engine.functions import arithmetic
from mcml_service.xpath.engine.samples.condition import Condition
from mcml_service.xpath.engine.samples.kernel import Columns
from mcml_service.xpath.engine.samples.stacked import Some, StackedBones
from mcml_service.xpath.engine.sequences import some_of
from mcml_service.xpath.language.conditions import (
    any_bone_condition,
    attribute_conditions,
    bone_conditions,
    conjunction,
    present,
    sample,
)
from mcml_service.xpath.language.tree import Call, Expression, Operation, Path, Variable
from mcml_service.xpath.nodes.items import Items
from mcml_service.xpath.nodes.nodesets import NodeSets
from mcml_service.xpath.nodes.numbering import Bools, Floats, Ints, documents_of

FEW = 64
"""Frames that are walked as soon."""
TOGETHER = 1 << 14
"""Frames that are looked at together."""
FUNCTIONS = frozenset({"count", "sum", "min", "max", "avg"})


@dataclass(frozen=True)
class Asked:
    """function: "any" or one of FUNCTIONS. condition: of the frame_bones that count. channel: of samples that are added
    or compared."""

    function: str
    condition: Condition
    channel: int = 0


class FrameBones:
    """The answers for frames of the documents of some columns."""

    def __init__(self, columns: Columns) -> None:
        self._columns = columns
        self._forest = columns.forest
        self._known: dict[Expression, Asked | None] = {}
        self._bones: StackedBones | None = None

    def value(
        self, expression: Expression, context: Context, frames: NodeSets | None, walk: Callable[[Context], Value]
    ) -> Value | None:
        """Return the value for each context; None if the expression has another form.

        frames: the start of the expression's path, if it is not a context node. walk: evaluates other contexts.
        """
        if len(context) < FEW:
            return None
        if expression not in self._known:
            self._known[expression] = asked(expression)
        question = self._known[expression]
        nodes = context.nodes if frames is None else _one_each(frames)
        if question is None or nodes is None or not are_frames(nodes):
            return None
        if not self._forest.has_tracks(1 + int(np.count_nonzero(np.diff(documents_of(nodes))))):
            return None
        bones = self._bones = self._bones or StackedBones(self._columns)
        if not bones.takes(question.condition) or not (
            question.function in ("any", "count") or bones.fits(coded=False)
        ):
            return None
        stack, column, is_regular = self._places(bones, nodes)
        if not is_regular.any():
            return None
        numbers, exist = np.zeros(len(nodes)), np.ones(len(nodes), bool)
        for number in np.flatnonzero(np.bincount(stack[is_regular])).tolist():
            own = np.flatnonzero(is_regular & (stack == number))
            for at in range(0, len(own), TOGETHER):
                self._columns.check()
                index = own[at : at + TOGETHER]
                some = Some(bones.stacks.stacks[number], column[index])
                numbers[index], exist[index] = _reduced(bones, question, some)
        others = np.flatnonzero(~is_regular)
        if len(others):
            _put(walk(context.at(others)), others, numbers, exist)
        if question.function == "any":
            return numbers > 0
        return numbers if question.function in ("count", "sum") else some_of(numbers, exist)

    def _places(self, bones: StackedBones, frames: Ints) -> tuple[Ints, Ints, Bools]:
        """Stack and column of each frame, and which frames have exactly the frame_bones of their unit, in order."""
        shapes = self._forest.shapes
        stack, column, unit = bones.stacks.found(documents_of(frames), shapes.slot_of(frames))
        widths = np.array([each.width for each in bones.stacks.stacks] + [-1])
        shape = shapes.shape_of(frames)
        sizes = shapes.offsets[shape + 1] - shapes.offsets[shape]
        return stack, column, (sizes == widths[stack]) & bones.stacks.even[unit] & shapes.in_order[shape]


def asked(expression: Expression) -> Asked | None:
    """Return the aggregate of an expression over the frame_bones of a frame; None for other expressions."""
    if isinstance(expression, Path | Operation):
        condition = any_bone_condition(expression)
        return None if condition is None else Asked("any", Condition.of(condition))
    if not isinstance(expression, Call) or expression.function not in FUNCTIONS or len(expression.arguments) != 1:
        return None
    path = expression.arguments[0]
    if not isinstance(path, Path) or path.absolute or not 1 <= len(path.steps) <= 2:
        return None
    bone = bone_conditions(path.steps[0])
    if path.steps[0].name != FRAME_BONE or bone is None or bone[0] is not None:
        return None
    conditions, channel = list(bone[1]), None
    if len(path.steps) == 2:
        attribute = attribute_conditions(path.steps[1], None)
        if attribute is None or attribute[0] not in CHANNEL_INDEX:
            return None
        channel = CHANNEL_INDEX[attribute[0]]
        conditions += [*attribute[1], present(sample(None, channel))]
    elif expression.function != "count":
        return None
    # How many frame_bones a frame has is known without their samples.
    return Asked(expression.function, Condition.of(conjunction(conditions)), channel or 0) if conditions else None


def start_of(expression: Expression) -> Variable | None:
    """The variable that the path inside of a function starts from."""
    path = expression.arguments[0] if isinstance(expression, Call) and expression.arguments else None
    return path.start if isinstance(path, Path) and isinstance(path.start, Variable) else None


def _one_each(sets: NodeSets) -> Ints | None:
    """The one node of each context; None where one has none, or several."""
    if len(sets.nodes) != sets.count or (len(sets.groups) > 1 and (np.diff(sets.groups) != 1).any()):
        return None
    return np.asarray(sets.spread(sets.nodes), np.int64)


def _reduced(bones: StackedBones, question: Asked, some: Some) -> tuple[Floats | Bools, Floats | Bools]:
    """Return a number for each frame, and whether it exists."""
    always = np.ones(len(some), bool)
    holds = bones.truth(question.condition, some)
    if question.function == "any":
        return np.logical_or.reduce(holds, axis=0), always
    counts = np.add.reduce(holds.view(np.uint8), axis=0, dtype=np.int64).astype(np.float64)
    if question.function == "count":
        return counts, always
    samples = bones.samples(question.channel, some)
    if question.function in ("min", "max"):
        function = np.fmin if question.function == "min" else np.fmax
        return function.reduce(np.where(holds, samples, np.nan), axis=0), counts > 0
    # One bone after the other, in the order of the frame: in another order sums differ in their last digit.
    total = np.zeros(len(some))
    for row, which in zip(samples, holds, strict=True):
        total += np.where(which, row, 0.0)
    if question.function == "sum":
        return total, always
    return arithmetic("div", total, counts), counts > 0


def _put(value: Value, index: Ints, numbers: Floats, exist: Bools) -> None:
    """The values of some contexts among those of all."""
    if isinstance(value, Items):
        exist[index] = False
        exist[index[value.groups]] = True
        numbers[index[value.groups]] = value.column  # type: ignore[assignment]  # numbers
    else:
        numbers[index] = value.exist() if isinstance(value, NodeSets) else value  # type: ignore[assignment]  # no text
