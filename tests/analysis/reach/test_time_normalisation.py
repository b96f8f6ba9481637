"""Samples at matched instants, and the way back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.motion.rotations import from_euler, slerp
from mcml_service.analysis.reach_blending.time_normalisation import (
    PAPER_KNOTS,
    instants,
    mean_knots,
    positions,
    read_rotations,
    read_values,
)

durations = st.tuples(*[st.floats(0.2, 40)] * 3).map(lambda d: tuple(np.cumsum(d)))


@given(durations)
def test_playback_is_the_inverse_of_sampling(times: tuple[float, float, float]) -> None:
    at = instants(PAPER_KNOTS, times)
    assert len(at) == 50
    assert np.allclose(at[[0, 5, 28, 49]], [0, *times])
    assert (np.diff(at) > 0).all()
    assert np.allclose(positions(PAPER_KNOTS, times, at), np.arange(50))


def printed_instants(times: tuple[float, float, float]) -> np.ndarray:
    """When the printed map shows each sample, (end + 1,): twice two samples at one instant."""
    c1, c2, last = PAPER_KNOTS
    t1, t2, end = times
    sample = np.arange(last + 1)
    first = np.interp(sample, [0, c1], [0.0, t1])
    second = np.interp(sample, [c1 + 1, c2], [t1, t2])
    third = np.interp(sample, [c2 + 1, last], [t2, end])
    return np.where(sample <= c1, first, np.where(sample <= c2, second, third))


@given(durations)
def test_the_printed_map_freezes_two_frames(times: tuple[float, float, float]) -> None:
    shown = printed_instants(times)
    assert list(np.flatnonzero(np.diff(shown) == 0)) == [5, 28]
    assert (np.diff(instants(PAPER_KNOTS, times)) > 0).all()
    # In playback the position leaps by a whole sample at t1 and t2, where the continuous map does not.
    for time in times[:2]:
        around = np.array([time, np.nextafter(time, np.inf)])
        assert np.diff(positions(PAPER_KNOTS, times, around, legacy=True))[0] == pytest.approx(1)
        assert np.diff(positions(PAPER_KNOTS, times, around))[0] == pytest.approx(0, abs=1e-9)


def test_the_printed_map_shows_each_sample_when_it_says() -> None:
    times = (7.0, 33.0, 70.0)
    at = np.delete(printed_instants(times), [6, 29])
    assert np.allclose(positions(PAPER_KNOTS, times, at, legacy=True), np.delete(np.arange(50), [6, 29]))


def test_knots_are_rounded_means_and_differ() -> None:
    assert mean_knots(np.array([[6.0, 29, 50], [5, 28, 48]])) == (6, 28, 49)
    assert mean_knots(np.array([[0.1, 0.2, 0.3]])) == (1, 2, 3)


def test_reading_between_frames() -> None:
    rng = np.random.default_rng(0)
    rotations, values = from_euler(rng.normal(size=(6, 2, 3)), "XYZ"), rng.normal(size=(6, 3))
    at = np.array([0.0, 1.25, 4.5, 5.0, 7.0])
    turned, read = read_rotations(rotations, at), read_values(values, at)
    assert np.allclose(np.abs(np.sum(turned[0] * rotations[0], axis=1)), 1)
    assert np.allclose(turned[1], slerp(rotations[1], rotations[2], np.array([0.25, 0.25])))
    assert np.allclose(read[2], (values[4] + values[5]) / 2)
    assert np.allclose(read[3:], values[5])
