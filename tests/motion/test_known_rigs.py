"""Known rigs: their names are recognised, their rest poses are those of a person, and motion arrives on them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from mcml.language.joint_names import named
from mcml.motion.clip import ClipStream, FrameBlock, full_shape
from mcml.motion.conventions.resizing import turn_up
from mcml.motion.frames import joined
from mcml.motion.hub import HubReader, walked
from mcml.motion.hub_writer import HubWriter
from mcml.motion.kinematics import rest_positions
from mcml.motion.pictures.figures import axis_of
from mcml.motion.retargeting.bone_mapping import suggest_matches
from mcml.motion.retargeting.known_rigs import KNOWN_RIGS, KnownRig
from mcml.motion.retargeting.retarget import Retargeted, retarget
from mcml.motion.rotations import IDENTITY, from_euler
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.units import metres_per_unit
from mcml_schemas.retarget import RigName
from mcml_service.demo import body
from tests.motion.test_retarget import taken

rigs = pytest.mark.parametrize("rig", KNOWN_RIGS.values(), ids=KNOWN_RIGS)


def places(rig: KnownRig) -> tuple[Skeleton, dict[str, Array]]:
    """Positions at rest in metres, by MCML's names or those of the rig."""
    skeleton = rig.clip().head.skeleton
    return skeleton, dict(zip(skeleton.names, metres_per_unit(rig.unit) * rest_positions(skeleton), strict=True))


def test_requests_name_every_rig() -> None:
    assert get_args(RigName) == tuple(KNOWN_RIGS)


@rigs
def test_recognition_gives_the_same_names(rig: KnownRig) -> None:
    skeleton = rig.clip().head.skeleton
    bare = Skeleton(tuple(replace(joint, name=joint.source_name, mapped=None) for joint in skeleton.joints))
    found, _ = named(bare)
    for one, other in zip(skeleton.joints, found.joints, strict=True):
        # A ground joint may move the body, and fingers may begin in the palm. Files say which; toes one by one are
        # not recognised.
        free = skeleton.names[0] != "Root" and one.parent <= 0
        free |= any(part in f"{one.name} {other.name}" for part in ("finger", "_toe_"))
        assert free or (one.mapped, one.name) == (other.mapped, other.name)


@rigs
def test_a_person_stands_at_rest(rig: KnownRig) -> None:
    _, at = places(rig)
    upward, front = axis_of(rig.up), axis_of(rig.front)
    left = np.cross(upward, front)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        assert sign * at[f"{side}_up_leg"] @ left > 0.05
        thigh, shank, foot = (at[f"{side}_{name}"] @ upward for name in ("up_leg", "low_leg", "foot"))
        assert thigh == pytest.approx(0.93)
        assert shank == pytest.approx(0.5)
        assert foot == pytest.approx(0.07)
        assert (at[f"{side}_toes"] - at[f"{side}_foot"]) @ front == pytest.approx(0.15)
        arm = at[f"{side}_low_arm"] - at[f"{side}_up_arm"]
        drop = np.deg2rad(rig.lowered)
        assert arm == pytest.approx(0.325 * (sign * np.cos(drop) * left - np.sin(drop) * upward), abs=1e-6)
    if "Head" in at:
        assert at["Head"] @ upward == pytest.approx(1.56)


def retarget_to(source: ClipStream, rig: KnownRig) -> Retargeted:
    target = rig.clip()
    head, block = source.head, joined(source.blocks())
    matches = suggest_matches(head.skeleton, target.head.skeleton)
    return retarget(
        head.skeleton, block, target.head.skeleton, matches, 1 / 60, up=rig.up, target_block=joined(target.blocks())
    )  # fmt: skip


@rigs
def test_a_walk_arrives(rig: KnownRig) -> None:
    clip = turn_up(body.clip("walk", 170.0, *body.walk(170.0, 1.0, 1.0, 2.0)), "Y", rig.up)
    made = retarget_to(clip, rig)
    parts = {part.what: part.mean for part in made.report.parts}
    assert {"left arm", "right arm", "left leg", "right leg", "hips", "trunk"} <= parts.keys()
    assert max(mean for part, mean in parts.items() if part.endswith((" arm", " leg"))) < 0.1
    assert max(parts.values()) < 3.0
    skeleton = rig.clip().head.skeleton
    if skeleton.joints[0].name != "Root":
        ground = [column for column, (joint, _) in enumerate(made.block.columns) if joint == 0]
        assert not made.block.values[:, ground].any()


