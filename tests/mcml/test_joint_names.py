"""Joints get MCML's names by their rig's convention, each name once, and nothing is ever lost or refused."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import VocabularyError
from mcml.language.joint_names import RIGS, NamingReport, named, root_candidates, table, translate
from mcml.motion.skeleton import Convention, Joint, Skeleton
from tests.builders import assign
from tests.mcml.strategies import NAMES


def report(rig: Skeleton) -> NamingReport:
    return named(rig)[1]


def skeleton(*names: str, convention: Convention = Convention.LISTED) -> Skeleton:
    return Skeleton(tuple(Joint(name, index - 1, name, convention) for index, name in enumerate(names)))


def mcml_names(*names: str) -> dict[str, str]:
    """What each source name became, mapped joints only."""
    return {joint.source_name: joint.name for joint in assign(skeleton(*names)).joints if joint.mapped}


PRINTED = {
    1: "Root", 2: "Head", 3: "neck1", 4: "neck2", 5: "left_shoulder", 6: "left_up_arm", 7: "left_low_arm",
    8: "left_wrist", 9: "left_hand", 10: "left_fingers", 11: "left_finger_one", 12: "left_finger_two",
    13: "left_finger_three", 14: "left_finger_four", 15: "left_finger_five", 16: "right_shoulder", 17: "right_up_arm",
    18: "right_low_arm", 19: "right_wrist", 50: "right_toe_two", 51: "right_toe_three", 52: "right_toe_four",
    53: "right_toe_five",
}  # fmt: skip


def test_table_1_has_53_rows_and_says_which_are_reconstructed() -> None:
    assert [row.number for row in table()] == list(range(1, 54))
    assert {row.number: row.name for row in table() if not row.reconstructed} == PRINTED
    assert len({row.name for row in table()}) == 53


def test_the_right_side_mirrors_the_left() -> None:
    rows = {row.name: row for row in table()}
    for name, row in rows.items():
        if name.startswith("left_"):
            mirrored = rows["right_" + name.removeprefix("left_")]
            for column, text in row.columns.items():
                other = mirrored.columns[column]
                assert bool(text) == bool(other)
                assert len(text.split("|")) == len(other.split("|"))
                assert not text or text != other, (name, column)


SPINE = {"Hips": "Root", "Spine": "waist", "Spine1": "torso2", "Spine2": "torso7"}


MAX = {
    "Pelvis": "Root", "RClavicle": "right_shoulder", "RUpperArm": "right_up_arm", "RForearm": "right_low_arm",
    "RThigh": "right_up_leg", "RCalf": "right_low_leg",
}  # fmt: skip


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["Hips", "LeftShoulder", "LeftArm"], {"LeftShoulder": "left_shoulder", "LeftArm": "left_up_arm"}),
        (["Hips", "LeftShoulder", "LeftElbow"], {"LeftShoulder": "left_up_arm", "LeftElbow": "left_low_arm"}),
        (["mixamorig:Hips", "mixamorig:LeftUpLeg", "mixamorig:LeftLeg"], {"mixamorig:LeftLeg": "left_low_leg"}),
        (["root", "lhumerus", "lwrist", "lhand"], {"root": "Root", "lwrist": "left_wrist", "lhand": "left_hand"}),
        (["root", "lshoulderjoint", "neckjoint", "lhumerus", "lwrist"], {"lwrist": "left_hand", "neckjoint": "neck1"}),
        (["root", "lowerneck", "upperneck", "lfemur"], {"upperneck": "neck1", "lowerneck": "neck2"}),
        (["root", "upperneck", "lowerneck", "lfemur"], {"upperneck": "neck2", "lowerneck": "neck1"}),
        (["Hips", "LeftArm", "Neck", "Neck1", "Head"], {"Neck": "neck2", "Neck1": "neck1", "Head": "Head"}),
        (["Hips", "LeftCollar", "LeftElbow", "Neck1", "Neck2"], {"Neck1": "neck2", "Neck2": "neck1"}),
        (["Bip01", "Bip01 Neck", "Bip01 Neck1", "Bip01 Neck2"], {"Bip01 Neck": "neck2", "Bip01 Neck2": "neck1"}),
        (["hip", "lShldr", "neckLower", "neckUpper"], {"neckLower": "neck2", "neckUpper": "neck1"}),
        (["root", "lhumerus", "lshoulderjoint", "neckjoint", "neck"], {"neckjoint": "neck2", "neck": "neck1"}),
        (["HumanoidRoot", "vl5", "vc7", "vc4", "vc2"], {"vc7": "neck2", "vc2": "neck1"}),
        (["h_root", "h_left_up_arm", "h_neck_1", "h_neck_2"], {"h_neck_1": "neck2", "h_neck_2": "neck1"}),
        (["hip", "lShldr", "lButtock", "lThigh"], {"lButtock": "left_hip", "lThigh": "left_up_leg"}),
        (["hip", "rShldr", "rButtock", "rThigh"], {"rButtock": "right_hip", "rThigh": "right_up_leg"}),
        (["Pelvis", "RClavicle", "RUpperArm", "RForearm", "RThigh", "RCalf"], MAX),
        (["Hips", "L Clavicle", "L UpperArm", "L Forearm", "L Hand", "L Calf"], {"L Forearm": "left_low_arm"}),
        (["Hips", "LCollar", "LUpperArm", "LLowerArm", "LUpperLeg", "LLowerLeg"], {"LLowerLeg": "left_low_leg"}),
        (["Bip01", "Bip01 Spine", "Bip01_L_UpperArm"], {"Bip01": "Root", "Bip01_L_UpperArm": "left_up_arm"}),
        (["LowerTorso", "UpperTorso", "LUpArm", "LLowArm"], {"LowerTorso": "Root", "UpperTorso": "torso7"}),
        (["Pelvis", "L5", "L3", "T12", "T8", "LeftUpperArm"], {"L5": "waist", "T8": "torso7"}),
        (["Pelvis", "L_Hip", "L_Collar", "L_Shoulder"], {"L_Hip": "left_up_leg", "L_Shoulder": "left_up_arm"}),
        (["h_root", "h_left_up_arm", "h_torso_3"], {"h_left_up_arm": "left_up_arm", "h_torso_3": "torso3"}),
        (["HumanoidRoot", "vl5", "l_shoulder"], {"l_shoulder": "left_up_arm", "vl5": "waist"}),
        (["Hips", "Spine", "Spine1", "Spine2", "LeftArm"], SPINE),
        (["Hips", "Chest", "LeftCollar"], {"Chest": "waist"}),
        (["Hips", "LowerBack", "Chest", "LeftCollar"], {"LowerBack": "waist", "Chest": "torso7"}),
        (["pre_hip", "pre_lShldr", "pre_abdomen", "pre_chest"], {"pre_lShldr": "left_up_arm", "pre_chest": "torso7"}),
    ],
)  # fmt: skip
def test_rigs(names: list[str], expected: dict[str, str]) -> None:
    assert expected.items() <= mcml_names(*names).items()


def test_necks_of_two_heads_are_not_one_chain() -> None:
    joints = [Joint(name, parent, name, Convention.LISTED) for name, parent in
              (("Hips", -1), ("LeftArm", 0), ("Neck", 0), ("Neck1", 0), ("Neck2", 3))]  # fmt: skip
    named = assign(Skeleton(tuple(joints)))
    assert [joint.name for joint in named.joints] == ["Root", "left_up_arm", "Neck", "neck2", "neck1"]


def rooted(*names: str, moving: tuple[str, ...]) -> Skeleton:
    return Skeleton(
        tuple(
            Joint(name, index - 1, name, Convention.LISTED, ("Tx", "Ty", "Tz") if name in moving else ())
            for index, name in enumerate(names)
        )
    )


def test_the_root_is_a_joint_that_can_move_the_figure() -> None:
    names = ("Root", "Hips", "LeftUpLeg")
    assert root_candidates(rooted(*names, moving=("Hips",))) == (1,)
    assert assign(rooted(*names, moving=("Hips",))).names == ("Root#2", "Root", "left_up_leg")
    assert assign(rooted(*names, moving=("Root",))).names == ("Root", "Hips", "left_up_leg")
    both = rooted(*names, moving=("Root", "Hips"))
    assert root_candidates(both) == (0, 1)
    for index in (0, 1):
        assert [joint.name for joint in named(both, root=index)[0].joints if joint.mapped] == ["Root", "left_up_leg"]
        assert named(both, root=index)[0].joints[index].name == "Root"
    # Names that are MCML's own stay as they are.
    assert root_candidates(rooted("Root", "left_up_leg", moving=("Root",))) == ()


SMPL = [
    "pelvis",
    "left_hip",
    "right_hip",
    "spine1",
    "left_knee",
    "right_knee",
    "spine2",
    "left_ankle",
    "right_ankle",
    "spine3",
    "left_foot",
    "right_foot",
    "neck",
    "left_collar",
    "right_collar",
    "head",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_wrist",
    "right_wrist",
]
SMPL_MEANS = {
    "pelvis": "Root", "left_hip": "left_up_leg", "left_knee": "left_low_leg", "left_ankle": "left_foot",
    "left_foot": "left_toes", "left_collar": "left_shoulder", "left_shoulder": "left_up_arm",
    "left_elbow": "left_low_arm", "head": "Head", "neck": "neck1",
}  # fmt: skip
MEDIAPIPE = [
    "nose",
    "left_eye",
    "right_eye",
    "left_ear",
    "right_ear",
    "mouth_left",
    "mouth_right",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_wrist",
    "right_wrist",
    "left_pinky",
    "right_pinky",
    "left_index",
    "right_index",
    "left_thumb",
    "right_thumb",
    "left_hip",
    "right_hip",
    "left_knee",
    "right_knee",
    "left_ankle",
    "right_ankle",
    "left_heel",
    "right_heel",
    "left_foot_index",
    "right_foot_index",
]
COCO = [
    name for name in MEDIAPIPE if name.endswith(("eye", "ear", "shoulder", "elbow", "wrist", "hip", "knee", "ankle"))
]
WRONG = {
    "left_hip": {"left_hip"}, "left_shoulder": {"left_shoulder"}, "left_ankle": {"left_toes"},
    "left_foot_index": {"left_foot", "left_finger_two"}, "left_index": {"left_hand"}, "left_heel": {"left_foot"},
}  # fmt: skip


@pytest.mark.parametrize("rename", [str, str.upper, lambda name: f"m_avg:{name}", lambda name: f"f_avg_{name}"])
def test_the_words_of_smpl_are_not_taken_literally(rename: Callable[[str], str]) -> None:
    """`left_foot` is the toes, `left_shoulder` the upper arm, whoever else is called so in Table 1."""
    found = mcml_names(*map(rename, SMPL))
    for side, other in (("left", "left"), ("left", "right")):
        for name, means in SMPL_MEANS.items():
            assert found[rename(name.replace(side, other))] == means.replace(side, other)
    assert found[rename("left_wrist")] == "left_hand"
    with_hands = mcml_names(*map(rename, [*SMPL, "left_hand", "right_hand", "left_index1", "left_thumb1"]))
    assert with_hands[rename("left_hand")] == "left_hand"
    assert with_hands[rename("left_wrist")] == "left_wrist"
    assert with_hands[rename("left_index1")] == "left_finger_two"
    assert report(skeleton(*map(rename, SMPL))).convention == "smpl"


@pytest.mark.parametrize("names", [MEDIAPIPE, COCO, COCO[6:], MEDIAPIPE[7:]])
def test_key_points_of_cameras_are_not_taken_literally(names: list[str]) -> None:
    found = mcml_names(*names)
    for name, wrong in WRONG.items():
        assert found.get(name) not in wrong, name
    expected = {"left_hip": "left_up_leg", "left_shoulder": "left_up_arm", "left_ankle": "left_foot"}
    assert {name: found[name] for name in expected if name in names} == {
        n: m for n, m in expected.items() if n in names
    }
    assert report(skeleton(*names)).convention != "mcml"


def test_one_word_of_table_1_makes_no_rig_mcml() -> None:
    rig = ["Hips", "Spine", "LeftUpLeg", "LeftLeg", "LeftFoot", "RightUpLeg", "left_finger_two", "left_hand"]
    assert report(skeleton(*rig)).convention == "motionbuilder"
    assert mcml_names(*rig)["LeftFoot"] == "left_foot"
    assert report(skeleton("left_hip", "left_foot", "left_shoulder", "left_hand")).convention != "mcml"
    own = ["Root", "left_up_leg", "left_low_leg", "left_foot", "waist", "left_shoulder"]
    assert report(skeleton(*own, "sword")).convention == "mcml"
    assert report(skeleton(*own, "left_knee")).convention != "mcml"


def body(words: dict[str, tuple[str, tuple[float, float, float]]]) -> Skeleton:
    """Joints by name: the one above, and where it stands in that."""
    places = list(words)
    return Skeleton(
        tuple(
            Joint(
                name,
                places.index(above) if above else -1,
                name,
                Convention.LISTED,
                ("Tx", "Ty", "Tz", "Rz", "Rx", "Ry") if not above else ("Rz", "Rx", "Ry"),
                rotation_order="ZXY",
                offset=tuple(map(str, offset)),  # type: ignore[arg-type]
                translation="" if above else "absolute",
            )
            for name, (above, offset) in words.items()
        )
    )


def quadruped(lying: bool, tail: bool = False) -> Skeleton:
    """A dog, or a person, with a person's words."""
    on = (0.0, 0.0, 30.0) if lying else (0.0, 30.0, 0.0)
    words: dict[str, tuple[str, tuple[float, float, float]]] = {
        "Hips": ("", (0, 60, 0)), "Spine": ("Hips", on), "Neck": ("Spine", on), "Head": ("Neck", on),
    }  # fmt: skip
    for side, x in (("Left", 8.0), ("Right", -8.0)):
        words |= {
            f"{side}UpLeg": ("Hips", (x, 0, 0)), f"{side}Leg": (f"{side}UpLeg", (0, -28, 0)),
            f"{side}Foot": (f"{side}Leg", (0, -28, 0)), f"{side}Arm": ("Spine", (x, 0, 0)),
            f"{side}ForeArm": (f"{side}Arm", (0, -25, 0)), f"{side}Hand": (f"{side}ForeArm", (0, -25, 0)),
        }  # fmt: skip
    if tail:
        words["Tail"] = ("Hips", (0, 0, -10))
    return body(words)


