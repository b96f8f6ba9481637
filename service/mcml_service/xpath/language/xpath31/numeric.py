"""Functions of numbers that elementpath answers otherwise than the specification (Functions and Operators 3.1)."""

from __future__ import annotations

import functools
import math
import operator
from collections.abc import Callable, Iterable, Iterator
from copy import copy
from typing import Any

from elementpath.collations import CollationManager
from elementpath.datatypes import UntypedAtomic
from elementpath.namespaces import XPATH_MATH_FUNCTIONS_NAMESPACE
from elementpath.xpath1 import _xpath1_functions
from elementpath.xpath2 import _xpath2_functions
from elementpath.xpath31 import XPath31Parser
from elementpath.xpath_nodes import XPathNode
from elementpath.xpath_tokens import XPathFunction

from mcml_service.xpath.language.xpath31.ordering import key_of


def _of_one(compute: Callable[[float], float]) -> Any:
    """A function of a double, with an overflow to infinity (IEEE 754, as F&O 3.1 §4.8 has it)."""

    def evaluate(self: XPathFunction, context: Any = None) -> Any:
        value = _double(self, self.context or context, 0)
        if value is None:
            return []
        try:
            return compute(value)
        except OverflowError:
            return math.inf

    return evaluate


def _power(self: XPathFunction, context: Any = None) -> Any:
    """math:pow (F&O 3.1 §4.8.7): that of IEEE 754."""
    base, exponent = (_double(self, self.context or context, place) for place in (0, 1))
    if base is None:
        return []
    if exponent is None:
        raise self.error("XPTY0004", "the exponent of math:pow() is missing")
    odd = exponent % 2 == 1
    if base == 0 and exponent < 0:
        return math.copysign(math.inf, base) if odd else math.inf
    try:
        return math.pow(base, exponent)
    except OverflowError:
        return -math.inf if base < 0 and odd else math.inf
    except ValueError:
        return math.nan


def _double(token: XPathFunction, context: Any, index: int) -> float | None:
    value = number_argument(token, context, index)
    if value is None:
        return None
    if isinstance(value, bool) or not hasattr(value, "__float__"):
        raise token.error("XPTY0004", f"{token.symbol}() needs numbers")
    return float(value)


def number_argument(self: Any, context: Any = None, index: int = 0, **options: Any) -> Any:
    """An argument; a node and an untyped value as the double that it is cast to (XPath 3.1 §3.1.5.2)."""
    value = XPathFunction.get_argument(self, context, index, **options)
    if index == 0 and isinstance(value, bool) and not self.parser.compatibility_mode:
        raise self.error("XPTY0004", f"{self.symbol}() needs a number")
    if not isinstance(value, UntypedAtomic | XPathNode):
        return value
    number = self.number_value(value)
    text = self.string_value(value) if isinstance(value, XPathNode) else str(value)
    if math.isnan(number) and text.strip() != "NaN" and not self.parser.compatibility_mode:
        raise self.error("FORG0001", f"{text[:60]!r} is no number")
    return number


def _index_of(self: Any, context: Any = None) -> Iterator[int]:
    """fn:index-of (F&O 3.1 §14.2.1): texts, numbers and booleans are not equal to one another."""
    context = self.context or context
    value = self[1].get_atomized_operand(copy(context))
    if value is None:
        raise self.error("XPTY0004", "the second argument of index-of() is empty")
    asked = self.get_argument(context, 2, required=True, cls=str) if len(self) > 2 else None
    with CollationManager(asked or self.parser.default_collation, self) as collation:
        for place, item in enumerate(self[0].atomization(copy(context)), start=1):
            if key_of(item, str)[0] == key_of(value, str)[0] and collation.eq(item, value):
                yield place


def _sum(self: Any, context: Any = None) -> Any:
    """fn:sum (F&O 3.1 §14.4.5): of numbers and durations, no booleans."""
    found = _SUM(self, context)
    if isinstance(found, bool):
        raise self.error("FORG0006", "sum() is of numbers")
    return found


def add_up(values: Iterable[Any], start: Any = 0) -> Any:
    """The sum as F&O 3.1 §14.4.5 has it: one value added after the other, each sum rounded.

    Python's `sum` compensates for rounding from 3.12 on, so that its numbers would depend on the version, and differ
    from those of columns.
    """
    return functools.reduce(operator.add, values, start)


_xpath1_functions.sum = _xpath2_functions.sum = add_up  # type: ignore[attr-defined]  # in the place of the builtin

_SUM: Any = XPath31Parser.symbol_table["sum"].evaluate

NUMERIC: dict[str, dict[str, Any]] = {
    **{
        f"{prefix}{name}": {"evaluate": evaluate}
        for prefix in ("", f"{{{XPATH_MATH_FUNCTIONS_NAMESPACE}}}")
        for name, evaluate in (
            ("pow", _power), ("exp", _of_one(math.exp)), ("exp10", _of_one(lambda value: math.pow(10.0, value))),
        )
    },
    "index-of": {"select": _index_of},
    "sum": {"evaluate": _sum},
    "round-half-to-even": {"get_argument": number_argument},
}  # fmt: skip
"""By symbol: methods of its tokens."""
