"""Strides and what is measured of them, of walkers whose parameters are known."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.laboratory.gait_events import SIDES, Side, WalkerPaths, find_events, times_of
from mcml.laboratory.gait_parameters import (
    EXCLUDED,
    PARAMETERS,
    Exclusion,
    exclude_strides,
    measure_belt,
    measure_strides,
    reject_outliers,
    summarise,
    symmetry,
)
from tests.fuzz import examples
from tests.laboratory.walkers import WALKS, Gait, events_of, make_walker


@given(WALKS)
@examples(40)
def test_parameters_are_those_that_the_walker_was_made_of(gait: Gait) -> None:
    walker, events = make_walker(gait), events_of(gait)
    belt = measure_belt(walker, events)
    assert belt.is_belt == gait.on_belt
    assert belt.speed == pytest.approx(gait.speed if gait.on_belt else 0.0, abs=0.03)
    strides = measure_strides(walker, events, belt.speed if belt.is_belt else 0.0)
    for stride in strides.strides:
        assert stride.stride_time == pytest.approx(gait.stride_time)
        assert stride.cadence == pytest.approx(120 / gait.stride_time)
        assert stride.stance == pytest.approx(100 * gait.duty)
        assert stride.double_support == pytest.approx(200 * gait.duty - 100)
        step = 1 - gait.late if stride.side == "left" else gait.late
        assert stride.step_time == pytest.approx((1 - step) * gait.stride_time)
        if gait.turn:
            # The chord of a turn is shorter than its arc, and the other foot is inside or outside of it.
            assert 0.85 * gait.speed < stride.speed < 1.15 * gait.speed
            assert np.isfinite(stride.step_width)
        else:
            assert stride.speed == pytest.approx(gait.speed, abs=0.01)
            # A belt moves while the nearest frame is not the time of the strike.
            assert stride.step_width == pytest.approx(gait.width, abs=0.02)
            assert stride.step_length == pytest.approx((1 - step) * gait.stride_time * gait.speed, abs=0.025)
    for side in SIDES:
        assert len(times_of(events, side, "strike")) > 3
        summary = summarise(strides.strides, side, "stride_time")
        assert summary.n >= 2
        assert summary.sd == pytest.approx(0, abs=1e-9)


def test_found_events_give_nearly_the_same_parameters() -> None:
    gait = Gait(heading=70)
    walker = make_walker(gait)
    strides = measure_strides(walker, find_events(walker).events).strides
    assert len(strides) >= 6
    for stride in strides:
        assert stride.stride_time == pytest.approx(gait.stride_time, abs=0.02)
        assert stride.speed == pytest.approx(gait.speed, abs=0.02)
        assert stride.stance == pytest.approx(62, abs=3)


def test_running_has_no_double_support() -> None:
    gait = Gait(rate=200, speed=3.5, stride_time=0.7, duty=0.32)
    strides = measure_strides(make_walker(gait), events_of(gait)).strides
    assert len(strides) > 8
    assert all(np.isnan(stride.double_support) and np.isnan(stride.single_support) for stride in strides)
    assert all(stride.stance == pytest.approx(32) for stride in strides)


def test_a_stride_without_an_event_is_left_out_and_counted() -> None:
    gait = Gait()
    events = events_of(gait)
    whole = measure_strides(make_walker(gait), events)
    assert whole.incomplete == {"left": 0, "right": 0}
    off = next(event for event in events if (event.side, event.kind) == ("left", "off") and event.seconds > 2)
    fewer = measure_strides(make_walker(gait), [event for event in events if event is not off])
    # Its own stride, and that of the other foot.
    assert fewer.incomplete == {"left": 1, "right": 1}
    assert len(fewer.strides) == len(whole.strides) - 2


def test_a_gap_at_a_strike_leaves_times_and_takes_lengths() -> None:
    gait = Gait()
    walker, events = make_walker(gait), events_of(gait)
    strike = times_of(events, "left", "strike")[1]
    toe = walker.toes["left"].copy()
    middle = round(strike * gait.rate)
    toe[middle - 10 : middle + 10] = np.nan
    strides = measure_strides(replace(walker, toes={**walker.toes, "left": toe}), events).strides
    hurt = [stride for stride in strides if stride.side == "left" and strike in (stride.begin, stride.end)]
    assert len(hurt) == 2
    assert all(np.isnan(stride.stride_length) and np.isnan(stride.speed) for stride in hurt)
    assert all(np.isfinite(stride.stride_time) and np.isfinite(stride.stance) for stride in hurt)


def test_crossed_feet_have_a_negative_width() -> None:
    gait = Gait(width=-0.05)
    assert all(
        stride.step_width == pytest.approx(-0.05)
        for stride in measure_strides(make_walker(gait), events_of(gait)).strides
    )


def test_only_an_outlier_of_time_is_rejected_and_says_by_which_rule() -> None:
    gait = Gait(seconds=12)
    strides = measure_strides(make_walker(gait), events_of(gait)).strides
    assert not any(stride.rejected for stride in reject_outliers(strides, 100))
    slow = [replace(stride, stride_time=1.6) if number == 4 else stride for number, stride in enumerate(strides)]
    marked = reject_outliers(slow, 100)
    assert [number for number, stride in enumerate(marked) if stride.rejected] == [4]
    assert "3 median absolute deviations" in marked[4].rejected
    side = marked[4].side
    assert summarise(marked, side, "stride_time").n == summarise(strides, side, "stride_time").n - 1
    few = [stride for stride in slow if stride.side == side][:4]
    assert not any(stride.rejected for stride in reject_outliers(few, 100))


def test_one_stride_has_no_standard_deviation() -> None:
    gait = Gait(seconds=2.6)
    strides = [
        stride for stride in measure_strides(make_walker(gait), events_of(gait)).strides if stride.side == "left"
    ]
    summary = summarise(strides[:1], "left", "stride_time")
    assert (summary.n, summary.mean) == (1, pytest.approx(1.1))
    assert np.isnan(summary.sd)
    nothing = summarise([], "left", "speed")
    assert nothing.n == 0
    assert np.isnan(nothing.mean)


def test_symmetry_has_the_sign_of_the_larger_side() -> None:
    assert symmetry(1.0, 1.0) == 0
    assert symmetry(1.1, 0.9) == pytest.approx(20)
    assert symmetry(0.9, 1.1) == pytest.approx(-20)
    assert np.isnan(symmetry(np.nan, 1.0))
    assert np.isnan(symmetry(0.0, 0.0))


def test_names_of_parameters_are_fields_of_strides() -> None:
    (stride, *_) = measure_strides(make_walker(Gait()), events_of(Gait())).strides
    assert all(np.isfinite(getattr(stride, parameter.name)) for parameter in PARAMETERS)
    assert len({parameter.name for parameter in PARAMETERS}) == len(PARAMETERS)
    starts = [stride.begin for stride in measure_strides(make_walker(Gait()), events_of(Gait())).strides]
    assert all(one <= other for one, other in pairwise(starts))


@given(st.integers(0, 2**32 - 1), st.integers(0, 300), st.sampled_from([5.0, 24.0, 50.0, 120.0, 1000.0]))
@examples(60)
def test_any_paths_are_measured_without_failure(seed: int, frames: int, rate: float) -> None:
    """Wandering points with gaps of every length, or points that stay: no error, and nothing infinite."""
    rng = np.random.default_rng(seed)

    def path() -> np.ndarray:
        steps = rng.normal(0, rng.choice([0.0, 0.02, 0.3]), (frames, 3)).cumsum(axis=0)
        for _ in range(rng.integers(0, 6)):
            first = int(rng.integers(0, frames + 1))
            steps[first : first + int(rng.integers(0, 40))] = np.nan
        return steps

    walker = WalkerPaths(
        {side: path() for side in SIDES},
        {side: path() for side in SIDES},
        path(),
        path(),
        np.array([0.0, 0.0, 1.0]),
        rate,
    )
    events = find_events(walker).events
    assert all(0 <= event.seconds <= frames / rate + 0.1 for event in events)
    belt = measure_belt(walker, events)
    strides = reject_outliers(measure_strides(walker, events, belt.speed if belt.is_belt else 0.0).strides, rate)
    for parameter in PARAMETERS:
        assert not any(np.isinf(getattr(stride, parameter.name)) for stride in strides)


@pytest.mark.parametrize(("left", "right"), [(1.2, 1.0), (60.0, 64.0), (0.3, 0.3)])
def test_symmetry_is_of_the_mean_of_both_sides(left: float, right: float) -> None:
    assert symmetry(left, right) == pytest.approx(200 * (left - right) / (left + right), abs=1e-8)
    assert symmetry(right, left) == -symmetry(left, right)


@pytest.mark.parametrize(
    ("first", "last", "side", "expected"),
    [
        (150, 150, None, {"left", "right"}),
        (150, 150, "left", {"left"}),
        (210, 400, None, set()),
        (0, 99, None, set()),
        (0, 100, None, {"left", "right"}),
        (200, 300, "right", {"right"}),
    ],
)
def test_strides_that_share_time_with_frames_left_out_do_not_count(
    first: int, last: int, side: Side | None, expected: set[str]
) -> None:
    gait = Gait(rate=100.0, stride_time=1.0, seconds=4)
    (stride, *_) = measure_strides(make_walker(gait), events_of(gait)).strides
    strides = [replace(stride, side=each, begin=1.0, end=2.0, rejected="") for each in SIDES]
    marked = exclude_strides(strides, [Exclusion(first, last, side)], 100.0)
    assert {each.side for each in marked if each.rejected} == expected
    assert all(each.rejected in ("", EXCLUDED) for each in marked)
