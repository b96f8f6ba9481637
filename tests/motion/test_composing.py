"""Clips made of pieces: what follows in its source stays bit by bit; seams leap no further than the pieces do."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mcml.errors import ConversionError
from mcml.motion.clip import ClipStream, FrameBlock, full_shape
from mcml.motion.edits.composing import Composed, Piece, compose
from mcml.motion.edits.layering import lay_over
from mcml.motion.edits.transitions import LARGEST_JUMP
from mcml.motion.frames import in_columns
from mcml.motion.hub import HubReader
from mcml.motion.skeleton import Array, Convention, Joint, Skeleton
from mcml.motion.units import Reading, reading_of
from tests import fuzz
from tests.formats.test_real_files import opened
from tests.motion.random_clips import random_clip
from tests.motion.test_frames import same_bits, whole
from tests.poses import chosen_frames, global_positions, global_rotations

CONVENTIONS = [Convention.LISTED, Convention.FIXED, Convention.BASE]
BANDAI = "bvh/bandai/dataset-1_{}_001.bvh"


def cut(block: FrameBlock, first: int, end: int) -> FrameBlock:
    return chosen_frames(block, np.arange(first, end))


@pytest.mark.parametrize("convention", CONVENTIONS)
@fuzz.examples(20)
@given(seed=st.integers(0, 10_000), cuts=st.lists(st.integers(1, 19), max_size=4), transition=st.integers(0, 3))
def test_pieces_in_order_are_the_clip(convention: Convention, seed: int, cuts: list[int], transition: int) -> None:
    clip = random_clip(convention, seed, moving=True)
    block = whole(clip)
    edges = sorted({0, 20, *cuts})
    pieces = [Piece(cut(block, first, end), 0.01, "clip", first) for first, end in pairwise(edges)]
    result = compose(clip.head.skeleton, pieces, 0.01, transition=transition, reading=reading_of(clip.head))
    assert same_bits(result.block.values, in_columns(block, clip.head.skeleton.columns()))
    assert result.seams == ()
    assert [(first, last + 1) for _, first, last, _ in result.spans] == list(pairwise(edges))


@pytest.mark.parametrize("name", ["asfamc/cmu02/02_lf_01.amc", BANDAI.format("walk_happy"), "trc/Knee.trc"])
def test_pieces_of_real_clips_in_order_are_the_clip(shared: Path, name: str) -> None:
    clip = opened(shared / name)
    block = whole(clip)
    pieces = [
        Piece(cut(block, first, min(first + 37, len(block))), 0.01, "a", first) for first in range(0, len(block), 37)
    ]
    result = compose(clip.head.skeleton, pieces, 0.01, transition=10, reading=reading_of(clip.head))
    columns = clip.head.skeleton.columns()
    assert same_bits(result.block.values, in_columns(block, columns))


def measured(skeleton: Skeleton, block: FrameBlock, body: int, reading: Reading) -> tuple[Array, Array]:
    """Steps (n - 1,) of a joint in the world, and the largest of any joint's angle in its parent (SciPy)."""
    place = global_positions(skeleton, block, reading)[:, body]
    turned = global_rotations(skeleton, block, reading)
    angles = []
    for index, joint in enumerate(skeleton.joints):
        local = Rotation.from_quat(turned[:, index])
        if joint.parent >= 0:
            local = Rotation.from_quat(turned[:, joint.parent]).inv() * local
        angles.append((local[:-1].inv() * local[1:]).magnitude())
    return np.linalg.norm(np.diff(place, axis=0), axis=1), np.max(angles, axis=0)


def check_seams(
    clip_blocks: list[FrameBlock], skeleton: Skeleton, result: Composed, body: int, reading: Reading
) -> None:
    most = np.max(
        [[part.max() for part in measured(skeleton, block, body, reading)] for block in clip_blocks if len(block) > 1],
        axis=0,
    )
    found = measured(skeleton, result.block, body, reading)
    assert found[0].max() <= most[0] * LARGEST_JUMP + 1e-9
    assert found[1].max() <= most[1] * LARGEST_JUMP + 1e-9
    for seam in result.seams:
        around = slice(max(seam.first - 1, 0), seam.first + seam.frames)
        assert seam.root_step * most[0] == pytest.approx(found[0][around].max(), abs=1e-6)
        assert seam.angle_step * most[1] == pytest.approx(found[1][around].max(), abs=1e-6)


