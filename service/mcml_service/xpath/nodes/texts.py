"""Strings as columns, each distinct string stored once; and XPath 1.0 conversions between numbers and strings."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal

import numpy as np

from mcml_service.xpath.nodes.numbering import Bools, Floats, Ints

_NUMBER = re.compile(r"[ \t\r\n]*-?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]*)?[ \t\r\n]*", re.ASCII)
_INTEGER_LIMIT = 2**31 - 1
_DIGITS = 15


@dataclass(frozen=True, slots=True)
class Strings:
    """codes: for each item its place in `values`. The values may repeat."""

    codes: Ints
    values: list[str]

    def __len__(self) -> int:
        return len(self.codes)

    def __getitem__(self, which: Ints | Bools) -> Strings:
        return Strings(self.codes[which].astype(np.int64, copy=False), self.values)

    def list(self) -> list[str]:
        return [self.values[code] for code in self.codes.tolist()]

    def map(self, function: Callable[[str], str]) -> Strings:
        return Strings(self.codes, [function(value) for value in self.values])

    def numbers(self, function: Callable[[str], float] | None = None) -> Floats:
        """A number for each item; `number()` of XPath if no function is given."""
        made = [(function or to_number)(value) for value in self.values]
        return np.asarray(np.array(made, np.float64)[self.codes], np.float64)

    def test(self, function: Callable[[str], bool]) -> Bools:
        return np.asarray(np.array([function(value) for value in self.values], bool)[self.codes], bool)


def constant(text: str, count: int) -> Strings:
    return Strings(np.zeros(count, np.int64), [text])


def of_texts(texts: Sequence[str]) -> Strings:
    places: dict[str, int] = {}
    codes = [places.setdefault(text, len(places)) for text in texts]
    return Strings(np.array(codes, np.int64), list(places))


def first_filled(one: Strings, other: Strings) -> Strings:
    """For each item the first text, or the other where that is empty."""
    every = joined((one, other))
    return every[np.arange(len(one)) + np.where(one.test(bool), 0, len(one))]


def joined(parts: Sequence[Strings]) -> Strings:
    """Several columns of strings, one after the other."""
    values: list[str] = []
    codes = []
    for part in parts:
        codes.append(part.codes + len(values))
        values += part.values
    return Strings(np.concatenate([*codes, np.empty(0, np.int64)]).astype(np.int64), values)


def compact(strings: Strings) -> Strings:
    """The same without the values that no item has."""
    used = np.zeros(len(strings.values), bool)
    used[strings.codes] = True
    kept = np.flatnonzero(used)
    places = np.cumsum(used) - 1
    return Strings(places[strings.codes], [strings.values[code] for code in kept.tolist()])


def unified(one: Strings, other: Strings) -> tuple[Ints, Ints]:
    """Codes that are equal exactly where the strings are."""
    places: dict[str, int] = {}
    first = np.array([places.setdefault(value, len(places)) for value in one.values], np.int64)
    second = np.array([places.setdefault(value, len(places)) for value in other.values], np.int64)
    return first[one.codes], second[other.codes]


def combine(columns: Sequence[Strings], function: Callable[..., str | float | bool]) -> list[str | float | bool]:
    """A function of several columns, called once for each combination that occurs; the values item by item."""
    key = columns[0].codes
    for column in columns[1:]:
        key = key * max(1, len(column.values)) + column.codes
    _, where, inverse = np.unique(key, return_index=True, return_inverse=True)
    rows = zip(*(column[where].list() for column in columns), strict=True)
    made = [function(*row) for row in rows]
    return [made[index] for index in inverse.tolist()]


def to_number(text: str) -> float:
    """`number()` of a string: NaN for other text. As in libxml2, an exponent is part of a number."""
    if not _NUMBER.fullmatch(text):
        return math.nan
    stripped = text.strip(" \t\r\n")
    if stripped[-1] in "eE+-":
        stripped = stripped.rstrip("+-").rstrip("eE")
    return float(stripped)


def to_text(number: float) -> str:
    """`string()` of a number, with the digits that libxml2 gives: 15, an exponent beyond 1e9 and below 1e-5."""
    if math.isnan(number):
        return "NaN"
    if math.isinf(number):
        return "Infinity" if number > 0 else "-Infinity"
    if number == 0:
        return "0"
    if -_INTEGER_LIMIT < number < _INTEGER_LIMIT and number == int(number):
        return str(int(number))
    size = abs(number)
    if size > 1e9 or size < 1e-5:
        digits, _, exponent = f"{number:.{_DIGITS - 1}e}".partition("e")
        return f"{_without_zeros(digits)}e{exponent}"
    magnitude = int(math.log10(size))
    places = _DIGITS - magnitude - 1 if magnitude > 0 else _DIGITS - magnitude
    return _without_zeros(f"{number:.{places}f}")


def to_later_text(number: float, *, is_integer: bool) -> str:
    """`string()` of a number in XPath 2.0: as few digits as tell it apart, an exponent from a million on and below a
    millionth. XPath 2.0 Functions and Operators §17.1.2."""
    if math.isnan(number):
        return "NaN"
    if math.isinf(number):
        return "INF" if number > 0 else "-INF"
    if is_integer:
        return str(int(number))
    if number == 0:
        return "-0" if math.copysign(1, number) < 0 else "0"
    if 1e-6 <= abs(number) < 1e6:
        return _without_zeros(format(Decimal(repr(number)), "f"))
    sign, digits, exponent = Decimal(repr(number)).normalize().as_tuple()
    letters = "".join(map(str, digits))
    power = int(exponent) + len(letters) - 1
    return f"{'-' * sign}{letters[0]}.{letters[1:] or '0'}E{power}"


def of_numbers(numbers: Floats, write: Callable[[float], str] = to_text) -> Strings:
    """`string()` of each number."""
    # By their bits, for -0.0 and 0.0 may be two texts.
    unique, inverse = np.unique(np.ascontiguousarray(numbers).view(np.int64), return_inverse=True)
    return Strings(inverse.reshape(-1).astype(np.int64), [write(number) for number in unique.view(np.float64).tolist()])


def _without_zeros(digits: str) -> str:
    return digits.rstrip("0").rstrip(".") if "." in digits else digits
