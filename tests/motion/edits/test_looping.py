"""Loops: round after round without a jump."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import ConversionError
from mcml.motion.clip import FrameBlock, full_shape
from mcml.motion.edits.composing import Piece, compose
from mcml.motion.edits.looping import close_loop
from mcml.motion.frames import in_columns
from mcml.motion.hub import HubReader, walked
from mcml.motion.skeleton import Convention
from tests import fuzz
from tests.motion.random_clips import random_clip
from tests.motion.test_composing import smooth_clip
from tests.motion.test_retarget import taken

CLIPS = [
    ("bvh/bandai/dataset-1_walk_normal_001.bvh", 1 / 30),
    ("bvh/dance/131_01.bvh", 1 / 120),
    ("asfamc/cmu_misc/07_05-walk.amc", 1 / 120),
    ("asfamc/cmu_misc/09_06-run.amc", 1 / 120),
]


@pytest.mark.parametrize("search", [0.0, 0.4])
@pytest.mark.parametrize(("name", "frame_time"), CLIPS)
def test_two_rounds_follow_one_another(shared: Path, name: str, frame_time: float, search: float) -> None:
    skeleton, block, reading = taken(shared / name)
    made = close_loop(skeleton, block, frame_time, 0.3, search, reading=reading)
    assert made.jump <= 1.1
    assert 0 <= made.first < made.last < len(block)
    assert len(made.block) == made.last - made.first + 1
    if not search:
        assert (made.first, made.last) == (0, len(block) - 1)
    # Frames before the end keep their bits.
    kept = len(made.block) - round(0.3 / frame_time)
    columns = skeleton.columns()
    own = in_columns(block, columns)[made.first : made.first + kept]
    assert np.array_equal(in_columns(made.block, columns)[:kept], own)
    # Composed with itself, without any transition, it goes on as inside.
    rounds = compose(skeleton, [Piece(made.block, frame_time)] * 2, frame_time, reading=reading, lengthen=False)
    assert rounds.seams[0].angle_step <= 1.1


@pytest.mark.parametrize(("name", "frame_time"), CLIPS)
def test_in_place_the_body_comes_back(shared: Path, name: str, frame_time: float) -> None:
    skeleton, block, reading = taken(shared / name)
    made = close_loop(skeleton, block, frame_time, 0.3, 0.4, in_place=True, reading=reading)
    hub = HubReader(skeleton, reading).read(made.block)
    positions = walked(skeleton, hub.translations, hub.rotations)[0]
    size = np.ptp(positions[0], axis=0).max()
    thigh = skeleton.names.index("left_up_leg")
    assert np.linalg.norm((positions[-1] - positions[0])[thigh]) < 0.12 * size
    assert made.jump <= 1.1


@pytest.mark.parametrize("convention", [Convention.LISTED, Convention.FIXED, Convention.BASE])
@fuzz.examples(6)
@given(seed=st.integers(0, 10_000), seconds=st.floats(0, 0.2), search=st.floats(0, 0.5))
def test_loops_of_generated_clips(convention: Convention, seed: int, seconds: float, search: float) -> None:
    skeleton, blocks, reading = smooth_clip(seed, convention)
    made = close_loop(skeleton, blocks[2], 0.01, seconds, search, reading=reading)
    assert len(made.block) >= 4
    assert np.isfinite(made.block.values).all()
    assert list(made.block.ids) == list(blocks[2].ids[made.first : made.last + 1])


def test_missing_samples_stay_missing_and_short_ranges_are_refused() -> None:
    clip = random_clip(Convention.LISTED, 7, partial=False)
    skeleton = clip.head.skeleton
    columns = skeleton.columns()
    values = np.cumsum(np.ones((40, len(columns))), axis=0)
    values[35, 3] = np.nan
    block = FrameBlock(values, columns, (full_shape(columns),), np.arange(40, dtype=np.int64))
    made = close_loop(skeleton, block, 0.01, 0.1, 0.0)
    assert np.argwhere(np.isnan(made.block.values)).tolist() == [[35, 3]]
    with pytest.raises(ConversionError, match="at least 4 frames"):
        close_loop(skeleton, FrameBlock(values[:3], columns, (full_shape(columns),), block.ids[:3]), 0.01, 0.1, 0.0)
