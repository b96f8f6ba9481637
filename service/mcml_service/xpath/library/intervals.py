"""Ranges of numbers, a track at a time: arithmetic on the least and greatest samples in zone maps.

IEEE arithmetic is monotonic also after rounding, so the ends of an interval are exact: if they exclude a condition, no
frame fulfils it, and if they imply it, every frame does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mcml_service.xpath.nodes.numbering import Bools, Floats


@dataclass(frozen=True)
class Interval:
    """low, high: of a number in each track. some, all: whether any frame of the track has the number, whether each."""

    low: Floats
    high: Floats
    some: Bools
    all: Bools


@dataclass(frozen=True)
class Verdict:
    """may: in which tracks a frame may fulfil a condition. must: in which each frame does that the track has."""

    may: Bools
    must: Bools


def exactly(value: float) -> Interval:
    """A constant."""
    always = np.asarray(True)
    return _known(np.asarray(value), np.asarray(value), always, always)


def monotonic(function: Callable[[Floats], Floats], inner: Interval) -> Interval:
    """A rounding of a number, or the number itself."""
    return _known(function(inner.low), function(inner.high), inner.some, inner.all)


def negative(inner: Interval) -> Interval:
    return _known(-inner.high, -inner.low, inner.some, inner.all)


def magnitude(inner: Interval) -> Interval:
    """`abs()` of a number."""
    high = np.maximum(np.abs(inner.low), np.abs(inner.high))
    low = np.maximum(0.0, np.maximum(inner.low, -inner.high))
    return _known(low, high, inner.some, inner.all)


def computed(operator: str, left: Interval, right: Interval) -> Interval:
    """A sum, difference or product; of other results nothing is known."""
    some, always = left.some & right.some, left.all & right.all
    with np.errstate(invalid="ignore", over="ignore"):
        if operator == "+":
            return _known(left.low + right.low, left.high + right.high, some, always)
        if operator == "-":
            return _known(left.low - right.high, left.high - right.low, some, always)
        if operator == "*":
            corners = np.array(
                [left.low * right.low, left.low * right.high, left.high * right.low, left.high * right.high]
            )
            return _known(corners.min(axis=0), corners.max(axis=0), some, always)
    nothing = np.full(np.shape(some), np.nan)
    return _known(nothing, nothing, some, always)


def compared(operator: str, left: Interval, right: Interval) -> Verdict:
    """`<`, `<=`, `>`, `>=` or `=` between two numbers."""
    if operator in (">", ">="):
        return compared({">": "<", ">=": "<="}[operator], right, left)
    if operator == "<":
        may, must = left.low < right.high, left.high < right.low
    elif operator == "<=":
        may, must = left.low <= right.high, left.high <= right.low
    else:
        may, must = (left.low <= right.high) & (right.low <= left.high), np.zeros(np.shape(left.low), bool)
    return Verdict(may & left.some & right.some, must & left.all & right.all)


def present(inner: Interval) -> Verdict:
    """That a frame has the number."""
    return Verdict(inner.some, inner.all)


def unknown(inner: Interval) -> Verdict:
    """Nothing is ruled out, nothing certain. inner: any interval, for the number of tracks."""
    return Verdict(np.ones(np.shape(inner.some), bool), np.zeros(np.shape(inner.some), bool))


def all_of(parts: list[Verdict]) -> Verdict:
    return Verdict(
        np.logical_and.reduce([part.may for part in parts]), np.logical_and.reduce([part.must for part in parts])
    )


def any_of(parts: list[Verdict]) -> Verdict:
    return Verdict(
        np.logical_or.reduce([part.may for part in parts]), np.logical_or.reduce([part.must for part in parts])
    )


def _known(low: Floats, high: Floats, some: Bools, always: Bools) -> Interval:
    """If an end is not finite, any result is possible, also NaN."""
    finite = np.isfinite(low) & np.isfinite(high)
    return Interval(np.where(finite, low, -np.inf), np.where(finite, high, np.inf), some, always & finite)
