"""Feet that stand stay where they stand: on made courses, and in real clips."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.motion.feet.legs import legs_of
from mcml.motion.feet.locking import Contacts, FootReport, foot_contacts, lock_feet, move_feet
from mcml.motion.feet.moves import hold_moves, spread_moves
from mcml.motion.hub import HubReader, walked
from mcml.motion.hub_writer import HubWriter
from mcml.motion.skeleton import Array, Convention, Joint, Skeleton
from mcml.numerics.runs import find_true
from tests.motion.test_retarget import taken

UP = np.array([0.0, 1.0, 0.0])


@given(seed=st.integers(0, 100_000))
def test_the_standing_part_of_a_foot_does_not_slide(seed: int) -> None:
    """The heel stands first, then the toe too, then the toe alone; each drifts while it stands."""
    rng = np.random.default_rng(seed)
    toe, ankle = rng.normal(0, 0.01, (2, 40, 3)).cumsum(axis=1)
    heel_end, toe_start = sorted(rng.integers(12, 28, 2))[::-1]
    ankle_stands, toe_stands = np.zeros((2, 40), dtype=bool)
    ankle_stands[8 : heel_end + 1], toe_stands[toe_start:33] = True, True
    moves = hold_moves(toe, ankle, toe_stands, ankle_stands, UP, np.inf)
    inside = ankle_stands | toe_stands
    assert (np.isnan(moves[:, 0]) == ~inside).all()
    assert np.abs(moves[inside] @ UP).max() < 1e-12
    assert np.abs(moves[inside].mean(axis=0)).max() < 1e-12
    flat = np.array([1.0, 0.0, 1.0])
    toe_steps, ankle_steps = (np.diff((part + moves) * flat, axis=0) for part in (toe, ankle))
    assert np.abs(toe_steps[toe_start:32]).max() < 1e-12
    assert np.abs(ankle_steps[8:toe_start]).max() < 1e-12
    # A foot that slides further than feet do by mistake is left alone.
    assert np.isnan(hold_moves(toe, ankle, toe_stands, ankle_stands, UP, 1e-6)).all()


@given(seed=st.integers(0, 100_000), fade=st.integers(1, 12))
def test_moves_spread_without_leaps(seed: int, fade: int) -> None:
    rng = np.random.default_rng(seed)
    slope, start = rng.normal(size=(2, 3)) * 0.01
    moves = np.full((80, 3), np.nan)
    spans = [(20, 30), (30 + int(rng.integers(2, 30)), 65)]
    for first, end in spans:
        moves[first:end] = start + slope * np.arange(end - first)[:, None]
    whole = spread_moves(moves, fade)
    known = ~np.isnan(moves[:, 0])
    assert (whole[known] == moves[known]).all()
    assert (whole[: 20 - fade] == 0).all()
    assert (whole[65 + fade :] == 0).all()
    # Speed has no leap: second differences are small beside those of a sudden stop, for fades of several frames.
    largest = np.abs(moves[known]).max() + 10 * np.abs(slope).max()
    gap = min(fade, (spans[1][0] - 30) / 2)
    assert np.abs(np.diff(whole, 2, axis=0)).max() <= 40 * largest / max(gap, 1.0)
    assert (spread_moves(np.full((9, 3), np.nan), fade) == 0).all()


def skeleton_with(*names: tuple[str, int]) -> Skeleton:
    return Skeleton(
        tuple(Joint(name, parent, name, Convention.LISTED, offset=("0", "-1", "0")) for name, parent in names)
    )


def test_legs_may_have_joints_between() -> None:
    skeleton = skeleton_with(
        ("hips", -1), ("left_up_leg", 0), ("twist", 1), ("left_low_leg", 2), ("left_foot", 3), ("left_toes", 4),
        ("right_up_leg", 0), ("right_foot", 6), ("right_low_leg", 7),
    )  # fmt: skip
    (leg,) = legs_of(skeleton)
    assert (leg.side, leg.hip, leg.knee, leg.ankle, leg.toe) == ("left", 1, 3, 4, 5)


CLIPS = [
    ("bvh/bandai/dataset-1_walk_normal_001.bvh", 1 / 30),
    ("bvh/dance/131_01.bvh", 1 / 120),
    ("asfamc/cmu16/16_15.amc", 1 / 120),
    ("asfamc/cmu_misc/09_06-run.amc", 1 / 120),
]


def speeds_of(positions: Array, joint: int, frame_time: float) -> Array:
    steps = np.diff(positions[:, joint], axis=0)
    speeds: Array = np.linalg.norm(steps - np.outer(steps @ UP, UP), axis=1) / frame_time
    return speeds


@pytest.mark.parametrize(("name", "frame_time"), CLIPS)
def test_feet_of_real_clips_are_held(shared: Path, name: str, frame_time: float) -> None:
    skeleton, block, reading = taken(shared / name)
    hub = HubReader(skeleton, reading).read(block)
    before = walked(skeleton, hub.translations, hub.rotations)[0]
    legs = legs_of(skeleton)
    assert len(legs) == 2
    size = legs[0].length(before)
    stands = [foot_contacts(before, leg.toe, leg.ankle, frame_time, size, UP) for leg in legs]
    locked = lock_feet(
        skeleton, legs, stands, hub.translations, hub.rotations, frame_time, UP, HubWriter(skeleton, reading)
    )
    after = walked(skeleton, locked.translations, locked.rotations)[0]
    for leg, stand, report in zip(legs, stands, locked.reports, strict=True):
        assert report.missed < 0.002
        assert report.shortcomings() == []
        inside = stand.any[1:] & stand.any[:-1]
        held = [
            np.minimum(speeds_of(at, leg.toe, frame_time), speeds_of(at, leg.ankle, frame_time))[inside]
            for at in (before, after)
        ]
        # Speeds in leg lengths a second: 0.011 is 1 cm/s of a person.
        assert np.percentile(held[1], 95) < 0.011 * size
        assert held[1].mean() < 0.1 * held[0].mean()
        assert np.linalg.norm(after[:, leg.toe] - before[:, leg.toe], axis=1).max() < 0.3 * size
        for one, two in ((leg.hip, leg.knee), (leg.knee, leg.ankle), (leg.ankle, leg.toe)):
            bones = [np.linalg.norm(at[:, one] - at[:, two], axis=1) for at in (before, after)]
            assert np.abs(bones[0] - bones[1]).max() < 1e-9 * size
    # Frames far from any contact keep their bits.
    near = np.zeros(len(block), dtype=bool)
    for stand in stands:
        for first, end in find_true(stand.any).tolist():
            near[max(0, first - round(0.4 / frame_time)) : end + round(0.4 / frame_time)] = True
    assert (locked.rotations[~near] == hub.rotations[~near]).all()
    assert (locked.translations[~near] == hub.translations[~near]).all()
    # The body sinks smoothly, and only a little.
    sunk = (before - after)[:, legs[0].hip] @ UP
    assert -1e-9 < sunk.min() <= sunk.max() < 0.08 * size


def test_nothing_to_lock_changes_nothing(shared: Path) -> None:
    skeleton, block, reading = taken(shared / CLIPS[0][0])
    hub = HubReader(skeleton, reading).read(block)
    legs = legs_of(skeleton)
    stands = [foot_contacts(np.zeros((0, len(skeleton), 3)), leg.toe, leg.ankle, 1 / 30, 1.0, UP) for leg in legs]
    empty = lock_feet(
        skeleton, legs, stands, hub.translations[:0], hub.rotations[:0], 1 / 30, UP, HubWriter(skeleton, reading)
    )
    assert len(empty.rotations) == 0
    assert all(report.contacts == () and report.missed == 0 for report in empty.reports)


def test_shortcomings_are_told(shared: Path) -> None:
    """A foot that slides all the time is left alone; one that nothing lets reach is told."""
    skeleton, block, reading = taken(shared / CLIPS[0][0])
    hub = HubReader(skeleton, reading).read(block)
    leg = legs_of(skeleton)[0]
    always = Contacts(np.ones(len(block), dtype=bool), np.zeros(len(block), dtype=bool))
    locked = lock_feet(
        skeleton, [leg], [always], hub.translations, hub.rotations, 1 / 30, UP, HubWriter(skeleton, reading)
    )
    assert locked.reports[0].shortcomings() == ["1 contacts slide too far and are left alone"]
    assert (locked.rotations == hub.rotations).all()
    # Half a leg lower is more than lowering the body gives.
    places = walked(skeleton, hub.translations, hub.rotations)[0]
    size = leg.length(places)
    moves = [np.tile(-0.5 * size * UP, (len(block), 1))]
    *_, missed = move_feet(
        skeleton, [leg], moves, hub.translations, hub.rotations, 1 / 30, UP, HubWriter(skeleton, reading)
    )
    assert missed[0] > 0.3 * size
    told = FootReport(leg.toe, (), 0.0, 0.0, float(missed[0]) / size).shortcomings()
    assert len(told) == 1
    assert "misses its place by up to 0." in told[0]
