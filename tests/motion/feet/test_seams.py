"""Transitions in which standing feet stay in place, and differences that decay."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.motion.edits.composing import Composed, Piece, compose
from mcml.motion.edits.splicing import decay
from mcml.motion.edits.transitions import Style
from mcml.motion.feet.legs import legs_of
from mcml.motion.feet.seams import Stance, pivot_shift, seam_moves, slide_of
from mcml.motion.hub import HubReader, walked
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.units import Reading
from tests.motion.test_retarget import taken
from tests.poses import chosen_frames

UP = np.array([0.0, 1.0, 0.0])
TOE = np.array([0.0, 0.0, 0.1])
"""From an ankle to its toe."""


def stance(places: Array, stands: Any, frames: int) -> Stance:
    """Legs in one pose: places (L, 3) of ankles, with toes 0.1 before them, and whether each stands."""
    both = np.stack([places + TOE, places], axis=1)[None]
    flags = np.repeat(np.array(stands, dtype=bool)[None, :, None], 2, axis=2)
    return Stance(both, flags).over(frames)


def held_places(between: Array, before: Stance, after: Stance) -> Array:
    """(m, L, 3) ankles after the moves."""
    hips = np.zeros((len(between), between.shape[1], 3))
    moves = seam_moves(between, before, after, UP, 1.0, hips, np.full(between.shape[1], 99.0))
    places: Array = between[:, :, 1] + np.stack(moves, axis=1)
    return places


@given(seed=st.integers(0, 100_000), frames=st.integers(8, 60))
def test_one_foot_always_stands_in_a_transition(seed: int, frames: int) -> None:
    """Whichever feet stand before and after: there is one that does not move in almost every frame."""
    rng = np.random.default_rng(seed)
    ends = rng.normal(0, 0.4, (2, 2, 3)) * [1, 0, 1]
    stands = [[bool(flag) for flag in rng.integers(0, 2, 2)] for _ in "ab"]
    if not any(stands[0]) or not any(stands[1]):
        return
    shift = ends[0] if rng.integers(2) else np.zeros((2, 3))
    before, after = stance(ends[0], stands[0], frames), stance(ends[1] * 0.01 + shift, stands[1], frames)
    part = (np.arange(1, frames + 1) / (frames + 1))[:, None, None]
    between = (1 - part) * before.places[0, :, 1] + part * after.places[0, :, 1]
    both = np.stack([between + TOE, between], axis=2)
    places = held_places(both, before, after)
    # Both ends are continued without a leap.
    whole = np.concatenate([before.places[:1, :, 1], places, after.places[:1, :, 1]])
    speeds = np.linalg.norm(np.diff(whole, axis=0)[..., [0, 2]], axis=2)
    distance = np.linalg.norm(after.places[0, :, 1] - before.places[0, :, 1], axis=1).max()
    assert speeds.max() <= 8 * distance / frames + 1e-9
    same_foot_only = stands[0] == stands[1] and sum(stands[0]) == 1
    if not same_foot_only:
        still = speeds.min(axis=1) < 0.02 * max(distance, 1e-9) + 0.15 / frames
        assert still.sum() >= len(still) - 2


def test_a_foot_that_stands_on_both_sides_places_the_body() -> None:
    before, after = stance(np.array([[0.0, 0, 0], [0.3, 0, 0.4]]), [True, False], 1), None
    after = stance(np.array([[5.0, 0, 5], [5.3, 0.2, 5.0]]), [True, True], 1)
    # The speed of the body would place it 0.2 further; the left foot keeps its place.
    shift = pivot_shift(before, after, after.places[0], np.array([-5.0, 0, -4.8]), UP, 1.0)
    assert np.abs(shift - [-5, 0, -5]).max() < 1e-12
    # Nothing stands on both sides, or much too far away: the speed decides.
    alone = stance(np.array([[0.0, 0, 0], [0.3, 0, 0.4]]), [False, False], 1)
    for side, moved in ((alone, [-5.0, 0, -4.8]), (before, [-5.0, 0, -4.0])):
        assert (pivot_shift(side, after, after.places[0], np.array(moved), UP, 1.0) == moved).all()


def test_a_leg_that_is_too_short_releases_its_foot() -> None:
    before, after = (
        stance(np.zeros((2, 3)), [True, False], 20),
        stance(np.array([[0.0, 0, 3], [0, 0, 3]]), [False] * 2, 20),
    )
    course = np.linspace(0, 3, 22)[1:-1, None, None] * [0, 0, 1] + np.zeros((20, 2, 3))
    both = np.stack([course + TOE, course], axis=2)
    hips = course + 0.9 * UP
    near = seam_moves(both, before, after, UP, 1.0, hips, np.full(2, 1.0))[0]
    far = seam_moves(both, before, after, UP, 1.0, hips, np.full(2, 9.0))[0]
    held = [int((np.abs(both[:, 0, 0, 2] + moves[:, 2] - 0.1) < 1e-9).sum()) for moves in (near, far)]
    assert 0 < held[0] < held[1] == 10


@given(seed=st.integers(0, 100_000), frames=st.integers(1, 60))
def test_a_difference_decays_to_nothing(seed: int, frames: int) -> None:
    rng = np.random.default_rng(seed)
    values, speeds = rng.normal(size=(2, 5, 3)) * [[[1.0]], [[0.05]]]
    course = decay(values, speeds, frames)
    assert course.shape == (frames, 5, 3)
    assert np.abs(course[0] - values).max() < 1e-12
    # It never changes sides, nor grows.
    assert (course * np.sign(values) >= -1e-9).all()
    assert (np.abs(course) <= np.abs(values) + 1e-9).all()
    if frames >= 20:
        assert np.abs(course[-1]).max() < 0.01 * np.abs(values).max()
        towards = np.minimum(speeds * np.sign(values), 0)
        calm = np.abs(towards) * frames < 2 * np.abs(values)
        assert np.abs((np.abs(course[1]) - np.abs(values) - towards)[calm]).max(initial=0) < 0.05 * np.abs(values).max()
    assert (decay(np.zeros((5, 3)), speeds, frames) == 0).all()


PAIRS = [
    ("bvh/dance/131_01.bvh", "bvh/dance/131_02.bvh", 443, 874, 1 / 120),
    ("bvh/bandai/dataset-1_bow_happy_001.bvh", "bvh/bandai/dataset-1_walk_angry_001.bvh", 27, 47, 1 / 30),
    ("bvh/bandai/dataset-1_walk_normal_001.bvh", "bvh/bandai/dataset-1_walk_normal_001.bvh", 60, 20, 1 / 30),
    ("asfamc/cmu16/16_15.amc", "asfamc/cmu16/16_29.amc", 283, 1, 1 / 120),
]


WALKS_ON = {"bvh/bandai/dataset-1_walk_normal_001.bvh", "asfamc/cmu16/16_29.amc"}
"""Clips that walk on at once: a difference that decays over their first frames leaves no time for a step."""


def composed(
    shared: Path, pair: tuple[str, str, int, int, float], style: Style = "bridge", **options: Any
) -> tuple[Skeleton, Reading, Composed, list[Any]]:
    one, two, first, second, frame_time = pair
    skeleton, block, reading = taken(shared / one)
    other = taken(shared / two)[1]
    size = round(1.2 / frame_time)
    blocks = [chosen_frames(whole, np.arange(at, at + size)) for whole, at in ((block, first), (other, second))]
    frames = round(0.3 / frame_time)
    pieces = [Piece(part, frame_time) for part in blocks]
    made = compose(skeleton, pieces, frame_time, transition=frames, style=style, reading=reading, **options)
    return skeleton, reading, made, blocks


@pytest.mark.parametrize("style", ["bridge", "crossfade", "inertial"])
@pytest.mark.parametrize("pair", PAIRS)
def test_feet_slide_less_in_seams_of_real_clips(
    shared: Path, pair: tuple[str, str, int, int, float], style: Style
) -> None:
    slides = []
    for lock in (False, True):
        skeleton, reading, made, _ = composed(shared, pair, style, lock_feet=lock)
        (seam,) = made.seams
        hub = HubReader(skeleton, reading).read(made.block)
        positions = walked(skeleton, hub.translations, hub.rotations)[0]
        legs = legs_of(skeleton)
        points = positions[seam.first - 1 : seam.first + seam.frames + 1][:, [[leg.toe, leg.ankle] for leg in legs]]
        slides.append(slide_of(points, UP, pair[-1], legs[0].length(positions)))
        # Measured with and without a lock, around the seam, in lengths of the legs of both pieces.
        assert seam.slide == pytest.approx(slides[-1], rel=0.3, abs=0.01)
        assert (seam.locked == ()) == (not lock)
        assert max(seam.root_step, seam.angle_step) <= 1.1 + 1e-9
        # Bones keep their lengths.
        for leg in legs:
            bones = np.linalg.norm(positions[:, leg.knee] - positions[:, leg.ankle], axis=1)
            assert np.ptp(bones) < 1e-6 * bones.mean()
    if style == "bridge":
        assert slides[1] < 0.3 * slides[0]
    elif style == "crossfade" or not WALKS_ON.intersection(pair):
        assert slides[1] < 0.6 * slides[0]


def test_inertial_transitions_use_no_new_frames(shared: Path) -> None:
    skeleton, reading, made, blocks = composed(shared, PAIRS[2], "inertial", lock_feet=False)
    (seam,) = made.seams
    assert len(made.block) == sum(len(block) for block in blocks)
    assert seam.first == len(blocks[0])
    # After the transition the second piece is itself, but for where it was placed.
    hubs = [HubReader(skeleton, reading).read(block) for block in (made.block, blocks[1])]
    after = seam.first + seam.frames
    assert np.abs(hubs[0].rotations[after:, 2:] - hubs[1].rotations[seam.frames :, 2:]).max() < 1e-9
