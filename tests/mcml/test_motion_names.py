"""Which motion names are possible: every pair of part and movement, against the table written out here again."""

from __future__ import annotations

import doctest
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import VocabularyError
from mcml.language import lexical, motion_names
from mcml.language.joint_names import table
from mcml.language.motion_names import SIDES, MotionName, canonical, movements, parse, parts

# The table of movements as anatomy books have it, in the letters of its column heads.
F, E, AB, AD = "flexion", "extension", "abduction", "adduction"
C, EL, DE, PR, RE = "circumduction", "elevation", "depression", "protraction", "retraction"
TURNS = ("left-rotation", "right-rotation", "left-lateral-flexion", "right-lateral-flexion")
LONG_AXIS = ("medial-rotation", "lateral-rotation")
ACROSS = ("horizontal-abduction", "horizontal-adduction")
POSSIBLE = {
    "head": {F, E, *TURNS, C, PR, RE},
    "neck": {F, E, *TURNS, C, PR, RE},
    "trunk": {F, E, *TURNS, C},
    "pelvis": {*TURNS, "anterior-tilt", "posterior-tilt", "left-obliquity", "right-obliquity"},
    "jaw": {EL, DE, PR, RE, "left-lateral-deviation", "right-lateral-deviation"},
    "shoulder": {C, EL, DE, PR, RE, "upward-rotation", "downward-rotation"},
    "arm": {F, E, AB, AD, *LONG_AXIS, C, *ACROSS},
    "elbow": {F, E},
    "forearm": {F, E, "pronation", "supination"},
    "wrist": {F, E, AB, AD, C, "radial-deviation", "ulnar-deviation"},
    "hand": {F, E, AB, AD, C, "radial-deviation", "ulnar-deviation", "pronation", "supination"},
    "thumb": {F, E, AB, AD, C, "opposition", "reposition"},
    "leg": {F, E, AB, AD, *LONG_AXIS, C, *ACROSS},
    "knee": {F, E, *LONG_AXIS},
    "foot": {"dorsiflexion", "plantarflexion", "inversion", "eversion", "pronation", "supination", C},
    **{part: {F, E, AB, AD, C} for part in ("fingers", "finger-two", "finger-three", "finger-four", "finger-five")},
    **{part: {F, E, AB, AD} for part in ("toes", "toe-one", "toe-two", "toe-three", "toe-four", "toe-five")},
}
AXIAL = {"head", "neck", "trunk", "pelvis", "jaw"}


def possible_names() -> Iterator[str]:
    for part in parts().values():
        for side in SIDES if part.sided else ("",):
            yield from (str(MotionName(side, part.name, movement)) for movement in part.movements)


def test_every_part_is_in_the_table() -> None:
    assert set(parts()) == set(POSSIBLE)
    assert {name for name, part in parts().items() if not part.sided} == AXIAL
    assert {movement for possible in POSSIBLE.values() for movement in possible} <= set(movements())


@pytest.mark.parametrize("part", POSSIBLE)
def test_every_pair_of_part_and_movement(part: str) -> None:
    side = "" if part in AXIAL else "left-"
    for movement in movements():
        name = f"{side}{part}-{movement}"
        if movement in POSSIBLE[part]:
            stored = canonical(name)
            assert canonical(stored) == stored
            assert stored in set(possible_names())
        else:
            with pytest.raises(VocabularyError) as caught:
                canonical(name)
            nearest = str(caught.value.details["suggestion"])
            assert canonical(nearest) == nearest
            assert nearest in str(caught.value)


@pytest.mark.parametrize("part", POSSIBLE)
def test_sided_parts_need_a_side_and_axial_ones_must_not_have_one(part: str) -> None:
    movement = sorted(POSSIBLE[part])[0]
    wrong = f"{part}-{movement}" if part not in AXIAL else f"left-{part}-{movement}"
    with pytest.raises(VocabularyError, match="which side" if part not in AXIAL else "only one|not an anatomical"):
        canonical(wrong)
    if part not in AXIAL:
        assert canonical(f"both-{part}-{movement}").startswith("both-")


@pytest.mark.parametrize(
    ("said", "stored"),
    [
        ("left-arm_abduction", "left-arm-abduction"),
        ("left-arm-front", "left-arm-flexion"),
        ("Left Arm Back", "left-arm-extension"),
        ("right-upper-arm-internal-rotation", "right-arm-medial-rotation"),
        ("back-bend", "trunk-flexion"),
        ("left-hip-abduction", "left-leg-abduction"),
        ("right-hand-supination", "right-forearm-supination"),
        ("left-low-arm-flexion", "left-elbow-flexion"),
        ("left-wrist-radial-deviation", "left-wrist-abduction"),
        ("left-finger-one-opposition", "left-thumb-opposition"),
        ("pelvis-left-obliquity", "pelvis-left-lateral-flexion"),
        ("head-left-rotation", "head-left-rotation"),
    ],
)
def test_synonyms(said: str, stored: str) -> None:
    assert canonical(said) == stored
    assert canonical(said, strict=True) == stored


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("left-shoulder-abduction", "left-arm-abduction"),
        ("right-shoulder-flexion", "right-arm-flexion"),
        ("left-foot-flexion", "left-foot-plantarflexion"),
        ("left-head-rotation", "head-left-rotation"),
        ("left-arm-pronation", "left-arm-medial-rotation"),
        ("arm-flexion", "left-arm-flexion"),
    ],
)
def test_impossible_names_are_refused_with_the_nearest_possible_one(said: str, meant: str) -> None:
    with pytest.raises(VocabularyError) as caught:
        canonical(said)
    assert caught.value.details["suggestion"] == meant


@pytest.mark.parametrize(
    "name", ["walk", "bar-3", "hand-shake", "arm", "left-arm", "left-turn", "걷기", "Bar 3", "arm-wave"]
)
def test_other_names_are_free_unless_strict(name: str) -> None:
    assert canonical(f" {name}\n") == name
    assert parse(name) is None
    with pytest.raises(VocabularyError, match="only those are allowed"):
        canonical(name, strict=True)


@given(st.text())
def test_canonical_names_are_their_own_canonical_form(name: str) -> None:
    try:
        stored = canonical(name)
    except VocabularyError:
        return
    assert canonical(stored) == stored


def test_joints_are_those_of_table_1() -> None:
    names = {row.name for row in table()}
    for name in possible_names():
        meant = parse(name)
        assert meant is not None
        assert set(meant.joints()) <= names
    both = parse("both-arm-flexion")
    assert both is not None
    assert both.joints() == ("left_up_arm", "right_up_arm")


@pytest.mark.parametrize("module", [lexical, motion_names])
def test_examples_in_docstrings(module: object) -> None:
    result = doctest.testmod(module)  # type: ignore[arg-type]
    assert result.attempted > 0
    assert result.failed == 0
