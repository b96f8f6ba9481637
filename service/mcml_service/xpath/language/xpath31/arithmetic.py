"""Arithmetic of XPath 3.1 (§3.5), corrected: operands of the mode compatible with XPath 1.0, signs of remainders."""

from __future__ import annotations

import math
from copy import copy
from decimal import Decimal
from typing import Any

from elementpath.datatypes import AnyURI, Duration, Float, UntypedAtomic
from elementpath.xpath31 import XPath31Parser

OPERATORS = ("+", "-", "*", "div", "mod", "idiv")


def arithmetic(symbol: str) -> dict[str, Any]:
    """Methods of the tokens of an operator."""
    kind = XPath31Parser.symbol_table[symbol]

    def get_operands(self: Any, context: Any, cls: Any = None) -> tuple[Any, Any]:
        """Two numbers of one type, or other values that the operator takes. Of None both, where one is nothing."""
        one, other = (_operand(self, place, context) for place in (0, 1))
        if one is None or other is None:
            return None, None
        if _is_number(one) and _is_number(other):
            return _of_one_type(one, other)
        if isinstance(one, Duration) and symbol in ("*", "div") and _is_number(other):
            return one, _factor(self, other)
        if isinstance(other, Duration) and symbol == "*" and _is_number(one):
            return _factor(self, one), other
        if any(isinstance(value, (bool, str, AnyURI)) or _is_number(value) for value in (one, other)):
            raise self.error("XPTY0004", f"{symbol} has no meaning for {type(one)!r} and {type(other)!r}")
        return kind.get_operands(self, context, cls=cls)  # type: ignore[no-any-return]  # elementpath says Any

    def evaluate(self: Any, context: Any = None) -> Any:
        found = _apply_sign(self, context) if len(self) == 1 else compute(self, context)
        nothing = isinstance(found, list) and not found
        return math.nan if nothing and self.parser.compatibility_mode else found

    compute = {"div": _divide, "mod": _remainder, "idiv": _quotient}.get(symbol, kind.evaluate)
    return {"get_operands": get_operands, "evaluate": evaluate}


def _operand(self: Any, place: int, context: Any) -> Any:
    """One value, None for nothing: untyped values are doubles.

    In the compatible mode it is the first item, texts and truths are doubles, NaN where they show none; integers and
    decimals stay exact, where the specification makes doubles. Else raises XPTY0004 for several items, and
    FORG0001 for untyped text that shows no number.
    """
    values = self[place].atomization(copy(context))
    value = next(values, None)
    if self.parser.compatibility_mode:
        return float(self.number_value(value)) if isinstance(value, (bool, str, UntypedAtomic)) else value
    if next(values, None) is not None:
        raise self.error("XPTY0004", "an operand has several items")
    return self.cast_to_double(value.value) if isinstance(value, UntypedAtomic) else value


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, Decimal)) and not isinstance(value, bool)


def _of_one_type(one: Any, other: Any) -> tuple[Any, Any]:
    """Numbers promoted to the wider type of two (XPath 3.1 §B.1)."""
    if isinstance(one, float) or isinstance(other, float):
        is_single = all(not isinstance(value, float) or isinstance(value, Float) for value in (one, other))
        kind: Any = Float if is_single else float
    elif isinstance(one, Decimal) or isinstance(other, Decimal):
        kind = Decimal
    else:
        return one, other
    return kind(one), kind(other)


def _factor(self: Any, number: Any) -> Any:
    """A factor of a duration."""
    if not isinstance(number, float):
        return number
    if math.isnan(number):
        raise self.error("FOCA0005", "a duration is multiplied or divided by no number")
    return Decimal(number)


def _apply_sign(self: Any, context: Any) -> Any:
    value = _operand(self, 0, context)
    if value is None:
        return []
    if not _is_number(value):
        raise self.error("XPTY0004", "a sign needs a number")
    return -value if self.symbol == "-" else value


def _divide(self: Any, context: Any) -> Any:
    """op:numeric-divide (Functions and Operators 3.1 §4.2.4): by zero, doubles give an infinity or NaN."""
    one, other = self.get_operands(context)
    if not isinstance(one, float) or other != 0:
        return XPath31Parser.symbol_table["div"].evaluate(self, context)
    if math.isnan(one) or one == 0:
        return type(one)(math.nan)
    return type(one)(math.copysign(math.inf, one) * math.copysign(1.0, other))


def _numbers(self: Any, context: Any) -> tuple[Any, Any] | None:
    """Two numbers of one type, None where one of them is nothing. Raises XPTY0004."""
    one, other = self.get_operands(context)
    if one is None:
        return None
    if not _is_number(one) or not _is_number(other):
        raise self.error("XPTY0004", f"{self.symbol} needs numbers")
    return one, other


def _remainder(self: Any, context: Any) -> Any:
    """op:numeric-mod (Functions and Operators 3.1 §4.2.6): the sign is that of the dividend."""
    pair = _numbers(self, context)
    if pair is None:
        return []
    one, other = pair
    if isinstance(one, float):
        undefined = math.isnan(one) or math.isnan(other) or math.isinf(one) or other == 0
        return type(one)(math.nan if undefined else math.fmod(one, other))
    if other == 0:
        if self.parser.compatibility_mode:
            return math.nan
        raise self.error("FOAR0001")
    if isinstance(one, Decimal):
        return one % other
    rest = abs(one) % abs(other)
    return rest if one >= 0 else -rest


def _quotient(self: Any, context: Any) -> Any:
    """op:numeric-integer-divide (Functions and Operators 3.1 §4.2.5): rounded towards zero."""
    pair = _numbers(self, context)
    if pair is None:
        return []
    one, other = pair
    if other == 0:
        raise self.error("FOAR0001")
    if isinstance(one, float):
        if math.isnan(one) or math.isinf(one) or math.isnan(other):
            raise self.error("FOAR0002")
        return math.trunc(one / other) if math.isfinite(one / other) else math.trunc(Decimal(one) / Decimal(other))
    rounded = abs(one) // abs(other)
    return int(rounded) if (one < 0) == (other < 0) else -int(rounded)