def test_animals_are_not_named_as_people() -> None:
    assert len(assign(quadruped(lying=False)).joints) == 16
    assert report(quadruped(lying=False)).convention == "motionbuilder"
    costume = report(quadruped(lying=False, tail=True))
    assert costume.convention == "motionbuilder"
    dog = quadruped(lying=True)
    assert report(dog).convention == "not a person"
    assert not any(joint.mapped for joint in assign(dog).joints)
    assert assign(dog).names == tuple(joint.source_name for joint in dog.joints)
    (notice,) = report(dog).notices()
    assert "not a person" in notice.what
    assert "trunk lies over its legs" in notice.what
    # Who names joints of a dog all the same is believed.
    assert assign(dog, extra=[("LeftFoot", "left_foot")]).joints[6].name == "left_foot"


@pytest.mark.parametrize(
    "names",
    [
        ["Hips", "Spine", "LeftUpLeg", "LeftLeg", "LeftFoot", "LeftHindLeg"],
        ["Hips", "Spine", "LeftArm", "LeftForeArm", "LeftPaw"],
        ["Hips", "Head", "BackLeg_L", "BackFoot_L", "FrontLeg_L"],
        ["Pelvis", "FL_hip", "FL_knee", "FR_hip", "FR_knee", "RL_hip", "RR_hip", "Head"],
        ["Hips", "Spine", "LeftUpLeg", "LeftLeg", "RightUpLeg", "RightLeg", "Head", "LeftWing", "RightWing"],
        ["Bip01", "Bip01 Pelvis", "Bip01 L Thigh", "Bip01 L Calf", "Bip01 Beak"],
    ],
)
def test_words_of_animals(names: list[str]) -> None:
    assert report(skeleton(*names)).convention == "not a person"
    assert mcml_names(*names) == {}


