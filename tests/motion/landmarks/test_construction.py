"""Centres of joints that no marker has on both sides: their geometry, and how they depend on unit and place."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.language.joint_names import named
from mcml.motion.landmarks.centres import body_names, centres_of, doubtful_names, with_centres
from mcml.motion.landmarks.construction import harrington_hip, place_hip
from mcml.motion.landmarks.sizes import Sizes
from mcml.motion.markers import marker_skeleton
from mcml.motion.rotations import rotate
from mcml.motion.skeleton import Array
from tests.motion.landmarks.standing import NAMES, PLACES, SKELETON


def centre(name: str, positions: Array = PLACES, metres: float | None = 0.001) -> Array:
    """(n, 3) a centre of the body."""
    points = with_centres(centres_of(SKELETON), positions, Sizes(metres))
    return points[:, body_names(SKELETON).index(name)]


def marker(name: str) -> Array:
    return PLACES[0, NAMES.index(name)]


def test_every_joint_of_legs_has_a_rule() -> None:
    rules = {each.name: each.rule for each in centres_of(SKELETON)}
    assert [rules[f"left_{joint}"] for joint in ("up_leg", "low_leg", "foot", "up_arm", "low_arm", "hand")] == [
        "hip", "wand", "wand", "shoulder", "elbow", "mean"
    ]  # fmt: skip
    assert "right_low_arm" not in rules
    assert doubtful_names(SKELETON) == ()
    told = "\n".join(notice.what for notice in named(SKELETON)[1].notices())
    assert "the centre left_up_leg is estimated from left_asis and right_asis and left_psis and right_psis by" in told
    assert "the centre left_low_leg is constructed from left_knee_lateral and left_thigh_tracking" in told


@pytest.mark.parametrize(
    ("joint", "above", "lateral", "share"), [("low_leg", "up_leg", "LKNE", 0.155), ("foot", "low_leg", "LANK", 0.098)]
)
def test_a_centre_is_beside_its_marker_with_a_right_angle(joint: str, above: str, lateral: str, share: float) -> None:
    here, up, outer = centre(f"left_{joint}")[0], centre(f"left_{above}")[0], marker(lateral)
    assert np.linalg.norm(outer - here) == pytest.approx(share * np.linalg.norm(outer - up))
    assert (outer - here) @ (up - here) == pytest.approx(0, abs=1e-6)
    # In the plane of the wand, and towards the middle of the body.
    wand = marker({"LKNE": "LTHI", "LANK": "LTIB"}[lateral])
    assert np.cross(up - here, outer - here) @ (wand - here) == pytest.approx(0, abs=1e-4)
    assert 0 < here[1] < outer[1]


def test_the_hip_is_where_the_regression_says() -> None:
    width, depth = 260.0, np.hypot(180, 10)
    x, y, z = harrington_hip(1, np.array(width), np.array(depth))
    hip = centre("left_up_leg")[0]
    middle = (marker("LASI") + marker("RASI")) / 2
    assert hip[1] == pytest.approx(y)
    assert np.linalg.norm(hip - middle) == pytest.approx(np.linalg.norm([x, y, z]))
    right = centre("right_up_leg")[0]
    np.testing.assert_allclose(hip * [1, -1, 1], right)


@given(
    turn=st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda each: np.linalg.norm(each) > 0.1),
    move=st.tuples(*[st.floats(-5000, 5000)] * 3),
    metres=st.sampled_from([0.001, 0.01, 1.0, 0.0254]),
)
def test_centres_move_with_the_body_in_every_unit(
    turn: tuple[float, ...], move: tuple[float, ...], metres: float
) -> None:
    quaternion = np.array(turn) / np.linalg.norm(turn)
    moved = rotate(np.tile(quaternion, (len(NAMES), 1)), PLACES[0]) + np.array(move)
    points = with_centres(centres_of(SKELETON), moved[None] * (0.001 / metres), Sizes(metres))[0] * (metres / 0.001)
    still = with_centres(centres_of(SKELETON), PLACES, Sizes(0.001))[0]
    expected = rotate(np.tile(quaternion, (len(still), 1)), still) + np.array(move)
    np.testing.assert_allclose(points, expected, atol=1e-5)


def test_hips_need_a_unit_and_all_their_markers() -> None:
    assert np.isnan(centre("left_up_leg", metres=None)).all()
    assert np.isnan(centre("left_low_leg", metres=None)).all()
    assert np.isfinite(centre("Root", metres=None)).all()
    gone = PLACES.repeat(2, axis=0)
    gone[1, NAMES.index("RPSI")] = np.nan
    assert np.isnan(centre("left_up_leg", gone)).all(axis=1).tolist() == [False, True]
    assert np.isnan(place_hip(1, *gone[:, :3].transpose(1, 0, 2), None)).all()


def test_without_a_wand_a_centre_is_a_guess() -> None:
    names = [name for name in NAMES if name not in ("LTHI", "LTIB")]
    skeleton = marker_skeleton(names)
    rules = {each.name: each.rule for each in centres_of(skeleton)}
    assert (rules["left_low_leg"], rules["left_foot"], rules["right_low_leg"]) == ("guess", "guess", "wand")
    assert set(doubtful_names(skeleton)) == {"left_low_leg", "left_foot"}
    told = [notice.what for notice in named(skeleton)[1].notices()]
    assert any("left_low_leg is guessed from left_knee_lateral" in each and "no marker shows" in each for each in told)


def test_centres_of_the_files_own_model_come_first() -> None:
    skeleton = marker_skeleton([*NAMES, *(f"LFE{letter}" for letter in "OALP"), "LHJC"])
    centres = {each.name: each for each in centres_of(skeleton)}
    assert centres["left_up_leg"].landmarks == ("LFEP",)
    assert centres["left_low_leg"].landmarks == ("LFEO",)
    assert centres["right_up_leg"].rule == "hip"
