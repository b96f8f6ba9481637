"""Whole bodies: trunk, sides, rest pose, who is no person, and what is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mcml.motion.retargeting.bone_mapping import suggest_matches
from mcml.motion.rigs.readings import read_names
from mcml.motion.rigs.recognise import NOBODY, PERSON, UNKNOWN, recognise
from mcml.motion.rigs.tree import Tree
from mcml.motion.rigs.words import read_words
from tests.motion.rigs.rig_builder import CORE, PLACES, USUAL, mirrored, names_of, person, skeleton_of, tree

SMPL = mirrored(
    {"Root": "pelvis", "waist": "spine1", "torso2": "spine2", "torso7": "spine3", "neck1": "neck", "Head": "head",
     "left_shoulder": "left_collar", "left_up_arm": "left_shoulder", "left_low_arm": "left_elbow",
     "left_hand": "left_wrist", "left_up_leg": "left_hip", "left_low_leg": "left_knee", "left_foot": "left_ankle",
     "left_toes": "left_foot"},
    [("left", "right")],
)  # fmt: skip
MMD = mirrored(
    {"Root": "下半身", "waist": "上半身", "torso7": "上半身2", "neck1": "首", "Head": "頭", "left_shoulder": "左肩",
     "left_up_arm": "左腕", "left_low_arm": "左ひじ", "left_hand": "左手首", "left_up_leg": "左足",
     "left_low_leg": "左ひざ", "left_foot": "左足首", "left_toes": "左つま先"},
    [("左", "右")],
)  # fmt: skip
SPANISH = mirrored(
    {"Root": "Cadera", "waist": "Columna", "torso7": "Pecho", "neck1": "Cuello", "Head": "Cabeza",
     "left_up_arm": "Brazo.I", "left_low_arm": "Antebrazo.I", "left_hand": "Mano.I", "left_up_leg": "Muslo.I",
     "left_low_leg": "Pierna.I", "left_foot": "Pie.I"},
    [(".I", ".D")],
)  # fmt: skip


@pytest.mark.parametrize("names", [USUAL, SMPL, SPANISH, {k: v.upper() for k, v in SMPL.items()}, MMD])
def test_a_person_is_complete(names: dict[str, str]) -> None:
    for lengths in (True, False):
        rig = person(names, lengths=lengths)
        found = recognise(rig)
        assert found.verdict == PERSON
        assert names_of(rig, found) == names
        assert not found.told


def test_every_name_and_joint_is_given_once_with_how_sure_it_is() -> None:
    found = recognise(person(USUAL)).joints
    assert len({each.joint for each in found}) == len({each.name for each in found}) == len(USUAL)
    sure = {each.name: (each.confidence, each.how) for each in found}
    assert sure["left_hand"] == (1.0, "word")
    assert sure["left_low_leg"] == (0.775, "word")
    assert all(0.7 <= confidence <= 1 for confidence, _ in sure.values())


def test_d_bones_of_mmd_are_no_second_legs() -> None:
    rig = person(MMD)
    doubled = ["左足D", "左ひざD", "左足首D", "右足D", "右ひざD", "右足首D"]
    at = {name: place for place, name in enumerate(rig.names)}
    root, places, parents = at["下半身"], list(rig.places), list(rig.parents)
    for place, name in enumerate(doubled):
        parents.append(len(rig) + place - 1 if place % 3 else root)
        places.append(rig.places[at[name[:-1]]])
    found = recognise(Tree([*rig.names, *doubled], parents, np.array(places)))
    assert {each.name for each in found.joints} >= set(CORE)
    assert all(each.joint < len(rig) for each in found.joints)


@pytest.mark.parametrize(
    "form", ["{source}_to_{other}", "{name}_to_{own}", "ns:{source} to {other}", "{name}.TO.{own}"]
)
def test_bones_that_lead_to_another_one_have_no_name(form: str) -> None:
    rig = person(USUAL)
    ours = {source: name for name, source in USUAL.items()}
    names, parents, places = list(rig.names), list(rig.parents), list(rig.places)
    for joint, parent in enumerate(rig.parents):
        if parent >= 0 and rig.parents.count(parent) > 1:
            source, other = rig.names[parent], rig.names[joint]
            names.append(form.format(source=source, other=other, name=ours[source], own=ours[other]))
            places.append(rig.places[parent])
            parents.append(parent)
            parents[joint] = len(names) - 1
    order = sorted(range(len(names)), key=lambda joint: depth_of(joint, parents))
    place = {joint: index for index, joint in enumerate(order)}
    above = [place.get(parents[joint], -1) for joint in order]
    led = Tree([names[joint] for joint in order], above, np.array([places[joint] for joint in order]))
    assert names_of(led) == USUAL


def depth_of(joint: int, parents: list[int]) -> int:
    return 0 if joint < 0 else 1 + depth_of(parents[joint], parents)


def test_names_of_bones_by_both_ends_are_read_where_no_joint_is_named_by_an_end() -> None:
    names = ["body", "neck_to_head", "left_hip_to_knee", "left_knee_to_ankle"]
    assert not any(reading.helper for reading in read_names(names, read_words(names)[0]))


def test_the_root_of_a_biped_is_its_pelvis_though_thighs_hang_from_the_spine() -> None:
    rig = tree("""
