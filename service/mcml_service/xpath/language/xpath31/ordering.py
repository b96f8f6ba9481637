"""Functions that compare values of sequences with each other, corrected: distinct-values, sort and array:sort.

Untyped values are compared as strings, strings by a collation (Functions and Operators 3.1 §14.2.1, §16.2.6, §17.3.17).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from decimal import Decimal
from functools import cmp_to_key
from typing import Any, TypeAlias

from elementpath.datatypes import AbstractBinary, AnyURI, UntypedAtomic
from elementpath.exceptions import ElementPathError
from elementpath.sequences import xlist
from elementpath.xpath_tokens import XPathArray, XPathFunction

from mcml_service.xpath.language.xpath31.collations import Collations

_TEXTS = (str, UntypedAtomic, AnyURI)
_NUMBERS = (int, float, Decimal)

Key: TypeAlias = tuple[str, Any]
"""A kind of values, and a value that is comparable with others of its kind."""


def distinct_values(self: Any, context: Any = None) -> Iterator[Any]:
    """fn:distinct-values: NaN is equal to itself, values that cannot be compared are distinct."""
    context = self.context or context
    known: set[Key] = set()
    others: list[Any] = []
    with _collation(self, context) as collation:
        for value in self[0].atomization(context):
            if isinstance(value, (bool, *_TEXTS, *_NUMBERS)):
                key = key_of(value, collation.strxfrm)
                if key not in known:
                    known.add(key)
                    yield value
            elif not any(_equals(value, other) for other in others):
                others.append(value)
                yield value


def sort(self: Any, context: Any = None) -> Any:
    """fn:sort: by the values of items, or by those of a function of each item."""
    context = self.context or context
    return xlist(_sort_items(self, context, self[0].select(context)))


def sort_array(self: Any, context: Any = None) -> XPathArray:
    """array:sort: as fn:sort, of the members of an array."""
    context = self.context or context
    array = self.get_argument(context, required=True, cls=XPathArray)
    return XPathArray(self.parser, _sort_items(self, context, array.items(context)))


def _sort_items(self: Any, context: Any, items: Iterable[Any]) -> list[Any]:
    value_of = None
    if len(self) == 3:
        value_of = self.get_argument(context, index=2, required=True, cls=XPathFunction)
    with _collation(self, context) as collation:
        keyed = []
        for item in items:
            values = item if value_of is None else value_of(item, context=context)
            keyed.append(([key_of(value, collation.strxfrm) for value in self.atomize_item(values)], item))

    def compare(one: tuple[list[Key], Any], other: tuple[list[Key], Any]) -> int:
        return compare_keys(self, one[0], other[0])

    return [item for _, item in sorted(keyed, key=cmp_to_key(compare))]


def compare_keys(token: Any, one: list[Key], other: list[Key]) -> int:
    """-1, 0 or 1 for sequences of keys: by their items, then the shorter one first. Raises XPTY0004 for two kinds."""
    for first, second in zip(one, other, strict=False):
        if first == second:
            continue
        if first[0] != second[0]:
            raise token.error("XPTY0004", f"a {first[0]} and a {second[0]} have no order")
        try:
            return -1 if first[1] < second[1] else 1
        except TypeError as error:
            raise token.error("XPTY0004", str(error)) from error
    return (len(one) > len(other)) - (len(one) < len(other))


def _collation(self: Any, context: Any) -> Collations:
    """That of the second argument, or the default."""
    asked = self.get_argument(context, 1, cls=str) if len(self) > 1 else None
    return Collations(asked or self.parser.default_collation, self)


def key_of(value: Any, text_key: Callable[[str], Any]) -> Key:
    """The same of values that are equal. NaN is equal to itself and less than all other numbers."""
    if isinstance(value, _TEXTS):
        return "string", text_key(str(value))
    if isinstance(value, bool):
        return "boolean", value
    if isinstance(value, _NUMBERS):
        return "number", (0, 0) if math.isnan(value) else (1, value)
    return type(value).__name__, value


def _equals(one: Any, other: Any) -> bool:
    if isinstance(one, AbstractBinary) and type(one) is not type(other):
        return False
    try:
        return bool(one == other)
    except (TypeError, ValueError, ElementPathError):
        return False
