"""Speed, candidates, refinement, period: against their definitions written out."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mcml.motion.skeleton import Convention, EndSite, Joint, Skeleton
from mcml_service.analysis.dance import motion_beats as beats
from mcml_service.analysis.dance.figure import body_size, figure_of, finger_joints
from tests.analysis.dance.motions import generated

levels = arrays(np.float64, st.integers(0, 60), elements=st.sampled_from([0.0, 1.0, 2.0, 3.0, 5.0]))
curves = arrays(np.float64, st.integers(40, 160), elements=st.integers(0, 1000).map(lambda level: level / 100))


def mean_speed_slowly(positions: np.ndarray, fps: float, smooth: float, difference: str) -> list[float]:
    """positions (F, J, 3)."""
    frames = len(positions)
    sigma = smooth * fps
    radius = int(4 * sigma + 0.5)
    weights = [np.exp(-(k**2) / (2 * sigma**2)) if sigma else 1.0 for k in range(-radius, radius + 1)]
    smoothed = [
        sum(
            weight * positions[min(max(frame + k, 0), frames - 1)]
            for k, weight in zip(range(-radius, radius + 1), weights, strict=True)
        )
        / sum(weights)
        for frame in range(frames)
    ]
    speeds = []
    for frame in range(frames):
        before, after = max(0, frame - 1), min(frames - 1, frame + 1)
        if difference == "forward" and frame < frames - 1:
            before = frame
        velocity = (smoothed[after] - smoothed[before]) / (after - before) * fps
        speeds.append(float(np.mean([np.linalg.norm(joint) for joint in velocity])))
    return speeds


@given(
    seed=st.integers(0, 9999),
    smooth=st.sampled_from([0.0, 0.02, 0.04]),
    difference=st.sampled_from(["central", "forward"]),
)
def test_speed_is_the_mean_of_smoothed_velocities(seed: int, smooth: float, difference: beats.Difference) -> None:
    rng = np.random.default_rng(seed)
    positions = np.cumsum(rng.normal(0, 1, (30, 3, 3)), axis=0)
    found = beats.mean_speed(positions.transpose(1, 2, 0), 30.0, smooth, difference)
    assert np.allclose(found, mean_speed_slowly(positions, 30.0, smooth, difference), rtol=1e-9)


def test_speed_does_not_depend_on_the_blocks_it_is_computed_in(monkeypatch: pytest.MonkeyPatch) -> None:
    motion, _ = generated("step", bars=3)
    figure = figure_of(motion.skeleton, motion.translations)
    whole = beats.speed_signal(figure, motion.translations, motion.rotations, motion.fps)
    monkeypatch.setattr(beats, "_BLOCK", 37)
    assert np.array_equal(beats.speed_signal(figure, motion.translations, motion.rotations, motion.fps), whole)


def minima_slowly(speed: np.ndarray) -> list[int]:
    found, frame = [], 0
    while frame < len(speed):
        last = frame
        while last + 1 < len(speed) and speed[last + 1] == speed[frame]:
            last += 1
        if frame > 0 and last < len(speed) - 1 and speed[frame - 1] > speed[frame] < speed[last + 1]:
            found.append((frame + last) // 2)
        frame = last + 1
    return found


@given(levels)
def test_minima_are_runs_lower_than_both_neighbours(speed: np.ndarray) -> None:
    assert beats.minima(speed).tolist() == minima_slowly(speed)


def refine_slowly(speed: np.ndarray, fps: float, k2: float, k3: float) -> list[tuple[int, str]]:
    window, mean = int(np.floor(fps / 3 + 0.5)), speed.mean()
    verdicts, before = [], None
    for frame in minima_slowly(speed):
        around = speed[max(0, frame - window) : frame + window + 1]
        if min(frame, len(speed) - 1 - frame) < max(1, window // 4):
            verdicts.append((frame, "end"))
        elif speed[frame] > around.min() or (before is not None and frame - before <= window):
            verdicts.append((frame, "F1"))
        elif around.mean() - speed[frame] < k2 * mean:
            verdicts.append((frame, "F2"))
        elif speed[frame] > k3 * mean:
            verdicts.append((frame, "F3"))
        else:
            verdicts.append((frame, "beat"))
            before = frame
    return verdicts


@given(speed=curves, fps=st.sampled_from([12.0, 24.0, 30.0]), k2=st.floats(0.05, 0.6), k3=st.floats(0.3, 1.2))
def test_candidates_fail_the_first_condition_they_do_not_meet(
    speed: np.ndarray, fps: float, k2: float, k3: float
) -> None:
    found = beats.refine(speed, fps, k2, k3)
    names = [beats.REASONS[verdict] for verdict in found.verdicts]
    expected = refine_slowly(speed, fps, k2, k3) if speed.mean() > 0 else []
    assert list(zip(found.frames.tolist(), names, strict=True)) == expected


def test_every_verdict_occurs_by_hand() -> None:
    """30 frames a second: w = 10, margin 2. A flat curve of 10 with dips."""
    speed = np.full(100, 10.0)
    for frame, value in {1: 5.0, 20: 1.0, 26: 2.0, 45: 8.9, 80: 0.5}.items():
        speed[frame] = value
    speed[60:68] = np.array([20, 20, 20, 11.5, 20, 20, 20, 20])
    found = beats.refine(speed, 30.0)
    named = {int(f): beats.REASONS[v] for f, v in zip(found.frames, found.verdicts, strict=True)}
    assert named[1] == "end"
    assert named[20] == "beat"
    assert named[26] == "F1"
    assert named[45] == "F2"
    assert named[63] == "F1"
    assert named[80] == "beat"
    high = np.concatenate([np.zeros(40), np.full(40, 30.0)])
    high[60] = 20.0
    assert beats.REASONS[beats.refine(high, 30.0).verdicts[0]] == "F3"


@pytest.mark.parametrize("frames", [0, 1, 2, 50])
def test_no_movement_gives_no_candidates(frames: int) -> None:
    assert not len(beats.refine(np.zeros(frames), 30.0).frames)


def test_the_mean_of_the_window_makes_depth_the_same_at_every_rate() -> None:
    """The thesis's sum over 2 w + 1 frames would be four times looser at 120 than at 30 frames a second."""
    for fps in (30.0, 120.0):
        time = np.arange(0, 4, 1 / fps)
        shallow = 10 - 1.3 * np.cos(2 * np.pi * time)
        deep = 10 - 3.0 * np.cos(2 * np.pi * time)
        assert not len(beats.refine(shallow, fps).beats)
        assert len(beats.refine(deep, fps).beats) == 3


