"""Curves of strides on one scale of percent."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.laboratory.gait_cycles import POINTS, mean_cycle, normalise_cycles


@given(st.floats(0.11, 1.2), st.floats(0.6, 1.4), st.sampled_from([60.0, 100.0, 250.0]))
def test_a_smooth_curve_is_kept_between_frames(begin: float, lasts: float, rate: float) -> None:
    seconds = np.arange(int(3 * rate)) / rate
    cycles = normalise_cycles(np.sin(2 * np.pi * seconds), rate, [(begin, begin + lasts)])
    assert cycles.curves.shape == (1, POINTS)
    wanted = np.sin(2 * np.pi * (begin + lasts * np.linspace(0, 1, POINTS)))
    assert np.abs(cycles.curves[0] - wanted).max() < 1e-4


def test_strides_with_gaps_are_left_out_whole_and_counted() -> None:
    values = np.linspace(0, 1, 400)
    values[150] = np.nan
    cycles = normalise_cycles(values, 100, [(0.2, 1.2), (1.2, 2.2), (2.2, 3.2), (3.2, 4.2)])
    assert cycles.intervals == ((0.2, 1.2), (2.2, 3.2))
    assert cycles.gaps == 2
    assert np.isfinite(cycles.curves).all()


def test_the_mean_counts_as_samples_do() -> None:
    curves = np.stack([np.full(POINTS, value) for value in (1.0, 2.0, 6.0)])
    mean = mean_cycle(curves)
    assert (mean.mean[0], mean.n) == (3.0, 3)
    assert mean.sd[0] == pytest.approx(np.std([1, 2, 6], ddof=1))
    fewer = mean_cycle(curves, np.array([True, False, False]))
    assert (fewer.mean[0], fewer.n) == (1.0, 1)
    assert np.isnan(fewer.sd).all()
    assert np.isnan(mean_cycle(curves[:0]).mean).all()


@pytest.mark.parametrize("interval", [(-0.5, 0.5), (0.5, 99.0), (0.5, 0.5), (0.5, 0.505)])
def test_an_interval_outside_of_the_frames_or_too_short_is_left_out(interval: tuple[float, float]) -> None:
    cycles = normalise_cycles(np.arange(200.0), 100, [interval])
    assert cycles.curves.shape == (0, POINTS)
    assert cycles.gaps == 1


def test_one_cycle_has_no_standard_deviation_and_none_has_no_mean() -> None:
    curves = np.random.default_rng(0).normal(0, 10, (3, POINTS))
    whole, one, none = (
        mean_cycle(curves, np.array(kept))
        for kept in ([1, 1, 1], [0, 1, 0], [0, 0, 0])
        for kept in [np.array(kept, bool)]
    )
    np.testing.assert_allclose(whole.sd, curves.std(axis=0, ddof=1))
    np.testing.assert_array_equal(one.mean, curves[1])
    assert np.isnan(one.sd).all()
    assert np.isnan(none.mean).all()
    assert (whole.n, one.n, none.n) == (3, 1, 0)
    two = mean_cycle(curves[:2])
    np.testing.assert_allclose(two.sd, np.abs(curves[0] - curves[1]) / np.sqrt(2))
