"""Joints without a name of MCML's: what they are for, by words in the ways of many rigs, and by the tree."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import mcml
from mcml.language.joint_names import named, rename_joints, table
from mcml.motion.rigs.recognise import recognise
from mcml.motion.rigs.roles import find_roles
from mcml.motion.rigs.tree import Tree
from tests.motion.rigs.rig_builder import USUAL, person, skeleton_of
from tests.motion.rigs.test_people import MMD

OF_RIGS: Mapping[str, Mapping[str, tuple[str, str]]] = {
    "VRM": {
        "J_Adj_L_FaceEye": ("Head", "left_eye"), "J_Sec_Hair1_01": ("Head", "hair"),
        "J_Sec_L_Bust1": ("torso7", "soft_tissue"), "J_Sec_R_CoatSkirtBack": ("Root", "clothing"),
    },
    "Character Creator": {
        "CC_Base_L_Eye": ("Head", "left_eye"), "CC_Base_JawRoot": ("Head", "jaw"), "CC_Base_Tongue01": ("Head", "face"),
        "CC_Base_L_ThighTwist01": ("left_up_leg", "twist"), "CC_Base_L_ElbowShareBone": ("left_up_arm", "twist"),
        "CC_Base_FacialBone": ("Head", "face"), "CC_Base_L_Breast": ("torso7", "soft_tissue"),
    },
    "Daz": {
        "lEye": ("Head", "left_eye"), "rEye": ("Head", "right_eye"), "lowerJaw": ("Head", "jaw"),
        "upperTeeth": ("Head", "face"), "lEyelidUpper": ("Head", "face"), "lPectoral": ("torso7", "soft_tissue"),
        "lHeel": ("left_foot", "left_heel"),
    },
    "Unreal": {
        "upperarm_twist_01_l": ("left_up_arm", "twist"), "ik_hand_gun": ("Root", "control"),
        "weapon_l": ("left_hand", "prop"), "FACIAL_L_Eye": ("Head", "left_eye"), "FACIAL_C_Jaw": ("Head", "jaw"),
    },
    "Rigify": {
        "DEF-eye.L": ("Head", "left_eye"), "DEF-jaw": ("Head", "jaw"), "DEF-lid.T.L": ("Head", "face"),
        "heel.02.L": ("left_foot", "left_heel"), "MCH-eye_parent.L": ("Head", "control"),
    },
    "3ds Max": {
        "Bip01 Ponytail1": ("Head", "hair"), "Bip01 HeadNub": ("Head", "end"),
        "Bip01 L ForeTwist": ("left_low_arm", "twist"),
    },
    "other": {
        "HeadTop_End": ("Head", "end"), "Cape_01": ("torso7", "clothing"), "EyeTarget": ("Head", "control"),
        "LeftHandProp": ("left_hand", "prop"), "Tail1": ("Root", "tail"),
    },
}  # fmt: skip
OF_MMD = {
    "左目": ("Head", "left_eye"), "両目": ("Head", "eye"), "左腕捩": ("left_up_arm", "twist"),
    "左足ＩＫ": ("left_foot", "control"), "スカート_0_1": ("Root", "clothing"), "舌1": ("Head", "face"),
}  # fmt: skip


def with_joints(names: Mapping[str, str], more: list[tuple[str, str]]) -> Tree:
    """A person with joints more: (name, name of the one above)."""
    base = person(names)
    order, parents, places = list(base.names), list(base.parents), list(base.places)
    for name, above in more:
        index = order.index(above)
        end = next((at for at in range(index + 1, len(order)) if not base_below(parents, index, at)), len(order))
        parents = [parent + (parent >= end) for parent in parents]
        order.insert(end, name)
        parents.insert(end, index)
        places.insert(end, places[index] + np.array([1.0, 2.0, 3.0]))
    return Tree(order, parents, np.array(places))


def base_below(parents: list[int], upper: int, joint: int) -> bool:
    while joint > upper:
        joint = parents[joint]
    return joint == upper


def roles_of(rig: Tree) -> dict[str, str]:
    """Name or role of every joint that has one, by its own name."""
    given = {each.joint: each.name for each in recognise(rig).joints}
    return {rig.names[joint]: name for joint, name in (given | find_roles(rig, given)).items()}


@pytest.mark.parametrize("disguise", [str, lambda name: f"Actor01:{name}", lambda name: f"{name}.001"])
@pytest.mark.parametrize(("rig", "base"), [*((rig, USUAL) for rig in OF_RIGS), ("MMD", MMD)])
def test_roles_by_words(rig: str, base: Mapping[str, str], disguise: type[str]) -> None:
    asked = OF_MMD if rig == "MMD" else OF_RIGS[rig]
    names = {name: disguise(own) for name, own in base.items()}
    made = with_joints(names, [(disguise(own), names[above]) for own, (above, _) in asked.items()])
    found = roles_of(made)
    assert {own: found.get(disguise(own)) for own in asked} == {own: role for own, (_, role) in asked.items()}
    # Their neighbours keep their names.
    assert {found[disguise(own)] for own in base.values()} == set(base)


def test_roles_by_the_tree() -> None:
    fingers = {"left_finger_one": "LeftHandThumb1", "left_finger_two": "LeftInHandIndex", "left_toes": "LeftToeBase"}
    made = with_joints(
        {**USUAL, **fingers},
        [
            ("LeftHandThumb2", "LeftHandThumb1"), ("LeftHandThumb3", "LeftHandThumb2"),
            ("LeftHandThumb4", "LeftHandThumb3"),
            ("LeftHandIndex1", "LeftInHandIndex"), ("LeftHandIndex2", "LeftHandIndex1"),
            ("Hair", "Head"), ("Bone007", "Hair"), ("Bone008", "Bone007"), ("Thing", "Spine2"),
        ],
    )  # fmt: skip
    made = Tree(
        ["Armature", *made.names], [-1, *(parent + 1 for parent in made.parents)], np.vstack([np.zeros(3), made.places])
    )
    found = roles_of(made)
    assert [found[f"LeftHandThumb{number}"] for number in (1, 2, 3, 4)] == [
        "left_finger_one", "left_finger_one_2", "left_finger_one_3", "end",
    ]  # fmt: skip
    # The palm has the finger's name here, so the knuckle is its first joint.
    assert [found[f"LeftHandIndex{number}"] for number in (1, 2)] == ["left_finger_two_1", "left_finger_two_2"]
    assert found["Hair"] == found["Bone007"] == found["Bone008"] == "hair"
    assert found["Armature"] == "origin"
    assert "Thing" not in found


def test_a_control_that_the_body_hangs_from_is_a_link_of_it() -> None:
    base = person(USUAL)
    neck = list(base.names).index("Neck")
    names = [*base.names[:neck], "Neck_Ctrl", *base.names[neck:]]
    parents = [parent + (parent >= neck) for parent in base.parents]
    parents = [*parents[:neck], parents[neck], *parents[neck:]]
    parents[neck + 1] = neck
    rig = Tree(names, parents, np.insert(base.places, neck, base.places[neck], axis=0))
    found = roles_of(rig)
    assert found["Neck_Ctrl"] == "connector"
    assert found["Neck"] == "neck1"
    assert roles_of(with_joints(USUAL, [("HeadAim", "Head"), ("HeadAim_Ctrl", "HeadAim")]))["HeadAim"] == "control"


def test_naming_gives_roles_and_a_chosen_name_takes_one_away() -> None:
    skeleton, _ = named(skeleton_of(with_joints(USUAL, [("Jaw", "Head"), ("LeftEye", "Head")])))
    assert {joint.source_name: joint.role for joint in skeleton.joints if joint.role} == {
        "Jaw": "jaw", "LeftEye": "left_eye",
    }  # fmt: skip
    jaw = skeleton.names.index("Jaw")
    assert rename_joints(skeleton, {jaw: "neck2"}).joints[jaw].role is None


def test_roles_of_real_files(shared: Path) -> None:
    for path, roles in (
        ("bvh/exporters/mixamo_freebvh.bvh", {"left_eye", "right_eye", "end", "left_finger_five_3"}),
        ("bvh/exporters/rokoko_jesse_dance.bvh", {"left_finger_two_1", "right_finger_one_3"}),
        ("npz/cmu131_01_smplx_165.npz", {"jaw", "left_eye", "right_eye", "left_finger_four_2"}),
    ):
        motion = mcml.read(shared / path)
        assert roles <= set(motion.roles.values())
        known = {row.name for row in table()}
        assert all(name in known or name in motion.roles for name in motion.bones)
