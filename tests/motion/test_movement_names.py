"""Movements of one joint get one name, the right one; real clips get sensible ones, never an impossible one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mcml.errors import ConversionError
from mcml.language.motion_names import MotionName, parse, parts
from mcml.motion.anatomy.axes import PARTS
from mcml.motion.anatomy.movement_names import CIRCLING, Suggestion, suggest_movements
from mcml.motion.frames import joined
from mcml.motion.hub import HubReader, rest_of
from mcml.motion.lexemes import triple
from mcml.motion.skeleton import Array, Convention, EndSite, Joint, Skeleton
from mcml.motion.units import reading_of
from tests import fuzz
from tests.builders import assign
from tests.formats.test_real_files import opened

LEFT: dict[str, tuple[str, tuple[float, float, float]]] = {
    "shoulder": ("torso7", (0.5, 3, 0)),
    "up_arm": ("shoulder", (2, 0, 0)),
    "low_arm": ("up_arm", (0, -4, 0)),
    "wrist": ("low_arm", (0, -3, 0)),
    "hand": ("wrist", (0, -0.5, 0)),
    "fingers": ("hand", (0, -1, 0)),
    "finger_one": ("hand", (0, -0.3, 0.3)),
    "finger_two": ("hand", (0, -1, 0.4)),
    "finger_three": ("hand", (0, -1, 0.1)),
    "finger_four": ("hand", (0, -1, -0.2)),
    "finger_five": ("hand", (0, -1, -0.5)),
    "up_leg": ("Root", (1, -0.5, 0)),
    "low_leg": ("up_leg", (0, -5, 0)),
    "foot": ("low_leg", (0, -5, 0)),
    "toes": ("foot", (0, -0.2, 2)),
    "toe_one": ("toes", (-0.2, 0, 0.4)),
}
"""The left side, where a joint stands in the one above: X to the left, Y up, Z on; arms hang, thumbs on."""
TIPS = {"finger_one": (0.0, -0.5, 0.5), "toes": (0.0, 0, 1), "toe_one": (0.0, 0, 0.3)}
MIDDLE = {"Root": ("", (0, 11, 0)), "waist": ("Root", (0, 1, 0)), "torso7": ("waist", (0, 2, 0)),
          "neck1": ("torso7", (0, 4, 0)), "Head": ("neck1", (0, 1, 0.1))}  # fmt: skip
ARM = {
    "up_arm",
    "low_arm",
    "wrist",
    "hand",
    "fingers",
    *(f"finger_{n}" for n in ("one", "two", "three", "four", "five")),
}
DOWN = Rotation.from_rotvec([0, 0, -np.pi / 2])
"""A left arm held out, to hang."""

SLANT = 0.5**0.5
MOVEMENTS: dict[tuple[str, str], tuple[str, tuple[float, float, float]]] = {
    ("pelvis", "anterior-tilt posterior-tilt"): ("Root", (1, 0, 0)),
    ("pelvis", "left-rotation right-rotation"): ("Root", (0, 1, 0)),
    ("pelvis", "right-lateral-flexion left-lateral-flexion"): ("Root", (0, 0, 1)),
    **{
        (part, names): (joint, axis)
        for part, joint in (("trunk", "waist"), ("trunk", "torso7"), ("neck", "neck1"), ("head", "Head"))
        for names, axis in (
            ("flexion extension", (1, 0, 0)),
            ("left-rotation right-rotation", (0, 1, 0)),
            ("right-lateral-flexion left-lateral-flexion", (0, 0, 1)),
        )
    },
    ("shoulder", "elevation depression"): ("left_shoulder", (0, 0, 1)),
    ("shoulder", "protraction retraction"): ("left_shoulder", (0, -1, 0)),
    ("arm", "flexion extension"): ("left_up_arm", (-1, 0, 0)),
    ("arm", "abduction adduction"): ("left_up_arm", (0, 0, 1)),
    ("arm", "medial-rotation lateral-rotation"): ("left_up_arm", (0, -1, 0)),
    ("elbow", "flexion extension"): ("left_low_arm", (-1, 0, 0)),
    ("forearm", "pronation supination"): ("left_low_arm", (0, -1, 0)),
    ("forearm", " pronation supination"): ("left_wrist", (0, -1, 0)),
    ("wrist", "flexion extension"): ("left_hand", (0, 0, -1)),
    ("wrist", "abduction adduction"): ("left_hand", (-1, 0, 0)),
    ("fingers", "flexion extension"): ("left_fingers", (0, 0, -1)),
    ("thumb", "flexion extension"): ("left_finger_one", (1, 0, 0)),
    ("thumb", "abduction adduction"): ("left_finger_one", (0, -SLANT, -SLANT)),
    **{
        (f"finger-{number}", "flexion extension"): (f"left_finger_{number}", (0, 0, -1))
        for number in ("two", "three", "four", "five")
    },
    ("finger-two", "abduction adduction"): ("left_finger_two", (-1, 0, 0)),
    ("finger-four", "abduction adduction"): ("left_finger_four", (1, 0, 0)),
    ("finger-five", "abduction adduction"): ("left_finger_five", (1, 0, 0)),
    ("leg", "flexion extension"): ("left_up_leg", (-1, 0, 0)),
    ("leg", "abduction adduction"): ("left_up_leg", (0, 0, 1)),
    ("leg", "medial-rotation lateral-rotation"): ("left_up_leg", (0, -1, 0)),
    ("knee", "flexion extension"): ("left_low_leg", (1, 0, 0)),
    ("knee", "medial-rotation lateral-rotation"): ("left_low_leg", (0, -1, 0)),
    ("foot", "dorsiflexion plantarflexion"): ("left_foot", (-1, 0, 0)),
    ("foot", "inversion eversion"): ("left_foot", (0, 0.0995, -0.995)),
    ("toes", "extension flexion"): ("left_toes", (-1, 0, 0)),
    ("toe-one", "extension flexion"): ("left_toe_one", (-1, 0, 0)),
}
"""(part, movement and its opposite): the joint and the axis about which it turns, of the left side."""


@cache
def body(arms_out: bool, turn: float) -> Skeleton:
    """A body of the table, turned about Y at rest."""
    names, offsets = list(MIDDLE), {name: (parent, np.array(place, float)) for name, (parent, place) in MIDDLE.items()}
    for side, mirror in (("left", 1.0), ("right", -1.0)):
        for name, (parent, place) in LEFT.items():
            vector = np.array(place, float)
            if arms_out and name in ARM - {"up_arm"}:
                vector = DOWN.inv().apply(vector)
            above = parent if parent in MIDDLE else f"{side}_{parent}"
            names.append(f"{side}_{name}")
            offsets[f"{side}_{name}"] = (above, vector * [mirror, 1, 1])
    order: list[str] = []

    def add(name: str) -> None:
        order.append(name)
        for child in names:
            if offsets[child][0] == name:
                add(child)

    add("Root")
    facing = Rotation.from_rotvec([0, turn, 0])
    joints = []
    for name in order:
        parent, place = offsets[name]
        side, _, bare = name.partition("_")
        tip = np.array(TIPS.get(bare, (0.0, 1.0 if name == "Head" else -0.8, 0.0)))
        if arms_out and bare in ARM:
            tip = DOWN.inv().apply(tip)
        tip = facing.apply(tip * [-1 if side == "right" else 1, 1, 1])
        leaf = not any(offsets[other][0] == name for other in names)
        joints.append(
            Joint(
                name, order.index(parent) if parent else -1, name, Convention.LISTED, ("Rz", "Rx", "Ry"), "ZXY",
                offset=triple(facing.apply(place)), mapped=True, end_sites=(EndSite(triple(tip)),) if leaf else (),
            )
        )  # fmt: skip
    return Skeleton(tuple(joints))


def made(skeleton: Skeleton, arms_out: bool, turn: float, joint: str, path: Rotation) -> Array:
    """Local rotations (n, J, 4): one joint moves, in the body's axes with hanging arms, the others stay."""
    facing = Rotation.from_rotvec([0, turn, 0])
    rotations = np.tile([0.0, 0.0, 0.0, 1.0], (len(path), len(skeleton), 1))
    for index, name in enumerate(skeleton.names):
        side, _, bare = name.partition("_")
        hang = DOWN if side == "left" else DOWN.inv()
        moving = path if name == joint else Rotation.from_rotvec(np.zeros((len(path), 3)))
        if arms_out and bare == "up_arm":
            moving = moving * hang
        elif arms_out and bare in ARM:
            moving = hang.inv() * moving * hang
        rotations[:, index] = (facing * moving * facing.inv()).as_quat()
    return rotations