Bip01 0 95 0
 Bip01~Pelvis 0 95 0
  Bip01~Spine 0 105 0
   Bip01~L~Thigh 9 92 0
    Bip01~L~Calf 9 50 0
     Bip01~L~Foot 9 8 0
   Bip01~R~Thigh -9 92 0
    Bip01~R~Calf -9 50 0
     Bip01~R~Foot -9 8 0
   Bip01~Spine1 0 120 0
    Bip01~Neck 0 150 0
     Bip01~Head 0 160 0
""")
    assert names_of(rig)["Root"] == "Bip01 Pelvis"
    assert names_of(rig)["waist"] == "Bip01 Spine"


def test_a_spine_in_one_word_ends_in_the_head() -> None:
    names = USUAL | {
        "Root": "spine", "waist": "spine.001", "torso2": "spine.002", "torso7": "spine.003", "neck2": "spine.004",
        "neck1": "spine.005", "Head": "spine.006",
    }  # fmt: skip
    assert names_of(person(names)) == names


def test_necks_without_a_head_stay_necks() -> None:
    names = {name: own for name, own in USUAL.items() if name != "Head"} | {"neck2": "LowerNeck", "neck1": "UpperNeck"}
    found = recognise(person(names))
    assert names_of(person(names), found) == names
    assert "not found: Head" in found.told


def test_a_spare_joint_of_the_trunk_is_left_out() -> None:
    names = USUAL | {"torso2": "Spine_virtual"}
    assert "torso2" not in names_of(person(names))


@pytest.mark.parametrize("word", ["HeadEnd", "Eye", "jaw", "Hair_1", "HeadTop_End", "hat"])
def test_helpers_at_the_head_have_no_name(word: str) -> None:
    rig = person(USUAL)
    at = rig.names.index("Head")
    more = Tree([*rig.names, word], [*rig.parents, at], np.vstack([rig.places, [0, 180, 0]]))
    assert names_of(more) == USUAL


def unnamed(rig: Tree) -> Tree:
    return replace(rig, names=[f"joint_{number}" for number in range(len(rig))])


def test_joints_without_names_are_named_by_shape_and_toes() -> None:
    rig = person(USUAL)
    found = recognise(unnamed(rig))
    names = names_of(rig, found)
    assert {name: names.get(name) for name in CORE} == {name: USUAL[name] for name in CORE}
    assert {each.confidence for each in found.joints if each.name.endswith("leg")} == {0.6}
    assert found.verdict == PERSON


def test_a_body_that_faces_away_has_its_sides_by_its_toes() -> None:
    rig = person(USUAL)
    turned = replace(rig, places=rig.places * [-1, 1, -1], tips=[(joint, tip * [-1, 1, -1]) for joint, tip in rig.tips])
    assert names_of(rig, recognise(unnamed(turned)))["left_foot"] == "LeftFoot"


def test_without_toes_nothing_tells_left_from_right() -> None:
    rig = person({name: own for name, own in USUAL.items() if "toes" not in name})
    found = recognise(unnamed(rig))
    assert found.joints == ()
    assert any("no toes or names tell left from right: not mapped" in sentence for sentence in found.told)


def test_a_rest_pose_along_one_axis_is_judged_by_frames() -> None:
    rig = person(USUAL)
    flat = np.zeros_like(rig.places)
    for joint, parent in enumerate(rig.parents):
        if parent >= 0:
            flat[joint] = flat[parent] + [0, float(np.linalg.norm(rig.places[joint] - rig.places[parent])), 0]
    folded = replace(rig, places=flat, tips=())
    found = recognise(folded)
    assert found.verdict == PERSON
    assert found.asks_for_frames
    assert names_of(rig, found) == USUAL
    assert not recognise(folded, [rig.places]).asks_for_frames


def test_a_left_handed_export_is_told_and_keeps_its_names() -> None:
    rig = person(USUAL)
    mirror = replace(rig, places=rig.places * [-1, 1, 1])
    found = recognise(mirror)
    assert names_of(rig, found) == USUAL
    assert any("names and toes disagree about left and right" in sentence for sentence in found.told)


def test_a_crossed_limb_is_told() -> None:
    rig = person(USUAL)
    places = rig.places.copy()
    arms = [place for place, name in enumerate(rig.names) if "Arm" in name or "Hand" in name]
    places[arms] *= [-1, 1, 1]
    found = recognise(replace(rig, places=places))
    assert "some limbs named left stand on the right of the others" in found.told


def dog(tail: bool) -> Tree:
    """A dog with a person's names."""
    text = "Hips 0 60 0\n Spine 0 60 30\n  Neck 0 60 60\n   Head 0 60 70\n"
    for side, x in (("Left", 8), ("Right", -8)):
        text += f"  {side}Arm {x} 55 30\n   {side}ForeArm {x} 30 30\n    {side}Hand {x} 5 30\n"
    for side, x in (("Left", 8), ("Right", -8)):
        text += f" {side}UpLeg {x} 55 0\n  {side}Leg {x} 30 0\n   {side}Foot {x} 5 0\n"
    return tree(text + (" Tail 0 60 -10\n" if tail else ""))


