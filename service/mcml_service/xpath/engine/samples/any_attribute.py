"""`//@*[. > 170]` and `//@*[. = 'x']`: attributes of any name, compared with a constant.

Nearly all attributes are samples, for which zone maps and codes find matches (`stacked`); names and attributes of heads
are compared one text at a time, ids as numbers. So no node is made for attributes that do not match.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import orjson

from mcml.motion.skeleton import CHANNELS
from mcml_service.xpath.engine import values
from mcml_service.xpath.engine.comparisons import compare_numbers
from mcml_service.xpath.engine.samples.condition import Condition
from mcml_service.xpath.engine.samples.kernel import Columns
from mcml_service.xpath.engine.samples.stacked import Some, StackedBones
from mcml_service.xpath.language.conditions import sample
from mcml_service.xpath.language.rules import ANY
from mcml_service.xpath.language.tree import TURNED, Expression, Literal, Operation, Path
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.zones import BONE
from mcml_service.xpath.nodes.numbering import (
    DOCUMENT_SHIFT,
    FIRST_ATTRIBUTE,
    FIRST_CHANNEL,
    FRAME_SHIFT,
    IS_ATTRIBUTE,
    Bools,
    Floats,
    Ints,
)
from mcml_service.xpath.nodes.pairs import rows_and_columns
from mcml_service.xpath.nodes.texts import Strings, to_number

RELATIONS = frozenset(TURNED) - {"!="}


@dataclass(frozen=True)
class AnyAttribute:
    """operator: with the attribute on the left. value: the constant; compared with a text, an attribute is a text."""

    operator: str
    value: float | str

    def of_texts(self, texts: Sequence[str]) -> Bools:
        """Which of different texts fulfil it."""
        if isinstance(self.value, str):
            return np.array([text == self.value for text in texts], bool)
        return self.of_numbers(np.array([to_number(text) for text in texts], np.float64))

    def of_numbers(self, numbers: Floats) -> Bools:
        return compare_numbers(self.operator, numbers, float(self.value))

    def of_strings(self, strings: Strings, which: Ints) -> Bools:
        """The same of some strings, each different one compared once."""
        codes, index = np.unique(strings.codes[which], return_inverse=True)
        found = self.of_texts([strings.values[code] for code in codes.tolist()])
        return found[index.reshape(-1)]

    @property
    def number(self) -> float | None:
        """The number that a sample of this value has; None for a text that no number is written as."""
        if isinstance(self.value, float):
            return self.value
        number = to_number(self.value)
        same = math.isfinite(number) and orjson.dumps(number).decode() == self.value
        return number if same else None


def any_attribute(tree: Expression) -> AnyAttribute | None:
    """Return the condition of an expression on all attributes, in the form of `rules.normal`; None for another
    expression.
    """
    if not isinstance(tree, Path) or not tree.absolute or len(tree.steps) != 2:
        return None
    every, last = tree.steps
    if (every.axis, every.name) != ANY or every.predicates or (last.axis, last.name) != ("attribute", "*"):
        return None
    asked = last.predicates[0] if len(last.predicates) == 1 else None
    if not isinstance(asked, Operation) or asked.operator not in RELATIONS or len(asked.operands) != 2:
        return None
    left, right = asked.operands
    for operator, one, other in ((asked.operator, left, right), (TURNED[asked.operator], right, left)):
        if isinstance(one, Path) and not one.steps and one.start is None and not one.absolute:
            return _compared(operator, other)
    return None


def _compared(operator: str, other: Expression) -> AnyAttribute | None:
    sign = 1.0
    if isinstance(other, Operation) and other.operator == "negate":
        sign, other = -1.0, other.operands[0]
    if not isinstance(other, Literal):
        return None
    if isinstance(other.value, str):
        return AnyAttribute(operator, other.value) if operator == "=" and sign > 0 else None
    return AnyAttribute(operator, sign * other.value) if math.isfinite(other.value) else None


def attributes(columns: Columns, asked: AnyAttribute) -> Ints | None:
    """All attributes that fulfil it, in order; None where the samples are too many to be looked at together."""
    forest = columns.forest
    frames = forest.frames
    if not forest.has_tracks(len(frames)):
        return None
    bones = StackedBones(columns)
    if not bones.fits(coded=True):
        return None
    rows = np.flatnonzero(forest.head.kinds == IS_ATTRIBUTE)
    found = [forest.head.nodes(rows[asked.of_strings(forest.head.texts, rows)])]
    every = forest.all_frames(np.arange(len(frames)))[1]
    found.append(every[_ids(forest, asked, every)] + FIRST_ATTRIBUTE)
    texts = forest.shapes.texts
    for name in np.flatnonzero(asked.of_texts(texts)).tolist():
        columns.check()
        found.append(forest.shapes.named(every, texts[name])[1] + FIRST_ATTRIBUTE)
    for channel in range(len(CHANNELS)):
        compared = _condition(asked, channel)
        if compared is not None:
            found.append(_samples(bones, compared, channel))
    nodes = np.concatenate(found)
    if isinstance(asked.value, str):
        strings = values.strings(forest, nodes)
        nodes = nodes[asked.of_strings(strings, np.arange(len(nodes)))]
    return np.sort(nodes)


def _ids(forest: Forest, asked: AnyAttribute, frames: Ints) -> Bools:
    """Which frames have such an id."""
    if asked.operator == "=":
        return np.isin(frames, forest.ids.find(asked.value))
    ids, others = forest.ids.numbers(frames)
    found = asked.of_numbers(ids.astype(np.float64))
    if others:
        found[list(others)] = asked.of_texts(list(others.values()))
    return found


def _condition(asked: AnyAttribute, channel: int) -> Condition | None:
    number = asked.number
    return None if number is None else Condition(Operation(asked.operator, (sample(None, channel), Literal(number))))


def _samples(bones: StackedBones, compared: Condition, channel: int) -> Ints:
    """The samples that fulfil a comparison, in any order."""
    forest, found = bones.forest, [np.empty(0, np.int64)]
    for stack in bones.stacks.stacks if bones.may(compared) else ():
        bone, column = rows_and_columns(bones.truth(compared, Some(stack)))
        unit, offset = Some(stack).slots(column)
        tracks = stack.tracks[bone, unit]
        places, slots = bones.stacks.slots(stack.units[unit], offset)
        positions = forest.timeline.positions(places, slots)
        there = positions > 0
        nodes = ((places << DOCUMENT_SHIFT) | (positions << FRAME_SHIFT))[there]
        owners = forest.tracks.about[BONE, tracks[there]]
        found.append(forest.shapes.numbered(nodes, owners) + FIRST_CHANNEL + channel)
    return np.concatenate(found)