def offsets_of(skeleton: Skeleton, rotations: Array) -> Array:
    """Translations (n, J, 3) of joints that stay where they are at rest."""
    return np.tile(rest_of(skeleton).offsets, (len(rotations), 1, 1))


def smooth(frames: int = 60) -> Array:
    part = np.clip((np.arange(frames + 30) - 15) / frames, 0, 1)
    return part * part * (3 - 2 * part)


def named(skeleton: Skeleton, rotations: Array) -> list[tuple[str, str, str]]:
    found = suggest_movements(skeleton, rest_of(skeleton), offsets_of(skeleton, rotations), rotations, 1 / 60)
    check_possible(found)
    return [(one.part, one.side, one.movement) for one in found]


def check_possible(found: list[Suggestion]) -> None:
    for one in found:
        meant = parse(str(MotionName(one.side, one.part, one.movement)))
        assert meant == MotionName(one.side, one.part, one.movement)
        assert 0 < one.confidence <= 1
        assert one.first <= one.last


def cases() -> Iterator[tuple[str, str, str, str, Array, bool]]:
    """(part, side, movement, joint, axis, whether it is the opposite)."""
    for (part, names), (joint, axis) in MOVEMENTS.items():
        sides = ("left", "right") if joint.startswith("left_") else ("",)
        for side in sides:
            # An axis of rotation in a mirror keeps its part across the mirror.
            vector = np.array(axis) * ([1, -1, -1] if side == "right" else [1, 1, 1])
            for opposite, movement in enumerate(names.split()):
                yield part, side, movement, joint.replace("left", side or "left"), vector, bool(opposite)


