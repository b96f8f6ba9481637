"""Spikes: the Hampel identifier against a plain one, planted spikes found again, everything else bit by bit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mcml
from mcml.motion.edits.despiking import despike, find_spikes, from_neighbours
from mcml.motion.frames import joined
from mcml_service.demo import body
from tests.motion.matching.curved_walks import curved_walk


def plain(values: np.ndarray, deviations: float, window: int, small: float) -> np.ndarray:
    """The same, sample by sample."""
    half, flags = window // 2, np.zeros(len(values), dtype=bool)
    for row in range(len(values)):
        for column in range(values.shape[1]):
            around = values[max(0, row - half) : row + half + 1, column]
            around = around[~np.isnan(around)]
            if len(around) < 3 or np.isnan(values[row, column]):
                continue
            middle = np.median(around)
            away = abs(values[row, column] - middle)
            spread = 1.4826 * np.median(np.abs(around - middle))
            flags[row] |= away > deviations * spread and abs(values[row, column]) > small
    return flags


def told(values: np.ndarray, window: int) -> np.ndarray:
    """The medians of means of neighbours, sample by sample."""
    found, half = np.full(values.shape, np.nan), window // 2
    for row in range(len(values)):
        for column in range(values.shape[1]):
            inside = [by for by in range(1, half + 1) if row - by >= 0 and row + by < len(values)]
            means = [(values[row - by, column] + values[row + by, column]) / 2 for by in inside]
            means = [mean for mean in means if not np.isnan(mean)]
            if len(means) >= min(3, half):
                found[row, column] = np.median(means)
    return found


@given(st.integers(0, 2**32 - 1), st.sampled_from([3, 5, 7, 11]), st.floats(1, 8))
def test_the_identifier_is_the_plain_one(seed: int, window: int, deviations: float) -> None:
    rng = np.random.default_rng(seed)
    values = np.cumsum(rng.normal(size=(int(rng.integers(1, 40)), 3)), axis=0)
    values[rng.random(values.shape) < 0.1] += 20
    values[rng.random(len(values)) < 0.15] = np.nan
    small = float(rng.choice([0.0, 0.5]))
    assert find_spikes(values, deviations, window, small).tolist() == plain(values, deviations, window, small).tolist()
    assert from_neighbours(values, window) == pytest.approx(told(values, window), nan_ok=True)


@pytest.mark.parametrize("kind", ["root", "rotation"])
def test_planted_spikes_are_found_and_bridged(kind: str) -> None:
    clip = curved_walk(20.0)
    block, skeleton = joined(clip.blocks()), clip.head.skeleton
    rng = np.random.default_rng(3)
    planted = np.sort(rng.choice(np.arange(10, len(block) - 10, 6), 20, replace=False))
    joint = 0 if kind == "root" else skeleton.names.index("LeftForeArm")
    columns = [
        place for place, (one, channel) in enumerate(block.columns) if one == joint and (channel < 3) is (joint == 0)
    ]
    values = block.values.copy()
    values[np.ix_(planted, columns)] += rng.choice([-1, 1], (20, len(columns))) * rng.uniform(
        25, 60, (20, len(columns))
    )
    made = despike(skeleton, replace(block, values=values), slice(0, len(block)))
    assert made.frames == tuple(planted.tolist())
    assert made.counts == {joint: 20}
    others = np.setdiff1d(np.arange(len(block)), planted)
    assert (made.block.values[others] == values[others]).all()
    # Splines over the neighbours: the walk is known again within its own roughness.
    assert np.abs(made.block.values[planted] - block.values[planted]).max() < 1.5


def test_clean_motion_stays() -> None:
    for clip in (curved_walk(30.0), body.clip("wave", 170.0, *body.wave(170.0, 4.0, 1.5))):
        block = joined(clip.blocks())
        made = despike(clip.head.skeleton, block, slice(0, len(block)))
        assert not made.counts
        assert made.block is block


def test_only_the_rows_and_joints_that_are_asked_for() -> None:
    clip = curved_walk(0.0)
    block, skeleton = joined(clip.blocks()), clip.head.skeleton
    values = block.values.copy()
    values[[50, 150], 0] += 80
    spiky = replace(block, values=values)
    assert despike(skeleton, spiky, slice(100, 200)).frames == (150,)
    assert not despike(skeleton, spiky, slice(0, 300), joints=[3]).counts
    # At its very ends nothing is known on one side, and what is there tells nothing of its neighbours.
    values[0, 0] += 500
    made = despike(skeleton, replace(block, values=values), slice(0, 10))
    assert (made.frames, made.left) == ((), 0)


@pytest.mark.parametrize("name", ["body/HDM_dg_06-03_03_120.c3d", "body/mocap36.c3d"])
def test_planted_spikes_in_real_markers(shared: Path, name: str) -> None:
    motion = mcml.read(shared / "c3d" / name)
    clip = motion._clip
    block, skeleton = joined(clip.blocks()), clip.head.skeleton
    rows = slice(0, len(block))
    own = set(despike(skeleton, block, rows).frames)
    rng = np.random.default_rng(1)
    places = [place for place, (_, channel) in enumerate(block.columns) if channel == 0]
    known = np.isfinite(block.values[:, places])
    inner = np.lib.stride_tricks.sliding_window_view(known, 21, axis=0).all(axis=2)
    candidates = np.argwhere(inner) + np.array([10, 0])
    chosen = candidates[rng.choice(len(candidates), 60, replace=False)]
    values = block.values.copy()
    for row, marker in chosen:
        values[row, places[marker]] += rng.choice([-1, 1]) * rng.uniform(80, 200)
    made = despike(skeleton, replace(block, values=values), rows)
    planted = {int(row) for row, _ in chosen}
    assert len(planted & set(made.frames)) / len(planted) > 0.95
    assert len(set(made.frames) - planted - own) <= 0.05 * len(block)
