"""Figures, curves and outliers of frame ranges, against NumPy and SciPy."""

from __future__ import annotations

import doctest
import math

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mcml.numerics import curves
from mcml.numerics.curves import POINTS, CurveSums, normalise_range, summarise_samples
from mcml.numerics.outliers import FEWEST, THRESHOLD, score_outliers

numbers = st.floats(-1e6, 1e6, allow_subnormal=False)
samples = st.lists(numbers | st.just(math.nan), min_size=1, max_size=40).map(np.array)


@given(samples)
def test_figures_are_those_of_numpy(values: np.ndarray) -> None:
    found = summarise_samples(values)
    if np.isnan(values).all():
        assert found is None
        return
    assert found is not None
    assert (found.minimum, found.maximum) == (np.nanmin(values), np.nanmax(values))
    assert found.range == np.nanmax(values) - np.nanmin(values)
    assert found.place == np.nanargmax(values)
    assert found.missing == np.isnan(values).sum()
    assert found.mean == pytest.approx(np.nanmean(values))
    if len(values) - found.missing > 1:
        assert found.sd == pytest.approx(np.nanstd(values, ddof=1))
    else:
        assert np.isnan(found.sd)


@given(st.lists(numbers, min_size=1, max_size=40).map(np.array), st.data())
def test_curves_are_those_of_interp(values: np.ndarray, data: st.DataObject) -> None:
    last = len(values) - 1
    begin = data.draw(st.floats(0, last))
    end = data.draw(st.floats(begin, last))
    expected = np.interp(np.linspace(begin, end, POINTS), np.arange(len(values)), values)
    assert normalise_range(values, begin, end) == pytest.approx(expected, rel=1e-9, abs=1e-6)


@given(samples)
def test_gaps_of_curves_are_not_bridged(values: np.ndarray) -> None:
    curve = normalise_range(values, 0, len(values) - 1)
    assert np.isnan(curve[0]) == np.isnan(values[0])
    assert np.isnan(curve[-1]) == np.isnan(values[-1])
    places = np.linspace(0, len(values) - 1, POINTS)
    low, high = np.floor(places).astype(int), np.ceil(places).astype(int)
    assert (np.isnan(curve) == (np.isnan(values[low]) | np.isnan(values[high]))).all()


@given(arrays(np.float64, st.tuples(st.integers(1, 8), st.just(POINTS)), elements=numbers | st.just(math.nan)))
def test_sums_of_curves_are_those_of_numpy(some: np.ndarray) -> None:
    sums = CurveSums()
    for curve in some:
        sums.add(curve)
    count = np.isfinite(some).sum(axis=0)
    assert sums.count.tolist() == count.tolist()
    assert np.isnan(sums.mean).tolist() == (count == 0).tolist()
    assert np.isnan(sums.sd).tolist() == (count < 2).tolist()
    many = count > 1
    assert sums.mean[many] == pytest.approx(np.nanmean(some[:, many], axis=0), abs=1e-6)
    assert sums.sd[many] == pytest.approx(np.nanstd(some[:, many], axis=0, ddof=1), abs=1e-6)


@given(st.lists(st.integers(-1000, 1000).map(float), min_size=FEWEST, max_size=30).map(np.array))
def test_scores_are_those_of_the_median_absolute_deviation(values: np.ndarray) -> None:
    spread = scipy.stats.median_abs_deviation(values, scale="normal")
    scores = score_outliers(values)
    if spread:
        assert scores == pytest.approx((values - np.median(values)) / spread, rel=1e-4)
        assert score_outliers(3 * values - 7) == pytest.approx(scores)
    elif np.ptp(values) == 0:
        assert not scores.any()
    else:
        assert np.isfinite(scores).all()
        assert scores[values == np.median(values)].tolist() == [0.0] * int((values == np.median(values)).sum())


def test_an_outlier_is_found_and_rounding_is_none() -> None:
    rng = np.random.default_rng(4)
    values = np.append(rng.normal(60, 2, 30), 85.0)
    assert (np.abs(score_outliers(values)) > THRESHOLD).tolist() == [False] * 30 + [True]
    equal = np.full(9, 0.1) * np.linspace(1, 1 + 1e-14, 9)
    assert not score_outliers(equal).any()
    assert np.isnan(score_outliers(values[: FEWEST - 1])).all()
    unknown = score_outliers(np.append(values, np.nan))
    assert np.isnan(unknown[-1])
    assert np.isfinite(unknown[:-1]).all()


def test_examples() -> None:
    assert doctest.testmod(curves).failed == 0