@pytest.mark.parametrize("tail", [False, True])
def test_a_dog_with_a_person_s_names_is_refused(tail: bool) -> None:
    found = recognise(dog(tail))
    assert (found.verdict, found.joints) == (NOBODY, ())
    assert found.reason == "its trunk lies over its legs"


def test_a_person_may_have_a_tail_or_wings() -> None:
    for word in ("Tail", "LeftWing"):
        rig = person(USUAL)
        costume = Tree([*rig.names, word], [*rig.parents, 0], np.vstack([rig.places, [0, 95, -10]]))
        assert recognise(costume).verdict == PERSON


def test_four_arms_are_no_person_s() -> None:
    rig = person(USUAL)
    names, parents, places = list(rig.names), list(rig.parents), list(rig.places)
    for side in ("left", "right"):
        for place, slot in enumerate(("up_arm", "low_arm", "hand")):
            names.append(USUAL[f"{side}_{slot}"] + "2")
            parents.append(rig.names.index("Spine2") if not place else len(names) - 2)
            places.append(np.array(PLACES[f"{side}_{slot}"]) - [0, 25, 0])
    found = recognise(Tree(names, parents, np.array(places)))
    assert (found.verdict, found.reason) == (NOBODY, "it has more than two arms")


@pytest.mark.parametrize(
    "words",
    [
        ["Hips", "Spine", "LeftUpLeg", "LeftLeg", "LeftFoot", "LeftHindLeg"],
        ["Hips", "Spine", "LeftArm", "LeftForeArm", "LeftPaw"],
        ["Hips", "Head", "BackLeg_L", "BackFoot_L", "FrontLeg_L"],
        ["Pelvis", "FL_hip", "FL_knee", "FR_hip", "FR_knee", "RL_hip", "RR_hip", "Head"],
        ["base", "LF_HIP", "LF_KNEE", "LH_HIP", "RH_HIP", "RF_HIP"],
        ["Hips", "Spine", "LeftUpLeg", "LeftLeg", "RightUpLeg", "RightLeg", "Head", "LeftWing", "RightWing"],
        ["Bip01", "Bip01 Pelvis", "Bip01 L Thigh", "Bip01 L Calf", "Bip01 Beak"],
        ["Body", "FrontRightUpperLeg", "FrontRightLowerLeg", "FrontRightFoot"],
        ["Root", "L_FLeg", "L_FLeg1", "L_BLeg", "R_FLeg", "R_BLeg"],
    ],
)
def test_words_of_animals(words: list[str]) -> None:
    rig = Tree(words, list(range(-1, len(words) - 1)), np.zeros((len(words), 3)))
    assert recognise(rig).verdict == NOBODY


def test_a_corrective_bone_behind_the_knee_is_no_hind_leg() -> None:
    rig = person(USUAL)
    more = Tree(
        [*rig.names, "L_kneeBack", "R_kneeBack"], [*rig.parents, 0, 0], np.vstack([rig.places, np.zeros((2, 3))])
    )
    assert names_of(more) == USUAL


@pytest.mark.parametrize(
    "names", [["Camera"], ["Box", "Lid"], ["Head", "Jaw", "Eye_L", "Eye_R"], ["Pelvis", "Spine"], []]
)
def test_what_is_no_body_has_no_names(names: list[str]) -> None:
    rig = Tree(names, list(range(-1, len(names) - 1)), np.zeros((len(names), 3)))
    found = recognise(rig)
    assert (found.verdict, found.joints) == (UNKNOWN, ())
    assert found.told == ("no two arms or legs are recognised: nothing is mapped",)


@pytest.mark.parametrize("names", [SMPL, MMD, SPANISH])
def test_matches_of_any_rigs_are_suggested(names: dict[str, str]) -> None:
    """Also where documents were stored without names of MCML; joints without a name match nothing."""
    source, target = skeleton_of(person(USUAL)), skeleton_of(person(names))
    matches = {target.joints[match.target].name: match for match in suggest_matches(source, target)}
    expected = {names[name]: USUAL[name] for name in names if name in USUAL}
    assert {own: source.joints[match.source].name for own, match in matches.items()} == expected
    assert all(0.7 <= match.confidence <= 1 for match in matches.values())
    assert matches[names["left_hand"]].reason in ("both are left_hand", "both are called so in MCML")
