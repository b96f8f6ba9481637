"""Runs: maximal ranges of an array with equal, true, or consecutive entries."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Places = NDArray[np.intp]
Some: TypeAlias = slice | NDArray[np.int64]
"""Which of an array's entries."""


def find_starts(values: NDArray[np.generic]) -> Places:
    """(r,) where runs of equal entries of (n,) begin; none of nothing.

    >>> find_starts(np.array([4, 4, 7, 4])).tolist()
    [0, 2, 3]
    """
    is_start = np.ones(len(values), dtype=np.bool_)
    np.not_equal(values[1:], values[:-1], out=is_start[1:])
    return np.flatnonzero(is_start)


def find_equal(values: NDArray[np.generic]) -> Places:
    """(r, 2) where runs of equal entries of (n,) begin and end; the end is the place behind the last.

    >>> find_equal(np.array([4, 4, 7, 4])).tolist()
    [[0, 2], [2, 3], [3, 4]]
    """
    starts = find_starts(values)
    return np.stack([starts, np.append(starts[1:], len(values))[: len(starts)]], axis=1)


def find_true(flags: NDArray[np.bool_]) -> Places:
    """(r, 2) where runs of true flags (n,) begin and end; the end is the place behind the last.

    >>> find_true(np.array([True, False, True, True])).tolist()
    [[0, 1], [2, 4]]
    """
    padded = np.zeros(len(flags) + 2, dtype=np.bool_)
    padded[1:-1] = flags
    return np.flatnonzero(padded[1:] != padded[:-1]).reshape(-1, 2)


def find_consecutive(numbers: NDArray[np.integer]) -> NDArray[np.integer]:
    """(r, 2) first and last number of runs of (n,) that count up by one.

    >>> find_consecutive(np.array([9, 10, 11, 15])).tolist()
    [[9, 11], [15, 15]]
    """
    bounds = find_equal(numbers - np.arange(len(numbers)))
    return np.stack([numbers[bounds[:, 0]], numbers[bounds[:, 1] - 1]], axis=1)


def evenly(numbers: NDArray[np.int64]) -> Some:
    """The same as a slice where they ascend by equal distances, which arrays read and write several times faster."""
    first, last, count = int(numbers[0]), int(numbers[-1]), len(numbers)
    if count == 1:
        return slice(first, first + 1)
    step = (last - first) // max(1, count - 1) or 1
    regular = slice(first, last + 1, step)
    return regular if np.array_equal(np.arange(first, last + 1, step), numbers) else numbers