PAIRS = [
    ("asfamc/cmu16/16_15.amc", "asfamc/cmu16/16_26.amc"),
    ("asfamc/cmu16/16_38.amc".replace("16_38", "run_veer_left_16_38"), "asfamc/cmu16/16_12.amc"),
    (BANDAI.format("walk_happy"), BANDAI.format("run_angry")),
    (BANDAI.format("bow_old"), BANDAI.format("walk_tired")),
    ("bvh/dance/131_01.bvh", "bvh/dance/131_01.bvh"),
]


@pytest.mark.parametrize("transition", [1, 12])
@pytest.mark.parametrize("pair", PAIRS)
def test_seams_of_real_clips(shared: Path, pair: tuple[str, str], transition: int) -> None:
    one, two = (opened(shared / name) for name in pair)
    assert one.head.skeleton == two.head.skeleton
    skeleton, reading = one.head.skeleton, reading_of(one.head)
    blocks = [cut(whole(one), 20, 80), cut(whole(two), 30, 75), cut(whole(one), 5, 40)]
    pieces = [Piece(block, 1 / 30) for block in blocks]
    result = compose(skeleton, pieces, 1 / 30, transition=transition, reading=reading)
    body = 1 if "bandai" in pair[0] else 0
    check_seams(blocks, skeleton, result, body, reading)
    assert len(result.seams) == 2
    assert all(seam.frames >= transition for seam in result.seams)
    assert result.shortfall.lengths.max() < 1e-9 * np.abs(blocks[0].values).max()
    # The first piece keeps its bits; the others keep them in all joints but the one that was placed.
    assert same_bits(result.block.values[:60], in_columns(blocks[0], skeleton.columns()))
    for piece, first, last, _ in result.spans:
        same = [index for index, (joint, _) in enumerate(skeleton.columns()) if joint != body]
        raw = in_columns(blocks[piece], skeleton.columns())
        assert same_bits(result.block.values[first : last + 1][:, same], raw[:, same])


def smooth_clip(seed: int, convention: Convention = Convention.LISTED) -> tuple[Skeleton, list[FrameBlock], Reading]:
    """Pieces on one random skeleton, each a smooth motion of its own, far from the others."""
    clip = random_clip(convention, seed, partial=False)
    skeleton = clip.head.skeleton
    rng = np.random.default_rng(seed)
    columns = skeleton.columns()
    blocks = []
    for length in (12, 2, 15):
        start = rng.uniform(-90, 90, len(columns))
        pace = rng.normal(0, 4, len(columns))
        values = start + np.sin(np.arange(length)[:, None] / 6 + rng.uniform(0, 6, len(columns))) * pace * 6
        for index, (joint, channel) in enumerate(columns):
            if channel == 6:
                values[:, index] = 1.0
            elif channel < 3 and skeleton.joints[joint].parent >= 0:
                values[:, index] = 0.0
        ids = np.arange(length, dtype=np.int64)
        blocks.append(FrameBlock(values, columns, (full_shape(columns),), ids))
    return skeleton, blocks, reading_of(clip.head)


@pytest.mark.parametrize("convention", CONVENTIONS)
@fuzz.examples(8)
@given(seed=st.integers(0, 10_000), transition=st.integers(1, 9))
def test_seams_of_generated_clips(convention: Convention, seed: int, transition: int) -> None:
    skeleton, blocks, reading = smooth_clip(seed, convention)
    result = compose(skeleton, [Piece(block, 0.01) for block in blocks], 0.01, transition=transition, reading=reading)
    check_seams(blocks, skeleton, result, 0, reading)


@pytest.mark.parametrize("transition", [0, 8])
def test_the_body_goes_on_as_it_went(shared: Path, transition: int) -> None:
    """It faces as it did, keeps its heights, and its speed lies between those of the two sides."""
    one, two = (opened(shared / BANDAI.format(name)) for name in ("walk_happy", "run_angry"))
    skeleton = one.head.skeleton
    blocks = [cut(whole(one), 0, 60), cut(whole(two), 30, 75)]
    result = compose(skeleton, [Piece(b, 1 / 30) for b in blocks], 1 / 30, transition=transition, lengthen=False)
    places, turned = global_positions(skeleton, result.block)[:, 1], global_rotations(skeleton, result.block)[:, 1]
    start = result.spans[1][1]
    assert start == 60 + transition
    assert np.abs(places[start:, 1] - global_positions(skeleton, blocks[1])[:, 1, 1]).max() < 1e-9
    between = Rotation.from_quat(turned[59]).inv() * Rotation.from_quat(turned[start])
    apart = Rotation.from_quat(turned[59]) * between * Rotation.from_quat(turned[59]).inv()
    # No turn about Y would bring the two nearer.
    for angle in (-0.01, 0.01):
        assert (Rotation.from_rotvec([0, angle, 0]) * apart).magnitude() > apart.magnitude()
    flat = places[:, [0, 2]]
    steps = np.diff(flat, axis=0)
    mean = (steps[58] + steps[start]) / 2
    assert np.abs((flat[start] - flat[59]) / (transition + 1) - mean).max() < 1e-9
    if transition:
        # Speeds change from one side's to the other's by even steps: the second differences agree.
        second = np.diff(steps[58 : start + 1], axis=0)
        assert np.abs(second - second.mean(axis=0)).max() < 0.51 * np.abs(second).max() + 1e-9


