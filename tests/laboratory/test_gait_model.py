"""The Conventional Gait Model 1 on bodies whose joint angles are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.laboratory.gait_model.measures import Measures, clean_measures
from mcml.laboratory.gait_model.model_body import QUANTITIES, LackError, ModelBody, choose_method, is_load
from mcml.laboratory.gait_model.segment_frames import joint_angles, wrap
from mcml.laboratory.gait_model.subject import Subject, find_laboratory, find_subject, is_standing
from mcml.motion.landmarks.construction import place_centre
from mcml.motion.skeleton import Array
from tests.fuzz import examples
from tests.laboratory.gait_bodies import LENGTHS, LegPose, make_body, mirror, turn

UP = np.array([0.0, 0.0, 1.0])
LEGS = [name for name in QUANTITIES if name[1:] in ("PelvisAngles", "HipAngles", "KneeAngles", "AnkleAngles",
                                                    "FootProgressAngles", "HJC", "KJC", "AJC")]  # fmt: skip


def subject_of(measures: Measures, laboratory: Array | None = None) -> Subject:
    axes = np.eye(3) if laboratory is None else laboratory
    return Subject(measures, 14.0, measures.of("InterAsisDistance", 240.0), 180.0, axes)


def angle(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False)


def triple(low: float, high: float) -> st.SearchStrategy[tuple[float, float, float]]:
    return st.tuples(angle(low, high), angle(-25, 25), angle(-40, 40))


turns = st.fixed_dictionaries(
    {
        "ThighRotation": angle(-0.5, 0.5),
        "ShankRotation": angle(-0.5, 0.5),
        "TibialTorsion": angle(-0.5, 0.5),
        "AnkleAbAdd": angle(-0.2, 0.2),
    }
)
poses = st.builds(LegPose, hip=triple(-30, 70), knee=triple(-10, 100), turns=turns)


@given(left=poses, right=poses, tilt=angle(-30, 30), list_=angle(-20, 20), rotation=angle(-60, 60))
@examples(60)
def test_known_joint_angles_come_back(
    left: LegPose, right: LegPose, tilt: float, list_: float, rotation: float
) -> None:
    pelvis = turn("y", tilt) @ turn("x", list_) @ turn("z", rotation)
    both = {"L": left, "R": right}
    markers, measures, centres = make_body(both, pelvis)
    body = ModelBody(markers, subject_of(measures))
    for side, k in (("L", 1), ("R", -1)):
        np.testing.assert_allclose(body.quantity(f"{side}PelvisAngles")[0], [tilt, k * list_, -k * rotation], atol=1e-6)
        np.testing.assert_allclose(body.quantity(f"{side}HipAngles")[0], both[side].hip, atol=1e-4)
        np.testing.assert_allclose(body.quantity(f"{side}KneeAngles")[0], both[side].knee, atol=1e-4)
        for centre in ("HJC", "KJC", "AJC"):
            np.testing.assert_allclose(body.quantity(side + centre)[0], centres[side + centre], atol=1e-4)


@given(dorsiflexion=angle(-60, 40), flexion=angle(-0.5, 0.5))
@examples(30)
def test_dorsiflexion_is_from_the_right_angle_between_shank_and_foot(dorsiflexion: float, flexion: float) -> None:
    toe = turn("y", -dorsiflexion) @ [1.0, 0.0, 0.0]
    pose = LegPose(toe=toe)
    markers, measures, _ = make_body({"L": pose, "R": replace(pose, turns={"StaticPlantFlex": flexion})})
    body = ModelBody(markers, subject_of(measures))
    np.testing.assert_allclose(body.quantity("LAnkleAngles")[0], [dorsiflexion, 0, 0], atol=1e-6)
    np.testing.assert_allclose(body.quantity("RAnkleAngles")[0], [dorsiflexion + np.degrees(flexion), 0, 0], atol=1e-6)


@given(left=poses, right=poses, tilt=angle(-30, 30), list_=angle(-20, 20), rotation=angle(-60, 60))
@examples(40)
def test_a_body_in_a_mirror_has_the_angles_of_the_other_side(
    left: LegPose, right: LegPose, tilt: float, list_: float, rotation: float
) -> None:
    pelvis = turn("y", tilt) @ turn("x", list_) @ turn("z", rotation)
    markers, measures, _ = make_body({"L": left, "R": right}, pelvis)
    other = {"L": "R", "R": "L"}
    swapped = {other.get(name[0], name[0]) + name[1:]: value for name, value in measures.values.items()}
    values = {name: swapped.get(name, value) if name[0] in other else value for name, value in measures.values.items()}
    body, twin = ModelBody(markers, subject_of(measures)), ModelBody(mirror(markers), subject_of(Measures(values)))
    for name in LEGS:
        expected = body.quantity(name) * ([1.0, -1.0, 1.0] if name.endswith("C") else 1.0)
        np.testing.assert_allclose(twin.quantity(other[name[0]] + name[1:]), expected, atol=1e-6, err_msg=name)


@pytest.mark.parametrize("quarter", range(4))
def test_the_direction_of_the_walk_does_not_matter(quarter: int) -> None:
    turned = turn("z", 90.0 * quarter)
    markers, measures, _ = make_body({"L": LegPose(), "R": LegPose()}, turn("y", 10.0) @ turn("z", 8.0))
    way = np.outer(np.arange(3), [1000.0, 40.0, 0.0])
    walk = {name: place + way for name, place in markers.items()}
    subject = find_subject(measures, {name: places @ turned.T for name, places in walk.items()}, UP)
    np.testing.assert_allclose(subject.laboratory, turned, atol=1e-12)
    body = ModelBody({name: places @ turned.T for name, places in walk.items()}, subject)
    np.testing.assert_allclose(body.quantity("LPelvisAngles"), [[10.0, 0.0, -8.0]] * 3, atol=1e-9)


def test_a_pelvis_that_stays_tells_forward_by_where_it_faces() -> None:
    markers, _, _ = make_body({"L": LegPose(), "R": LegPose()}, turn("z", 170.0))
    axes, note = find_laboratory(markers, UP)
    np.testing.assert_allclose(axes[:, 0], [-1.0, 0.0, 0.0])
    assert "faces" in note


def test_with_y_up_the_laboratory_is_right_handed() -> None:
    markers, _, _ = make_body({"L": LegPose(), "R": LegPose()})
    upright = turn("x", -90.0)
    axes, _ = find_laboratory({name: place @ upright.T for name, place in markers.items()}, upright @ UP)
    np.testing.assert_allclose(axes, upright, atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)


BELOW = {
    "LASI": LEGS,
    "LPSI": LEGS,
    "LTHI": ["LHipAngles", "LKneeAngles", "LAnkleAngles", "LFootProgressAngles", "LKJC", "LAJC"],
    "LKNE": ["LHipAngles", "LKneeAngles", "LAnkleAngles", "LFootProgressAngles", "LKJC", "LAJC"],
    "LTIB": ["LKneeAngles", "LAnkleAngles", "LFootProgressAngles", "LAJC"],
    "LANK": ["LKneeAngles", "LAnkleAngles", "LFootProgressAngles", "LAJC"],
    "LTOE": ["LAnkleAngles", "LFootProgressAngles"],
    "LHEE": [],
}
"""Quantities that a marker leaves unknown in the frames in which it is missing."""


@pytest.mark.parametrize("gone", BELOW)
def test_a_missing_marker_leaves_the_segments_below_unknown_and_nothing_else(gone: str) -> None:
    markers, measures, _ = make_body({"L": LegPose(), "R": LegPose()})
    walk = {name: np.repeat(place, 5, axis=0) for name, place in markers.items()}
    walk[gone][2] = np.nan
    body = ModelBody(walk, subject_of(measures))
    for name in LEGS:
        unknown = np.isnan(body.quantity(name)).all(axis=1)
        assert unknown.tolist() == [False, False, name in BELOW[gone], False, False], name


@pytest.mark.parametrize("gone", ["LKneeWidth", "LAnkleWidth", "LTHI", "LTIB", "LKNE", "LASI"])
def test_what_is_missing_altogether_is_named(gone: str) -> None:
    markers, measures, _ = make_body({"L": LegPose(), "R": LegPose()})
    markers.pop(gone, None)
    body = ModelBody(markers, subject_of(Measures({k: v for k, v in measures.values.items() if k != gone})))
    with pytest.raises(LackError, match=gone):
        body.quantity("LKneeAngles")
    if gone != "LASI":
        body.quantity("RKneeAngles")


def test_a_foot_without_a_toe_leaves_the_knee_known() -> None:
    markers, measures, _ = make_body({"L": LegPose(), "R": LegPose()})
    del markers["LTOE"]
    body = ModelBody(markers, subject_of(measures))
    np.testing.assert_allclose(body.quantity("LKneeAngles")[0], LegPose().knee, atol=1e-6)
    with pytest.raises(LackError, match="LTOE"):
        body.quantity("LAnkleAngles")


def test_a_knee_marker_too_near_to_the_hip_gives_nothing() -> None:
    hip, marker, wand = np.zeros((1, 3)), np.array([[0.0, 30.0, 0.0]]), np.array([[0.0, 30.0, 90.0]])
    assert np.isnan(place_centre(hip, marker, wand, 50.0)).all()


def test_measures_are_degrees_if_one_of_them_exceeds_pi() -> None:
    stated = {"LTibialTorsion": -14.0, "LThighRotation": 2.0, "LKneeWidth": 100.0, "lshankrotation": 0.5}
    cleaned = clean_measures(stated)
    assert cleaned.were_degrees
    assert cleaned.values == pytest.approx(
        {"LTibialTorsion": np.radians(-14.0), "LThighRotation": np.radians(2.0), "LShankRotation": np.radians(0.5),
         "LKneeWidth": 100.0}
    )  # fmt: skip
    plain = clean_measures({"LTibialTorsion": -0.3, "LThighRotation": 2.0})
    assert not plain.were_degrees
    assert plain.values == {"LTibialTorsion": -0.3, "LThighRotation": 2.0}


def test_zero_widths_are_absent_and_zero_angles_are_not() -> None:
    cleaned = clean_measures({"LKneeWidth": 0.0, "MarkerDiameter": 0.0, "LTibialTorsion": 0.0, "RKneeWidth": np.nan})
    assert dict(cleaned.values) == {"LTibialTorsion": 0.0}


@pytest.mark.parametrize("diameter", [9.0, 14.0, 16.0])
def test_the_diameter_of_markers_is_told_by_knee_centres_of_the_file(diameter: float) -> None:
    markers, measures, centres = make_body({"L": LegPose(), "R": LegPose()})
    less = {name: value for name, value in measures.values.items() if name != "MarkerDiameter"}
    for side in "LR":
        less[f"{side}KneeWidth"] += 14.0 - diameter
    assumed = find_subject(Measures(less), markers, UP)
    assert assumed.diameter == 14.0
    assert "assumed" in assumed.diameter_note
    own = {**markers, "LKJC": centres["LKJC"][None], "RKJC": centres["RKJC"][None]}
    told = find_subject(Measures(less), own, UP)
    assert told.diameter == pytest.approx(diameter, abs=1e-6)


def test_method_of_a_leg() -> None:
    markers, measures, centres = make_body({"L": LegPose(), "R": LegPose()})
    subject = subject_of(measures)
    assert choose_method("L", markers, subject) == "cgm1"
    own = markers | {"LHJC": centres["LHJC"][None], "LKJC": centres["LKJC"][None], "LAJC": centres["LAJC"][None]}
    assert choose_method("L", own, subject) == "centres"
    # Without widths the model's own centres do, others need landmarks on both sides.
    bare = subject_of(Measures({k: v for k, v in measures.values.items() if "Width" not in k}))
    assert choose_method("L", own, bare) == "cgm1"
    model = own | {"LFEP": own["LHJC"], "LFEO": own["LKJC"], "LTIO": own["LAJC"]}
    assert choose_method("L", model, bare) == "centres"
    np.testing.assert_allclose(ModelBody(model, bare, "centres").quantity("LKneeAngles")[0], LegPose().knee, atol=1e-6)
    pairs = {"LKneeLateral": markers["LKNE"], "LKneeMedial": 2 * own["LKJC"] - markers["LKNE"],
             "LAnkleLateral": markers["LANK"], "LAnkleMedial": 2 * own["LAJC"] - markers["LANK"],
             "LHeel": markers["LHEE"], "LToe": markers["LTOE"]}  # fmt: skip
    assert choose_method("L", markers | pairs, bare) == "landmarks"


def test_landmarks_give_the_angles_between_their_axes() -> None:
    markers, _, centres = make_body({"L": LegPose(), "R": LegPose()})
    pairs = {"LKneeLateral": markers["LKNE"], "LKneeMedial": 2 * centres["LKJC"] - markers["LKNE"],
             "LAnkleLateral": markers["LANK"], "LAnkleMedial": 2 * centres["LAJC"] - markers["LANK"],
             "LHJC": centres["LHJC"][None], "LHeel": markers["LHEE"], "LToe": markers["LTOE"]}  # fmt: skip
    body = ModelBody(markers | pairs, subject_of(Measures({})), "landmarks")
    np.testing.assert_allclose(body.quantity("LKneeAngles")[0], LegPose().knee, atol=1e-6)
    np.testing.assert_allclose(body.quantity("LHipAngles")[0], LegPose().hip, atol=1e-6)


def test_angles_are_of_rotations_about_three_axes_in_turn() -> None:
    whole = turn("y", 100.0) @ turn("x", -20.0) @ turn("z", 30.0)
    np.testing.assert_allclose(joint_angles(np.eye(3)[None], whole[None]), [[100.0, -20.0, 30.0]], atol=1e-9)
    np.testing.assert_allclose(wrap(np.array([181.0, -180.0, 180.0, -200.0])), [-179.0, 180.0, 180.0, 160.0])


def test_moments_need_force_plates_and_a_mass() -> None:
    markers, measures, _ = make_body({"L": LegPose(), "R": LegPose()})
    with pytest.raises(LackError, match="frame rate"):
        ModelBody(markers, subject_of(measures), find_ground=lambda _: None).quantity("LKneeMoment")  # type: ignore[arg-type,return-value]
    for name in filter(is_load, QUANTITIES):
        with pytest.raises(LackError, match="force plates"):
            ModelBody(markers, subject_of(measures)).quantity(name)
        with pytest.raises(LackError, match="Bodymass"):
            ModelBody(markers, subject_of(Measures({k: v for k, v in LENGTHS.items() if k != "Bodymass"}))).quantity(
                name
            )


def test_forward_is_level_also_where_the_way_goes_up() -> None:
    markers = {
        name: np.repeat(place, 20, axis=0) for name, place in make_body({"L": LegPose(), "R": LegPose()})[0].items()
    }
    for way, expected in (([-60.0, 5.0, 90.0], [-1, 0, 0]), ([4.0, 50.0, -80.0], [0, 1, 0])):
        going = {name: place + np.outer(np.arange(20), way) for name, place in markers.items()}
        axes, note = find_laboratory(going, np.array([0.0, 0.0, 1.0]))
        np.testing.assert_array_equal(axes[:, 0], expected)
        assert np.linalg.det(axes) == pytest.approx(1.0)
        assert "travels" in note


@pytest.mark.parametrize("name", ["LANK", "RANK", "LASI", "RASI"])
def test_nobody_stands_whose_ankle_or_pelvis_moves(name: str) -> None:
    markers = {
        each: np.repeat(place, 40, axis=0) for each, place in make_body({"L": LegPose(), "R": LegPose()})[0].items()
    }
    assert is_standing(markers)
    moving = {**markers, name: markers[name] + np.outer(np.linspace(0, 200, 40), [1.0, 0.0, 0.0])}
    assert not is_standing(moving)
    assert is_standing({**markers, name: markers[name] + np.outer(np.linspace(0, 60, 40), [1.0, 0.0, 0.0])})
    assert not is_standing({**markers, name: np.full((40, 3), np.nan)})


def test_width_and_depth_of_a_pelvis_are_stated_or_those_of_its_markers() -> None:
    markers, measures, _ = make_body({"L": LegPose(), "R": LegPose()})
    up = np.array([0.0, 0.0, 1.0])
    wide = find_subject(measures.with_values({"InterAsisDistance": 250.0}), markers, up)
    own = find_subject(
        Measures({name: value for name, value in LENGTHS.items() if name != "InterAsisDistance"}), markers, up
    )
    assert (wide.width, own.width) == (250.0, pytest.approx(240.0))
    assert own.depth == pytest.approx(180.0)
