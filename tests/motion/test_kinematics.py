"""Forward kinematics against the written-out formulas, and by hand."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.motion import hub
from mcml.motion.clip import FrameBlock, full_shape
from mcml.motion.hub import rest_of
from mcml.motion.kinematics import Walker, rest_positions
from mcml.motion.rotations import rotate
from mcml.motion.skeleton import Convention, EndSite, Joint, Skeleton, once_a_skeleton
from mcml.motion.units import reading_of
from tests.motion import obvious
from tests.motion.random_clips import random_clip
from tests.poses import global_positions, global_rotations

CONVENTIONS = [Convention.LISTED, Convention.FIXED, Convention.BASE]


@pytest.mark.parametrize("convention", CONVENTIONS)
@given(seed=st.integers(0, 100_000), moving=st.booleans(), radians=st.booleans())
def test_positions_are_those_of_the_formulas(convention: Convention, seed: int, moving: bool, radians: bool) -> None:
    clip = random_clip(convention, seed, moving=moving, radians=radians and convention is not Convention.LISTED)
    walker = Walker(clip.head.skeleton, reading_of(clip.head))
    found = np.concatenate([walker.poses(block)[0] for block in clip.blocks()])
    assert np.abs(found - obvious.positions(clip)).max() < 1e-9
    ends = np.concatenate([walker.tips(block) for block in clip.blocks()])
    expected = obvious.tips(clip)
    for place, joint in enumerate([joint for joint, _ in rest_of(clip.head.skeleton).tips]):
        assert np.abs(ends[:, place] - expected[joint]).max() < 1e-9


@pytest.mark.parametrize("convention", CONVENTIONS)
@given(seed=st.integers(0, 100_000))
def test_joints_of_one_depth_walk_as_each_alone(convention: Convention, seed: int) -> None:
    skeleton = random_clip(convention, seed).head.skeleton
    rng = np.random.default_rng(seed)
    translations = rng.normal(size=(5, len(skeleton), 3))
    rotations = rng.normal(size=(5, len(skeleton), 4))
    together = hub.walked(skeleton, translations, rotations)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(hub, "AT_ONCE", 0)
        alone = hub.walked(skeleton, translations, rotations)
    for one, other in zip(together, alone, strict=True):
        assert one.tobytes() == other.tobytes()


def test_what_follows_from_a_skeleton_is_found_once_and_stays_at_home() -> None:
    skeleton = arm()
    asked: list[float] = []

    @once_a_skeleton
    def scaled(given: Skeleton, factor: float) -> list[float]:
        asked.append(factor)
        return [factor * len(given)]

    assert scaled(skeleton, 2.0) is scaled(skeleton, 2.0)
    assert scaled(skeleton, 3.0) == [6.0]
    assert scaled(arm(), 2.0) == [4.0]
    assert asked == [2.0, 3.0, 2.0]
    sent = pickle.loads(pickle.dumps(skeleton))
    assert sent == skeleton
    assert scaled(sent, 2.0) == [4.0]
    assert len(asked) == 4
    assert not rest_of(skeleton).offsets.flags.writeable


def arm() -> Skeleton:
    upper = Joint("upper", -1, "upper", Convention.LISTED, ("Tx", "Ty", "Tz", "Rz"), "Z", offset=("0", "9", "0"))
    lower = Joint("lower", 0, "lower", Convention.LISTED, ("Rx",), "X", offset=("2", "0", "0"))
    return Skeleton(
        (replace(upper, translation="absolute"), replace(lower, end_sites=(EndSite(("1", "0", "0")),)))
    )  # fmt: skip


def block_of(skeleton: Skeleton, rows: list[list[float]]) -> FrameBlock:
    columns = skeleton.columns()
    values = np.array(rows, dtype=np.float64)
    bits = [
        tuple(
            (joint, sum(1 << c for (j, c), value in zip(columns, row, strict=True) if j == joint and value == value))
            for joint in range(len(skeleton))
        )
        for row in rows
    ]
    shapes = tuple(dict.fromkeys(bits))
    shape_of = np.array([shapes.index(shape) for shape in bits])
    return FrameBlock(values, columns, shapes, np.arange(1, len(rows) + 1), shape_of)


def test_an_arm_by_hand() -> None:
    skeleton = arm()
    block = block_of(skeleton, [[1, 2, 3, 90, 0], [0, 0, 0, 180, 90]])
    places = global_positions(skeleton, block)
    assert np.allclose(places, [[[1, 2, 3], [1, 4, 3]], [[0, 0, 0], [-2, 0, 0]]])
    assert np.allclose(Walker(skeleton).tips(block), [[[1, 5, 3]], [[-3, 0, 0]]])
    turned = rotate(global_rotations(skeleton, block)[:, 0], np.array([1.0, 0.0, 0.0]))
    assert np.allclose(turned, [[0, 1, 0], [-1, 0, 0]])


def test_missing_samples_hold_the_last_value() -> None:
    skeleton = arm()
    nan = float("nan")
    blocks = [
        block_of(skeleton, [[nan, nan, nan, nan, 0], [1, 2, 3, 90, 0]]),
        block_of(skeleton, [[nan, nan, 5, nan, 0]]),
    ]
    walker = Walker(skeleton)
    places = np.concatenate([walker.poses(block)[0] for block in blocks])
    # Before the first sample the joint rests at its offset.
    assert np.allclose(places[:, 0], [[0, 9, 0], [1, 2, 3], [1, 2, 5]])
    assert np.allclose(places[2, 1], [1, 4, 5])


def test_columns_may_come_in_any_order() -> None:
    skeleton = arm()
    block = block_of(skeleton, [[1, 2, 3, 90, 30], [0, 0, 0, 180, 90]])
    order = [3, 4, 0, 2, 1]
    columns = tuple(block.columns[place] for place in order)
    shuffled = FrameBlock(block.values[:, order], columns, (full_shape(columns),), block.ids)
    assert np.array_equal(global_positions(skeleton, shuffled), global_positions(skeleton, block))


def test_rest_positions() -> None:
    assert rest_positions(arm()).tolist() == [[0, 9, 0], [2, 9, 0], [3, 9, 0]]


@given(seed=st.integers(0, 10_000))
def test_a_clip_that_stands_still_is_in_its_rest_pose(seed: int) -> None:
    clip = random_clip(Convention.BASE, seed)
    skeleton = clip.head.skeleton
    reading = reading_of(clip.head)
    columns = skeleton.columns()
    still = FrameBlock(np.zeros((1, len(columns))), columns, (full_shape(columns),), np.array([1]))
    found = global_positions(skeleton, still, reading)[0]
    assert np.abs(found - rest_positions(skeleton, reading)[: len(skeleton)]).max() < 1e-12
    assert np.abs(global_rotations(skeleton, still, reading) - [0, 0, 0, 1]).max() < 1e-12
