"""Functions of the frames around a frame (`min(mo:window(-1, 0)/mo:height('Root'))`), without listing these for each.

The expression is evaluated once for every frame of a document; the least, greatest and sum over a window of each are
found from that together.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from mcml_service.xpath.engine.context import Context, Value
from mcml_service.xpath.engine.motion.motions import Kept, Motions
from mcml_service.xpath.engine.sequences import some_of
from mcml_service.xpath.language.motion_functions import WINDOW
from mcml_service.xpath.language.tree import Call, Each, Expression, Filter, Path, free_variables, predicates_of
from mcml_service.xpath.language.types import depends_on_position, type_of
from mcml_service.xpath.nodes.numbering import Bools, Floats, Ints, frames_of

NUMBERS = frozenset({"min", "max", "sum", "avg"})
ONE_BY_ONE = 1024
"""Limit of frames in a window that are added one after the other."""


class Columns(Protocol):
    """The evaluator of the parts."""

    @property
    def check(self) -> Callable[[], None]: ...

    def numbers(self, expression: Expression, context: Context) -> Floats: ...

    def sliced(self, predicate: Expression, context: Context) -> Bools: ...


class MotionWindows:
    """Of the documents of some columns."""

    def __init__(self, columns: Columns, motions: Motions) -> None:
        self._columns = columns
        self._motions = motions

    def value(self, call: Call, context: Context) -> Value | None:
        """The value of a function of a window for each context; None where this is no such call."""
        inner = call.arguments[0] if call.arguments else None
        if call.function in NUMBERS and isinstance(inner, Each) and _is_window(inner.source) and _is_plain(inner.body):
            return self._of_numbers(call.function, inner, context) if type_of(inner.body) == "number" else None
        if call.function in ("count", "exists", "empty") and inner is not None:
            counts = self.counts(inner, context, only_frames=call.function == "count")
            if counts is None or call.function == "count":
                return None if counts is None else counts.astype(np.float64)
            return np.asarray((counts > 0) == (call.function == "exists"))
        return None

    def counts(self, expression: Expression, context: Context, *, only_frames: bool = False) -> Ints | None:
        """Count the frames of a window that fulfil its predicates, or from which a path reaches a node; None for
        other expressions. only_frames: return None for paths.
        """
        asked = _asked(expression)
        if asked is None or (only_frames and isinstance(expression, Path)):
            return None
        window, predicates = asked

        def sums(around: Context) -> Ints:
            keep = np.ones(len(around), bool)
            for predicate in predicates:
                index = np.flatnonzero(keep)
                keep[index] = self._columns.sliced(predicate, Context(around.nodes[index]))
            return np.concatenate([[0], np.cumsum(keep)]).astype(np.int64)

        totals, low, high = self._around(expression, sums, window, context.nodes)
        return np.asarray(totals[high] - totals[low], np.int64)

    def _of_numbers(self, function: str, inner: Each, context: Context) -> Value:
        def evaluate(around: Context) -> Floats:
            return self._columns.numbers(inner.body, around)

        numbers, low, high = self._around(inner, evaluate, _window(inner.source), context.nodes)
        exist = high > low
        if function in ("min", "max"):
            least = function == "min"
            return some_of(extremes(numbers, low, high, np.minimum if least else np.maximum), exist)
        totals = totals_of(numbers, low, high, self._columns.check)
        if function == "sum":
            return totals
        return some_of(totals / np.maximum(high - low, 1), exist)

    def _around(
        self, key: object, evaluate: Callable[[Context], Kept], window: Call, nodes: Ints
    ) -> tuple[Kept, Ints, Ints]:
        """Return the values of all frames, and for each node the begin and end of its window in them."""
        found, _, starts = self._motions.everywhere(key, evaluate, nodes)
        first, last = self._motions.reach(window, nodes)
        inside = frames_of(nodes) > 0
        low = np.where(inside, starts + first - 1, 0)
        return found, low, np.where(inside, np.maximum(starts + last, low), 0)


def _window(expression: Expression) -> Call:
    if not isinstance(expression, Call):
        raise TypeError("not a window")
    return expression


def _is_window(expression: Expression | None) -> bool:
    return (
        isinstance(expression, Call)
        and expression.function == WINDOW
        and not any(map(free_variables, expression.arguments))
    )


def _is_plain(expression: Expression) -> bool:
    """Tell whether it is only the context node."""
    return not free_variables(expression) and not depends_on_position(expression)


def _asked(expression: Expression) -> tuple[Call, tuple[Expression, ...]] | None:
    """Return the window, and the conditions on its frames."""
    if _is_window(expression):
        return _window(expression), ()
    if isinstance(expression, Filter) and _is_window(expression.operand):
        window, predicates = expression.operand, expression.predicates
    elif isinstance(expression, Path) and expression.start is not None:
        inner = _asked(expression.start)
        if inner is None or any(map(free_variables, predicates_of(expression.steps))):
            return None
        window, predicates = inner[0], (*inner[1], Path(expression.steps))
        return (inner[0], predicates) if expression.steps else None
    else:
        return None
    if any(type_of(each) == "number" or not _is_plain(each) for each in predicates):
        return None
    return _window(window), predicates


def extremes(numbers: Floats, low: Ints, high: Ints, function: np.ufunc) -> Floats:
    """The least (np.minimum) or greatest of each range low to high - 1; NaN where one is NaN, or the range is empty.

    Two ranges whose length is a power of two cover any other one.
    """
    lengths = high - low
    found = np.full(len(low), np.nan)
    level, width = numbers, 1
    while True:
        some = np.flatnonzero((lengths >= width) & (lengths < 2 * width))
        if len(some):
            found[some] = function(level[low[some]], level[high[some] - width])
        if not (lengths >= 2 * width).any():
            return found
        level = function(level[:-width], level[width:])
        width *= 2


def totals_of(numbers: Floats, low: Ints, high: Ints, check: Callable[[], None]) -> Floats:
    """The sum of each range low to high - 1: one number after the other, as a loop over the frames would."""
    lengths = high - low
    found = np.zeros(len(low))
    longest = int(lengths.max(initial=0))
    if longest > ONE_BY_ONE:
        sums = np.concatenate([[0.0], np.cumsum(np.nan_to_num(numbers), dtype=np.longdouble)])
        gaps = np.concatenate([[0], np.cumsum(np.isnan(numbers))])
        return np.where(gaps[high] > gaps[low], np.nan, (sums[high] - sums[low]).astype(np.float64))
    for step in range(longest):
        check()
        some = np.flatnonzero(lengths > step)
        found[some] += numbers[low[some] + step]
    return found
