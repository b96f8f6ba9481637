"""Angles that need rotations: of one joint that turns, of any body, and of real hands and heads."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mcml.errors import VocabularyError
from mcml.formats import FORMATS
from mcml.motion.anatomy.axes import segments_of
from mcml.motion.bodies.limb_angles import NEEDS_ROTATIONS, turn_named
from mcml.motion.bodies.turned_angles import turned_angle
from mcml.motion.hub import rest_of, walked
from mcml.motion.kinematics import Walker
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.units import reading_of
from mcml.testing import read
from tests.formats.test_real_files import opened
from tests.motion.bodies.made import named, stretch_of
from tests.motion.bodies.made import stance as stance_of_pose
from tests.motion.test_movement_names import BODIES, body, made, offsets_of

UP = np.array([0.0, 1.0, 0.0])
CASES = [
    (case, arms_out)
    for case, arms_out in BODIES
    if case[2] in NEEDS_ROTATIONS.get(case[0].strip(), ()) and not (case[0] == "pelvis" and "lateral" in case[2])
]


def world_of(skeleton: Skeleton, local: Array) -> tuple[Array, Array]:
    return walked(skeleton, offsets_of(skeleton, local), local)


@pytest.mark.parametrize(
    ("case", "arms_out"), CASES, ids=["-".join((case[1], case[0], case[2], case[3], str(out))) for case, out in CASES]
)
def test_one_joint_turned_has_its_angle(case: tuple[str, str, str, str, Array, bool], arms_out: bool) -> None:
    part, side, movement, joint, axis, opposite = case
    degrees = np.linspace(-60, 60, 9)
    for turn in (0.0, 2.1):
        skeleton = body(arms_out, turn)
        path = Rotation.from_rotvec(np.radians(degrees)[:, None] * axis)
        positions, rotations = world_of(skeleton, made(skeleton, arms_out, turn, joint, path))
        pose = (positions[4], rotations[4]) if arms_out else None
        stance = stance_of_pose(skeleton, pose)
        name = "-".join(word for word in (side, part.strip(), movement) if word)
        found = turned_angle(name, skeleton, rest_of(skeleton), stance, rotations)
        expected = -degrees if opposite else degrees
        if part == "toes":
            # This body's toes point inwards, to the big one: their bone is not square to the axis.
            expected = expected * np.cos(np.arctan2(0.2, 0.4))
        # Axes of the table are written with three digits.
        np.testing.assert_allclose(found, expected, atol=1e-9 if set(np.abs(axis)) <= {0.0, 1.0} else 0.3)


def test_every_part_is_tried() -> None:
    toes = {f"toe-{number}" for number in ("two", "three", "four", "five")}
    assert {case[0].strip() for case, _ in CASES} == set(NEEDS_ROTATIONS) - toes


def test_a_pelvis_tilts_wherever_it_faces() -> None:
    skeleton = body(False, 0.0)
    facing = Rotation.from_rotvec(np.radians(np.arange(-170, 180, 20))[:, None] * UP)
    path = facing * Rotation.from_rotvec([np.radians(25), 0, 0])
    _, rotations = world_of(skeleton, made(skeleton, False, 0.0, "Root", path))
    stance = stance_of_pose(skeleton)
    tilt = turned_angle("pelvis-anterior-tilt", skeleton, rest_of(skeleton), stance, rotations)
    np.testing.assert_allclose(tilt, 25, atol=1e-9)
    turned = turned_angle("pelvis-right-rotation", skeleton, rest_of(skeleton), stance, rotations)
    np.testing.assert_allclose(turned, -np.arange(-170, 180, 20), atol=1e-9)
    upside_down = made(skeleton, False, 0.0, "Root", Rotation.from_rotvec([[np.pi, 0, 0]]))
    _, rotations = world_of(skeleton, upside_down)
    found = turned_angle("pelvis-anterior-tilt", skeleton, rest_of(skeleton), stance, rotations)
    assert abs(found[0]) == pytest.approx(180)


@pytest.mark.parametrize("bend", [0.0, 30.0, 60.0, 90.0, 120.0, 150.0])
def test_a_forearm_is_turned_as_far_however_the_elbow_is_bent(bend: float) -> None:
    """By one joint that bends and turns, about the axis of the elbow, then about the forearm itself."""
    skeleton = body(False, 0.0)
    stance = stance_of_pose(skeleton)
    rest = rest_of(skeleton)
    arm = next(
        found for found in segments_of(skeleton, rest, stance) if (found.part.name, found.side) == ("forearm", "left")
    )
    pronated = np.array([-170.0, -90.0, -60.0, 0.0, 20.0, 60.0, 90.0, 179.0])
    hinge = Rotation.from_rotvec(np.radians(bend) * np.cross(arm.bone, stance.on))
    path = hinge * Rotation.from_rotvec(np.radians(pronated)[:, None] * arm.bone)
    _, rotations = world_of(skeleton, made(skeleton, False, 0.0, "left_low_arm", path))
    found = turned_angle("left-forearm-pronation", skeleton, rest, stance, rotations)
    np.testing.assert_allclose(found, pronated, atol=1e-9)


ARM = """HIERARCHY
ROOT Root
{ OFFSET 0 0 0 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
JOINT left_up_leg { OFFSET 9 0 0 CHANNELS 3 Zrotation Xrotation Yrotation End Site { OFFSET 0 -80 0 } }
JOINT right_up_leg { OFFSET -9 0 0 CHANNELS 3 Zrotation Xrotation Yrotation End Site { OFFSET 0 -80 0 } }
JOINT Head { OFFSET 0 60 0 CHANNELS 3 Zrotation Xrotation Yrotation End Site { OFFSET 0 10 0 } }
JOINT left_up_arm { OFFSET 18 45 0 CHANNELS 3 Zrotation Xrotation Yrotation
JOINT left_low_arm { OFFSET 0 -28 0 CHANNELS 1 Xrotation
JOINT left_wrist { OFFSET 2 -10 0 CHANNELS 3 Zrotation Xrotation Yrotation
JOINT left_hand { OFFSET 3 -15 0 CHANNELS 3 Zrotation Xrotation Yrotation End Site { OFFSET 0 -8 0 } } } } } }
MOTION
Frames: 4
Frame Time: 0.01
"""


@pytest.mark.parametrize("pronated", [-120.0, 0.0, 60.0, 170.0])
def test_a_forearm_below_an_oblique_elbow_is_measured_from_the_ulna(pronated: float) -> None:
    bone = np.array([3.0, -15.0, 0.0]) / np.hypot(3, 15)
    twist = Rotation.from_rotvec(np.radians(pronated) * bone).as_euler("ZXY", degrees=True)
    rows = []
    for bend in (0.0, -60.0, -90.0, -150.0):
        values = np.zeros(6 + 3 * 4 + 1 + 3 + 3)
        values[18] = bend
        values[19:22] = twist
        rows.append(" ".join(f"{value:.12f}" for value in values))
    clip = named(read(FORMATS["bvh"], {"bvh": (ARM + "\n".join(rows) + "\n").encode()}))
    skeleton = clip.head.skeleton
    rotations = np.concatenate([Walker(skeleton).poses(block)[1] for block in clip.blocks()])
    found = turned_angle("left-forearm-pronation", skeleton, rest_of(skeleton), stance_of_pose(skeleton), rotations)
    np.testing.assert_allclose(found, pronated, atol=1e-6)


@pytest.mark.parametrize("name", ["left-arm-medial-rotation", "right-leg-medial-rotation", "head-left-rotation"])
@pytest.mark.parametrize("swing", [0.0, 45.0, 100.0])
def test_other_bones_too(name: str, swing: float) -> None:
    skeleton = body(False, 0.0)
    stance, rest = stance_of_pose(skeleton), rest_of(skeleton)
    part, side, _ = turn_named(name) or ("", "", "")
    segment = next(
        found for found in segments_of(skeleton, rest, stance) if (found.part.name, found.side) == (part, side)
    )
    axis = stance.up if part == "head" else segment.bone
    across = stance.left if abs(float(axis @ stance.left)) < 0.5 else stance.on
    across = across - (across @ axis) * axis
    twists = np.array([-120.0, 40.0, 75.0])
    path = Rotation.from_rotvec(np.radians(swing) * across / np.linalg.norm(across))
    path = path * Rotation.from_rotvec(np.radians(twists)[:, None] * axis)
    joint = skeleton.joints[segment.joint].name
    _, rotations = world_of(skeleton, made(skeleton, False, 0.0, joint, path))
    found = turned_angle(name, skeleton, rest, stance, rotations)
    np.testing.assert_allclose(np.abs(found), np.abs(twists), atol=1e-9)
    assert (np.sign(found) == np.sign(found[0]) * np.sign(twists) * np.sign(twists[0])).all()


def test_half_a_turn_of_swing_tells_no_twist() -> None:
    skeleton = body(False, 0.0)
    _, rotations = world_of(skeleton, made(skeleton, False, 0.0, "Root", Rotation.from_rotvec([[np.pi, 0, 0]])))
    stance = stance_of_pose(skeleton)
    assert np.isnan(turned_angle("pelvis-left-rotation", skeleton, rest_of(skeleton), stance, rotations)).all()


def test_joints_that_are_missing_or_never_turned_have_no_angle() -> None:
    skeleton = body(False, 0.0)
    stance, rest = stance_of_pose(skeleton), rest_of(skeleton)
    path = Rotation.from_rotvec(np.radians([[0.0, 20.0, 0.0]] * 4))
    _, rotations = world_of(skeleton, made(skeleton, False, 0.0, "Head", path))
    unseen = np.zeros((4, len(skeleton)), bool)
    unseen[2, skeleton.names.index("Head")] = True
    found = turned_angle("head-left-rotation", skeleton, rest, stance, rotations, unseen)
    assert np.isnan(found).tolist() == [False, False, True, False]
    places = replace(skeleton, joints=tuple(replace(one, channels=("Tx", "Ty", "Tz")) for one in skeleton.joints))
    for name in ("head-left-rotation", "left-forearm-pronation", "pelvis-anterior-tilt", "left-foot-inversion"):
        assert np.isfinite(turned_angle(name, skeleton, rest, stance, rotations)).all(), name
        assert np.isnan(turned_angle(name, places, rest, stance, rotations)).all(), name


def test_what_is_not_there_is_unknown() -> None:
    skeleton = body(False, 0.0)
    alone = Skeleton(skeleton.joints[:1])
    stance = stance_of_pose(skeleton)
    rotations = np.tile([0.0, 0.0, 0.0, 1.0], (3, 1, 1))
    assert np.isnan(turned_angle("head-flexion", alone, rest_of(alone), stance, rotations)).all()
    with pytest.raises(VocabularyError):
        turned_angle("left-knee-flexion", skeleton, rest_of(skeleton), stance, rotations)
    assert turn_named("left-wrist-flexion") == ("wrist", "left", "flexion")


@pytest.mark.parametrize("name", ["bvh/bandai/dataset-1_walk_normal_001.bvh", "asfamc/cmu_misc/07_05-walk.amc"])
def test_walkers_hold_their_heads(shared: Path, name: str) -> None:
    clip = named(opened(shared / name))
    skeleton, reading = clip.head.skeleton, reading_of(clip.head)
    calibration = stretch_of(clip).calibration
    walker = Walker(skeleton, reading)
    poses = [walker.poses(block) for block in clip.blocks()]
    positions, rotations = (np.concatenate(each) for each in zip(*poses, strict=True))
    frame = calibration.reference
    pose = None if frame is None else (positions[frame], rotations[frame])
    stance = stance_of_pose(skeleton, pose, reading)
    for angle in ("head-flexion", "neck-left-rotation", "pelvis-anterior-tilt", "right-leg-medial-rotation"):
        found = turned_angle(angle, skeleton, rest_of(skeleton, reading), stance, rotations)
        assert np.ptp(found) < 40, angle
        assert abs(np.median(found)) < 40, angle