def test_mcml_names_stay() -> None:
    names = [row.name for row in table()]
    assert mcml_names(*names) == dict(zip(names, names, strict=True))
    assert report(skeleton(*names)).convention == "mcml"


def test_unknown_joints_keep_their_names_and_say_why() -> None:
    rig = skeleton("Hips", "LeftArm", "LeftArm", "tail", "LeftForeArm", "")
    named = assign(rig)
    assert named.names == ("Root", "left_up_arm", "LeftArm", "tail", "left_low_arm", "joint")
    assert [joint.mapped for joint in named.joints] == [True, True, False, False, True, False]
    said = report(rig)
    assert said.convention == "motionbuilder"
    assert said.unmapped[:2] == (("LeftArm", "LeftArm", "left_up_arm is taken"), ("tail", "tail", "not in Table 1"))
    assert "motionbuilder rig, 3 of 6 joints mapped" in said.notices()[0].what


def test_a_team_s_own_rows_come_first() -> None:
    named = assign(skeleton("Hips", "LeftArm", "tail_1"), extra=[("Tail 1", "tail"), ("LeftArm", "left_shoulder")])
    assert named.names == ("Root", "left_shoulder", "tail")
    assert all(joint.mapped for joint in named.joints)


def test_markers_are_no_joints() -> None:
    named = assign(skeleton("LeftArm", "Head", convention=Convention.MARKER))
    assert named.names == ("LeftArm", "Head")
    assert not any(joint.mapped for joint in named.joints)


