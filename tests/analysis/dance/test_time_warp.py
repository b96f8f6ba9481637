"""Grids, pulses, time maps, poses between frames."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from mcml_service.analysis.dance import time_warp as warp

BARS = np.array([[10.0, 20, 30, 40], [50, 60, 70, 80], [200, 212, 224, 236]])
ENTRIES, LEAVES = np.array([0.0, 40, 188]), np.array([50.0, 90, 248])


@pytest.mark.parametrize("bpm", [40.0, 113.0, 127.3, 200.0, 240.0])
@pytest.mark.parametrize("fps", [24.0, 30.0, 59.94, 120.0])
def test_the_length_is_exact_after_ten_minutes(bpm: float, fps: float) -> None:
    """A bar rounded to frames would drift: 53.33 frames rounded make a second in three minutes."""
    bars = round(bpm * 10 / 4)
    grid = warp.even_grid(bpm, bars)
    assert len(grid) == 4 * bars + 1
    assert abs(grid[-1] - 240 * bars / bpm) < 1e-9
    assert warp.frame_count(grid, fps) == int(240 * bars / bpm * fps + 0.5)
    assert np.allclose(grid, [beat * 60 / bpm for beat in range(4 * bars + 1)], atol=1e-9)


def test_half_and_double_pulses() -> None:
    grid = np.array([0.0, 1, 2, 4, 5, 6, 7, 8, 9])
    assert warp.motion_grid(grid, Fraction(1)).tolist() == grid.tolist()
    assert warp.motion_grid(grid, Fraction(2)).tolist() == [0, 2, 5, 7, 9]
    assert warp.motion_grid(grid, Fraction(1, 2))[:6].tolist() == [0, 0.5, 1, 1.5, 2, 3]
    assert len(warp.motion_grid(grid, Fraction(1, 2))) == 17


@pytest.mark.parametrize(
    ("music", "own", "bars", "pulse"),
    [
        (0.5, 0.5, 4, Fraction(1)),
        (0.25, 0.5, 4, Fraction(2)),
        (0.25, 0.5, 3, Fraction(1)),
        (1.0, 0.5, 3, Fraction(1, 2)),
        (0.5, 0.5 * 2**0.5, 4, Fraction(1)),
        (0.5, 0.5 / 2**0.5, 4, Fraction(1)),
    ],
)
def test_the_pulse_is_the_nearest_that_divides(music: float, own: float, bars: int, pulse: Fraction) -> None:
    assert warp.choose_pulse(music, own, bars) == pulse


def runs(path: list[int], natural: list[bool], **options: object) -> list[warp.Segment]:
    grid = np.arange(4 * len(path) + 1) * 0.5
    return warp.segments(path, natural, BARS, ENTRIES, LEAVES, grid, **options)  # type: ignore[arg-type]


def test_every_beat_of_a_bar_is_a_knot_on_the_grid() -> None:
    one, two = runs([0, 1, 2], [True, False])
    assert (one.first, one.last, one.start, one.end, one.beat) == (0, 1, 0.0, 3.5, 0.0)
    assert one.knots.tolist() == [[0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5], [10, 20, 30, 40, 50, 60, 70, 80]]
    assert (two.first, two.last, two.start, two.end, two.beat) == (2, 2, 3.5, 6.0, 4.0)
    assert two.knots.tolist() == [[3.5, 4, 4.5, 5, 5.5, 6], [188, 200, 212, 224, 236, 248]]


def test_a_motion_that_plays_on_has_a_knot_more() -> None:
    one, _ = runs([0, 2], [False], play_on=True)
    assert one.knots[:, -1].tolist() == [2.0, 50.0]
    assert one.end == 1.5


def test_the_uniform_warp_keeps_the_ends_of_bars_only() -> None:
    one, two = runs([0, 1, 2], [True, False], warp="uniform")
    assert one.knots.tolist() == [[0, 1.5, 3.5], [10, 40, 80]]
    assert two.knots.tolist() == [[3.5, 5.5, 6], [188, 236, 248]]


@given(seed=st.integers(0, 9999))
def test_the_map_meets_its_knots_and_never_runs_back(seed: int) -> None:
    rng = np.random.default_rng(seed)
    knots = np.cumsum(rng.uniform(0.1, 3, (2, 6)), axis=1)
    segment = warp.Segment(0, 0, knots[0, 0], knots[0, -1], knots[0, 0], knots)
    assert np.allclose(warp.source_frames(segment, knots[0]), knots[1])
    dense = warp.source_frames(segment, np.linspace(knots[0, 0] - 1, knots[0, -1] + 1, 200))
    assert (np.diff(dense) >= -1e-12).all()
    assert dense[0] == knots[1, 0]
    assert dense[-1] == pytest.approx(knots[1, -1])


@given(seed=st.integers(0, 9999))
def test_poses_between_frames_are_lerp_and_slerp(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rotations = rng.normal(0, 1, (5, 2, 4))
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    translations = rng.normal(0, 1, (5, 2, 3))
    frames = np.array([-3.0, 0.0, 0.25, 2.5, 3.999, 4.0, 9.0])
    moved, turned = warp.sample(translations, rotations, frames)
    for row, frame in enumerate(np.clip(frames, 0, 4)):
        for joint in range(2):
            between = Slerp(range(5), Rotation.from_quat(rotations[:, joint]))([frame])
            assert (between.inv() * Rotation.from_quat(turned[row, joint])).magnitude()[0] < 1e-6
            expected = [np.interp(frame, range(5), translations[:, joint, axis]) for axis in range(3)]
            assert np.allclose(moved[row, joint], expected)


def test_a_clip_of_one_frame_holds() -> None:
    moved, turned = warp.sample(np.ones((1, 1, 3)), np.array([[[0.0, 0, 0, 1]]]), np.array([-1.0, 0, 5]))
    assert (moved == 1).all()
    assert (turned[..., 3] == 1).all()
