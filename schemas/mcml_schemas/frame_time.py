"""Seconds a frame, as people write them: a number, or a text such as 0.0083333 or 1/120."""

from __future__ import annotations

from decimal import Decimal
from numbers import Rational, Real
from typing import Annotated, Any

from pydantic import BeforeValidator


def _plain(value: Any) -> Any:
    """Fractions, decimals and numbers of NumPy as JSON can hold them."""
    if isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Decimal):
        return f"{value:f}"
    return str(value) if isinstance(value, Rational) else float(value) if isinstance(value, Real) else value


FrameTime = Annotated[str | float, BeforeValidator(_plain)]
