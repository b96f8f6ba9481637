"""Bars among beats, tracking, and what a bar plays before and after."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mcml_service.analysis.dance import bars

strengths = arrays(np.float64, st.integers(1, 120), elements=st.sampled_from([0.0, 0.0, 0.0, 0.2, 0.7, 1.3]))


def sure(beats: np.ndarray) -> np.ndarray:
    return np.ones(len(beats), dtype=bool)


def bars_of(beats: list[float], period: float | None = 10.0, **options: object) -> bars.Bars:
    times = np.array(beats, dtype=float)
    return bars.bars_of(times, sure(times), "detected", period, 20, **options)  # type: ignore[arg-type]


def test_four_even_beats_are_a_bar_and_bars_do_not_overlap() -> None:
    found = bars_of([5, 15, 25, 35, 45, 55, 65, 75])
    assert found.bars.tolist() == [[5, 15, 25, 35], [45, 55, 65, 75]]
    assert bars_of([5, 15, 25, 35, 45], stride=1).bars.tolist() == [[5, 15, 25, 35], [15, 25, 35, 45]]


def test_a_bar_starts_after_a_gap() -> None:
    assert bars_of([0, 10, 20, 33, 43, 53, 63]).bars.tolist() == [[33, 43, 53, 63]]


@pytest.mark.parametrize(
    ("gap", "tolerance", "fits"), [(12, 0.2, True), (12.1, 0.2, False), (29, "window", True), (31, "window", False)]
)
def test_the_tolerance_is_a_part_of_the_period_or_the_thesis_window(
    gap: float, tolerance: bars.Tolerance, fits: bool
) -> None:
    found = bars_of([0, gap, 2 * gap, 3 * gap], tolerance=tolerance)
    assert len(found.bars) == fits


def test_the_lead_in_is_the_beat_before_or_a_third_of_the_bar() -> None:
    found = bars_of([6, 15, 25, 35, 45, 56, 66, 76, 97])
    assert found.bars.tolist() == [[6, 15, 25, 35], [45, 56, 66, 76]]
    assert found.entries.tolist() == [6 - 10, 35]
    assert found.leaves.tolist() == [45, 76 + 10]
    thirds = bars_of([6, 15, 25, 35, 45, 56, 66, 76], lead_in="third")
    assert thirds.entries.tolist() == [-4, 35]
    assert thirds.leaves.tolist() == [45, 86]
    assert bars.find_held_frames(found.entries, found.leaves, 80).tolist() == [4, 7]


def test_no_period_or_too_few_beats_give_no_bars() -> None:
    assert bars_of([0, 10, 20, 30], period=None).bars.shape == (0, 4)
    assert bars_of([0, 10, 20]).bars.shape == (0, 4)
    assert bars_of([]).support == 0.0


def test_three_of_four_beats_of_a_bar_must_be_supported() -> None:
    good = np.ones(3, dtype=bool)
    assert bars.group(good, np.array([True, True, False, True])) == [0]
    assert bars.group(good, np.array([True, False, False, True])) == []


def track_slowly(strength: np.ndarray, period: float) -> list[int]:
    frames = len(strength)
    if not strength.any():
        return []
    lags = [lag for lag in range(1, frames + 1) if 2 * period / 3 - 1e-9 <= lag <= 3 * period / 2 + 1e-9]
    score, before = [0.0] * frames, [0] * frames
    for frame in range(frames):
        best = 0.0
        for lag in lags:
            if lag <= frame and score[frame - lag] - 10 * np.log(lag / period) ** 2 > best:
                best = score[frame - lag] - 10 * np.log(lag / period) ** 2
                before[frame] = lag
        score[frame] = strength[frame] + best
    frame = int(np.argmax(score))
    path = [frame]
    while before[frame]:
        frame -= before[frame]
        path.append(frame)
    return path[::-1]


@given(strength=strengths, period=st.floats(2.0, 30.0))
def test_tracking_in_blocks_is_tracking_frame_by_frame(strength: np.ndarray, period: float) -> None:
    if 3 * period / 2 < len(strength):
        assert bars.track(strength, period).tolist() == track_slowly(strength, period)


def test_a_missing_beat_is_bridged() -> None:
    strength = np.zeros(100)
    strength[[10, 20, 30, 50, 60, 70, 80]] = 1.0
    assert bars.track(strength, 10.0).tolist() == [10, 20, 30, 40, 50, 60, 70, 80]


def dips(beats: list[int], frames: int, depth: float = 1.0) -> np.ndarray:
    speed = np.full(frames, 1.0)
    for beat in beats:
        speed[beat] -= depth
        speed[[beat - 1, beat + 1]] -= depth / 2
    return speed


def found(which: bars.Source, beats: list[int], candidates: list[int]) -> bars.Bars:
    speed = dips(candidates, 420)
    return bars.find_bars(speed, 30.0, np.array(candidates), np.array(beats, dtype=float), 20 / 30, which, middle=False)


def test_auto_takes_tracked_beats_only_if_they_give_more_bars() -> None:
    all_beats = list(range(20, 400, 20))
    gappy = [beat for beat in all_beats if beat not in (60, 140, 220, 300)]
    assert found("detected", gappy, gappy).source == "detected"
    auto = found("auto", gappy, gappy)
    assert (auto.source, auto.reason) == ("tracked", "more bars")
    assert auto.compared == (len(found("detected", gappy, gappy).bars), len(auto.bars))
    assert 0.7 < auto.support < 1.0
    assert found("auto", all_beats, all_beats).reason == "no more bars"
    assert found("auto", all_beats, all_beats).source == "detected"
    assert found("tracked", all_beats, all_beats).reason == "requested"
    assert found("auto", all_beats[:5], all_beats[:5]).source == "detected"


def test_auto_takes_more_tracked_bars_also_where_enough_are_detected() -> None:
    """Detected beats lost one in five: four bars of eight stay, which once was enough to stop there."""
    all_beats = list(range(20, 700, 20))
    gappy = [beat for beat in all_beats if beat not in (120, 240, 360, 480)]
    speed = dips(all_beats, 720)
    arguments = speed, 30.0, np.array(all_beats), np.array(gappy, dtype=float), 20 / 30
    detected, auto = (bars.find_bars(*arguments, which, middle=False) for which in ("detected", "auto"))
    assert len(detected.bars) >= bars.ENOUGH
    assert len(auto.bars) > len(detected.bars)
    assert (auto.source, auto.reason) == ("tracked", "more bars")


@given(
    counts=st.tuples(st.integers(0, 9), st.integers(0, 9)),
    periods=st.tuples(st.sampled_from([10.0, 10.1, 10.5, 20.0]), st.sampled_from([10.0, 10.1, 10.5, 20.0])),
)
def test_auto_never_loses_bars_but_to_another_tempo(counts: tuple[int, int], periods: tuple[float, float]) -> None:
    made = [
        bars_of((np.arange(4 * count) * period).tolist(), period, tolerance=0.01)
        for count, period in zip(counts, periods, strict=True)
    ]
    chosen = bars.choose_bars(made[0], made[1])
    assert chosen.compared == counts
    if 0 in counts or abs(periods[0] / periods[1] - 1) <= bars.SAME_TEMPO:
        assert len(chosen.bars) == max(counts)
    elif counts[0] >= bars.ENOUGH:
        assert chosen.bars is made[0].bars
    assert (chosen.reason == "other tempo") <= (chosen.bars is made[0].bars and counts[1] > counts[0])


@given(speed=arrays(np.float64, st.integers(1, 50), elements=st.floats(0, 5)), window=st.integers(1, 12))
def test_strength_is_the_dip_below_the_mean_of_the_window(speed: np.ndarray, window: int) -> None:
    frames = np.arange(0, len(speed), 3)
    found = bars.beat_strength(speed, frames, window)
    for frame in range(len(speed)):
        around = speed[max(0, frame - window) : frame + window + 1]
        dip = max(0.0, float(around.mean() - speed[frame])) / speed.mean() if speed.mean() else 0.0
        assert found[frame] == pytest.approx(dip if frame in frames else 0.0, abs=1e-9)