def _words(case: tuple[str, str, str, str, Array, bool]) -> tuple[str, str, str, str]:
    return case[1], case[0], case[2], case[3]


BODIES = [(case, False) for case in cases()] + [(case, True) for case in cases() if case[3].partition("_")[2] in ARM]


@pytest.mark.parametrize(
    "body_case", fuzz.share(BODIES, 3), ids=["-".join((*_words(case), str(out))) for case, out in BODIES]
)
def test_one_joint_moving_is_one_name(body_case: tuple[tuple[str, str, str, str, Array, bool], bool]) -> None:
    case, arms_out = body_case
    part, side, movement, joint, axis, opposite = case
    # What is right is left in a mirror.
    for turn in (2.1,) if arms_out or side == "right" else (0.0, 2.1):
        skeleton = body(arms_out, turn)
        angles = np.radians(45) * (smooth()[::-1] if opposite else smooth())
        path = Rotation.from_rotvec(angles[:, None] * axis)
        assert named(skeleton, made(skeleton, arms_out, turn, joint, path)) == [(part, side, movement)]


@pytest.mark.parametrize("arms_out", [False, True])
@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(("part", "joint"), [("arm", "up_arm"), ("leg", "up_leg")])
def test_a_limb_held_out_moves_horizontally(part: str, joint: str, side: str, arms_out: bool) -> None:
    mirror = 1.0 if side == "left" else -1.0
    skeleton = body(arms_out, 0.0)
    held = Rotation.from_rotvec([0, 0, mirror * np.pi / 2])
    for movement, angle in (("horizontal-adduction", -1.0), ("horizontal-abduction", 0.7)):
        path = Rotation.from_rotvec(smooth()[:, None] * [0, angle * mirror, 0]) * held
        assert named(skeleton, made(skeleton, arms_out, 0.0, f"{side}_{joint}", path)) == [(part, side, movement)]


def test_what_is_little_of_a_movement_is_not_named() -> None:
    skeleton = body(False, 0.0)

    def arm(path: Rotation) -> set[str]:
        return {movement for _, _, movement in named(skeleton, made(skeleton, False, 0.0, "left_up_arm", path))}

    angles = np.radians(45) * smooth()[:, None]
    slant, aside = np.array([-SLANT, 0, SLANT]), np.array([-0.95, 0, 0.312])
    assert arm(Rotation.from_rotvec(angles * slant)) == {"flexion", "abduction"}
    assert arm(Rotation.from_rotvec(angles * aside)) == {"flexion"}
    # A limb that is lifted by less than 45 degrees does not move horizontally.
    low = Rotation.from_rotvec([0, 0, np.radians(30)])
    assert not any("horizontal" in name for name in arm(Rotation.from_rotvec(-2 * angles * [0, 1, 0]) * low))


