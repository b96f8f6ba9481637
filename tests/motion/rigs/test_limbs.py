"""Words that mean different joints in different rigs, settled by the chain that they stand in."""

from __future__ import annotations

import numpy as np
import pytest

from mcml.motion.rigs.recognise import PART, recognise
from mcml.motion.rigs.tree import Tree
from tests.motion.rigs.rig_builder import chain, mirrored, names_of, person, tree

ARMS = [
    ("LeftShoulder LeftArm LeftForeArm LeftHand", "shoulder up_arm low_arm hand"),
    ("LeftCollar LeftShoulder LeftElbow LeftWrist", "shoulder up_arm low_arm hand"),
    ("LeftShoulder LeftArm LeftWrist", "up_arm low_arm hand"),
    ("lhumerus lradius lwrist lhand", "up_arm low_arm wrist hand"),
    ("L_Clavicle L_UpperArm L_UpperArm1 L_UpperArm2 L_UpperArm3 L_Forearm L_Hand",
     "shoulder up_arm - - - low_arm hand"),
    ("clavicle_l upperarm_l upperarm_twist_01_l lowerarm_l lowerarm_twist_01_l hand_l",
     "shoulder up_arm - low_arm - hand"),
    ("LUArm LFArm LHand", "up_arm low_arm hand"),
    ("LArm LForeArm LPalm", "up_arm low_arm hand"),
    ("左肩 左腕 左ひじ 左手首", "shoulder up_arm low_arm hand"),
    ("left_shoulder_pitch_link left_shoulder_roll_link left_shoulder_yaw_link left_elbow_link left_wrist_roll_link",
     "up_arm - - low_arm hand"),
]  # fmt: skip
LEGS = [
    ("left_hip left_knee left_ankle left_foot", "up_leg low_leg foot toes"),
    ("LHipJoint LeftUpLeg LeftLeg LeftFoot", "hip up_leg low_leg foot"),
    ("LeftLeg LeftShin LeftFoot", "up_leg low_leg foot"),
    ("LeftUpLeg LeftLeg LeftFoot LeftToeBase", "up_leg low_leg foot toes"),
    ("pelvis.L thigh.L shin.L foot.L toe.L", "hip up_leg low_leg foot toes"),
    ("cadera_izq rodilla_izq tobillo_izq punta_izq", "up_leg low_leg foot toes"),
    ("momo_l sune_l asi_l", "up_leg low_leg foot"),
    ("l_hip_pitch l_hip_roll l_hip_yaw l_knee l_ankle", "up_leg - - low_leg foot"),
    ("Upperleg_L Foreleg_L Foot_L", "up_leg low_leg foot"),
    ("LeftUpLeg LeftLeg LeftFoot LeftForeFoot", "up_leg low_leg foot toes"),
    ("Oberschenkel_L Unterschenkel_L Fuss_L", "up_leg low_leg foot"),
]


@pytest.mark.parametrize(("names", "slots"), ARMS + LEGS)
def test_a_chain_settles_what_words_mean(names: str, slots: str) -> None:
    rig = chain(*names.split())
    expected = {f"left_{slot}": name for name, slot in zip(names.split(), slots.split(), strict=True) if slot != "-"}
    assert names_of(rig) == expected
    assert recognise(rig).verdict == PART


def test_two_shoulders_that_stand_apart_are_shoulder_and_upper_arm() -> None:
    far = tree("""
l_shoulder_1 5 140 0
 l_shoulder_2 15 140 0
  l_elbow 45 140 0
   l_wrist 70 140 0
""")
    assert names_of(far)["left_shoulder"] == "l_shoulder_1"
    assert names_of(far)["left_up_arm"] == "l_shoulder_2"
    near = tree("""
l_shoulder_1 5 140 0
 l_shoulder_2 6 140 0
  l_elbow 45 140 0
   l_wrist 70 140 0
""")
    assert names_of(near)["left_up_arm"] == "l_shoulder_1"


