"""The functions of XPath 1.0 §4 on columns, and the conversions between types."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from service.xpath.engine import values
from service.xpath.engine.node_tests import kinds_and_names
from service.xpath.library.forest import Forest
from service.xpath.nodes.nodesets import NodeSets
from service.xpath.nodes.numbering import Bools, Floats, code_names
from service.xpath.nodes.texts import Strings, combine, constant, of_numbers, of_texts

Value: TypeAlias = NodeSets | Floats | Bools | Strings


class NotOnColumnsError(Exception):
    """Columns have no answer to this expression; the document as XML has."""


COMPARISONS = ("=", "!=", "<", "<=", ">", ">=")
OF_CONTEXT = frozenset({"string", "number", "string-length", "normalize-space", "name", "local-name", "namespace-uri"})
"""Functions that without an argument take the context node."""


def kind_of(value: Value) -> str:
    """ "nodes", "string", "boolean" or "number"."""
    if isinstance(value, NodeSets):
        return "nodes"
    if isinstance(value, Strings):
        return "string"
    return "boolean" if value.dtype == np.bool_ else "number"


def as_strings(forest: Forest, value: Value) -> Strings:
    if isinstance(value, NodeSets):
        return _of_first(forest, value)
    if isinstance(value, Strings):
        return value
    if value.dtype == np.bool_:
        return Strings(value.astype(np.int64), ["false", "true"])
    return of_numbers(value.astype(np.float64))


def as_numbers(forest: Forest, value: Value) -> Floats:
    if isinstance(value, NodeSets):
        first = value.first()
        result = np.full(len(first), np.nan)
        some = first >= 0
        result[some] = values.numbers(forest, first[some])
        return result
    if isinstance(value, Strings):
        return value.numbers()
    return np.asarray(value.astype(np.float64))


def as_booleans(value: Value) -> Bools:
    if isinstance(value, NodeSets):
        return value.exist()
    if isinstance(value, Strings):
        return value.test(bool)
    return np.asarray(value if value.dtype == np.bool_ else (value != 0) & ~np.isnan(value), bool)


def arithmetic(operator: str, left: Floats, right: Floats) -> Floats:
    """`+ - * div mod`, as IEEE 754 has them; `mod` keeps the sign of the dividend."""
    with np.errstate(all="ignore"):
        return np.asarray(_ARITHMETIC[operator](left, right), np.float64)


_ARITHMETIC: dict[str, Callable[[Floats, Floats], Floats]] = {
    "+": np.add, "-": np.subtract, "*": np.multiply, "div": np.divide, "mod": np.fmod,
}  # fmt: skip


def call(forest: Forest, name: str, arguments: Sequence[Value], count: int) -> Value:
    """A function other than position() and last(). count: of context nodes."""
    if name in ("true", "false"):
        return np.broadcast_to(np.bool_(name == "true"), count)
    if name == "lang":
        # No element of MCML has xml:lang.
        return np.zeros(count, bool)
    if name == "id":
        # No attribute of MCML has the type ID.
        return NodeSets(np.empty(0, np.int64), np.empty(0, np.int64), count)
    if name == "string-join":
        return _string_join(forest, arguments)
    if name in _OF_NODES:
        sets = arguments[0]
        if not isinstance(sets, NodeSets):
            raise TypeError(f"{name}() of no node set")
        return _OF_NODES[name](forest, sets)
    if name == "boolean":
        return as_booleans(arguments[0])
    if name == "not":
        return ~as_booleans(arguments[0])
    if name == "number":
        return as_numbers(forest, arguments[0])
    if name in _OF_NUMBERS:
        with np.errstate(all="ignore"):
            return np.asarray(_OF_NUMBERS[name](as_numbers(forest, arguments[0])), np.float64)
    return _of_strings(forest, name, arguments)


def _of_strings(forest: Forest, name: str, arguments: Sequence[Value]) -> Value:
    if name == "substring":
        return _substring(forest, arguments)
    columns = [as_strings(forest, argument) for argument in arguments]
    if name == "string":
        return columns[0]
    if len(columns) == 1:
        column = columns[0]
        if name == "string-length":
            return column.numbers(lambda text: float(len(text)))
        if name == "normalize-space":
            return column.map(_normalized)
        if name in ("lower-case", "upper-case"):
            return column.map(str.lower if name == "lower-case" else str.upper)
        raise TypeError(f"{name}() with one argument")
    made = combine(columns, _TEXT_FUNCTIONS[name])
    if name in ("contains", "starts-with", "ends-with"):
        return np.array(made, bool)
    return of_texts([str(text) for text in made])


def _normalized(text: str) -> str:
    return " ".join(part for part in text.translate(_SPACES).split(" ") if part)


_SPACES = str.maketrans("\t\r\n", "   ")


def _translate(text: str, old: str, new: str) -> str:
    table: dict[int, str | None] = {}
    for place, letter in enumerate(old):
        table.setdefault(ord(letter), new[place] if place < len(new) else None)
    return text.translate(table)


_TEXT_FUNCTIONS: dict[str, Callable[..., str | float | bool]] = {
    "concat": lambda *texts: "".join(texts),
    "contains": lambda text, part: part in text,
    "starts-with": lambda text, part: text.startswith(part),
    "ends-with": lambda text, part: text.endswith(part),
    "substring-before": lambda text, part: text[: text.find(part)] if part in text else "",
    "substring-after": lambda text, part: text[text.find(part) + len(part) :] if part in text else "",
    "translate": _translate,
}


def _substring(forest: Forest, arguments: Sequence[Value]) -> Strings:
    text = as_strings(forest, arguments[0])
    first = round_half_up(as_numbers(forest, arguments[1]))
    if len(arguments) == 3:
        end = arithmetic("+", first, round_half_up(as_numbers(forest, arguments[2])))
    else:
        end = np.full(len(first), math.inf)
    bounds = zip(text.list(), first.tolist(), end.tolist(), strict=True)
    return of_texts([_cut(one, begin, stop) for one, begin, stop in bounds])


def _cut(text: str, begin: float, stop: float) -> str:
    """The letters at positions p with begin <= p < stop, from 1."""
    if math.isnan(begin) or math.isnan(stop):
        return ""
    low = max(1, begin)
    high = min(len(text) + 1, stop)
    return text[int(low) - 1 : int(high) - 1] if low < high else ""


def round_half_up(numbers: Floats) -> Floats:
    """`round()` of XPath 1.0: the closest integer, of two the greater; -0.5 up to 0 is negative zero."""
    with np.errstate(all="ignore"):
        floor = np.floor(numbers)
        rounded = np.where(numbers - floor >= 0.5, floor + 1, floor)
        return np.asarray(np.where((numbers < 0) & (numbers >= -0.5), -0.0, rounded), np.float64)


_OF_NUMBERS: dict[str, Callable[[Floats], Floats]] = {
    "abs": np.abs, "floor": np.floor, "ceiling": np.ceil, "round": round_half_up,
}  # fmt: skip


def _names(forest: Forest, sets: NodeSets) -> Strings:
    first = sets.first()
    some = first >= 0
    codes = np.zeros(len(first), np.int64)
    codes[some] = kinds_and_names(forest, first[some])[1]
    return Strings(codes, code_names())


def _of_first(forest: Forest, sets: NodeSets) -> Strings:
    first = sets.first()
    some = np.flatnonzero(first >= 0)
    found = values.strings(forest, first[some])
    codes = np.full(len(first), len(found.values), np.int64)
    codes[some] = found.codes
    return Strings(codes, [*found.values, ""])


def _sum(forest: Forest, sets: NodeSets) -> Floats:
    return sets.sums(values.numbers(forest, sets.nodes))


def _extreme(function: str) -> Callable[[Forest, NodeSets], Value]:
    """`min`, `max` and `avg` of XPath 2.0, NaN for nothing; a text that is no number is an error there."""

    def found(forest: Forest, sets: NodeSets) -> Floats:
        all_numbers = values.numbers(forest, sets.nodes)
        if np.isnan(all_numbers).any():
            raise NotOnColumnsError
        if function == "avg":
            return arithmetic("div", sets.sums(all_numbers), sets.counts())
        return sets.least(all_numbers) if function == "min" else sets.greatest(all_numbers)

    return found


def _string_join(forest: Forest, arguments: Sequence[Value]) -> Strings:
    sets = arguments[0]
    if not isinstance(sets, NodeSets):
        raise TypeError("string-join() of no node set")
    between = as_strings(forest, arguments[1]).list() if len(arguments) > 1 else [""] * sets.size
    flat, place = sets.flat()
    parts: list[list[str]] = [[] for _ in range(flat.count)]
    for group, text in zip(flat.groups.tolist(), values.strings(forest, sets.nodes)[place].list(), strict=True):
        parts[group].append(text)
    return of_texts([between[group].join(part) for group, part in enumerate(parts)])


_OF_NODES: dict[str, Callable[[Forest, NodeSets], Value]] = {
    "count": lambda forest, sets: sets.counts(),
    "sum": _sum,
    "min": _extreme("min"),
    "max": _extreme("max"),
    "avg": _extreme("avg"),
    "exists": lambda forest, sets: sets.exist(),
    "empty": lambda forest, sets: ~sets.exist(),
    "name": _names,
    "local-name": _names,
    "namespace-uri": lambda forest, sets: constant("", sets.size),
}
