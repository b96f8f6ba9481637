"""Noise and leaps of angles: taken out, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import freqz_sos

from mcml.errors import ConversionError
from mcml.motion.edits.gap_filling import fill_gaps
from mcml.motion.edits.low_pass import design, low_pass, suggest_cutoff
from mcml.motion.edits.unrolling import unroll
from mcml.motion.frames import in_columns, joined
from mcml.motion.markers import marker_skeleton
from mcml.motion.rotations import from_euler
from mcml.motion.skeleton import Array, Skeleton
from tests.motion.bodies.made import clip_of, person
from tests.motion.edits.test_gap_filling import FRAMES, block_of, segment

RATE = 100.0
ONES = np.ones(FRAMES)


def markers(positions: Array) -> tuple[Skeleton, Array]:
    return marker_skeleton([f"M{place}" for place in range(positions.shape[1])]), positions.reshape(len(positions), -1)


def test_half_of_the_power_is_left_at_the_cut_off() -> None:
    sections = design(6.0, RATE)
    _, gain = freqz_sos(sections, worN=[6.0], fs=RATE)
    # Two passes: the gain of one is squared.
    assert abs(gain[0]) ** 4 == pytest.approx(0.5)


def test_noise_goes_and_nothing_lags() -> None:
    seconds = np.arange(FRAMES) / RATE
    true = np.stack([100 * np.sin(2 * np.pi * 1.0 * seconds)] * 3, axis=1)[:, None]
    noisy = true + 2 * np.sin(2 * np.pi * 30 * seconds)[:, None, None]
    skeleton, values = markers(noisy)
    found = low_pass(skeleton, block_of(skeleton, values), 6.0, RATE, ONES).block.values.reshape(FRAMES, 1, 3)
    assert np.abs(found - true)[20:-20].max() < 0.2
    strength = np.zeros(FRAMES)
    kept = low_pass(skeleton, block_of(skeleton, values), 6.0, RATE, strength).block.values
    assert np.array_equal(kept, values)


def test_runs_between_gaps_are_filtered_alone() -> None:
    skeleton, values = markers(segment(1))
    holed = values.copy()
    holed[100:105] = np.nan
    found = low_pass(skeleton, block_of(skeleton, holed), 10.0, RATE, ONES).block.values
    assert np.isnan(found[100:105]).all()
    part = low_pass(skeleton, block_of(skeleton, values[:100]), 10.0, RATE, ONES[:100]).block.values
    np.testing.assert_allclose(found[:100], part)


@pytest.mark.parametrize("hertz", [0.0, -1.0, 50.0, float("nan")])
def test_impossible_cut_offs_are_refused(hertz: float) -> None:
    with pytest.raises(ConversionError, match="cut-off"):
        design(hertz, RATE)


def test_rotations_are_filtered_as_rotations() -> None:
    clip = clip_of(person(5, 60))
    skeleton, block = clip.head.skeleton, joined(clip.blocks())
    found = low_pass(skeleton, block, 5.0, RATE, np.ones(len(block))).block
    before, after = (in_columns(each, skeleton.columns()) for each in (block, found))
    assert np.isfinite(after).all()
    assert np.abs(np.diff(after, 2, axis=0)).sum() < np.abs(np.diff(before, 2, axis=0)).sum()


@pytest.mark.parametrize("noise", [0.3, 1.0])
def test_the_suggested_cut_off_is_between_motion_and_noise(noise: float) -> None:
    rng = np.random.default_rng(1)
    seconds = np.arange(1000) / RATE
    true = np.stack([100 * np.sin(2 * np.pi * f * seconds) / f for f in (0.7, 1.1, 1.9)], axis=1)[:, None]
    found = suggest_cutoff(true + rng.normal(size=true.shape) * noise, RATE)
    assert found is not None
    assert 2 < found < 12
    assert suggest_cutoff(np.full((5, 2, 3), np.nan), RATE) is None


def angles_of(skeleton: Skeleton, joint: int) -> list[int]:
    return [place for place, (each, channel) in enumerate(skeleton.columns()) if each == joint and 3 <= channel <= 5]


def test_unrolled_angles_are_the_same_rotations_without_leaps() -> None:
    clip = clip_of(person(5, 60))
    skeleton, block = clip.head.skeleton, joined(clip.blocks())
    values = block.values.copy()
    own = angles_of(skeleton, 1)
    order = "".join("XYZ"[skeleton.columns()[place][1] - 3] for place in own)
    for frame in range(10, 40):
        if frame % 3 == 0:
            values[frame, own] += [180, 0, 180]
            values[frame, own[1]] = 180 - block.values[frame, own[1]]
        if frame % 7 == 0:
            values[frame, own[0]] -= 360
    leaping = block_of(skeleton, values)
    found, changed = unroll(skeleton, leaping)
    assert changed > 0
    before, after = (from_euler(np.radians(each[:, own]), order) for each in (values, found.values))
    assert np.abs(np.abs((before * after).sum(axis=1)) - 1).max() < 1e-12
    assert np.abs(np.diff(found.values[:, own], axis=0)).max() < 90
    again, none = unroll(skeleton, found)
    assert none == 0
    assert np.array_equal(again.values, found.values)


def test_joints_are_filled_too() -> None:
    clip = clip_of(person(5, 60))
    skeleton, block = clip.head.skeleton, joined(clip.blocks())
    values = in_columns(block, skeleton.columns()).copy()
    own = angles_of(skeleton, 2)
    holed = values.copy()
    holed[20:24, own] = np.nan
    filled = fill_gaps(skeleton, block_of(skeleton, holed), slice(0, 60), 10, 10)
    assert filled.counts == {"spline": 4}
    found = in_columns(filled.block, skeleton.columns())
    assert np.isfinite(found[20:24, own]).all()
    assert np.array_equal(np.delete(found, np.s_[20:24], 0), np.delete(values, np.s_[20:24], 0))