def test_one_word_for_a_limb_is_settled_by_lengths() -> None:
    leg = tree("""
L_leg_1 9 92 0
 L_leg_2 9 50 0
  L_leg_3 9 8 0
   L_leg_4 9 2 13
""")
    assert names_of(leg) == {
        "left_up_leg": "L_leg_1", "left_low_leg": "L_leg_2", "left_foot": "L_leg_3", "left_toes": "L_leg_4",
    }  # fmt: skip
    arm = tree("""
L_arm_1 4 146 0
 L_arm_2 18 146 0
  L_arm_3 45 146 0
   L_hand 71 146 0
""")
    assert names_of(arm) == {
        "left_shoulder": "L_arm_1", "left_up_arm": "L_arm_2", "left_low_arm": "L_arm_3", "left_hand": "L_hand",
    }  # fmt: skip


def test_one_word_for_a_limb_without_lengths_is_told() -> None:
    rig = chain(*(f"L_leg_{number}" for number in range(1, 6)), "L_foot", "L_toe")
    found = recognise(rig)
    assert any("5 joints of the left leg have one word and no lengths" in sentence for sentence in found.told)
    assert "left_up_leg" not in names_of(rig)
    assert names_of(chain("LArm", "LArm1")) == {"left_up_arm": "LArm", "left_low_arm": "LArm1"}


def test_a_limb_in_equal_pieces_has_first_middle_and_last() -> None:
    text = "\n".join(f"{' ' * place}L_leg_{place + 1} 9 {92 - 21 * place} 0" for place in range(5))
    found = names_of(tree(text + "\n     L_foot 9 4 14"))
    assert found == {
        "left_up_leg": "L_leg_1", "left_low_leg": "L_leg_3", "left_foot": "L_leg_5", "left_toes": "L_foot",
    }  # fmt: skip


def test_one_joint_between_known_ones_is_the_missing_one() -> None:
    rig = chain("LeftUpLeg", "Bone12", "LeftFoot", "LeftToe")
    (low,) = [each for each in recognise(rig).joints if each.name == "left_low_leg"]
    assert (rig.names[low.joint], low.confidence, low.how) == ("Bone12", 0.6, "tree")
    assert "left_low_leg" not in names_of(chain("LeftUpLeg", "Bone12", "Bone13", "LeftFoot"))


def test_a_foot_under_a_control_bone_is_taken_and_told() -> None:
    rig = tree("""
Root 0 90 0
 Thigh_L 9 92 0
  Shin_L 9 50 0
 Control 9 8 0
  Foot_L 9 8 0
""")
    found = recognise(rig)
    (foot,) = [each for each in found.joints if each.name == "left_foot"]
    assert foot.confidence == 0.65
    assert "Foot_L is called left_foot and hangs elsewhere in the tree" in found.told


def test_mirror_names_at_different_places_of_their_limbs_are_dropped() -> None:
    rig = tree("""
Hips 0 90 0
 L_hip 9 92 0
  L_knee 9 50 0
   L_ankle 9 8 0
    L_foot 9 2 13
 R_hip -9 92 0
  R_knee -9 50 0
   R_foot -9 8 0
""")
    found = recognise(rig)
    assert "L_foot and R_foot stand at different places of their limbs: not mapped" in found.told
    assert not {"left_toes", "right_foot"} & names_of(rig).keys()


def test_numbers_may_count_the_other_way_on_the_other_side() -> None:
    """As in the skeleton of CesiumMan, a sample model of glTF."""
    rig = tree("""
torso 0 100 0
 arm_L_4 18 146 0
  arm_L_3 45 146 0
   arm_L_2 71 146 0
 arm_R -18 146 0
  arm_R_2 -45 146 0
   arm_R_3 -71 146 0
""")
    assert not any("different places" in sentence for sentence in recognise(rig).told)
    found = names_of(rig)
    assert [found[f"left_{slot}"] for slot in ("up_arm", "low_arm", "hand")] == ["arm_L_4", "arm_L_3", "arm_L_2"]
    assert [found[f"right_{slot}"] for slot in ("up_arm", "low_arm", "hand")] == ["arm_R", "arm_R_2", "arm_R_3"]


