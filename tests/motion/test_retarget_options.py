"""Options of retargeting: travel, limits of joints, contacts of hands; and errors of parts of the body."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.motion.clip import FrameBlock
from mcml.motion.frames import joined, leave_out, rows_of
from mcml.motion.hub import HubReader
from mcml.motion.hub_writer import HubWriter
from mcml.motion.kinematics import unseen
from mcml.motion.retargeting.bone_mapping import suggest_matches
from mcml.motion.retargeting.hand_contacts import fade_weights
from mcml.motion.retargeting.limits import clamp_joint, file_limits
from mcml.motion.retargeting.retarget import Retargeted, retarget
from mcml.motion.rotation_vectors import angle_between
from mcml.motion.rotations import from_euler
from mcml.motion.skeleton import Array, Convention, Joint, Skeleton
from mcml.motion.units import Reading
from mcml_service.demo import body
from tests.builders import assign
from tests.motion.test_retarget import taken
from tests.poses import chosen_frames, global_positions

FACTORS = st.floats(0.2, 5.0)


def person(height: float) -> tuple[Skeleton, FrameBlock]:
    clip = body.clip("walk", height, *body.walk(height, 1.0, 1.0, 6.0))
    return assign(clip.head.skeleton), joined(clip.blocks())


def made_of(source: Skeleton, block: FrameBlock, target: Skeleton, **options: object) -> Retargeted:
    return retarget(source, block, target, suggest_matches(source, target), 1 / 60, **options)  # type: ignore[arg-type]


@given(FACTORS)
def test_travel_is_scaled_along_the_ground_alone(factor: float) -> None:
    (source, block), (target, _) = person(160.0), person(184.0)
    usual, made = (made_of(source, block, target, travel_scale=each) for each in (None, factor))
    one, two = (global_positions(target, each.block)[:, 0] for each in (usual, made))
    np.testing.assert_allclose(two[:, 1], one[:, 1], atol=1e-6)
    np.testing.assert_allclose(two[:, [0, 2]], one[:, [0, 2]] * factor / usual.report.scale, atol=1e-6)
    assert (made.report.scale, made.report.travel) == (usual.report.scale, factor)


def test_joints_stay_inside_the_limits_of_their_file(shared: Path) -> None:
    """CMU's files state limits; a dance on that body leaves them, and is told where."""
    target, shown, target_reading = taken(next(shared.rglob("16_15.amc")))
    source, block, reading = taken(shared / "bvh/dance/Gangnam-Style.bvh")
    block = chosen_frames(block, np.arange(0, 240, 2))
    writer = HubWriter(target, target_reading)
    limits = file_limits(target, writer)
    assert len(limits) > 20
    options = {"reading": reading, "target_reading": target_reading, "target_block": shown}
    free, made = (made_of(source, block, target, limits=each, **options) for each in (None, limits))
    assert free.report.clamped == ()
    rotations, unlimited = (HubReader(target, target_reading).read(each.block).rotations for each in (made, free))
    outside = {}
    for joint, limit in limits.items():
        assert clamp_joint(limit, joint, writer, rotations[:, joint])[1].max() < 1e-6, target.names[joint]
        outside[joint] = clamp_joint(limit, joint, writer, unlimited[:, joint])[1].max()
    assert max(outside.values()) > 5
    told = {each.joint: each for each in made.report.clamped}
    # The first joint of a limb is as far outside as without limits; those below make up for it.
    highest = min(joint for joint, angle in outside.items() if angle > 1)
    assert told[highest].largest == pytest.approx(outside[highest], abs=1e-6)
    assert any("inside its limits" in notice.what for notice in made.report.notices(source, target))


@given(st.integers(0, 1000), st.sampled_from(["XYZ", "ZXY", "ZY", "X"]))
def test_limited_rotations_are_inside_and_inner_ones_stay(seed: int, letters: str) -> None:
    rng = np.random.default_rng(seed)
    channels = tuple(f"R{letter.lower()}" for letter in letters)
    writer = HubWriter(Skeleton((Joint("a", -1, "a", Convention.LISTED, channels, letters),)))
    edges = np.sort(rng.uniform(-80, 80, (len(letters), 2)), axis=1)
    inner = from_euler(np.radians(rng.uniform(edges[:, 0], edges[:, 1], (20, len(letters)))), letters)
    held, outside = clamp_joint(edges, 0, writer, inner)
    assert outside.max() < 1e-6
    assert np.degrees(angle_between(held, inner)).max() < 1e-6
    wild = from_euler(np.radians(rng.uniform(-180, 180, (20, len(letters)))), letters)
    held, outside = clamp_joint(edges, 0, writer, wild)
    assert clamp_joint(edges, 0, writer, held)[1].max() < 1e-6
    assert (np.degrees(angle_between(held, wild)) <= outside + 1e-6).all()


CLAPS = ["bvh/bandai/dataset-1_bow_happy_001.bvh", "bvh/dance/60_10_scaled.bvh", "bvh/dance/Gangnam-Style.bvh"]


def wrists(skeleton: Skeleton, block: FrameBlock) -> tuple[Array, float]:
    """Vectors (n, 3) from the right to the left hand, and the length of an arm."""
    places = global_positions(skeleton, block)
    names = list(skeleton.names)
    left, right = (
        names.index(f"{side}_wrist" if f"{side}_wrist" in names else f"{side}_hand") for side in ("left", "right")
    )
    arm = places[:, [names.index("left_up_arm"), names.index("left_low_arm"), left]]
    length = np.linalg.norm(np.diff(arm, axis=1), axis=2).sum(axis=1).mean()
    return places[:, left] - places[:, right], float(length)


