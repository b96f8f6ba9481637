"""Speed: places of frames at other factors. In place: the way over the ground taken out, all else kept."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from mcml.errors import ConversionError
from mcml.motion.carriers import carriers
from mcml.motion.clip import FrameBlock, full_shape
from mcml.motion.edits.in_place import ground_path, stay_in_place
from mcml.motion.edits.retiming import speed_places
from mcml.motion.frames import in_columns
from mcml.motion.hub import HubReader, walked
from mcml.motion.markers import marker_skeleton
from mcml.motion.skeleton import Convention
from tests import fuzz
from tests.motion.test_composing import smooth_clip
from tests.motion.test_retarget import taken

FACTORS = st.lists(st.floats(0.05, 20), min_size=1, max_size=6)


@given(st.integers(1, 400), FACTORS, st.booleans())
def test_places_begin_at_the_first_frame_and_never_go_back(frames: int, factors: list[float], follows: bool) -> None:
    places = speed_places(frames, factors, follows=follows)
    assert places[0] == 0.0
    assert (np.diff(places) > 0).all()
    assert places[-1] < frames if follows else np.isclose(places[-1], frames - 1)


@given(st.integers(2, 300), FACTORS, st.booleans())
def test_the_time_is_the_integral_of_the_pace(frames: int, factors: list[float], follows: bool) -> None:
    length = frames if follows else frames - 1
    at = np.linspace(0, length, len(factors))
    seconds = quad(lambda place: 1 / np.interp(place, at, factors), 0, length, points=list(at[1:-1]) or None)[0]
    steps = len(speed_places(frames, factors, follows=follows)) - (0 if follows else 1)
    assert abs(steps - seconds) <= 0.5 + 1e-6 * seconds or steps == 1


@given(st.integers(1, 300), st.booleans())
def test_factor_one_is_no_change(frames: int, follows: bool) -> None:
    assert speed_places(frames, [1.0], follows=follows).tolist() == list(range(frames))


def test_a_speed_that_rises_takes_longer_steps() -> None:
    steps = np.diff(speed_places(200, [0.5, 2.0], follows=True))
    assert (np.diff(steps) > 0).all()
    assert steps[0] == pytest.approx(0.5, rel=0.05)
    assert steps[-1] == pytest.approx(2.0, rel=0.05)


def test_speeds_that_are_not_positive_are_refused() -> None:
    for factors in ([], [0.0], [1.0, -1.0], [np.nan]):
        with pytest.raises(ConversionError):
            speed_places(10, factors, follows=True)


@pytest.mark.parametrize(
    "name",
    ["bvh/bandai/dataset-1_walk_normal_001.bvh", "asfamc/cmu_misc/09_06-run.amc"],
)
def test_a_walk_in_place_keeps_heights_and_poses(shared: Path, name: str) -> None:
    skeleton, block, reading = taken(shared / name)
    count = len(block)
    first, last = count // 4, count // 2
    made = stay_in_place(skeleton, block, first, last, reading=reading).block
    before, after = (HubReader(skeleton, reading).read(one) for one in (block, made))
    old = walked(skeleton, before.translations, before.rotations)[0]
    new = walked(skeleton, after.translations, after.rotations)[0]
    size = np.ptp(old[0], axis=0).max()
    (carrier,) = carriers(skeleton, before.translations)
    moved = (new - old)[:, carrier:]
    # All joints of a frame, without a fixed root, move by the same way over the ground, none before the range.
    assert np.abs(moved - moved[:, :1]).max() < 1e-5 * size
    assert np.abs(moved[..., 1]).max() < 1e-5 * size
    assert np.array_equal(in_columns(made, skeleton.columns())[:first], in_columns(block, skeleton.columns())[:first])
    path = ground_path(skeleton, made, reading=reading)[first : last + 1]
    assert np.ptp(path, axis=0).max() < 1e-5 * size
    # Later frames travel as they did.
    assert np.abs(moved[last:] - moved[last]).max() < 1e-5 * size
    assert np.abs(ground_path(skeleton, block, reading=reading)[last]).max() > 0.2 * size


@pytest.mark.parametrize("convention", [Convention.LISTED, Convention.FIXED, Convention.BASE])
@fuzz.examples(6)
@given(seed=st.integers(0, 10_000))
def test_any_skeleton_stays_in_place(convention: Convention, seed: int) -> None:
    skeleton, blocks, reading = smooth_clip(seed, convention)
    block = blocks[2]
    last = len(block) - 2
    made = stay_in_place(skeleton, block, 1, last, reading=reading)
    if made.shortfall.notices(skeleton):
        return  # A root whose channels cannot hold any place says so.
    path = ground_path(skeleton, made.block, reading=reading)
    size = max(1.0, np.abs(ground_path(skeleton, block, reading=reading)).max())
    assert np.abs(path[1 : last + 1] - path[1]).max() < 1e-6 * size


def test_gaps_of_markers_are_no_travel() -> None:
    skeleton = marker_skeleton(["LASI", "RASI", "SACR"])
    columns = skeleton.columns()
    values = np.tile(np.arange(len(columns), dtype=np.float64), (20, 1)) + np.arange(20)[:, None]
    values[5:9, :3] = np.nan
    block = FrameBlock(values, columns, (full_shape(columns),), np.arange(20, dtype=np.int64))
    made = in_columns(stay_in_place(skeleton, block, 0, 19).block, columns)
    assert np.array_equal(np.isnan(made), np.isnan(values))
    for (_, channel), column in zip(columns, made.T, strict=True):
        if channel in (0, 2):
            assert np.nanmax(column) == pytest.approx(np.nanmin(column))