CIRCLES = {"head": "Head", "neck": "neck1", "trunk": "waist", "shoulder": "left_shoulder", "arm": "right_up_arm",
           "wrist": "left_hand", "leg": "left_up_leg", "foot": "right_foot", "fingers": "left_fingers",
           "finger-two": "left_finger_two", "thumb": "right_finger_one"}  # fmt: skip


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("part", CIRCLES)
def test_going_round_is_circumduction(part: str, way: int) -> None:
    joint = CIRCLES[part]
    skeleton = body(False, 0.0)
    index = skeleton.names.index(joint)
    children = [numbers for numbers in skeleton.joints if numbers.parent == index]
    offset = children[0].offset if children else skeleton.joints[index].end_sites[0].offset
    assert offset is not None
    bone = np.array([float(text) for text in offset])
    bone /= np.linalg.norm(bone)
    across = np.cross(bone, [0.3, 0.5, 0.8])
    across /= np.linalg.norm(across)
    round_ = np.concatenate([np.zeros(10), np.linspace(0, 2 * np.pi, 100), np.full(10, 2 * np.pi)])[:, None] * way
    tilt = np.cos(round_) * across + np.sin(round_) * np.cross(bone, across)
    path = Rotation.from_rotvec(np.radians(28) * tilt)
    side = joint.partition("_")[0] if "_" in joint else ""
    assert named(skeleton, made(skeleton, False, 0.0, joint, path)) == [(part, side, "circumduction")]


def test_a_walk_does_not_turn_the_reference() -> None:
    """A body that has turned round still tilts its pelvis forward."""
    skeleton = body(False, 0.0)
    angles = np.concatenate([np.zeros(60), np.radians(40) * smooth()])
    faced = Rotation.from_rotvec([0, 2.5, 0])
    path = faced * Rotation.from_rotvec(angles[:, None] * [1, 0, 0])
    assert named(skeleton, made(skeleton, False, 0.0, "Root", path)) == [("pelvis", "", "anterior-tilt")]


@fuzz.examples(15)
@given(seed=st.integers(0, 100_000))
def test_no_impossible_name_is_made(seed: int) -> None:
    rng = np.random.default_rng(seed)
    skeleton = body(bool(seed % 2), rng.uniform(-3, 3))
    keys = Rotation.random(5 * len(skeleton), random_state=rng).as_rotvec().reshape(5, len(skeleton), 3)
    at = np.linspace(0, 4, 120)
    low = np.minimum(at.astype(int), 3)
    part = (at - low)[:, None, None]
    vectors = keys[low] + part * (keys[low + 1] - keys[low])
    rotations = Rotation.from_rotvec(vectors.reshape(-1, 3)).as_quat().reshape(120, len(skeleton), 4)
    found = suggest_movements(skeleton, rest_of(skeleton), offsets_of(skeleton, rotations), rotations, 1 / 60)
    check_possible(found)
    assert len(found) > 10


def test_every_part_of_the_vocabulary_with_joints_is_there() -> None:
    ours = {part.name for part in PARTS}
    assert ours == {name for name, part in parts().items() if part.joints and part.movements}
    assert set(CIRCLING) == {name for name, part in parts().items() if "circumduction" in part.movements}


def test_stillness_has_no_names() -> None:
    skeleton = body(False, 0.0)
    still = made(skeleton, False, 0.0, "Root", Rotation.from_rotvec(np.zeros((50, 3))))
    assert suggest_movements(skeleton, rest_of(skeleton), offsets_of(skeleton, still), still, 1 / 60) == []
    assert suggest_movements(skeleton, rest_of(skeleton), offsets_of(skeleton, still)[:1], still[:1], 1 / 60) == []
    with pytest.raises(ConversionError):
        suggest_movements(skeleton, rest_of(skeleton), offsets_of(skeleton, still), still, 0.0)


