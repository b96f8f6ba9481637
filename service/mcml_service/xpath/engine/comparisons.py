"""`=`, `!=`, `<`, `<=`, `>`, `>=` as XPath 1.0 §3.4 has them: with a node set or sequence, some item must do; and `eq`
and its kin of XPath 2.0 §3.5.1, of one item with one."""

from __future__ import annotations

from collections.abc import Callable
from operator import eq, ge, gt, le, lt, ne
from typing import Any

import numpy as np

from mcml_service.xpath.engine import functions, values
from mcml_service.xpath.engine.context import Value
from mcml_service.xpath.engine.sequences import items_of, numbers, texts, value_of
from mcml_service.xpath.language.tree import TURNED
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.items import Items
from mcml_service.xpath.nodes.nodesets import NodeSets
from mcml_service.xpath.nodes.numbering import Bools, Floats, Ints
from mcml_service.xpath.nodes.samples import Samples
from mcml_service.xpath.nodes.texts import Strings, combine, joined, unified

RELATIONS: dict[str, Callable[..., Bools]] = {
    "<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal,
}  # fmt: skip
_ALL: dict[str, Callable[..., Any]] = {
    "=": eq, "!=": ne, "<": lt, "<=": le, ">": gt, ">=": ge,
}  # fmt: skip


def compare(forest: Forest, operator: str, left: Value, right: Value) -> Bools:
    """The comparison for each context node."""
    if isinstance(left, Items) or isinstance(right, Items):
        return _sequences(forest, operator, items_of(left), items_of(right))
    if isinstance(left, Samples):
        return _sample_and_other(forest, operator, left, right)
    if isinstance(right, Samples):
        return _sample_and_other(forest, TURNED[operator], right, left)
    if isinstance(left, NodeSets) and isinstance(right, NodeSets):
        return _two_sets(forest, operator, left, right)
    if isinstance(left, NodeSets):
        return _set_and_value(forest, operator, left, right)
    if isinstance(right, NodeSets):
        return _set_and_value(forest, TURNED[operator], right, left)
    return _two_values(forest, operator, left, right)


def compare_numbers(operator: str, left: Floats, right: Floats | float) -> Bools:
    """Two numbers each."""
    return np.asarray(_ALL[operator](left, right), bool)


def compare_items(forest: Forest, operator: str, left: Value, right: Value) -> Value:
    """`eq`, `ne`, `lt`, `le`, `gt`, `ge`: empty if one side is empty.

    operator: the sign of the same meaning. Raises NotOnColumnsError for errors of XPath: several items, or a number and
    a text.
    """
    one, other = items_of(left), items_of(right)
    for side in (one, other):
        if (np.diff(side.groups) == 0).any():
            raise functions.NotOnColumnsError
    both = np.intersect1d(one.groups, other.groups)
    one, other = one.at(both), other.at(both)
    kinds = {"string" if side.kind == "nodes" else side.kind for side in (one, other)}
    if len(both) and len(kinds) > 1:
        raise functions.NotOnColumnsError
    if kinds == {"string"}:
        found = _letters(operator, texts(forest, one), texts(forest, other))
    else:
        found = np.asarray(_ALL[operator](one.column, other.column), bool)
    return found if len(both) == _count(left) else Items(both, found, _count(left))


def _count(value: Value) -> int:
    """How many contexts a value has."""
    if isinstance(value, NodeSets):
        return value.size
    return value.count if isinstance(value, Items) else len(value)


def _letters(operator: str, one: Strings, other: Strings) -> Bools:
    """Texts compared letter by letter."""
    return np.array(combine([one, other], _ALL[operator]), bool)


def _sequences(forest: Forest, operator: str, left: Items, right: Items) -> Bools:
    """Some item of each sequence against some item of another. XPath 2.0 §3.5.2, in 1.0-compatibility mode."""
    kinds = {items.kind for items in (left, right) if len(items)}
    if "boolean" in kinds:
        truths = [functions.as_booleans(value_of(items)) for items in (left, right)]
        return np.asarray(_ALL[operator](*truths), bool)
    if operator in RELATIONS:
        return _by_extremes(operator, left.sets, numbers(forest, left), right.sets, numbers(forest, right))
    if "number" in kinds:
        one, other = numbers(forest, left), numbers(forest, right)
        left, right = left.chosen(~np.isnan(one)), right.chosen(~np.isnan(other))
        if operator == "!=" and (np.isnan(one).any() or np.isnan(other).any()):
            # NaN is unequal to everything.
            raise functions.NotOnColumnsError
        one, other = one[~np.isnan(one)], other[~np.isnan(other)]
        codes = np.unique(np.concatenate([one, other]), return_inverse=True)[1].reshape(-1).astype(np.float64)
        first, second = codes[: len(one)], codes[len(one) :]
    else:
        some, others = unified(texts(forest, left), texts(forest, right))
        first, second = some.astype(np.float64), others.astype(np.float64)
    return _by_codes(operator, left.sets, first, right.sets, second)


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


def _set_and_value(forest: Forest, operator: str, sets: NodeSets, value: Value) -> Bools:
    """Some node of each set against the value of its context node."""
    kind = functions.kind_of(value)
    if kind == "boolean":
        return _two_values(forest, operator, sets.exist(), value)  # type: ignore[arg-type]  # it is no node set
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


def _sample_and_other(forest: Forest, operator: str, left: Samples, right: Value) -> Bools:
    """A node set of one sample or none against what has one item at most."""
    kind = functions.kind_of(right)
    if isinstance(right, NodeSets):
        raise functions.NotOnColumnsError
    if kind == "boolean":
        return _two_values(forest, operator, left.exist, right)  # type: ignore[arg-type]  # it is no node set
    if operator in RELATIONS:
        return np.asarray(RELATIONS[operator](left.numbers, functions.as_numbers(forest, right)), bool)
    if isinstance(right, Samples):
        equal, there = left.equal(right), left.exist & right.exist
    elif kind == "number":
        equal, there = np.asarray(left.numbers == right), left.exist
    else:
        one, other = unified(functions.as_strings(forest, left), functions.as_strings(forest, right))
        equal, there = one == other, left.exist
    return there & (equal if operator == "=" else ~equal)


def _two_sets(forest: Forest, operator: str, left: NodeSets, right: NodeSets) -> Bools:
    if operator in RELATIONS:
        one, other = values.numbers(forest, left.nodes), values.numbers(forest, right.nodes)
        return _by_extremes(operator, left, one, right, other)
    first, second = _codes(forest, left.nodes, right.nodes)
    return _by_codes(operator, left, first, right, second)


def _by_extremes(operator: str, left: NodeSets, one: Floats, right: NodeSets, other: Floats) -> Bools:
    """Some number is less than some other exactly if the least is less than the greatest."""
    if operator in ("<", "<="):
        return np.asarray(RELATIONS[operator](left.least(one), right.greatest(other)), bool)
    return np.asarray(RELATIONS[operator](left.greatest(one), right.least(other)), bool)


def _by_codes(operator: str, left: NodeSets, first: Floats, right: NodeSets, second: Floats) -> Bools:
    """`=` or `!=` of items whose codes are equal exactly where they are."""
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