def test_turns_join_without_a_jerk(shared: Path) -> None:
    one, two = (opened(shared / BANDAI.format(name)) for name in ("bye_happy", "walk_sad"))
    skeleton = one.head.skeleton
    blocks = [cut(whole(one), 0, 60), cut(whole(two), 30, 75)]
    result = compose(skeleton, [Piece(b, 1 / 30) for b in blocks], 1 / 30, transition=40)
    rotations = HubReader(skeleton).read(result.block).rotations
    for joint in range(2, len(skeleton)):
        turns = Rotation.from_quat(rotations[:, joint])
        step = (turns[:-1].inv() * turns[1:]).as_rotvec()
        # The first step of the transition is nearly the last one before it, and so at its end.
        for place in (58, 59 + result.seams[0].frames):
            limit = 0.25 * max(np.linalg.norm(step[place]), np.linalg.norm(step[place + 1])) + 0.012
            assert np.linalg.norm(step[place + 1] - step[place]) < limit


def test_a_crossfade_blends_frames_of_both(shared: Path) -> None:
    one, two = (opened(shared / BANDAI.format(name)) for name in ("walk_happy", "walk_sad"))
    skeleton = one.head.skeleton
    blocks = [cut(whole(one), 0, 60), cut(whole(two), 30, 75)]
    result = compose(
        skeleton, [Piece(b, 1 / 30) for b in blocks], 1 / 30, transition=15, style="crossfade", lengthen=False
    )
    assert len(result.block) == 60 + 45 - 15
    assert result.spans == ((0, 0, 44, 0), (1, 60, 89, 15))
    assert result.seams[0].frames == 15
    others = [index for index, (joint, _) in enumerate(skeleton.columns()) if joint != 1]
    assert same_bits(result.block.values[60:][:, others], blocks[1].values[15:][:, others])
    assert same_bits(result.block.values[:45], blocks[0].values[:45])
    # At the middle frame the two stand on one spot, half and half.
    flat = global_positions(skeleton, result.block)[:, 1][:, [0, 2]]
    steps = np.linalg.norm(np.diff(flat, axis=0), axis=1)
    assert steps[44:61].max() < 1.5 * max(steps[:44].max(), steps[61:].max())
    longer = compose(skeleton, [Piece(b, 1 / 30) for b in blocks], 1 / 30, transition=2, style="crossfade")
    assert max(longer.seams[0].root_step, longer.seams[0].angle_step) <= LARGEST_JUMP


def test_other_frame_rates_are_brought_to_one(shared: Path) -> None:
    clip = opened(shared / BANDAI.format("walk_happy"))
    skeleton, block = clip.head.skeleton, whole(clip)
    halved = chosen_frames(block, np.arange(0, 101, 2))
    pieces = [Piece(cut(block, 0, 50), 1 / 30), Piece(halved, 1 / 15)]
    result = compose(skeleton, pieces, 1 / 30, transition=5)
    _, first, last, _ = result.spans[1]
    assert last - first == 100
    others = [index for index, (joint, _) in enumerate(skeleton.columns()) if joint != 1]
    assert same_bits(result.block.values[first : last + 1 : 2][:, others], halved.values[:, others])
    # Two pieces in a row at another rate are cut where their frames fall.
    rows = [Piece(cut(block, 0, 31), 1 / 30, "a", 0), Piece(cut(block, 31, 61), 1 / 30, "a", 31)]
    slow = compose(skeleton, rows, 1 / 15)
    assert slow.spans == ((0, 0, 15, 0), (1, 16, 30, 0))
    assert same_bits(slow.block.values, block.values[:61:2])


