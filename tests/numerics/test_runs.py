"""Runs against a loop over the entries."""

from __future__ import annotations

import doctest
from itertools import groupby

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mcml.numerics import runs
from mcml.numerics.runs import find_consecutive, find_equal, find_starts, find_true

small = st.lists(st.integers(-2, 3), max_size=12)


@given(small)
def test_runs_of_equal_entries(values: list[int]) -> None:
    found = find_equal(np.array(values, dtype=np.int64)).tolist()
    lengths = [len(list(run)) for _, run in groupby(values)]
    ends = np.cumsum(lengths, dtype=int).tolist()
    assert found == [[end - length, end] for end, length in zip(ends, lengths, strict=True)]
    assert find_starts(np.array(values, dtype=np.int64)).tolist() == [begin for begin, _ in found]


@given(st.lists(st.booleans(), max_size=12))
def test_runs_of_true_flags(flags: list[bool]) -> None:
    found = find_true(np.array(flags, dtype=np.bool_)).tolist()
    lengths = [(is_true, len(list(run))) for is_true, run in groupby(flags)]
    begin, expected = 0, []
    for is_true, length in lengths:
        expected += [[begin, begin + length]] if is_true else []
        begin += length
    assert found == expected


@given(small)
def test_runs_of_consecutive_numbers(numbers: list[int]) -> None:
    expected: list[list[int]] = []
    for number in numbers:
        if expected and number == expected[-1][1] + 1:
            expected[-1][1] = number
        else:
            expected.append([number, number])
    assert find_consecutive(np.array(numbers, dtype=np.int64)).tolist() == expected


def test_examples() -> None:
    assert doctest.testmod(runs).failed == 0
