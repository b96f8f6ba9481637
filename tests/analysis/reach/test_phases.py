"""Phase times against the generator's truth and hand-made speeds; every reason why a clip has none."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mcml_service.analysis.interface import AnalysisError
from mcml_service.analysis.reach_blending.phases import angular_speed, check_phases, find_phases
from mcml_service.analysis.reach_blending.quaternion_tracks import exp
from tests.analysis.reach.reach_motions import generated

FPS = 30.0


def turning(speed: np.ndarray, fps: float = FPS) -> np.ndarray:
    """(F, 4) a joint that turns about one axis with these speeds, rad/s, each since the frame before."""
    angle = np.concatenate([[0.0], np.cumsum(speed[1:]) / fps])
    return exp(angle[:, None] * np.array([0.0, 0.6, 0.8]))


def bell(frames: int, centre: float, width: float, height: float = 4.0) -> np.ndarray:
    return height * np.exp(-(((np.arange(frames) - centre) / width) ** 2))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_found_times_are_the_generators(seed: int) -> None:
    motions, clips = generated(seed, few=False)
    place = motions[0].skeleton.names.index("right_up_arm")
    found = [find_phases(motion.rotations[:, place], motion.fps) for motion in motions]
    missed = np.abs(np.array([phases.times for phases in found]) - np.array([clip.times for clip in clips]))
    assert (missed <= 2).all(axis=1).mean() >= 0.95


@pytest.mark.parametrize(("fps", "noise"), [(60.0, True), (120.0, False)])
def test_found_times_are_the_generators_at_other_rates(fps: float, noise: bool) -> None:
    # Noise that is as large in every frame makes speeds as many times larger as there are more frames (docs).
    motions, clips = generated(fps=fps, noise=noise)
    place = motions[0].skeleton.names.index("right_up_arm")
    found = np.array([find_phases(motion.rotations[:, place], motion.fps).times for motion in motions])
    missed = np.abs(found - np.array([clip.times for clip in clips])) * 30 / fps
    assert (missed <= 2).all(axis=1).mean() >= 0.95


def test_speed_is_the_angle_between_frames() -> None:
    rotations = Rotation.random(30, random_state=4)
    slow = [(a.inv() * b).magnitude() * FPS for a, b in pairwise(rotations)]
    speed = angular_speed(rotations.as_quat(), FPS)
    assert np.allclose(speed[1:], slow)
    assert speed[0] == speed[1]


def test_published_speed_is_twice_the_sine_of_half_the_angle() -> None:
    step = np.radians(30)
    rotations = exp(np.arange(4)[:, None] * np.array([step, 0.0, 0.0]))
    assert np.allclose(angular_speed(rotations, 1.0, "paper"), 2 * np.sin(step / 2))
    assert np.allclose(angular_speed(rotations, 1.0), step)
    assert angular_speed(rotations, 1.0, "paper")[0] / step == pytest.approx(0.9886, abs=1e-4)


def test_signs_of_quaternions_do_not_matter() -> None:
    rotations = turning(bell(60, 30, 8))
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (60, 1))
    for method in ("robust", "paper"):
        assert find_phases(rotations, FPS, method) == find_phases(rotations * signs, FPS, method)


def test_paper_takes_the_minimum_before_and_the_tenth_after() -> None:
    speed = np.array([1, 1, 0.5, 2, 4, 8, 4, 2, 1, 0.79, 0.5, 0.4, 0.4, 0.4, 0.4]) / 2
    found = find_phases(turning(speed), FPS, "paper")
    assert found.times == (2.0, 9.0, 14.0)
    assert found.peak_frame == 5


def test_paper_without_minimum_or_settling() -> None:
    speed = np.array([0.1, 1, 2, 4, 8, 4, 2, 1.5, 1.4, 1.6, 1.7, 1.8])
    found = find_phases(turning(speed), FPS, "paper")
    assert found.times == (0.0, 8.0, 11.0)


def test_a_counter_movement_ends_at_its_standstill() -> None:
    speed = bell(80, 40, 8) + bell(80, 14, 4, 0.8)
    found = find_phases(turning(speed), FPS)
    still = 14 + int(np.argmin(speed[14:40]))
    assert abs(found.t1 - (still - 0.5)) < 1
    assert found.flags == ()


def test_without_standstill_the_threshold_counts() -> None:
    speed = np.linspace(0, 1, 70) ** 3 * 5
    speed[50:] = speed[50] * np.exp(-np.arange(20) / 2.0)
    found = find_phases(turning(speed), FPS)
    assert "t1-from-threshold" in found.flags
    assert speed[int(found.t1 + 0.5)] == pytest.approx(0.15 * found.peak, rel=0.3)


def test_a_clip_that_starts_at_speed_has_no_preparation() -> None:
    speed = np.concatenate([np.linspace(2, 4, 10), 4 * np.exp(-np.arange(50) / 5.0)])
    found = find_phases(turning(speed), FPS)
    assert found.flags[0] == "no-preparation"
    assert found.t1 == 1.0


def test_a_hand_that_drifts_on_settles_at_a_wider_threshold() -> None:
    # 6 % of the peak remains: 4 % comes too late, 8 % counts.
    speed = bell(90, 30, 8) + 0.24 * (np.arange(90) > 30)
    speed[80:] = 0.0
    found = find_phases(turning(speed), FPS)
    assert found.flags[-1] == "t2-from-8-percent"
    assert speed[int(found.t2) + 2] < 0.10 * found.peak


def test_a_hand_that_never_settles_is_said_so() -> None:
    speed = bell(60, 30, 8) + 0.9 * (np.arange(60) > 30)
    found = find_phases(turning(speed), FPS)
    assert "speed-never-settles" in found.flags
    assert found.peak_frame + 0.5 <= found.t2 <= found.end - 1


@pytest.mark.parametrize("method", ["robust", "paper"])
@pytest.mark.parametrize(
    ("speed", "code"),
    [
        (bell(7, 3, 1), "too-few-frames"),
        (bell(60, 30, 8, 0.4), "too-slow"),
        (3 + bell(60, 30, 8, 1.0), "no-clear-peak"),
        (bell(60, 58, 8), "peak-at-border"),
        (bell(60, 0, 8), "peak-at-border"),
    ],
)
def test_clips_without_phases_say_why(method: str, speed: np.ndarray, code: str) -> None:
    with pytest.raises(AnalysisError) as error:
        find_phases(turning(speed), FPS, method)  # type: ignore[arg-type]
    assert error.value.code == code


def test_the_fastest_of_several_movements_is_the_reach_and_flagged() -> None:
    speed = np.repeat([3.6, 4.0, 3.7], 20) * np.abs(np.sin(np.arange(60) * np.pi / 20))
    assert speed.max() < 2 * np.median(speed)
    found = find_phases(turning(speed), FPS)
    assert found.flags[0] == "peak-between-minima"
    assert found.peak_frame == pytest.approx(30, abs=1)
    assert 15 < found.t1 < 30 < found.t2 < 45
    with pytest.raises(AnalysisError) as error:
        find_phases(turning(speed), FPS, "paper")
    assert error.value.code == "no-clear-peak"
    assert "times" in str(error.value.remedy)


def test_a_person_knows_better_but_not_out_of_order() -> None:
    rotations = turning(bell(60, 30, 8))
    found = check_phases(rotations, FPS, (10.5, 40, 59), "robust")
    assert found.times == (10.5, 40, 59)
    assert found.flags == ("given",)
    for times in ((0, 40, 59), (41, 40, 59), (10, 59, 59), (10, 40, 60)):
        with pytest.raises(AnalysisError) as error:
            check_phases(rotations, FPS, times, "robust")
        assert error.value.code == "phase-order"
