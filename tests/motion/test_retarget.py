"""A motion on another skeleton: nothing changes on the same one, sizes scale, bones point as they did, feet stand."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mcml.errors import ConversionError
from mcml.motion.clip import FrameBlock, full_shape
from mcml.motion.conventions.resizing import scale
from mcml.motion.frames import joined
from mcml.motion.hub import HubReader
from mcml.motion.hub_writer import HubWriter
from mcml.motion.lexemes import triple
from mcml.motion.retargeting.bone_mapping import Match, check_matches, suggest_matches
from mcml.motion.retargeting.hinges import best_twist
from mcml.motion.retargeting.limits import clamp_joint, joint_limits
from mcml.motion.retargeting.retarget import Retargeted, retarget
from mcml.motion.rotation_vectors import angle_between
from mcml.motion.rotations import from_euler, inverse, multiply
from mcml.motion.skeleton import Array, Convention, Joint, Skeleton, numbers
from mcml.motion.units import Reading, reading_of
from tests import fuzz
from tests.builders import assign
from tests.formats.test_real_files import opened
from tests.poses import chosen_frames, global_positions

CMU, BANDAI = "asfamc/cmu02/02_lf_01.amc", "bvh/bandai/dataset-1_walk_normal_001.bvh"
RATES = {CMU: 1 / 120, BANDAI: 1 / 30}
SAME = (CMU, BANDAI, "htr/xbot_walking.HTR", "bvh/exporters/Chicken_Walk.bvh",
        "bvh/exporters/perception_neuron_milad.bvh", "htr/egnaro_skel_anim.htr")  # fmt: skip
WALKS = ("asfamc/cmu_misc/07_05-walk.amc", CMU, "asfamc/cmu16/16_15.amc",
         "asfamc/hdm05_reach/HDM_bk_sneak2StepsLStart_006_120.AMC")  # fmt: skip


@cache
def taken(path: Path) -> tuple[Skeleton, FrameBlock, Reading]:
    clip = opened(path)
    return assign(clip.head.skeleton), joined(clip.blocks()), reading_of(clip.head)


def moved(shared: Path, name: str, target: Skeleton, reading: Reading, clean: bool = False) -> Retargeted:
    skeleton, block, own = taken(shared / name)
    return retarget(
        skeleton, block, target, suggest_matches(skeleton, target), RATES.get(name, 1 / 120),
        reading=own, target_reading=reading, clean=clean,
    )  # fmt: skip


@pytest.mark.parametrize("name", SAME)
def test_on_the_same_skeleton_nothing_changes(shared: Path, name: str) -> None:
    skeleton, block, reading = taken(shared / name)
    result = moved(shared, name, skeleton, reading)
    one, other = (HubReader(skeleton, reading).read(part) for part in (block, result.block))
    assert angle_between(one.rotations, other.rotations).max() < 1e-9
    size = np.abs(one.translations).max()
    assert np.abs(one.translations - other.translations).max() < 1e-9 * size
    assert result.report.scale == pytest.approx(1.0, abs=1e-14)
    assert result.report.missing == result.report.extra == ()
    assert list(result.block.ids) == list(block.ids)


@pytest.mark.parametrize("name", SAME)
@pytest.mark.parametrize("factor", [0.01, 3.7])
def test_on_a_scaled_skeleton_positions_scale(shared: Path, name: str, factor: float) -> None:
    skeleton, block, reading = taken(shared / name)
    clip = scale(opened(shared / name), factor)
    target = assign(clip.head.skeleton)
    result = moved(shared, name, target, reading_of(clip.head))
    before = global_positions(skeleton, block, reading) * factor
    after = global_positions(target, result.block, reading_of(clip.head))
    assert np.abs(after - before).max() < 1e-9 * np.abs(before).max()


def directions(skeleton: Skeleton, positions: Array, names: set[str]) -> dict[tuple[str, str], Array]:
    """Unit vectors (n, 3) from each named joint to the next named ones below it."""
    found = {}
    for index, joint in enumerate(skeleton.joints):
        above = joint.parent
        while above >= 0 and skeleton.names[above] not in names:
            above = skeleton.joints[above].parent
        vector = positions[:, index] - positions[:, above]
        length = np.linalg.norm(vector, axis=1, keepdims=True)
        if above >= 0 and joint.name in names and length.min() > 1e-3 * np.ptp(positions[0], axis=0).max():
            found[skeleton.names[above], joint.name] = vector / length
    return found


def apart(one: Array, other: Array) -> float:
    """The largest angle between directions (n, 3), degrees."""
    cross, dot = np.linalg.norm(np.cross(one, other), axis=1), (one * other).sum(axis=1)
    return float(np.degrees(np.arctan2(cross, dot)).max())


BRANCHES = {
    ("torso7", "left_shoulder"),
    ("torso7", "right_shoulder"),
    ("Root", "left_up_leg"),
    ("Root", "right_up_leg"),
}
"""A chest and a pelvis are one bone: they cannot point at the neck or the spine and at both sides, too."""


@pytest.mark.parametrize("name", WALKS)
def test_there_and_back_again_bones_point_as_they_did(shared: Path, name: str) -> None:
    skeleton, block, reading = taken(shared / name)
    target, _, target_reading = taken(shared / BANDAI)
    there = moved(shared, name, target, target_reading)
    matches = suggest_matches(target, skeleton)
    back = retarget(target, there.block, skeleton, matches, 1 / 120, reading=target_reading, target_reading=reading)
    names = {joint.name for joint in target.joints if joint.mapped} & set(skeleton.names)
    assert len(names) == 21
    first, second, third = (
        directions(rig, global_positions(rig, part, units), names)
        for rig, part, units in (
            (skeleton, block, reading), (target, there.block, target_reading), (skeleton, back.block, reading),
        )
    )  # fmt: skip
    kept = (set(first) & set(second)) - BRANCHES
    assert len(kept) >= 14
    for bone in kept:
        assert apart(first[bone], second[bone]) < 1e-3, bone
        assert apart(first[bone], third[bone]) < 0.1, bone
    for bone in {("Root", "left_up_leg"), ("Root", "right_up_leg")}:
        assert apart(first[bone], third[bone]) < 1e-3
    # The rest is reported, as it is.
    told = {(target.names[bone.joint], target.names[bone.end]): bone for bone in there.report.bones}
    assert set(told) >= set(second) & set(first)
    for bone in set(told) & set(first):
        assert told[bone].largest == pytest.approx(apart(first[bone], second[bone]), abs=1e-6)
        assert told[bone].mean <= told[bone].largest
        assert told[bone].leads == (bone not in BRANCHES)
    # And the body is where it was, but for bones that only one of the two has.
    height = np.ptp(global_positions(skeleton, block, reading)[0, :, 1])
    hips = [skeleton.names.index(joint) for joint in ("left_up_leg", "right_up_leg")]
    places = [global_positions(skeleton, part, reading)[:, hips].mean(axis=1) for part in (block, back.block)]
    assert np.abs(places[0] - places[1]).max() < 1e-6 * height


@pytest.mark.parametrize("name", WALKS)
def test_feet_that_stand_slide_less_when_cleaned(shared: Path, name: str) -> None:
    target, _, reading = taken(shared / BANDAI)
    plain, clean = (moved(shared, name, target, reading, clean=flag) for flag in (False, True))
    assert [foot.joint for foot in clean.report.feet] == [target.names.index(f"{s}_toes") for s in ("left", "right")]
    before, after = (global_positions(target, result.block) for result in (plain, clean))
    slid = [0.0, 0.0]
    for foot, untouched in zip(clean.report.feet, plain.report.feet, strict=True):
        assert foot.contacts == untouched.contacts
        assert untouched.after == untouched.before == pytest.approx(foot.before)
        for place, positions in enumerate((before, after)):
            own = 0.0
            for first, last in foot.contacts:
                steps = np.diff(positions[first : last + 1, foot.joint][:, [0, 2]], axis=0)
                own += np.linalg.norm(steps, axis=1).sum()
            slid[place] += own
            assert (foot.before, foot.after)[place] == pytest.approx(own, abs=1e-6 * np.ptp(positions[..., 1]))
    assert slid[1] <= 0.2 * slid[0]
    assert slid[0] > 0
    # Bones keep their lengths; everything but the legs stays, or sinks a little with the body.
    legs = {f"{side}_{part}" for side in ("left", "right") for part in ("low_leg", "foot", "toes")}
    others = [index for index, joint in enumerate(target.names) if joint not in legs]
    body = target.names.index("Root")
    sunk = (before[:, body] - after[:, body])[:, None]
    assert np.abs(before[:, others[1:]] - after[:, others[1:]] - sunk).max() < 1e-9 * np.abs(before).max()
    assert np.abs(sunk[..., [0, 2]]).max() < 1e-9 * np.abs(before).max()
    assert -1e-9 <= sunk.min() <= sunk.max() < 0.04 * np.ptp(before[0, :, 1])
    assert np.ptp(np.diff(sunk[:, 0, 1], axis=0)) < 0.01 * np.ptp(before[0, :, 1])
    # No leap: feet are moved smoothly.
    toes = [foot.joint for foot in clean.report.feet]
    fastest = [np.linalg.norm(np.diff(positions[:, toes], axis=0), axis=2).max() for positions in (before, after)]
    assert fastest[1] < 1.25 * fastest[0]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["bvh/bandai/dataset-1_walk_normal_001.bvh", "bvh/bandai/dataset-1_walk_tired_001.bvh",
                                  "bvh/bandai/dataset-1_walk_old_001.bvh"])  # fmt: skip
def test_feet_of_a_body_with_hinges_are_held_too(shared: Path, name: str) -> None:
    """Onto CMU's skeleton, whose knees bend about one axis only."""
    target, _, reading = taken(shared / CMU)
    skeleton, block, own = taken(shared / name)
    result = retarget(
        skeleton, block, target, suggest_matches(skeleton, target), 1 / 30,
        reading=own, target_reading=reading, clean=True,
    )  # fmt: skip
    before, after = (sum(getattr(foot, when) for foot in result.report.feet) for when in ("before", "after"))
    assert before > 0
    assert after <= 0.2 * before


