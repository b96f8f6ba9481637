"""Medians and percentiles are NumPy's, bit for bit."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from mcml.numerics.ranks import median, percentile

FINITE = st.floats(-1e6, 1e6, allow_subnormal=False)
VALUES = arrays.arrays(np.float64, st.integers(1, 60), elements=FINITE)


@given(VALUES)
def test_median(values: np.ndarray) -> None:
    before = values.copy()
    assert median(values) == np.median(values)
    assert np.array_equal(values, before)


@given(VALUES, st.sampled_from([0.0, 5.0, 50.0, 97.5, 100.0]) | st.floats(0, 100))
def test_percentile(values: np.ndarray, percent: float) -> None:
    before = values.copy()
    assert percentile(values, percent) == np.percentile(values, percent)
    assert np.array_equal(values, before)