def test_a_beat_moves_to_the_middle_of_a_rest_and_to_the_foot_of_uneven_flanks() -> None:
    fps = 100.0
    time = np.arange(0, 2, 1 / fps)
    rest = np.where(np.abs(time - 1) < 0.05, 0.02 * (1.05 - time), 10 * (np.abs(time - 1) - 0.05))
    start = np.array([int(rest[90:111].argmin()) + 90])
    assert abs(start[0] - 100) >= 4
    assert abs(beats.locate(rest, start, fps)[0] - 100) < 0.5
    # Two limbs move by turns, one far, one less: smoothing lets them overlap, and draws the minima to the lesser one.
    time = np.arange(0, 4, 1 / fps)
    limbs = np.zeros((2, 3, len(time)))
    limbs[0, 0] = 3 * np.cos(np.pi * np.minimum(time % 1, 0.5) / 0.5) * np.where(np.floor(time) % 2, 1, -1)
    limbs[1, 1] = np.cos(np.pi * np.maximum(time % 1 - 0.5, 0) / 0.5) * np.where(np.floor(time) % 2, 1, -1)
    drawn = beats.mean_speed(limbs, fps, 0.04)
    found = beats.refine(drawn, fps).beats
    true = np.round(found / 50) * 50
    assert np.abs(found - true).max() >= 1
    assert np.abs(beats.locate(drawn, found, fps) - true).mean() < 0.65 * np.abs(found - true).mean()


