"""`=`, `!=`, `<`, `<=`, `>`, `>=` as XPath 1.0 §3.4 has them: with a node set, some node must do."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from service.xpath.engine import functions, values
from service.xpath.library.forest import Forest
from service.xpath.nodes.nodesets import NodeSets
from service.xpath.nodes.numbering import Bools, Floats, Ints
from service.xpath.nodes.texts import Strings, joined, unified

RELATIONS: dict[str, Callable[..., Bools]] = {
    "<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal,
}  # fmt: skip
_TURNED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "=": "=", "!=": "!="}


def compare(forest: Forest, operator: str, left: functions.Value, right: functions.Value) -> Bools:
    """The comparison for each context node."""
    if isinstance(left, NodeSets) and isinstance(right, NodeSets):
        return _two_sets(forest, operator, left, right)
    if isinstance(left, NodeSets):
        return _set_and_value(forest, operator, left, right)
    if isinstance(right, NodeSets):
        return _set_and_value(forest, _TURNED[operator], right, left)
    return _two_values(forest, operator, left, right)


def _two_values(
    forest: Forest, operator: str, left: Floats | Bools | Strings, right: Floats | Bools | Strings
) -> Bools:
    if operator in RELATIONS:
        return np.asarray(
            RELATIONS[operator](functions.as_numbers(forest, left), functions.as_numbers(forest, right)), bool
        )
    kinds = {functions.kind_of(left), functions.kind_of(right)}
    if "boolean" in kinds:
        equal = functions.as_booleans(left) == functions.as_booleans(right)
    elif "number" in kinds:
        equal = functions.as_numbers(forest, left) == functions.as_numbers(forest, right)
    else:
        one, other = unified(functions.as_strings(forest, left), functions.as_strings(forest, right))
        equal = one == other
    return np.asarray(equal if operator == "=" else ~equal, bool)


def _set_and_value(forest: Forest, operator: str, sets: NodeSets, value: functions.Value) -> Bools:
    """Some node of each set against the value of its context node."""
    kind = functions.kind_of(value)
    if kind == "boolean":
        return _two_values(forest, operator, sets.exist(), value)  # type: ignore[arg-type]
    if operator in RELATIONS:
        # The extreme decides: some node is less than the bound exactly if the least is.
        found = values.numbers(forest, sets.nodes)
        extreme = sets.least(found) if operator in ("<", "<=") else sets.greatest(found)
        return np.asarray(RELATIONS[operator](extreme, functions.as_numbers(forest, value)), bool)
    flat, place = sets.flat()
    if kind == "number":
        numbers = values.numbers(forest, sets.nodes)[place]
        equal = numbers == functions.as_numbers(forest, value)[flat.groups]
    else:
        strings = values.strings(forest, sets.nodes)
        one, other = unified(strings, functions.as_strings(forest, value))
        equal = one[place] == other[flat.groups]
    return flat.any(equal if operator == "=" else ~equal)


def _two_sets(forest: Forest, operator: str, left: NodeSets, right: NodeSets) -> Bools:
    if operator in RELATIONS:
        one, other = values.numbers(forest, left.nodes), values.numbers(forest, right.nodes)
        if operator in ("<", "<="):
            return np.asarray(RELATIONS[operator](left.least(one), right.greatest(other)), bool)
        return np.asarray(RELATIONS[operator](left.greatest(one), right.least(other)), bool)
    first, second = _codes(forest, left.nodes, right.nodes)
    if operator == "!=":
        low, high = left.least(first), left.greatest(first)
        least, greatest = right.least(second), right.greatest(second)
        same = (low == high) & (least == greatest) & (low == least)
        return np.asarray(left.exist() & right.exist() & ~same, bool)
    flat, place = left.flat()
    other_flat, other_place = right.flat()
    width = int(max(first.max(initial=0), second.max(initial=0))) + 1
    wanted = other_flat.groups * width + second[other_place].astype(np.int64)
    return flat.any(np.isin(flat.groups * width + first[place].astype(np.int64), wanted))


def _codes(forest: Forest, left: Ints, right: Ints) -> tuple[Floats, Floats]:
    """Numbers for nodes that are equal exactly where their strings are."""
    if values.channel_places(left).all() and values.channel_places(right).all():
        # The string of a channel is the shortest that gives its bits.
        bits = np.concatenate([values.samples(forest, left), values.samples(forest, right)]).view(np.int64)
        codes = np.unique(bits, return_inverse=True)[1].reshape(-1).astype(np.float64)
        return codes[: len(left)], codes[len(left) :]
    one, other = values.strings(forest, left), values.strings(forest, right)
    both = joined([one, other])
    first, _ = unified(both, both)
    codes = first.astype(np.float64)
    return codes[: len(left)], codes[len(left) :]
