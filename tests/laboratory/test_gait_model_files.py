"""The gait model on public trials of laboratories, against the values that the laboratory's own program wrote."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mcml
from mcml.files.motion import Motion
from mcml.formats.c3d.analog import read_channels
from mcml.formats.c3d.subjects import read_measures
from mcml.laboratory.gait_model.measures import clean_measures
from mcml.motion.skeleton import Array

ANGLES = ("Pelvis", "Hip", "Knee", "Ankle", "FootProgress")
UPPER = ("Thorax", "Head", "Neck", "Spine", "Shoulder", "Elbow", "Wrist")
WALKS = ("hc030a05", "s4_am_gait04", "mh0222_bp06")


@cache
def read(path: Path) -> Motion:
    return mcml.read(path)


@pytest.fixture
def lab(shared: Path) -> Path:
    if not (shared / "lab" / "expected.json").exists():
        pytest.skip("the trials of laboratories are not here (set MCML_SHARED to their folder)")
    return shared / "lab"


@pytest.fixture
def expected(lab: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((lab / "expected.json").read_text())
    return found


def vectors(motion: Motion, name: str) -> Array:
    return np.stack([motion.quantity(name, axis) for axis in "xyz"], axis=1)


def differences(motion: Motion, name: str) -> Array:
    """(3,) rms of a computed quantity from that of the file, over frames in which both are known."""
    away = vectors(motion, f"cgm1:{name}") - vectors(motion, name)
    away = away[np.isfinite(away).all(axis=1)]
    assert len(away) > 20, name
    rms: Array = np.sqrt(np.mean(away**2, axis=0))
    return rms


@pytest.mark.parametrize("trial", [*WALKS, "s4_am_cal_01"])
@pytest.mark.parametrize("side", "LR")
def test_angles_are_those_of_the_laboratory(lab: Path, trial: str, side: str) -> None:
    motion = read(lab / f"{trial}.c3d")
    for part in ANGLES:
        most = 0.07 if part in ("Ankle", "FootProgress") else 0.05
        assert (differences(motion, f"{side}{part}Angles") <= most).all(), part


@pytest.mark.parametrize("side", "LR")
def test_angles_of_the_upper_body_are_those_of_the_laboratory(lab: Path, side: str) -> None:
    for part in UPPER:
        assert (differences(read(lab / "hc030a05.c3d"), f"{side}{part}Angles") <= 0.02).all(), part


@pytest.mark.parametrize("side", "LR")
def test_on_a_belt_with_other_markers_under_the_same_names(lab: Path, side: str) -> None:
    motion = read(lab / "treadmill_events.c3d")
    for part in ("Pelvis", "Hip", "Knee", "Thorax", "Spine"):
        assert (differences(motion, f"{side}{part}Angles") <= 0.3).all(), part
    (ankle,) = [each for each in motion.measurements if each.name == f"cgm1:{side}AnkleAngles"]
    assert any("no offsets of a standing trial" in note for note in ankle.notes)


@pytest.mark.parametrize("trial", [*WALKS, "treadmill_events", "s4_am_cal_01"])
def test_computed_angles_are_near_those_expected(lab: Path, expected: dict[str, Any], trial: str) -> None:
    motion, facts = read(lab / f"{trial}.c3d"), expected[f"{trial}.c3d"]
    for name, rms in facts["cgm_rms_deg_against_file"].items():
        if not name.endswith("Angles"):
            continue
        for frame, stored in facts["vendor_angles_deg_at_frame_index"][name].items():
            np.testing.assert_allclose(vectors(motion, name)[int(frame)], stored, atol=1e-3, err_msg=name)
            computed = vectors(motion, f"cgm1:{name}")[int(frame)]
            assert (np.abs(computed - stored) <= 4 * np.array(rms) + 0.01).all(), (name, frame)


@pytest.mark.parametrize("trial", WALKS)
def test_moments_and_powers_are_near_those_of_the_laboratory(lab: Path, trial: str) -> None:
    motion = read(lab / f"{trial}.c3d")
    most = {"Ankle": (7, 1.5, 3.5), "Knee": (7.5, 8.2, 2.6), "Hip": (14.5, 14.5, 2.5)}
    for side in "LR":
        for joint, bounds in most.items():
            assert (differences(motion, f"{side}{joint}Moment") <= bounds).all(), (side, joint)
            assert differences(motion, f"{side}{joint}Power")[2] <= 0.1, (side, joint)


def test_medians_of_moments_and_powers(lab: Path) -> None:
    most = {"AnkleMoment": (5.6, 1, 1.8), "KneeMoment": (6.2, 5.2, 1.7), "HipMoment": (12.2, 7.5, 1.5),
            "AnklePower": (0, 0, 0.06), "KneePower": (0, 0, 0.03), "HipPower": (0, 0, 0.03)}  # fmt: skip
    for name, bounds in most.items():
        rms = [differences(read(lab / f"{trial}.c3d"), side + name) for trial in WALKS for side in "LR"]
        assert (np.median(rms, axis=0) <= np.array(bounds) + 1e-9).all(), (name, np.median(rms, axis=0))


def test_moments_and_powers_of_the_file_are_those_expected(lab: Path, expected: dict[str, Any]) -> None:
    for trial in WALKS:
        motion, facts = read(lab / f"{trial}.c3d"), expected[f"{trial}.c3d"]
        for name, by_frame in facts["vendor_moments_powers_at_frame_index"].items():
            for frame, stored in by_frame.items():
                np.testing.assert_allclose(vectors(motion, name)[int(frame)], stored, atol=1e-3, err_msg=name)
        units = {each.name: (each.unit, each.notes) for each in motion.measurements}
        unit, notes = units["LAnklePower"]
        assert unit == "W/kg"
        assert any("the file states W" in note for note in notes)


def test_the_static_trial_tells_its_own_offsets(lab: Path, expected: dict[str, Any]) -> None:
    motion, facts = read(lab / "s4_am_cal_01.c3d"), expected["s4_am_cal_01.c3d"]
    measures = {each.name: each.value for each in motion.measure_standing().measures}
    for side in "LR":
        names = [f"{side}StaticPlantFlex", f"{side}StaticRotOff"]
        found = [np.degrees(measures[name]) for name in names]
        np.testing.assert_allclose(found, facts["static_offsets_deg"][side], atol=0.01)
        for name, degrees in facts["static_measures_deg"][side].items():
            assert np.degrees(measures[side + name]) == pytest.approx(degrees, abs=0.01), name
    (ankle,) = [each for each in motion.measurements if each.name == "cgm1:LAnkleAngles"]
    assert any("heel set to the height of the toe" in note for note in ankle.notes)


def test_a_walk_takes_the_offsets_of_another_standing_trial(lab: Path) -> None:
    walk = read(lab / "s4_am_gait04.c3d")
    calibrated = walk.with_standing_trial(read(lab / "s4_am_cal_01.c3d"))
    assert not any("stays unknown" in note for note in calibrated.notices)
    # The wand of this walk was measured in another standing trial, 3 degrees away.
    turned = vectors(calibrated, "cgm1:LHipAngles")[:, 2] - vectors(walk, "cgm1:LHipAngles")[:, 2]
    assert np.nanmedian(np.abs(turned)) == pytest.approx(4.6, abs=0.5)
    np.testing.assert_array_equal(vectors(calibrated, "LHipAngles"), vectors(walk, "LHipAngles"))


def test_measures_of_a_file(lab: Path, expected: dict[str, Any]) -> None:
    for trial in WALKS:
        with (lab / f"{trial}.c3d").open("rb") as stream:
            measures = clean_measures(read_measures(read_channels(stream).said))
        facts = expected[f"{trial}.c3d"]
        assert measures.get("Bodymass") == pytest.approx(facts["body_mass_kg"])
        assert measures.get("MarkerDiameter") == facts["marker_diameter_in_file"]


def test_other_landmark_sets_agree_in_flexion_and_not_in_rotation(lab: Path) -> None:
    motion = read(lab / "treadmill_events.c3d")
    for side in "LR":
        for joint in ("Hip", "Knee"):
            own = motion.quantity(f"{side}{joint}Angles", "x")
            other = motion.quantity(f"landmarks:{side}{joint}Angles", "x")
            away = other - own
            assert np.corrcoef(own, other)[0, 1] >= 0.997
            assert np.std(away) <= 1.6
            assert -7.0 < away.mean() < -2.0
        away = motion.quantity(f"landmarks:{side}HipAngles", "y") - motion.quantity(f"{side}HipAngles", "y")
        assert np.std(away) <= 0.7


def test_centres_of_a_file_stand_in_for_its_measures(lab: Path) -> None:
    motion = read(lab / "walking5.c3d")
    listed = {each.name: each for each in motion.measurements if each.function == "quantity"}
    assert listed["LKneeAngles"].known
    assert any("landmarks" in note for note in listed["LKneeAngles"].notes)
    knee = motion.quantity("LKneeAngles", "x")
    assert 50 < np.nanmax(knee) < 80
    with pytest.raises(mcml.errors.NotFoundError, match="LKneeWidth"):
        motion.quantity("cgm1:LKneeAngles", "x")


def test_a_file_without_measures_names_them(lab: Path) -> None:
    motion = read(lab / "cb_dynamic0003.c3d")
    listed = {each.name: each for each in motion.measurements if each.function == "quantity"}
    assert listed["LPelvisAngles"].known
    assert not listed["LKneeAngles"].known
    assert "measure LLegLength" in listed["LKneeAngles"].reason
    with pytest.raises(mcml.errors.NotFoundError, match="measure LLegLength"):
        motion.quantity("LKneeAngles", "x")