@given(speed=curves, fps=st.sampled_from([24.0, 60.0]))
def test_located_beats_stay_in_order_and_near(speed: np.ndarray, fps: float) -> None:
    accepted = beats.refine(speed, fps).beats
    located = beats.locate(speed, accepted, fps)
    assert (np.abs(located - accepted) <= beats.window_of(fps) // 4 + 1e-9).all()
    assert (np.diff(located) > 0).all()


def test_beats_without_crests_stay_or_stand_on_their_parabola() -> None:
    falling = np.concatenate([np.linspace(5, 0, 50), np.full(50, 0.0)])
    assert beats.locate(falling, np.array([60]), 30.0).tolist() == [60.0]
    flat = np.full(60, 3.0)
    flat[28:33] = [1.5, 0.5, 0.1, 0.3, 1.1]
    assert beats.locate(np.minimum(flat, flat[::-1]), np.array([30]), 30.0)[0] == pytest.approx(30, abs=0.6)


def locate_slowly(speed: np.ndarray, beat: int, fps: float) -> float:
    window = beats.window_of(fps)
    left, right = (
        [float(speed[min(max(beat + side * k, 0), len(speed) - 1)]) for k in range(window + 1)] for side in (-1, 1)
    )
    least, height = float(speed[beat]), min(max(left), max(right)) - float(speed[beat])
    if height <= 1e-9 * speed.mean():
        curve = left[1] - 2 * least + right[1]
        return beat + (0.5 * (left[1] - right[1]) / curve if curve > 0 else 0.0)
    feet = []
    for flank in (left, right):
        crossings = []
        for part in (0.2, 0.5):
            level = least + part * height
            place = next(k for k, value in enumerate(flank) if value >= level)
            crossings.append(place - (flank[place] - level) / (flank[place] - flank[place - 1]))
        slope = 0.3 * height / (crossings[1] - crossings[0])
        feet.append(crossings[0] - 0.2 * height / slope - min(least / slope, 0.05 * fps))
    return beat + float(np.clip((feet[1] - feet[0]) / 2, -(window // 4), window // 4))


@given(speed=curves, fps=st.sampled_from([24.0, 60.0]))
def test_all_beats_at_once_are_located_as_one_by_one(speed: np.ndarray, fps: float) -> None:
    accepted = beats.refine(speed, fps).beats
    expected = [locate_slowly(speed, int(beat), fps) for beat in accepted]
    assert np.allclose(beats.locate(speed, accepted, fps), np.clip(expected, 0, len(speed) - 1), atol=1e-7)


def wave_slowly(times: np.ndarray, frames: int) -> list[float]:
    wave = []
    for frame in range(frames):
        value = 0.0
        for a, b in pairwise(times):
            if a <= frame < b:
                value = float(np.cos(2 * np.pi * (frame - a) / (b - a)))
        wave.append(value)
    return wave


@given(st.lists(st.floats(0, 99), min_size=0, max_size=8, unique_by=lambda x: round(x, 1)))
def test_the_wave_has_its_crests_on_the_beats(times: list[float]) -> None:
    ordered = np.sort(np.array(times))
    assert np.allclose(beats.beat_wave(ordered, 100), wave_slowly(ordered, 100), atol=1e-9)


@given(bpm=st.floats(45, 170), fps=st.sampled_from([30.0, 60.0, 120.0]))
def test_the_period_of_even_beats_is_theirs(bpm: float, fps: float) -> None:
    period = 60 / bpm * fps
    found = beats.periods(np.arange(0.5, 24) * period, int(24 * period) + 1, fps)
    assert abs(found[0].seconds * bpm / 60 - 1) < 0.002
    assert [peak.strength for peak in found] == sorted((peak.strength for peak in found), reverse=True)
    assert len(found) <= 3


def test_no_period_without_two_beats_or_a_peak() -> None:
    assert beats.periods(np.array([10.0]), 100, 30.0) == []
    assert beats.periods(np.array([]), 100, 30.0) == []


def test_equal_peaks_give_the_faster_one(monkeypatch: pytest.MonkeyPatch) -> None:
    spectrum = np.ones(129)
    spectrum[[10, 30]] = 2.0
    spectrum[20] = 1.9
    monkeypatch.setattr(beats.np.fft, "rfft", lambda wave, length: np.sqrt(spectrum))
    found = beats.periods(np.array([1.0, 5.0]), 32, 20.0)
    assert [round(256 / (20 * peak.seconds)) for peak in found] == [30, 10, 20]


def joint(name: str, parent: int, offset: tuple[str, str, str] = ("0", "1", "0"), **more: object) -> Joint:
    return Joint(name, parent, name, Convention.LISTED, ("Rx",), "X", offset=offset, **more)  # type: ignore[arg-type]


def test_fingers_count_only_below_a_hand_and_joints_on_their_parent_not_at_all() -> None:
    skeleton = Skeleton(
        (
            joint("Hips", -1),
            joint("IndexFinder", 0),
            joint("LeftForeArm", 0),
            joint("LeftHand", 2, ("0", "0", "0")),
            joint("LeftHandThumb", 3),
            joint("Tip", 4),
            joint("LeftToe", 0),
        )
    )
    assert finger_joints(skeleton).tolist() == [False, False, False, False, True, True, False]
    assert figure_of(skeleton, np.zeros((1, 7, 3))).used.tolist() == [0, 1, 2, 6]


def test_the_size_is_the_longest_path_end_sites_included() -> None:
    tip = EndSite(("0", "3", "0"))
    skeleton = Skeleton(
        (joint("a", -1, ("9", "9", "9")), joint("b", 0), joint("c", 1, end_sites=(tip,)), joint("d", 0))
    )
    figure = figure_of(skeleton, np.zeros((1, 4, 3)))
    assert figure.size == pytest.approx(1 + 1 + 3 + 1)


@given(seed=st.integers(0, 9999))
def test_the_size_is_that_of_all_pairs_of_nodes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    parents = np.array([-1, *(int(rng.integers(-1, index)) for index in range(1, 8))])
    offsets = rng.normal(0, 1, (8, 3))

    def above(node: int) -> dict[int, float]:
        path, length = {node: 0.0}, 0.0
        while parents[node] >= 0:
            length += float(np.linalg.norm(offsets[node]))
            node = int(parents[node])
            path[node] = length
        return path

    longest = 0.0
    for one in range(8):
        for other in range(8):
            shared = above(one).keys() & above(other).keys()
            if shared:
                longest = max(longest, min(above(one)[node] + above(other)[node] for node in shared))
    assert body_size(parents, offsets) == pytest.approx(longest)
