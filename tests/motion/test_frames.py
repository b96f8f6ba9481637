"""Frames joined, reversed, their channels moved, resampled, smoothed: against the obvious ways."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from mcml.errors import ConversionError
from mcml.motion.clip import ClipStream, FrameBlock, full_shape
from mcml.motion.edits.resampling import frame_places, resampled, sampled
from mcml.motion.edits.smoothing import smoothed
from mcml.motion.frames import adjusted, eased, in_columns, joined, reversed_frames
from mcml.motion.hub import HubReader
from mcml.motion.rotation_vectors import angle_between
from mcml.motion.skeleton import Array, Convention, Joint, Skeleton
from mcml.motion.units import reading_of
from tests import fuzz
from tests.formats.test_real_files import opened
from tests.motion.random_clips import random_clip
from tests.poses import chosen_frames, global_positions, rest_height

CONVENTIONS = [Convention.LISTED, Convention.FIXED, Convention.BASE]


def same_bits(one: Array, other: Array) -> bool:
    return (
        one.shape == other.shape
        and bool((np.isnan(one) == np.isnan(other)).all())
        and np.array_equal(np.nan_to_num(one).view(np.int64), np.nan_to_num(other).view(np.int64))
    )


def whole(clip: ClipStream) -> FrameBlock:
    return joined(clip.blocks())


@given(seed=st.integers(0, 10_000))
def test_blocks_become_one(seed: int) -> None:
    clip = random_clip(Convention.LISTED, seed)
    block = whole(clip)
    assert same_bits(block.values, np.vstack([part.values for part in clip.blocks()]))
    assert list(block.ids) == list(range(1, 21))
    assert block.shape_of is None


def test_blocks_of_other_columns_and_shapes() -> None:
    one = FrameBlock(np.array([[1.0, 2.0]]), ((0, 0), (0, 1)), (((0, 3),),), np.array([1]), None, [("walk",)])
    two = FrameBlock(np.array([[3.0]]), ((0, 1),), (((0, 2),),), ["b"])
    both = joined([one, two])
    assert same_bits(both.values, np.array([[1.0, 2.0], [np.nan, 3.0]]))
    assert both.ids == ["1", "b"]
    assert both.shape_of is not None
    assert [both.shapes[int(place)] for place in both.shape_of] == [((0, 3),), ((0, 2),)]
    assert both.motion_names == [("walk",), ()]
    with pytest.raises(ConversionError):
        joined([])


@given(seed=st.integers(0, 10_000))
def test_reversing_twice_is_nothing(seed: int) -> None:
    block = whole(random_clip(Convention.FIXED, seed))
    once = reversed_frames(block)
    assert same_bits(once.values[0], block.values[-1])
    assert list(once.ids) == list(block.ids)
    assert same_bits(reversed_frames(once).values, block.values)


def test_names_turn_round_with_their_frames() -> None:
    names = [("a",), ("b",), ()]
    block = FrameBlock(np.zeros((3, 0)), (), ((), ((0, 0),)), np.arange(3), np.array([0, 1, 1]), names)
    back = reversed_frames(block)
    assert back.motion_names == [(), ("b",), ("a",)]
    assert back.shape_of is not None
    assert back.shape_of.tolist() == [1, 1, 0]
    picked = chosen_frames(block, np.array([2, 0, 0]))
    assert picked.motion_names == [(), ("a",), ("a",)]
    assert list(picked.ids) == [1, 2, 3]


def test_strength_of_an_edit() -> None:
    assert eased(5, 1, 3).tolist() == [0, 1, 1, 1, 0]
    # No ease at the ends of the clip itself.
    assert eased(4, 0, 3, 2).tolist() == [1, 1, 1, 1]
    ramp = eased(20, 5, 14, 3)
    assert np.array_equal(ramp[5:15], ramp[5:15][::-1])
    assert 0 < ramp[5] < ramp[6] < ramp[7] < ramp[8] == 1.0
    # More ease than there are frames.
    assert eased(9, 3, 5, 50).max() <= 1.0
    for first, last in ((-1, 2), (2, 1), (0, 5)):
        with pytest.raises(ConversionError):
            eased(5, first, last)


@given(seed=st.integers(0, 10_000), factor=st.floats(-3, 3), offset=st.floats(-90, 90), ease=st.integers(0, 4))
def test_channels_are_moved_and_scaled_where_asked(seed: int, factor: float, offset: float, ease: int) -> None:
    block = whole(random_clip(Convention.LISTED, seed))
    column = block.columns[seed % len(block.columns)]
    index = block.columns.index(column)
    strength = eased(len(block), 4, 15, ease)
    after = adjusted(block, [column], strength, factor, offset)
    rest = [place for place in range(len(block.columns)) if place != index]
    assert same_bits(after.values[:, rest], block.values[:, rest])
    assert same_bits(after.values[[0, 3, 16], index], block.values[[0, 3, 16], index])
    for row in range(len(block)):
        old = block.values[row, index]
        assert after.values[row, index] == pytest.approx(old + strength[row] * (old * factor + offset - old))
    assert same_bits(adjusted(block, [column], strength).values, block.values)


def test_edits_that_cannot_be_are_refused() -> None:
    block = whole(random_clip(Convention.LISTED, 1))
    with pytest.raises(ConversionError):
        adjusted(block, [(99, 0)], np.ones(20))
    with pytest.raises(ConversionError):
        adjusted(block, [block.columns[0]], np.ones(20), np.inf)


def test_places_of_another_rate() -> None:
    # What files state is rounded: 120 and 30 frames a second.
    assert frame_places(400, 0.0083333, 0.0333333).tolist() == list(range(0, 400, 4))
    assert frame_places(1, 0.01, 0.02).tolist() == [0.0]
    assert frame_places(4, 0.02, 0.01).tolist() == [0, 0.5, 1, 1.5, 2, 2.5, 3]
    odd = frame_places(1000, 0.01, 0.01 * np.sqrt(2))
    assert np.allclose(odd, np.arange(len(odd)) * np.sqrt(2))
    assert odd[-1] <= 999 < odd[-1] + np.sqrt(2)
    for times in ((0.0, 1.0), (1.0, -1.0), (1.0, np.inf)):
        with pytest.raises(ConversionError):
            frame_places(9, *times)


@pytest.mark.parametrize("convention", CONVENTIONS)
@fuzz.examples(20)
@given(seed=st.integers(0, 10_000), rate=st.sampled_from([(0.01, 0.005), (0.01, 0.02), (0.03, 0.02), (0.01, 0.0123)]))
def test_resampling_is_scipys_slerp(convention: Convention, seed: int, rate: tuple[float, float]) -> None:
    clip = random_clip(convention, seed, moving=convention is not Convention.FIXED, partial=False)
    skeleton, reading, block = clip.head.skeleton, reading_of(clip.head), whole(clip)
    edited = resampled(skeleton, block, *rate, reading)
    places = frame_places(len(block), *rate)
    assert len(edited.block) == len(places)
    before, after = (HubReader(skeleton, reading).read(part) for part in (block, edited.block))
    times = np.arange(len(block))
    for joint in range(len(skeleton)):
        expected = Slerp(times, Rotation.from_quat(before.rotations[:, joint]))(places).as_quat()
        assert angle_between(after.rotations[:, joint], expected).max() < 1e-7
        for axis in range(3):
            line = np.interp(places, times, before.translations[:, joint, axis])
            assert np.abs(line - after.translations[:, joint, axis]).max() < 1e-9
    common = places % 1 == 0
    assert same_bits(edited.block.values[common], block.values[places[common].astype(int)])
    assert edited.shortfall.notices(skeleton) == []


@given(seed=st.integers(0, 10_000), turns=st.integers(-3, 3))
def test_angles_between_frames_are_those_nearest_by(seed: int, turns: int) -> None:
    """Past whole turns and with the middle angle beyond a quarter turn, as a source may write them."""
    rng = np.random.default_rng(seed)
    skeleton = Skeleton((Joint("j", -1, "j", Convention.LISTED, ("Rz", "Rx", "Ry"), "ZXY"),))
    start = rng.uniform(-180, 180, 3) + 360 * turns
    start[1] = rng.choice([-1, 1]) * rng.uniform(100, 260)
    values = start + np.cumsum(rng.uniform(-3, 3, (30, 3)), axis=0)
    columns = skeleton.columns()
    block = FrameBlock(values, columns, (full_shape(columns),), np.arange(30))
    halves = np.arange(59) / 2
    edited = sampled(skeleton, block, halves).block
    near_gimbal = np.abs(np.cos(np.radians(values[:, 1]))).min() < 0.2
    if not near_gimbal:
        line = np.stack([np.interp(halves, np.arange(30), values[:, axis]) for axis in range(3)], axis=1)
        assert np.abs(edited.values - line).max() < 3.0


def test_hinges_stay_hinges(shared: Path) -> None:
    clip = opened(shared / "asfamc/cmu02/02_lf_01.amc")
    skeleton, reading, block = clip.head.skeleton, reading_of(clip.head), whole(clip)
    faster = resampled(skeleton, block, 1 / 120, 1 / 200, reading)
    one = [index for index, joint in enumerate(skeleton.joints) if len(joint.channels) == 1]
    assert len(one) > 8
    assert faster.shortfall.angles[one].max() < 1e-9
    back = resampled(skeleton, faster.block, 1 / 200, 1 / 120, reading)
    height = rest_height(skeleton, reading=reading)
    places = np.arange(0, len(back.block), 3)
    positions = global_positions(skeleton, block, reading)[places]
    # Times that 120 and 200 frames a second share.
    assert np.abs(global_positions(skeleton, back.block, reading)[places] - positions).max() < 1e-3 * height
    assert same_bits(back.block.values[places], in_columns(block, skeleton.columns())[places])


def test_gaps_of_markers_stay_gaps(shared: Path) -> None:
    clip = opened(shared / "trc/dataWithBlanksForMissingMarkers.trc")
    block = whole(clip)
    gaps = np.isnan(block.values)
    assert gaps.any()
    edited = sampled(clip.head.skeleton, block, np.arange(2 * len(block) - 1) / 2).block
    assert same_bits(edited.values[::2], block.values)
    assert np.array_equal(np.isnan(edited.values[1::2]), gaps[1:] | gaps[:-1])
    assert edited.shape_of is not None
    for row in range(len(edited)):
        bits = dict(edited.shapes[int(edited.shape_of[row])])
        has = {column for column, value in zip(edited.columns, edited.values[row], strict=True) if not np.isnan(value)}
        assert {(joint, c) for joint, mask in bits.items() for c in range(8) if mask >> c & 1} == has
    smooth = smoothed(clip.head.skeleton, block, 1.0, np.ones(len(block))).block
    assert np.array_equal(np.isnan(smooth.values), gaps)
    assert not np.allclose(np.nan_to_num(smooth.values), np.nan_to_num(block.values))


def slow_mean(rotations: list[Rotation], weights: Array) -> Rotation:
    """The mean on the sphere, one rotation after the other."""
    mean = rotations[int(np.argmax(weights))]
    for _ in range(20):
        step = sum(w * (mean.inv() * r).as_rotvec() for w, r in zip(weights, rotations, strict=True))
        mean = mean * Rotation.from_rotvec(step)
    return mean


@pytest.mark.slow
@fuzz.examples(20)
@given(seed=st.integers(0, 10_000), deviation=st.floats(0.4, 3))
def test_smoothing_is_the_weighted_mean(seed: int, deviation: float) -> None:
    clip = random_clip(Convention.BASE, seed, moving=True)
    skeleton, reading, block = clip.head.skeleton, reading_of(clip.head), whole(clip)
    # Gentle motion: a tenth of the random one.
    gentle = FrameBlock(block.values * 0.1, block.columns, block.shapes, block.ids)
    edited = smoothed(skeleton, gentle, deviation, np.ones(len(block)), reading=reading)
    before, after = (HubReader(skeleton, reading).read(part) for part in (gentle, edited.block))
    for frame in (0, 1, 9, 19):
        room = min(frame, 19 - frame, int(np.ceil(3 * deviation)))
        window = np.arange(frame - room, frame + room + 1)
        weights = np.exp(-0.5 * ((window - frame) / deviation) ** 2)
        weights /= weights.sum()
        for joint in range(len(skeleton)):
            expected = slow_mean([Rotation.from_quat(before.rotations[w, joint]) for w in window], weights).as_quat()
            assert angle_between(after.rotations[frame, joint], expected) < 1e-4
            assert np.abs(after.translations[frame, joint] - weights @ before.translations[window, joint]).max() < 1e-9


def test_smoothing_is_for_the_frames_and_joints_asked(shared: Path) -> None:
    clip = opened(shared / "bvh/bandai/dataset-1_walk_happy_001.bvh")
    skeleton, block = clip.head.skeleton, whole(clip)
    strength = eased(len(block), 30, 60, 5)
    edited = smoothed(skeleton, block, 2.0, strength, [8, 9])
    outside = strength == 0
    assert same_bits(edited.block.values[outside], block.values[outside])
    others = [place for place, (joint, _) in enumerate(block.columns) if joint not in (8, 9)]
    assert same_bits(edited.block.values[:, others], block.values[:, others])
    before, after = (HubReader(skeleton).read(part).rotations[:, 9] for part in (block, edited.block))
    inside = slice(35, 56)
    assert rough(after[inside]) < 0.5 * rough(before[inside])


def rough(rotations: Array) -> float:
    steps = np.diff(rotations * np.sign((rotations * rotations[:1]).sum(axis=1))[:, None], axis=0)
    return float(np.abs(np.diff(steps, axis=0)).sum())


def test_what_never_changes_stays(shared: Path) -> None:
    clip = opened(shared / "bvh/bandai/dataset-1_bow_old_001.bvh")
    still = chosen_frames(whole(clip), np.zeros(30, dtype=np.intp))
    edited = smoothed(clip.head.skeleton, still, 4.0, np.ones(30))
    assert np.abs(edited.block.values - still.values).max() < 1e-9
    with pytest.raises(ConversionError):
        smoothed(clip.head.skeleton, still, 0.0, np.ones(30))
