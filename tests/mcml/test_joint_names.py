"""Joints get MCML's names as their rig is recognised, each name once, and nothing is ever lost or refused."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import VocabularyError
from mcml.language.joint_names import NamingReport, named, root_candidates, table, translate
from mcml.motion.rigs.recognise import PART, PERSON
from mcml.motion.rigs.skeletons import recognise_skeleton
from mcml.motion.skeleton import Convention, Joint, Skeleton
from tests.builders import assign
from tests.mcml.strategies import NAMES
from tests.motion.rigs.rig_builder import person, skeleton_of
from tests.motion.rigs.test_people import SMPL


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
                assert not text or text != other, (name, column)


LEG = ("LeftUpLeg", "LeftLeg", "LeftFoot")
NAMED_LEG = ("left_up_leg", "left_low_leg", "left_foot")


def rooted(*names: str, moving: tuple[str, ...]) -> Skeleton:
    return Skeleton(
        tuple(
            Joint(name, index - 1, name, Convention.LISTED, ("Tx", "Ty", "Tz") if name in moving else ())
            for index, name in enumerate((*names, *LEG))
        )
    )


def candidates(skeleton: Skeleton) -> tuple[int, ...]:
    return root_candidates(skeleton, recognise_skeleton(skeleton))


def test_the_root_is_a_joint_that_can_move_the_figure() -> None:
    names = ("Root", "Hips")
    assert candidates(rooted(*names, moving=("Hips",))) == (1,)
    assert assign(rooted(*names, moving=("Hips",))).names == ("Root#2", "Root", *NAMED_LEG)
    assert assign(rooted(*names, moving=("Root",))).names == ("Root", "Hips", *NAMED_LEG)
    both = rooted(*names, moving=("Root", "Hips"))
    assert candidates(both) == (0, 1)
    for index in (0, 1):
        mapped = [joint.name for joint in named(both, root=index)[0].joints if joint.mapped]
        assert mapped == ["Root", *NAMED_LEG]
        assert named(both, root=index)[0].joints[index].name == "Root"
    # Names that are MCML's own stay as they are.
    assert candidates(Skeleton((Joint("Root", -1, "Root", Convention.LISTED, ("Tx", "Ty", "Tz")),
                                Joint("left_up_leg", 0, "left_up_leg", Convention.LISTED)))) == ()  # fmt: skip


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
    rig = skeleton_of(person({name: rename(own) for name, own in SMPL.items()}))
    assert {joint.name: joint.source_name for joint in assign(rig).joints} == {
        name: rename(own) for name, own in SMPL.items()
    }
    assert report(rig).kind == PERSON


@pytest.mark.parametrize("names", [MEDIAPIPE, COCO, COCO[6:], MEDIAPIPE[7:]])
def test_key_points_of_cameras_are_not_taken_literally(names: list[str]) -> None:
    """They hang from nothing."""
    joints = tuple(Joint(name, -1, name, Convention.LISTED) for name in names)
    rig = Skeleton(joints)
    found = {joint.source_name: joint.name for joint in assign(rig).joints if joint.mapped}
    for name, wrong in WRONG.items():
        assert found.get(name) not in wrong, name
    expected = {"left_hip": "left_up_leg", "left_shoulder": "left_up_arm", "left_ankle": "left_foot"}
    assert {name: found[name] for name in expected if name in names} == {
        n: m for n, m in expected.items() if n in names
    }
    assert report(rig).kind == PERSON


def test_one_word_of_table_1_makes_no_rig_mcml() -> None:
    rig = ["Hips", "Spine", "LeftUpLeg", "LeftLeg", "LeftFoot", "left_finger_two", "left_hand"]
    assert report(skeleton(*rig)).kind == PART
    assert mcml_names(*rig)["LeftFoot"] == "left_foot"
    assert report(skeleton("left_hip", "left_foot", "left_shoulder", "left_hand")).kind != "mcml"
    own = ["Root", "left_up_leg", "left_low_leg", "left_foot", "waist", "left_shoulder"]
    assert report(skeleton(*own, "sword")).kind == "mcml"
    assert report(skeleton(*own, "left_knee")).kind != "mcml"


def test_animals_keep_their_names() -> None:
    dog = skeleton("Hips", "Spine", "LeftUpLeg", "LeftLeg", "LeftFoot", "LeftHindLeg")
    said = report(dog)
    assert said.kind == "not a person"
    assert assign(dog).names == tuple(joint.source_name for joint in dog.joints)
    (notice,) = said.notices()
    assert "not a person (it has 'LeftHindLeg')" in notice.what
    # Who names joints of a dog all the same is believed.
    assert assign(dog, extra=[("LeftFoot", "left_foot")]).joints[4].name == "left_foot"


def test_mcml_names_stay() -> None:
    names = [row.name for row in table()]
    assert mcml_names(*names) == dict(zip(names, names, strict=True))
    assert report(skeleton(*names)).kind == "mcml"


def test_unknown_joints_keep_their_names_and_say_why() -> None:
    rig = skeleton("Hips", "LeftArm", "LeftArm", "tail", "LeftForeArm", "")
    named = assign(rig)
    assert named.names == ("Root", "left_up_arm", "LeftArm", "tail", "left_low_arm", "joint")
    assert [joint.mapped for joint in named.joints] == [True, True, False, False, True, False]
    said = report(rig)
    assert said.unmapped[1] == ("tail", "tail", "not recognised")
    assert [notice.what for notice in said.notices()] == ["joint names: not found: Head, left_hand"]


def test_a_doubtful_name_says_how_sure_it_is() -> None:
    rig = skeleton("LeftUpLeg", "Bone12", "LeftFoot", "LeftToe")
    joints = assign(rig).joints
    assert [(joint.name, joint.confidence) for joint in joints] == [
        ("left_up_leg", None), ("left_low_leg", "0.6"), ("left_foot", None), ("left_toes", None),
    ]  # fmt: skip
    assert "joint names: guessed: Bone12 as left_low_leg" in [notice.what for notice in report(rig).notices()]


def test_a_team_s_own_rows_come_first() -> None:
    rig = skeleton("Hips", "LeftArm", "LeftForeArm", "tail_1")
    named = assign(rig, extra=[("Tail 1", "tail"), ("Left Arm", "left_shoulder"), ("x", "Root")])
    assert [joint.name for joint in named.joints] == ["Root", "left_shoulder", "left_low_arm", "tail"]
    taken = assign(rig, extra=[("tail_1", "left_low_arm")])
    assert taken.names[2:] == ("LeftForeArm", "left_low_arm")


def test_markers_are_no_joints() -> None:
    named = assign(skeleton("LeftArm", "Head", convention=Convention.MARKER))
    assert named.names == ("LeftArm", "Head")
    assert not any(joint.mapped for joint in named.joints)


ALIASES = sorted(
    {*MEDIAPIPE, *SMPL.values(), "Hips", "LeftArm", "LeftForeArm", "LeftHand", "L_leg", "左足", "Spine_01"}
)


@given(st.lists(st.one_of(st.sampled_from(ALIASES), NAMES), max_size=30))
def test_naming_never_fails_and_gives_each_name_once(names: list[str]) -> None:
    rig = skeleton(*names)
    named = assign(rig)
    assert [joint.source_name for joint in named.joints] == names
    assert len(set(named.names)) == len(names)
    mapped = [joint.name for joint in named.joints if joint.mapped]
    assert set(mapped) <= {row.name for row in table()}
    said = report(rig)
    assert len(said.named) + len(said.unmapped) == len(names)
    assert assign(named).names == named.names


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
    named = assign(skeleton("Hips", "Spine", "Spine1", "LeftArm", "LeftForeArm", "LeftHand", "tail"))
    translated = translate(named, to)
    assert [joint.source_name for joint in (*translated.joints[:3], *translated.joints[5:])] == expected
    assert translated.names == named.names


def test_no_translation_into_other_formats() -> None:
    with pytest.raises(VocabularyError, match="no joint names of 'fbx'"):
        translate(skeleton("a"), "fbx")