def test_a_name_of_both_sides_has_neither() -> None:
    rig = chain("LeftUpLeg", "LeftLeg", "Left_Right_Foot")
    assert "Left_Right_Foot says left and right: not mapped" in recognise(rig).told
    assert set(names_of(rig)) == {"left_up_leg", "left_low_leg"}


@pytest.mark.parametrize(
    ("fingers", "expected"),
    [
        (["L_Finger0", "L_Finger1", "L_Finger2"], ["finger_one", "finger_two", "finger_three"]),
        (["L_Finger1", "L_Finger2", "L_Finger3"], ["finger_one", "finger_two", "finger_three"]),
        (["L_Thumb1", "L_Finger1", "L_Finger2"], ["finger_one", "finger_two", "finger_three"]),
        (["lThumb1", "lIndex1", "lMid1", "lRing1", "lPinky1"],
         ["finger_one", "finger_two", "finger_three", "finger_four", "finger_five"]),
        (["L_Fingers"], ["fingers"]),
    ],
)  # fmt: skip
def test_fingers_are_counted_from_the_thumb(fingers: list[str], expected: list[str]) -> None:
    text = "L_Arm 18 146 0\n L_Forearm 45 146 0\n  L_Hand 71 146 0\n"
    for finger in fingers:
        text += f"   {finger} 75 146 0\n    {finger}_a 78 146 0\n"
    found = names_of(tree(text))
    assert {name: own for name, own in found.items() if "finger" in name} == {
        f"left_{name}": finger for name, finger in zip(expected, fingers, strict=True)
    }


def test_a_numbered_metacarpal_has_the_number_of_its_finger() -> None:
    rig = tree("""
upperarm.L 18 146 0
 lowerarm.L 45 146 0
  wrist.L 71 146 0
   finger1-1.L 73 145 3
    finger1-2.L 75 145 3
   metacarpal1.L 73 146 2
    finger2-1.L 78 146 2
""")
    found = names_of(rig)
    assert found["left_finger_one"] == "finger1-1.L"
    assert found["left_finger_two"] == "metacarpal1.L"


def test_a_list_without_a_tree_takes_certain_words_first() -> None:
    parts = ("clavicle", "shoulder", "elbow", "wrist", "hip", "knee", "ankle", "foot")
    names = ["world", *(f"{side}_{part}" for side in ("l", "r") for part in parts)]
    rig = Tree(names, [-1, *[0] * (len(names) - 1)], np.zeros((len(names), 3)))
    found = names_of(rig)
    assert found["left_up_arm"] == "l_shoulder"
    assert found["right_toes"] == "r_foot"
    assert found["right_foot"] == "r_ankle"


def test_too_many_candidates_are_told_and_a_deep_chain_is_no_trouble() -> None:
    deep = chain(*(f"L_leg_{number}" for number in range(3000)))
    assert any("3000 joints may be of the left leg" in sentence for sentence in recognise(deep).told)
    unknown = chain(*(f"x{number}" for number in range(3000)))
    assert recognise(unknown).joints == ()


def test_control_bones_beside_the_limb_do_not_take_its_names() -> None:
    rig = person(
        mirrored(
            {"Root": "hips", "torso7": "chest", "Head": "head", "left_up_arm": "upper_arm.L",
             "left_low_arm": "forearm.L", "left_hand": "hand.L", "left_up_leg": "thigh.L", "left_low_leg": "shin.L",
             "left_foot": "foot.L"},
            [(".L", ".R")],
        )
    )  # fmt: skip
    extra = ["hand_ik.L", "elbow_target.L", "upper_arm_fk.L", "thigh_prop.L"]
    names = [*rig.names, *extra]
    more = Tree(names, [*rig.parents, *[0] * 4], np.vstack([rig.places, np.zeros((4, 3))]), rig.tips)
    assert names_of(more) == names_of(rig)