ALIASES = sorted({alias for row in table() for text in row.columns.values() for alias in text.split("|") if alias})


@given(st.lists(st.one_of(st.sampled_from(ALIASES), NAMES), max_size=30))
def test_naming_never_fails_and_gives_each_name_once(names: list[str]) -> None:
    rig = skeleton(*names)
    named = assign(rig)
    assert [joint.source_name for joint in named.joints] == names
    assert len(set(named.names)) == len(names)
    mapped = [joint.name for joint in named.joints if joint.mapped]
    assert set(mapped) <= {row.name for row in table()}
    said = report(rig)
    assert len(said.mapped) + len(said.unmapped) == len(names)
    assert assign(named).names == named.names


@pytest.mark.parametrize("column", [rig.column for rig in RIGS])
def test_a_whole_rig_is_recognised_and_mapped(column: str) -> None:
    first = {row.name: row.columns[column].split("|")[0] for row in table()}
    # Each joint hangs below the one before it, and the lower neck is neck2.
    rows = [first.pop("neck2"), first.pop("neck1")]
    names = {name: alias for name, alias in (*zip(("neck2", "neck1"), rows, strict=True), *first.items()) if alias}
    rig = skeleton(*names.values())
    assert report(rig).convention in (column, "acclaim" if column == "vicon" else column)
    assert [joint.name for joint in assign(rig).joints] == list(names)


@pytest.mark.parametrize(
    ("to", "expected"),
    [
        ("mcml", ["Root", "waist", "torso7", "left_hand", "tail"]),
        ("bvh1", ["root", "Spine", "chest", "leftwrist", "tail"]),
        ("bvh2", ["root", "lowerback", "thorax", "lwrist", "tail"]),
        ("asf", ["h_root", "lowerback", "thorax", "lhand", "tail"]),
        ("htr", ["Hips", "lowertorso", "uppertorso", "lhand", "tail"]),
    ],
)
def test_translation(to: str, expected: list[str]) -> None:
    named = assign(skeleton("Hips", "Spine", "Spine1", "LeftHand", "tail", "LeftArm", "LeftForeArm"))
    translated = translate(named, to)
    assert [joint.source_name for joint in translated.joints][:5] == expected
    assert translated.names == named.names


def test_no_translation_into_other_formats() -> None:
    with pytest.raises(VocabularyError, match="no joint names of 'fbx'"):
        translate(skeleton("a"), "fbx")