@pytest.mark.parametrize("name", CLAPS)
@pytest.mark.parametrize("rig", ["bvh/exporters/rokoko_jesse_dance.bvh", "bvh/exporters/mixamo_freebvh.bvh"])
def test_hands_that_touch_stay_together(shared: Path, name: str, rig: str) -> None:
    source, block, reading = taken(shared / name)
    block = chosen_frames(block, np.arange(min(len(block), 500)))
    target, shown, target_reading = taken(shared / rig)
    options: dict[str, Reading | FrameBlock] = {
        "reading": reading, "target_reading": target_reading, "target_block": chosen_frames(shown, np.arange(40)),
    }  # fmt: skip
    free, made = (made_of(source, block, target, keep_hands=keep, **options) for keep in (False, True))
    assert free.report.hands == ()
    hands = {index for index, joint in enumerate(target.joints) if joint.name.endswith(("_hand", "_wrist"))}
    claps = [each for each in made.report.hands if each.other in hands]
    assert claps
    wanted, _ = wrists(source, block)
    ratio = free.report.scale
    before, after = (wrists(target, each.block) for each in (free, made))
    for clap in claps:
        rows = slice(clap.first, clap.last + 1)
        missed = np.linalg.norm(after[0][rows] - ratio * wanted[rows], axis=1)
        uncorrected = np.linalg.norm(before[0][rows] - ratio * wanted[rows], axis=1)
        assert uncorrected.max() == pytest.approx(clap.before, rel=1e-6)
        assert missed.max() == pytest.approx(clap.after, abs=1e-6 * after[1])
        assert clap.is_missed or missed.max() < 0.02 * after[1]
    assert sum(each.is_missed for each in claps) < len(claps)
    # Nothing but arms moves.
    one, two = (HubReader(target, target_reading).read(each.block).rotations for each in (free, made))
    arms = [index for index, each in enumerate(target.names) if each.endswith(("_arm", "_hand", "_wrist"))]
    others = np.setdiff1d(np.arange(len(target)), arms)
    np.testing.assert_allclose(one[:, others], two[:, others], atol=1e-9)


def test_hands_on_a_body_of_the_same_shape_stay_as_they_are(shared: Path) -> None:
    """A larger body of the same proportions has all contacts already."""
    source, block, reading = taken(shared / CLAPS[0])
    block = chosen_frames(block, np.arange(60))
    target = Skeleton(tuple(scale_joint(joint, 1.3) for joint in source.joints))
    free, made = (
        made_of(source, block, target, reading=reading, target_reading=reading, keep_hands=keep)
        for keep in (False, True)
    )
    assert made.report.hands
    assert max(each.before for each in made.report.hands) < 1e-3
    places = [global_positions(target, each.block) for each in (free, made)]
    np.testing.assert_allclose(places[0], places[1], atol=1e-2)


def scale_joint(joint: Joint, factor: float) -> Joint:
    return replace(joint, offset=tuple(repr(float(value) * factor) for value in joint.offset))  # type: ignore[arg-type]


def test_corrections_of_hands_fade() -> None:
    weights = fade_weights(20, 8, 10, 4)
    assert weights[8:11].tolist() == [1.0, 1.0, 1.0]
    assert weights[3] == weights[15] == 0.0
    assert (np.diff(weights[3:9]) > 0).all()
    assert weights[4:8].tolist() == pytest.approx(weights[14:10:-1].tolist())


def test_parts_of_the_body_are_measured() -> None:
    """Parts without matches are left out."""
    source, block = person(170.0)
    target, _ = person(180.0)
    made = made_of(source, block, target)
    parts = {part.what: part for part in made.report.parts}
    assert set(parts) == {
        "left arm", "right arm", "left leg", "right leg", "hips", "shoulders", "trunk", "head",
    }  # fmt: skip
    assert max(part.mean for part in parts.values()) < 0.1
    matches = [match for match in suggest_matches(source, target) if "arm" not in target.names[match.target]]
    less = retarget(source, block, target, matches, 1 / 60)
    assert not {"left arm", "shoulders", "trunk"} & {part.what for part in less.report.parts}


@given(st.integers(0, 59), st.integers(1, 20), st.sampled_from(["left_low_leg", "right_up_arm", "waist"]))
def test_a_gap_of_a_joint_stays_a_gap_below_it(first: int, length: int, joint: str) -> None:
    """What hangs from a joint without a sample is not known in the result either; the rest does not change."""
    (source, block), (target, _) = person(160.0), person(184.0)
    block = rows_of(block, 0, 60)
    known = np.ones((60, len(source)), dtype=bool)
    known[first : first + length, source.names.index(joint)] = False
    whole, made = made_of(source, block, target).block, made_of(source, leave_out(block, known), target).block
    lost = unseen(target, made)
    below = [name for name in target.names if joint in above(target, name)]
    for index, name in enumerate(target.names):
        expected = ~known[:, source.names.index(joint)] if name in below else np.zeros(60, dtype=bool)
        np.testing.assert_array_equal(lost[:, index], expected, err_msg=name)
    columns = [place for place, (index, _) in enumerate(made.columns) if target.names[index] not in below]
    rows = np.flatnonzero(known.all(axis=1))
    np.testing.assert_allclose(made.values[np.ix_(rows, columns)], whole.values[np.ix_(rows, columns)], atol=1e-6)


def above(skeleton: Skeleton, name: str) -> list[str]:
    """A joint and all above it."""
    found, index = [], skeleton.names.index(name)
    while index >= 0:
        found.append(skeleton.names[index])
        index = skeleton.joints[index].parent
    return found
