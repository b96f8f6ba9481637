"""Standing trials: the measures that they tell, and walking trials that take them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import mcml
from mcml.errors import ConversionError
from mcml.files.motion import Motion
from mcml.laboratory.gait_model.standing_trial import StandingTrial
from mcml.motion.skeleton import Array
from tests.laboratory.gait_files import (
    LENGTHS,
    OTHER_TURNS,
    STANDING,
    TURNS,
    WALKING,
    gait_file,
    stand,
    two_people,
    walk,
    without_angles,
)

Read = Callable[..., Motion]


@pytest.fixture
def read(tmp_path: Path) -> Read:
    def read_file(content: bytes, name: str = "trial") -> Motion:
        path = tmp_path / f"{name}.c3d"
        path.write_bytes(content)
        return mcml.read(path)

    return read_file


def values(trial: StandingTrial) -> dict[str, float]:
    assert trial.lacks == ""
    return {each.name: each.value for each in trial.measures}


def angles(motion: Motion, name: str) -> Array:
    return np.stack([motion.quantity(name, axis) for axis in "xyz"], axis=1)


def test_medial_markers_tell_how_wands_and_ankles_are_turned(read: Read) -> None:
    trial = read(gait_file(stand(), LENGTHS)).measure_standing()
    told = values(trial)
    for side, turns in (("L", TURNS), ("R", OTHER_TURNS)):
        for name, turn in turns.items():
            assert told[side + name] == pytest.approx(turn, abs=2e-5), side + name
    sources = {each.name: each.source for each in trial.measures}
    assert sources["LThighRotation"] == "medial knee marker"
    assert sources["RTibialTorsion"] == "medial ankle marker"
    assert sources["LStaticPlantFlex"] == "heel and toe"
    assert sources["LKneeWidth"] == "stated"


def test_a_walking_trial_has_the_angles_of_its_joints_with_them_alone(read: Read) -> None:
    walking = read(gait_file(walk(poses=WALKING), LENGTHS), "walk")
    calibrated = walking.with_standing_trial(read(gait_file(stand(), LENGTHS), "static"))
    for side, pose in WALKING.items():
        for name, true in (("Hip", pose.hip), ("Knee", pose.knee)):
            found, plain = (angles(motion, f"{side}{name}Angles") for motion in (calibrated, walking))
            np.testing.assert_allclose(found, [true] * len(found), atol=5e-3)
            assert np.abs(plain - true).max() > 0.5, name
    (knee,) = [each for each in calibrated.measurements if each.name == "LKneeAngles"]
    assert any("standing trial 'static'" in note for note in knee.notes)


def test_a_walk_in_the_pose_of_the_standing_trial_has_its_angles(read: Read) -> None:
    standing = read(gait_file(stand(), LENGTHS), "static")
    calibrated = read(gait_file(walk(poses=STANDING), LENGTHS), "walk").with_standing_trial(standing)
    for side in "LR":
        found, true = (angles(each, f"{side}KneeAngles")[0, :2] for each in (calibrated, standing))
        np.testing.assert_allclose(found, true, atol=1e-3)
        # The program turns the foot of a standing trial by the ankle's axis, that of a walk by the knee's.
        found, true = (angles(each, f"{side}AnkleAngles")[0, 0] for each in (calibrated, standing))
        assert found == pytest.approx(true, abs=0.1)


def test_widths_and_legs_that_nobody_measured_are_those_of_medial_markers(read: Read) -> None:
    bare = without_angles(LENGTHS, "KneeWidth", "AnkleWidth", "LegLength", "InterAsisDistance")
    told = values(read(gait_file(stand(), bare)).measure_standing())
    for name in ("LKneeWidth", "RKneeWidth", "LAnkleWidth", "RAnkleWidth"):
        assert told[name] == pytest.approx(LENGTHS[name], abs=0.01), name
    markers = stand(1)
    leg = np.linalg.norm(markers["LASI"] - markers["LMED"])
    assert told["LLegLength"] == pytest.approx(leg, abs=0.01)
    assert told["InterAsisDistance"] == pytest.approx(240.0, abs=0.01)
    walking = read(gait_file(walk(poses=WALKING), bare), "walk")
    assert "measure LLegLength" in next(each.reason for each in walking.measurements if each.name == "LKneeAngles")
    calibrated = walking.with_standing_trial(read(gait_file(stand(), bare), "static"))
    np.testing.assert_allclose(angles(calibrated, "LKneeAngles")[:, 0], WALKING["L"].knee[0], atol=0.5)


def test_measures_of_the_body_that_a_walking_trial_states_stay(read: Read) -> None:
    own = LENGTHS | {"LKneeWidth": 120.0}
    walking = read(gait_file(walk(poses=WALKING), own), "walk")
    calibrated = walking.with_standing_trial(read(gait_file(stand(), LENGTHS), "static"))
    assert "LKneeWidth stays 120 mm; the standing trial has 100 mm" in calibrated.notices
    properties = {name: value for name, value, _ in calibrated.properties}
    assert float(properties["gait LKneeWidth"]) == 120.0
    assert properties["gait standing trial"] == "static"


def test_another_standing_trial_takes_the_place_of_the_first(read: Read) -> None:
    first = read(gait_file(stand(), LENGTHS), "first")
    markers = {name: place for name, place in stand().items() if name[1:] not in ("KNM", "MED")}
    second = read(gait_file(markers, LENGTHS), "second")
    walking = read(gait_file(walk(poses=WALKING), LENGTHS), "walk")
    again = walking.with_standing_trial(first).with_standing_trial(second)
    assert sorted(again.properties) == sorted(walking.with_standing_trial(second).properties)
    assert not any("ThighRotation" in name for name, *_ in again.properties)


@pytest.mark.parametrize(
    ("content", "lack"),
    [
        (gait_file(walk(), LENGTHS), "move by more than 100 mm"),
        (gait_file({"LASI": walk()["LASI"]}, LENGTHS), "markers"),
        (gait_file({name: place for name, place in stand().items() if name[1:] != "HEE"}, LENGTHS), "marker LHEE"),
    ],
)
def test_trials_that_tell_nothing_are_refused_with_the_reason(read: Read, content: bytes, lack: str) -> None:
    trial = read(content)
    assert lack in trial.measure_standing().lacks
    walking = read(gait_file(walk(), LENGTHS), "walk")
    with pytest.raises(ConversionError, match="is no standing trial"):
        walking.with_standing_trial(trial)


def test_each_of_several_people_has_a_standing_trial(read: Read) -> None:
    people = two_people()
    markers = {f"{name}:{label}": place for name, (own, _) in people.items() for label, place in own.items()}
    both = read(gait_file(markers, {}, subjects=list(people)), "walk")
    standing = read(gait_file(stand(), LENGTHS, prefix="Anna:", subjects=["Anna"]), "static")
    calibrated = both.with_standing_trial(standing, subject="Anna")
    assert "several people" in both.measure_standing().lacks
    named = [name for name, *_ in calibrated.properties if "ThighRotation" in name]
    assert named == ["gait Anna LThighRotation", "gait Anna RThighRotation"]