def test_names_and_gaps_go_along() -> None:
    skeleton = Skeleton(
        tuple(Joint(name, -1, name, Convention.MARKER, ("Tx", "Ty", "Tz"), translation="absolute") for name in "ab")
    )
    columns = skeleton.columns()
    full = full_shape(columns)
    one = np.array([[0.0, 1, 0, 2, 1, 0], [0.1, 1, 0, 2.1, 1, 0]])
    two = np.array([[5.0, 1, 9, 5, 1, 7], [np.nan] * 3 + [5.0, 1, 6.9]])
    names: list[tuple[str, ...]] = [("walk",), ("walk",)]
    blocks = [
        FrameBlock(one, columns, (full,), np.array([1, 2]), None, names),
        FrameBlock(two, columns, (full, ((0, 0), full[1])), np.array([1, 2]), np.array([0, 1])),
    ]
    result = compose(skeleton, [Piece(block, 0.1) for block in blocks], 0.1, transition=2, lengthen=False)
    assert result.block.motion_names == [("walk",), ("walk",), (), (), (), ()]
    assert np.argwhere(np.isnan(result.block.values)).tolist() == [[5, 0], [5, 1], [5, 2]]
    # The two points of the second piece were turned about Y to lie as those of the first.
    seam = result.seams[0]
    assert abs(seam.turn) == pytest.approx(np.pi / 2)
    placed = result.block.values[4].reshape(2, 3)
    assert (placed[1] - placed[0]) == pytest.approx([2.0, 0, 0])


def test_a_transition_has_no_sample_where_an_end_has_none() -> None:
    skeleton = Skeleton(
        tuple(Joint(name, -1, name, Convention.MARKER, ("Tx", "Ty", "Tz"), translation="absolute") for name in "ab")
    )
    columns = skeleton.columns()
    full = full_shape(columns)
    values = np.arange(18.0).reshape(3, 6)
    gap = values.copy()
    gap[2, 3:] = np.nan
    whole_block = FrameBlock(values, columns, (full,), np.arange(3))
    with_gap = FrameBlock(gap, columns, (full, (full[0], (1, 0))), np.arange(3), np.array([0, 0, 1]))
    for pieces, rows in (((with_gap, whole_block), [2, 3, 4]), ((whole_block, with_gap), [7])):
        made = compose(skeleton, [Piece(p, 0.1) for p in pieces], 0.1, transition=2, lengthen=False).block
        expected = np.zeros(made.values.shape, dtype=bool)
        expected[rows, 3:] = True
        assert np.array_equal(np.isnan(made.values), expected)


def test_what_cannot_be_composed_is_refused() -> None:
    clip = random_clip(Convention.LISTED, 3)
    with pytest.raises(ConversionError):
        compose(clip.head.skeleton, [], 0.01)
    with pytest.raises(ConversionError):
        compose(clip.head.skeleton, [Piece(cut(whole(clip), 3, 3), 0.01)], 0.01)
    with pytest.raises(ConversionError):
        compose(clip.head.skeleton, [Piece(whole(clip), 0.01)], 0.01, transition=-1)


@pytest.mark.parametrize("convention", CONVENTIONS)
@fuzz.examples(8)
@given(seed=st.integers(0, 10_000))
def test_layers_take_bones_of_another_clip(convention: Convention, seed: int) -> None:
    clip: ClipStream = random_clip(convention, seed, moving=True)
    skeleton, reading, base = clip.head.skeleton, reading_of(clip.head), whole(clip)
    rng = np.random.default_rng(seed)
    over = FrameBlock(base.values[::-1] * 0.5, base.columns, base.shapes, base.ids)
    over = cut(over, 0, int(rng.integers(1, 21)))
    joints = [index for index in range(len(skeleton)) if rng.random() < 0.5]
    strength = rng.choice([0.0, 0.25, 1.0], len(base))
    begin = int(rng.choice([0, rng.integers(0, len(base))]))
    result = lay_over(skeleton, base, over, joints, strength, reading, begin).block
    one, two, made = (HubReader(skeleton, reading).read(part) for part in (base, over, result))
    for index, (joint, _) in enumerate(skeleton.columns()):
        for frame in range(len(base)):
            share = strength[frame] if joint in joints and 0 <= frame - begin < len(over) else 0.0
            if share in (0.0, 1.0):
                source, row = (over, frame - begin) if share else (base, frame)
                assert result.values[frame, index] == in_columns(source, skeleton.columns())[row, index]
    for joint in joints:
        for frame in begin + np.flatnonzero(strength[begin : begin + len(over)] == 0.25):
            first, last = (
                Rotation.from_quat(one.rotations[frame, joint]),
                Rotation.from_quat(two.rotations[frame - begin, joint]),
            )
            expected = first * Rotation.from_rotvec(0.25 * (first.inv() * last).as_rotvec())
            apart = (expected.inv() * Rotation.from_quat(made.rotations[frame, joint])).magnitude()
            if (first.inv() * last).magnitude() < 3.1 and len(skeleton.joints[joint].rotation_order) == 3:
                assert apart < 1e-6