@pytest.mark.parametrize("name", ["bvh/bandai/dataset-1_walk_normal_001.bvh", "bvh/bandai/dataset-1_walk_angry_001.bvh",
                                  "bvh/bandai/dataset-1_bye_normal_001.bvh"])  # fmt: skip
def test_limbs_are_turned_so_that_hinges_can_bend(shared: Path, name: str) -> None:
    """Knees and elbows of the target bend about one axis; the rest pose of the source does not say how limbs lie."""
    target, _, target_reading = taken(shared / CMU)
    skeleton, block, reading = taken(shared / name)
    result = retarget(
        skeleton, block, target, suggest_matches(skeleton, target), 1 / 30,
        reading=reading, target_reading=target_reading,
    )  # fmt: skip
    limbs = [bone for bone in result.report.bones if bone.leads and "low_" in target.names[bone.joint]]
    assert len(limbs) == 4
    assert max(bone.mean for bone in limbs) < 1.0
    # No knee bends forward: its limits say -10 to 170 degrees.
    values = result.block.values[:, target.columns().index((target.names.index("left_low_leg"), 3))]
    assert values.min() > -10
    assert values.max() < 170


def test_the_best_turn_is_found() -> None:
    def error(angle: float, best: float = 2.345) -> float:
        return float(np.degrees(abs((angle - best + np.pi) % (2 * np.pi) - np.pi)))

    assert best_twist(error) == pytest.approx(2.345, abs=1e-3)
    assert best_twist(lambda angle: error(angle, 0.01)) == 0.0