@pytest.mark.parametrize("turn", [0.0, 2.0])
@pytest.mark.parametrize("joint", ["left_up_arm", "right_low_arm", "left_low_leg", "Head"])
def test_offsets_that_come_with_the_motion(joint: str, turn: float) -> None:
    """A rig that lies in a heap at rest has the names of the one whose offsets stand in its skeleton."""
    skeleton = body(False, turn)
    path = Rotation.from_rotvec(np.outer(smooth(), [-1.2, 0, 0]))
    rotations = made(skeleton, False, turn, joint, path)
    nowhere = ("0", "0", "0")
    heap = Skeleton(
        tuple(replace(one, offset=nowhere, channels=("Tx", "Ty", "Tz", *one.channels)) for one in skeleton.joints)
    )
    moved = offsets_of(skeleton, rotations)
    expected = suggest_movements(skeleton, rest_of(skeleton), moved, rotations, 1 / 60)
    assert expected
    assert suggest_movements(heap, rest_of(heap), moved, rotations, 1 / 60) == expected
    # Someone who lies before standing up is looked at where they stand.
    lying = rotations[:1].repeat(40, axis=0)
    lying[:, 0] = (Rotation.from_rotvec([0, 0, np.pi / 2]) * Rotation.from_quat(lying[:, 0])).as_quat()
    both, where = np.concatenate([lying, rotations]), np.concatenate([moved[:1].repeat(40, axis=0), moved])
    later = suggest_movements(heap, rest_of(heap), where, both, 1 / 60)
    wanted = {(one.part, one.side, one.movement) for one in expected}
    assert wanted <= {(one.part, one.side, one.movement) for one in later if one.first > 35}


def test_where_names_tell_no_sides_someone_must_say() -> None:
    middle = [one for one in body(False, 0.0).joints if one.name in MIDDLE]
    places = {one.name: index for index, one in enumerate(middle)}
    joints = [replace(one, parent=places.get(MIDDLE[one.name][0], -1)) for one in middle]
    skeleton = Skeleton(tuple(joints))
    rotations = made(skeleton, False, 0.0, "Head", Rotation.from_rotvec(np.outer(smooth(), [1.0, 0, 0])))
    moved = offsets_of(skeleton, rotations)
    with pytest.raises(ConversionError, match="nothing tells left from right"):
        suggest_movements(skeleton, rest_of(skeleton), moved, rotations, 1 / 60)
    bends = {"Z": "flexion", "-Z": "extension", "X": "right-lateral-flexion", "-X": "left-lateral-flexion"}
    for facing, movement in bends.items():
        found = suggest_movements(skeleton, rest_of(skeleton), moved, rotations, 1 / 60, facing=facing)
        assert [(one.part, one.movement) for one in found] == [("head", movement)], facing
    with pytest.raises(ConversionError, match="nothing tells left from right"):
        suggest_movements(skeleton, rest_of(skeleton), moved, rotations, 1 / 60, facing="Y")


def real(shared: Path, name: str, frame_time: float) -> list[Suggestion]:
    clip = opened(shared / name)
    skeleton, reading = assign(clip.head.skeleton), reading_of(clip.head)
    hub = HubReader(skeleton, reading).read(joined(clip.blocks()))
    found = suggest_movements(skeleton, rest_of(skeleton, reading), hub.translations, hub.rotations, frame_time)
    check_possible(found)
    return found


def names_of(found: list[Suggestion]) -> set[tuple[str, str, str]]:
    return {(one.part, one.side, one.movement) for one in found}


@pytest.mark.parametrize(("name", "rate"), [("asfamc/cmu02/02_lf_01.amc", 120), ("asfamc/cmu_misc/07_05-walk.amc", 120),
                                            ("bvh/bandai/dataset-1_walk_normal_001.bvh", 30)])  # fmt: skip
def test_a_walk_swings_legs_and_bends_knees(shared: Path, name: str, rate: int) -> None:
    found = names_of(real(shared, name, 1 / rate))
    for side in ("left", "right"):
        for part, movement in (("leg", "flexion"), ("leg", "extension"), ("knee", "flexion"), ("knee", "extension")):
            assert (part, side, movement) in found


def test_a_raised_hand_a_wave_and_a_bow(shared: Path) -> None:
    raised = real(shared, "bvh/bandai_reach/dataset-2_raise-up-right-hand_normal_001.bvh", 1 / 30)
    lifted = {one.movement for one in raised if (one.part, one.side) == ("arm", "right")}
    assert lifted & {"flexion", "abduction"}
    assert lifted & {"extension", "adduction"}
    busiest = max(raised, key=lambda one: one.degrees)
    assert busiest.side == "right"
    waved = real(shared, "bvh/bandai/dataset-1_bye_happy_001.bvh", 1 / 30)
    assert ("elbow", "right", "flexion") in names_of(waved)
    assert max(waved, key=lambda one: one.degrees).side == "right"
    bowed = real(shared, "bvh/bandai/dataset-1_bow_normal_001.bvh", 1 / 30)
    assert {("trunk", "", "flexion"), ("trunk", "", "extension")} <= names_of(bowed)
