"""Metrics against their definitions written out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mcml.motion.rotations import from_euler
from mcml_service.analysis.dance import metrics
from mcml_service.analysis.dance.assembly import Transition

times = st.lists(st.floats(0, 20), min_size=1, max_size=12).map(sorted).map(np.array)


@given(beats=times, grid=times)
def test_alignment_is_the_mean_of_gaussians_of_the_nearest(beats: np.ndarray, grid: np.ndarray) -> None:
    expected = np.mean([np.exp(-(min(abs(grid - beat)) ** 2) / (2 * 0.05**2)) for beat in beats])
    assert metrics.beat_alignment(beats, grid) == pytest.approx(expected)


def test_alignment_of_nothing_is_zero() -> None:
    assert metrics.beat_alignment(np.array([]), np.array([1.0])) == 0
    assert metrics.beat_alignment(np.array([1.0]), np.array([])) == 0


@given(seed=st.integers(0, 9999), size=st.sampled_from([1e-7, 1e-3, 0.5, 3.0]))
def test_rotation_speed_is_the_greatest_angle_a_frame(seed: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    rotations = from_euler(np.cumsum(rng.normal(0, size, (6, 3, 3)), axis=0), "XYZ")
    signs = rng.choice([-1.0, 1.0], (6, 3, 1))
    expected = [
        max(
            (
                Rotation.from_quat(rotations[frame + 1, joint]) * Rotation.from_quat(rotations[frame, joint]).inv()
            ).magnitude()
            for joint in range(3)
        )
        for frame in range(5)
    ]
    assert metrics.rotation_speed(rotations * signs, 10.0) == pytest.approx(
        np.array(expected) * 10, rel=1e-5, abs=1e-12
    )


def test_feet_skate_only_near_the_ground() -> None:
    fps, frames = 10.0, 20
    feet = np.zeros((frames, 2, 3))
    feet[:, 0, 0] = np.arange(frames) * 0.3
    feet[10:, 0, 1] = 5.0
    feet[:, 1, 1] = 9.0
    found = metrics.foot_speed(feet, fps, 2.0)
    assert found[3] == pytest.approx((0.3 * fps / 2.0 + 0.0) / 2)
    assert found[15] == pytest.approx(0.0)
    assert np.isnan(metrics.foot_speed(np.zeros((5, 0, 3)), fps, 2.0)).all()
    assert metrics.mean_or_none(np.array([np.nan])) is None


def watched(speed: np.ndarray, beats: list[float], fps: float = 10.0) -> metrics.Watched:
    none = np.zeros(len(speed) - 1)
    return metrics.Watched(fps, speed, speed, np.array(beats), np.full(len(speed), 0.5), none, none)


def test_a_transition_is_judged_by_its_own_frames() -> None:
    speed = np.full(40, 2.0)
    speed[15] = 6.0
    found = metrics.of_transition(watched(speed, [1.05, 1.5, 1.95]), Transition(3, 1.0, 2.0))
    mean = speed.mean()
    inside = speed[11:20] / mean
    assert found["speed_peak"] == pytest.approx(6 / mean)
    assert found["speed_variance"] == pytest.approx(inside.var())
    assert found["beats_inside"] == 1
    assert found["foot_skate"] == 0.5
    assert metrics.inside(np.arange(40) / 10, [Transition(3, 1.0, 2.0)]).sum() == 9


def test_hits_count_minima_at_inner_beats_of_the_grid() -> None:
    speed = np.full(50, 2.0)
    speed[[10, 21, 33]] = 1.0
    found = metrics.grid_metrics(watched(speed, [1.0, 2.1, 3.3]), np.array([0.0, 1.0, 2.0, 3.0, 4.0]))
    assert found["grid_hits_frame"] == pytest.approx(2 / 3)
    assert found["grid_hits_70ms"] == pytest.approx(1 / 3)
    assert found["beat_align_music"] == pytest.approx(np.mean([1, np.exp(-2), np.exp(-18)]))