@rigs
def test_poses_come_back_from_another_rig(rig: KnownRig) -> None:
    """Random poses of the limbs of a rig, put on another one and back, point as before."""
    skeleton, _ = places(rig)
    random = np.random.default_rng(7)
    rotations = np.tile(IDENTITY, (20, len(skeleton), 1))
    limbs = [index for index, joint in enumerate(skeleton.joints) if joint.mapped and joint.name.count("_") == 2]
    for index in limbs:
        if "finger" not in skeleton.names[index] and "toe" not in skeleton.names[index]:
            rotations[:, index] = from_euler(np.deg2rad(random.uniform(-40, 40, (20, 3))), "XYZ")
    writer = HubWriter(skeleton)
    translations = np.tile(writer.rest.offsets, (20, 1, 1))
    columns = skeleton.columns()
    block = FrameBlock(writer.write(translations, rotations), columns, (full_shape(columns),), np.arange(1, 21))
    clip = ClipStream(rig.clip().head, lambda: iter([block]), 20)
    other = KNOWN_RIGS["smplx" if rig.name != "smplx" else "mixamo"]
    turned = turn_up(clip, rig.up, other.up)
    there = ClipStream(other.clip().head, lambda: iter([retarget_to(turned, other).block]), 20)
    back = retarget_to(turn_up(there, other.up, rig.up), rig)
    before = walked(skeleton, translations, rotations)[0]
    hub = HubReader(skeleton).read(back.block)
    after = walked(skeleton, hub.translations, hub.rotations)[0]
    for index in limbs:
        name = skeleton.names[index]
        parent = skeleton.joints[index].parent
        if name.endswith(("low_arm", "low_leg", "hand", "foot")) and "finger" not in name:
            assert before[:, index] - before[:, parent] == pytest.approx(after[:, index] - after[:, parent], abs=1e-4)


def pairs_of(source: str, target: str) -> dict[str, str]:
    one, two = (KNOWN_RIGS[name].clip().head.skeleton for name in (source, target))
    return {
        two.joints[match.target].source_name: one.joints[match.source].source_name
        for match in suggest_matches(one, two)
    }


@pytest.mark.parametrize(
    ("source", "target", "expected"),
    [
        # The palm of one side only, and a fourth joint that is a tip.
        ("mixamo", "unreal5", {"index_01_l": "mixamorig:LeftHandIndex1", "index_03_l": "mixamorig:LeftHandIndex3",
                               "index_metacarpal_l": None, "thumb_02_r": "mixamorig:RightHandThumb2"}),
        ("unreal5", "mixamo", {"mixamorig:LeftHandIndex1": "index_01_l", "mixamorig:LeftHandIndex4": None}),
        # Palms of both, with other names.
        ("daz9", "unreal5", {"index_metacarpal_l": "l_indexmetacarpal", "pinky_02_r": "r_pinky2"}),
        # The metacarpal of a thumb bends.
        ("vrm", "unity", {"LeftThumbProximal": "leftThumbMetacarpal", "LeftThumbDistal": "leftThumbDistal"}),
    ],
)  # fmt: skip
def test_fingers_are_paired_from_the_knuckle_on(source: str, target: str, expected: dict[str, str | None]) -> None:
    found = pairs_of(source, target)
    assert {name: found.get(name) for name in expected} == expected


def test_names_given_to_metacarpals_lead_to_the_knuckle() -> None:
    rig = KNOWN_RIGS["unreal5"].clip().head.skeleton
    bare, _ = named(Skeleton(tuple(replace(joint, name=joint.source_name, mapped=None) for joint in rig.joints)))
    assert bare.joints[bare.names.index("left_finger_two")].source_name == "index_metacarpal_l"
    target = KNOWN_RIGS["mixamo"].clip().head.skeleton
    found = {match.target: match.source for match in suggest_matches(bare, target)}
    knuckle = bare.joints[found[target.names.index("left_finger_two")]]
    assert knuckle.source_name == "index_01_l"


def test_fingers_of_a_file_with_palms(shared: Path) -> None:
    source, _, _ = taken(shared / "bvh" / "exporters" / "perception_neuron_milad.bvh")
    target = KNOWN_RIGS["unreal5"].clip().head.skeleton
    found = {
        target.joints[match.target].source_name: source.joints[match.source].source_name
        for match in suggest_matches(source, target)
    }
    assert found["index_metacarpal_l"] == "LeftInHandIndex"
    assert [found[f"index_0{joint}_l"] for joint in (1, 2, 3)] == [f"LeftHandIndex{joint}" for joint in (1, 2, 3)]
