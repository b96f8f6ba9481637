"""Functions of one item on columns, and the conversions between types. Those of sequences: `sequences.py`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from mcml_service.xpath.engine import values
from mcml_service.xpath.engine.context import Value
from mcml_service.xpath.engine.node_tests import kinds_and_names
from mcml_service.xpath.language.functions import SAFE_FUNCTIONS, Signature, round_half_up
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.nodes.items import Column, Items
from mcml_service.xpath.nodes.nodesets import NodeSets
from mcml_service.xpath.nodes.numbering import Bools, Floats, Ints, code_names
from mcml_service.xpath.nodes.samples import Samples, sample_texts
from mcml_service.xpath.nodes.texts import Strings, combine, compact, constant, of_numbers, of_texts


class NotOnColumnsError(Exception):
    """Columns have no answer to this expression; the document as XML has."""


COMPARISONS = ("=", "!=", "<", "<=", ">", ">=")


def kind_of(value: Value) -> str:
    """ "nodes", "string", "boolean" or "number"; "sequence" of items that are no nodes."""
    if isinstance(value, NodeSets | Samples):
        return "nodes"
    if isinstance(value, Items):
        return "sequence"
    if isinstance(value, Strings):
        return "string"
    return "boolean" if value.dtype == np.bool_ else "number"


def as_strings(forest: Forest, value: Value) -> Strings:
    if isinstance(value, Items):
        groups, column = value.first()
        return _scattered(value.count, groups, as_strings(forest, _single(column)))
    if isinstance(value, NodeSets):
        return _of_first(forest, value)
    if isinstance(value, Samples):
        return _scattered(len(value), np.flatnonzero(value.exist), sample_texts(value.numbers[value.exist]))
    if isinstance(value, Strings):
        return value
    if value.dtype == np.bool_:
        return Strings(value.astype(np.int64), ["false", "true"])
    return of_numbers(value.astype(np.float64))


def _scattered(count: int, groups: Ints, texts: Strings) -> Strings:
    """A text for each of some contexts, and the empty text for the others."""
    codes = np.full(count, len(texts.values), np.int64)
    codes[groups] = texts.codes
    return Strings(codes, [*texts.values, ""])


def _single(column: Column) -> Floats | Bools | Strings:
    """The column of values that are no nodes."""
    return column  # type: ignore[return-value]  # numbers of nodes occur only in node sets


def as_numbers(forest: Forest, value: Value) -> Floats:
    if isinstance(value, Items):
        groups, column = value.first()
        result = np.full(value.count, np.nan)
        result[groups] = as_numbers(forest, _single(column))
        return result
    if isinstance(value, NodeSets):
        first = value.first()
        result = np.full(len(first), np.nan)
        some = first >= 0
        result[some] = values.numbers(forest, first[some])
        return result
    if isinstance(value, Strings):
        return value.numbers()
    if isinstance(value, Samples):
        return value.numbers
    return np.asarray(value.astype(np.float64, copy=False))


def as_booleans(value: Value) -> Bools:
    """The effective boolean value. NotOnColumnsError for several values, which have none."""
    if isinstance(value, Items):
        if len(value) and (np.diff(value.groups) == 0).any():
            raise NotOnColumnsError
        result = np.zeros(value.count, bool)
        result[value.groups] = as_booleans(_single(value.column))
        return result
    if isinstance(value, NodeSets):
        return value.exist()
    if isinstance(value, Samples):
        return value.exist
    if isinstance(value, Strings):
        return value.test(bool)
    return np.asarray(value if value.dtype == np.bool_ else (value != 0) & ~np.isnan(value), bool)


def arithmetic(operator: str, left: Floats, right: Floats) -> Floats:
    """`+ - * div mod`, as IEEE 754 has them; `mod` keeps the sign of the dividend."""
    with np.errstate(all="ignore"):
        return np.asarray(_ARITHMETIC[operator](left, right), np.float64)


_ARITHMETIC: dict[str, Callable[[Floats, Floats], Floats]] = {
    "+": np.add, "-": np.subtract, "*": np.multiply, "div": np.divide, "mod": np.fmod,
    "idiv": lambda left, right: _whole(np.trunc(left / right)),
}  # fmt: skip


def _whole(numbers: Floats) -> Floats:
    if not np.isfinite(numbers).all():
        # An error of XPath 2.0.
        raise NotOnColumnsError
    return numbers


def call(
    forest: Forest, name: str, arguments: Sequence[Value], count: int, check: Callable[[], None] = lambda: None
) -> Value:
    """A function other than position() and last(). count: of context nodes. check: raises when the query must end."""
    if name in ("true", "false"):
        return np.broadcast_to(np.bool_(name == "true"), count)
    if name == "math:pi":
        return np.broadcast_to(np.float64(math.pi), count)
    if name == "lang":
        # No element of MCML has xml:lang.
        return np.zeros(count, bool)
    if name == "id":
        # No attribute of MCML has the type ID.
        return NodeSets(np.empty(0, np.int64), np.empty(0, np.int64), count)
    if name == "string":
        return as_strings(forest, arguments[0])
    if name == "boolean":
        return as_booleans(arguments[0])
    if name == "not":
        return ~as_booleans(arguments[0])
    if name == "number":
        return as_numbers(forest, arguments[0])
    if name == "substring":
        return _substring(forest, arguments)
    if name in _NAMES:
        if not isinstance(arguments[0], NodeSets):
            raise NotOnColumnsError
        return _NAMES[name](forest, arguments[0])
    signature = SAFE_FUNCTIONS[name]
    if signature.of_numbers is not None:
        numbers = [as_numbers(forest, argument) for argument in arguments]
        with np.errstate(all="ignore"):
            return np.asarray(signature.of_numbers(*numbers), np.float64)
    if signature.of_texts is None:
        raise NotOnColumnsError
    return _of_texts(signature, [as_strings(forest, argument) for argument in arguments], check)


def _of_texts(signature: Signature, columns: Sequence[Strings], check: Callable[[], None]) -> Value:
    """A function of texts, called once for each combination of them that occurs."""
    if signature.of_texts is None:
        raise TypeError("no function of texts")
    function = signature.of_texts if signature.is_quick else _checked(signature.of_texts, check)
    if len(columns) == 1:
        column = compact(columns[0])
        if signature.result == "number":
            return column.numbers(function)  # type: ignore[arg-type]  # checked by its result
        if signature.result == "boolean":
            return column.test(function)  # type: ignore[arg-type]  # the same
        return column.map(function)  # type: ignore[arg-type]  # the same
    if signature.of_many is not None and all(len(column.values) == 1 for column in columns[1:]):
        check()
        many = compact(columns[0])
        return np.array(signature.of_many(many.values, *(column.values[0] for column in columns[1:])), bool)[many.codes]
    made = combine(columns, function)
    if signature.result == "boolean":
        return np.array(made, bool)
    return of_texts([str(text) for text in made])


def _checked(
    function: Callable[..., str | float | bool], check: Callable[[], None]
) -> Callable[..., str | float | bool]:
    """The same, for a function that may take long for each text."""

    def called(*texts: str) -> str | float | bool:
        check()
        return function(*texts)

    return called


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


def _names(forest: Forest, sets: NodeSets) -> Strings:
    first = sets.first()
    some = first >= 0
    codes = np.zeros(len(first), np.int64)
    codes[some] = kinds_and_names(forest, first[some])[1]
    return Strings(codes, code_names())


def _of_first(forest: Forest, sets: NodeSets) -> Strings:
    first = sets.first()
    some = np.flatnonzero(first >= 0)
    return _scattered(len(first), some, values.strings(forest, first[some]))


_NAMES: dict[str, Callable[[Forest, NodeSets], Value]] = {
    "name": _names,
    "local-name": _names,
    "namespace-uri": lambda forest, sets: constant("", sets.size),
}
