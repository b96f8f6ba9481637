"""Gaps: filled where other samples tell what is missing, near what was really there, and left alone elsewhere."""

from __future__ import annotations

import numpy as np
import pytest

from mcml.motion.clip import FrameBlock, full_shape
from mcml.motion.edits.gap_filling import _Donors, fill_gaps
from mcml.motion.markers import marker_skeleton
from mcml.motion.rotation_vectors import from_vector
from mcml.motion.rotations import rotate
from mcml.motion.skeleton import Array, Skeleton

FRAMES = 200


def block_of(skeleton: Skeleton, values: Array) -> FrameBlock:
    columns = skeleton.columns()
    return FrameBlock(values, columns, (full_shape(columns),), np.arange(1, len(values) + 1))


def segment(count: int = 5) -> Array:
    """(FRAMES, count, 3) markers of a stiff segment that tumbles along a curve."""
    rng = np.random.default_rng(3)
    arms = rng.normal(size=(count, 3)) * 80
    seconds = np.arange(FRAMES) / 100
    way = np.stack([900 * seconds, 200 * np.sin(5 * seconds), 50 * np.cos(3 * seconds)], axis=1)
    turns = from_vector(np.stack([np.sin(4 * seconds), 0.7 * np.cos(3 * seconds), 2 * seconds], axis=1))
    return np.stack([way + rotate(turns, np.tile(arm, (FRAMES, 1))) for arm in arms], axis=1)


def fill(positions: Array, short: int = 10, longest: int = 100, names: list[str] | None = None):  # type: ignore[no-untyped-def]
    count = positions.shape[1]
    skeleton = marker_skeleton(names or [f"M{place}" for place in range(count)])
    block = block_of(skeleton, positions.reshape(FRAMES, -1))
    filled = fill_gaps(skeleton, block, slice(0, FRAMES), short, longest)
    return filled, filled.block.values.reshape(FRAMES, count, 3)


def test_a_short_gap_is_a_spline() -> None:
    true = segment()
    holed = true.copy()
    holed[50:58, 0] = np.nan
    filled, found = fill(holed)
    assert filled.counts == {"spline": 8}
    assert np.abs(found[50:58, 0] - true[50:58, 0]).max() < 0.05
    assert np.array_equal(np.delete(found, np.s_[50:58], 0), np.delete(true, np.s_[50:58], 0))


def test_a_long_gap_follows_the_segment() -> None:
    true = segment()
    holed = true.copy()
    holed[40:110, 2] = np.nan
    filled, found = fill(holed)
    assert filled.counts == {"segment": 70}
    assert np.abs(found - true).max() < 1e-6


def test_without_three_others_the_nearest_tells() -> None:
    true = segment(2)
    # Both are close together, and a third is far away.
    true[:, 1] = true[:, 0] + [20, 5, 0] + np.sin(np.arange(FRAMES) / 9)[:, None]
    holed = true.copy()
    holed[40:80, 1] = np.nan
    filled, found = fill(holed)
    assert filled.counts == {"nearby marker": 40}
    assert np.abs(found[40:80, 1] - true[40:80, 1]).max() < 3
    assert np.abs(np.diff(found[:, 1], axis=0) - np.diff(true[:, 1], axis=0)).max() < 1


@pytest.mark.parametrize("gap", [slice(0, 9), slice(190, 200), slice(30, 190)])
def test_ends_and_what_is_too_long_stay(gap: slice) -> None:
    holed = segment()
    holed[gap, 1] = np.nan
    filled, found = fill(holed)
    assert not filled.counts
    assert np.array_equal(found, holed, equal_nan=True)
    assert filled.left == (160 if gap.start == 30 else 0)


def test_unrelated_markers_tell_nothing() -> None:
    rng = np.random.default_rng(0)
    holed = np.cumsum(rng.normal(size=(FRAMES, 4, 3)) * 30, axis=0)
    holed[50:90, 0] = np.nan
    filled, found = fill(holed)
    assert filled.left == 40
    assert np.isnan(found[50:90, 0]).all()


def test_three_on_a_line_tell_no_rotation() -> None:
    true = segment(3)
    middle = (true[:, 0] + true[:, 1]) / 2
    true = np.stack([true[:, 0], true[:, 1], middle, true[:, 2]], axis=1)
    holed = true.copy()
    holed[40:110, 3] = np.nan
    filled, _ = fill(holed)
    assert "segment" not in filled.counts


def test_filled_markers_have_the_residual_of_interpolation() -> None:
    true = segment(3)
    skeleton = marker_skeleton(["A", "B", "C"], residual=True)
    values = np.concatenate([true, np.full((FRAMES, 3, 1), 0.7)], axis=2)
    values[50:55, 1] = np.nan
    filled = fill_gaps(skeleton, block_of(skeleton, values.reshape(FRAMES, -1)), slice(0, FRAMES), 10, 100)
    residuals = filled.block.values.reshape(FRAMES, 3, 4)[:, 1, 3]
    assert (residuals[50:55] == 0).all()
    assert (np.delete(residuals, np.s_[50:55]) == 0.7).all()


def test_only_the_rows_asked_for_change() -> None:
    holed = segment()
    holed[20:25, 0] = np.nan
    holed[120:125, 0] = np.nan
    skeleton = marker_skeleton([f"M{place}" for place in range(5)])
    filled = fill_gaps(skeleton, block_of(skeleton, holed.reshape(FRAMES, -1)), slice(100, 150), 10, 100)
    found = filled.block.values.reshape(FRAMES, 5, 3)
    assert np.isnan(found[20:25, 0]).all()
    assert np.isfinite(found[120:125, 0]).all()


@pytest.mark.slow
def test_many_markers_with_many_gaps_are_compared_with_few() -> None:
    """Work grows with the number of gaps, not with its square, nor with that of markers."""
    rng = np.random.default_rng(2)
    arms = rng.normal(size=(300, 3)) * 100
    way = np.stack([np.arange(FRAMES) * 5.0, np.zeros(FRAMES), np.zeros(FRAMES)], axis=1)
    true = way[:, None] + arms
    holed = true.copy()
    for marker in range(300):
        start = 20 + marker % 7 * 20
        holed[start : start + 15, marker] = np.nan
    compared: list[tuple[int, int]] = []
    spread = _Donors._spread

    def count(donors: _Donors, own: int, other: int) -> tuple[float, float]:
        compared.append((own, other))
        return spread(donors, own, other)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_Donors, "_spread", count)
        filled, found = fill(holed, short=5)
    assert filled.counts == {"segment": 300 * 15}
    assert np.abs(found - true).max() < 1e-6
    assert len(compared) <= 300 * 30