def test_limits_are_those_of_the_file() -> None:
    knee = Joint("knee", -1, "knee", Convention.FIXED, ("Rx",), "X", axis=("0", "0", "20"), axis_order="XYZ",
                 limits=("-10.0 170.0",))  # fmt: skip
    writer = HubWriter(Skeleton((knee,)))
    turn = writer.rest.orientations[0]
    angles = np.array([-30.0, -10.0, 0.0, 170.0, 175.0])
    local = multiply(multiply(turn, from_euler(np.radians(angles)[:, None], "X")), inverse(turn))
    limits = joint_limits(knee, "X")
    assert limits is not None
    held, outside = clamp_joint(limits, 0, writer, local)
    assert outside == pytest.approx([20, 0, 0, 0, 5], abs=1e-9)
    assert np.array_equal(held[1:4], local[1:4])
    assert np.degrees(angle_between(held, local)) == pytest.approx(outside, abs=1e-6)
    assert clamp_joint(limits, 0, writer, held)[1] == pytest.approx(0, abs=1e-9)
    assert joint_limits(replace(knee, limits=()), "X") is None
    assert joint_limits(replace(knee, limits=("-inf what",)), "X") is None


def tree(seed: int) -> tuple[Skeleton, Skeleton]:
    """A chain of joints and the same with other bones, turned otherwise at rest."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 7))
    names = ("Root", "left_up_leg", "left_low_leg", "left_foot", "left_toes", "left_toe_one", "left_toe_two")[:count]

    def made() -> Skeleton:
        return Skeleton(
            tuple(
                Joint(
                    name, place - 1, f"{name}_{seed}", Convention.LISTED,
                    (() if place else ("Tx", "Ty", "Tz")) + ("Rz", "Rx", "Ry"), "ZXY",
                    offset=triple(rng.normal(size=3) * rng.uniform(1, 9) * bool(place)),
                    translation="" if place else "absolute", mapped=True,
                )
                for place, name in enumerate(names)
            )
        )  # fmt: skip

    return made(), made()


@fuzz.examples(30)
@given(seed=st.integers(0, 100_000))
def test_chains_of_any_rest_pose_point_alike(seed: int) -> None:
    source, target = tree(seed)
    rng = np.random.default_rng(seed)
    columns = source.columns()
    block = FrameBlock(rng.uniform(-180, 180, (6, len(columns))), columns, (full_shape(columns),), np.arange(6))
    result = retarget(source, block, target, suggest_matches(source, target), 0.01)
    names = set(source.names)
    one = directions(source, global_positions(source, block), names)
    other = directions(target, global_positions(target, result.block), names)
    for bone, vectors in one.items():
        assert apart(vectors, other[bone]) < 1e-6
    # No twist of its own: what a bone turns relative to its rest direction is the source's turn, carried over.
    hub, made = HubReader(source).read(block), HubReader(target).read(result.block)
    last = len(source) - 1
    for frame in range(5):
        turns = []
        for part in (hub, made):
            steps = [Rotation.from_quat(part.rotations[row, : last + 1]) for row in (frame, frame + 1)]
            world = [np.prod([turn[joint] for joint in range(last + 1)]) for turn in steps]
            turns.append((world[1] * world[0].inv()).magnitude())
        assert turns[0] == pytest.approx(turns[1], abs=1e-6)


def test_poses_that_show_the_same_make_up_for_rest_poses_that_do_not() -> None:
    """An arm that hangs at rest and one that is held out: with poses given, the rest does not matter."""
    source, target = tree(11)
    rng = np.random.default_rng(0)
    pose = Rotation.random(len(source), random_state=rng).as_quat()
    columns = source.columns()
    block = FrameBlock(rng.uniform(-90, 90, (4, len(columns))), columns, (full_shape(columns),), np.arange(4))
    result = retarget(source, block, source, suggest_matches(source, source), 0.01, source_pose=pose, target_pose=pose)
    one, other = (HubReader(source).read(part) for part in (block, result.block))
    assert angle_between(one.rotations, other.rotations).max() < 1e-9
    turned = retarget(source, block, target, suggest_matches(source, target), 0.01, source_pose=pose)
    plain = retarget(source, block, target, suggest_matches(source, target), 0.01)
    rotations = [HubReader(target).read(part.block).rotations for part in (turned, plain)]
    assert angle_between(*rotations).max() > 0.1


def test_matches_have_reasons() -> None:
    def rig(*names: tuple[str, str, int, bool]) -> Skeleton:
        return Skeleton(
            tuple(
                Joint(name, parent, source, Convention.LISTED, mapped=mapped) for name, source, parent, mapped in names
            )
        )

    one = rig(
        ("Root", "Hips", -1, True),
        ("waist", "Spine", 0, True),
        ("left_wrist", "lw", 1, True),
        ("Tail", "tail", 0, False),
    )
    two = rig(
        ("Root", "pelvis", -1, True),
        ("torso7", "x", 0, True),
        ("left_hand", "lh", 1, True),
        ("t", "m:Tail", 1, False),
        ("Head", "head", 1, True),
    )
    found = {match.target: match for match in suggest_matches(one, two)}
    assert sorted(found) == [0, 1, 2, 3]
    assert [found[index].source for index in range(4)] == [0, 1, 2, 3]
    assert found[0].confidence == 1.0
    assert found[1].confidence == found[2].confidence == 0.6
    assert found[3].confidence == 0.45
    assert "elsewhere" in found[3].reason
    assert [match.confidence for match in suggest_matches(one, one)] == [1.0] * 4


def test_a_mapping_may_be_changed_but_not_into_nonsense(shared: Path) -> None:
    skeleton, block, reading = taken(shared / CMU)
    target, _, target_reading = taken(shared / BANDAI)
    matches = [m for m in suggest_matches(skeleton, target) if not target.names[m.target].startswith("left_")]
    result = retarget(skeleton, chosen_frames(block, np.arange(9)), target, matches, 1 / 120, reading=reading)
    extra = {target.names[index] for index in result.report.extra}
    assert {"left_up_arm", "left_foot", "joint_Root"} <= extra
    told = [notice.what for notice in result.report.notices(skeleton, target)]
    assert any("left_up_arm" in line for line in told)
    rest = [index for index, name in enumerate(target.names) if name.startswith("left_")]
    turned = HubReader(target, target_reading).read(result.block).rotations[:, rest]
    assert np.abs(turned[..., :3]).max() < 1e-9
    for wrong in ([], [Match(0, 99, 1, "")], [Match(0, 1, 1, ""), Match(1, 1, 1, "")]):
        with pytest.raises(ConversionError):
            retarget(skeleton, block, target, wrong, 1 / 120)
    check_matches(skeleton, target, [Match(0, 1, 1, ""), Match(0, 2, 1, "")])


def test_other_units_are_only_a_scale(shared: Path) -> None:
    """The same body in millimetres: places times a thousand, whatever the legs are called."""
    clip = opened(shared / BANDAI)
    bare = replace(clip.head.skeleton, joints=tuple(replace(j, mapped=None) for j in clip.head.skeleton.joints))
    large = replace(bare, joints=tuple(replace(j, offset=triple(numbers(j.offset) * 10)) for j in bare.joints))
    block = joined(clip.blocks())
    result = retarget(bare, block, large, suggest_matches(bare, large), 1 / 30)
    assert result.report.scale == pytest.approx(10)
    assert np.allclose(global_positions(large, result.block), global_positions(bare, block) * 10)
