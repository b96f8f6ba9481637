"""Markers of usual sets, and markers with telling words, are landmarks; centres come from both sides of a joint."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mcml
from mcml.language.joint_names import named
from mcml.motion.landmarks.centres import centres_of, with_centres
from mcml.motion.landmarks.recognise import landmark_by_words, recognise_markers
from mcml.motion.landmarks.sizes import Sizes
from mcml.motion.landmarks.tables import marker_sets
from mcml.motion.markers import marker_skeleton

GAIT = ["LASI", "RASI", "LPSI", "RPSI", "LTHI", "RTHI", "LKNE", "RKNE", "LTIB", "RTIB", "LANK", "RANK", "LHEE", "RHEE",
        "LTOE", "RTOE", "C7", "T10", "CLAV", "STRN", "LSHO", "RSHO"]  # fmt: skip
COCO = ["nose", *(f"{side}_{part}" for part in ("eye", "ear", "shoulder", "elbow", "wrist", "hip", "knee", "ankle")
                  for side in ("left", "right"))]  # fmt: skip


def landmarks(names: list[str]) -> dict[str, str]:
    (body,) = recognise_markers(names)
    return {names[index]: landmark for index, landmark in body.landmarks.items()}


@pytest.mark.parametrize("change", [str, str.lower, lambda name: f"Anna:{name}", lambda name: f"Skeleton_{name}"])
def test_a_set_is_known_by_most_of_its_names(change) -> None:  # type: ignore[no-untyped-def]
    names = [change(name) for name in GAIT]
    (body,) = recognise_markers(names)
    assert body.set_name == "plug-in-gait"
    assert landmarks(names)[change("LKNE")] == "left_knee_lateral"
    assert landmarks(names)[change("RTHI")] == "right_thigh_tracking"


def test_what_a_model_computed_does_not_hide_the_set() -> None:
    computed = [f"{side}{joint}{what}" for side in "LR" for joint in ("Hip", "Knee", "Ankle")
                for what in ("Angles", "Moment", "Power", "Force")]  # fmt: skip
    axes = [f"{stem}{letter}" for stem in ("PEL", "LFE", "RFE", "LTI") for letter in "OALP"]
    names = [*computed, *axes, "*0", "*1", "CentreOfMass", *GAIT]
    (body,) = recognise_markers(names)
    assert (body.set_name, body.markers) == ("plug-in-gait", len(GAIT))


def test_on_a_tie_the_smaller_set_is_meant() -> None:
    (body,) = recognise_markers(COCO)
    assert body.set_name == "coco-17"
    assert body.are_centres
    (told,) = [each.what for each in named(marker_skeleton(COCO))[1].notices() if "17 of 17" in each.what]
    assert "centres of joints" in told


@pytest.mark.parametrize("seed", range(4))
def test_of_two_markers_at_a_landmark_the_place_in_the_file_tells_nothing(seed: int) -> None:
    """Trials with markers of two sets: `LASI` and `LASIS` are one landmark, chosen alike on both sides."""
    names = [*GAIT, "LASIS", "RASIS", "LPSIS", "RPSIS", "L.Knee", "R.Knee", "LLEK", "RLEK", "L_MT2", "R_MT2"]
    shuffled = [names[index] for index in np.random.default_rng(seed).permutation(len(names))]
    assert landmarks(shuffled) == landmarks(names)
    assert {landmarks(shuffled)[name] for name in ("LASI", "RASI")} == {"left_asis", "right_asis"}


def test_several_people_are_several_bodies() -> None:
    names = [f"{who}:{name}" for who in ("Anna", "Bea") for name in GAIT]
    first, second = recognise_markers(names)
    assert (first.prefix, second.prefix) == ("Anna", "Bea")
    assert first.landmarks.keys().isdisjoint(second.landmarks)


@pytest.mark.parametrize(
    ("name", "landmark"),
    [
        ("R.Knee.Medial", "right_knee_medial"),
        ("RLFC", "right_knee_lateral"),
        ("ASISr", "right_asis"),
        ("LeftHeel", "left_heel"),
        ("L.Elbow", "left_elbow_lateral"),
        ("C7", "c7"),
        ("heel", None),
        ("Wand1", None),
        ("knee", None),
    ],
)
def test_single_markers_by_words(name: str, landmark: str | None) -> None:
    assert landmark_by_words(name) == landmark


@pytest.mark.parametrize("names", [[], ["", ""], [f"M{n}" for n in range(40)], ["::", "a:b", "a:"], ["*0"] * 30])
def test_numbered_markers_are_no_landmarks(names: list[str]) -> None:
    assert recognise_markers(names) == ()


def test_centres_are_means_of_both_sides() -> None:
    names = [*GAIT, "LKneeMed", "RAnkleMed"]
    skeleton = marker_skeleton(names)
    centres = {centre.name: centre for centre in centres_of(skeleton)}
    assert {name for name, centre in centres.items() if centre.rule == "mean"} == {
        "left_low_leg", "right_foot", "Root", "neck1", "left_toes", "right_toes"
    }  # fmt: skip
    positions = np.random.default_rng(0).normal(size=(4, len(names), 3))
    positions[2, names.index("LKneeMed")] = np.nan
    whole = with_centres(centres_of(skeleton), positions, Sizes())
    knee = whole[:, len(names) + list(centres).index("left_low_leg")]
    np.testing.assert_allclose(knee[0], (positions[0, names.index("LKNE")] + positions[0, names.index("LKneeMed")]) / 2)
    assert np.isnan(knee[2]).all()


def test_a_marker_of_the_name_of_a_centre_keeps_it() -> None:
    skeleton = marker_skeleton([*COCO, "Root"])
    assert "Root" not in {centre.name for centre in centres_of(skeleton)}


def test_the_receipt_says_what_markers_are() -> None:
    report = named(marker_skeleton([*GAIT, "LKneeMed"]))[1]
    assert dict(report.landmarks)["LKNE"] == "left_knee_lateral"
    told = [notice.what for notice in report.notices()]
    assert told[0] == "markers: 23 of 23 are landmarks of the set plug-in-gait (1 by words)"
    assert "markers: the centre left_low_leg is made from left_knee_lateral and left_knee_medial" in told


def test_tables_have_no_marker_at_two_places() -> None:
    for name, markers in marker_sets().items():
        assert len(markers) >= 17, name
        for side, other in (("left", "right"), ("right", "left")):
            sided = {landmark for landmark in markers.values() if landmark.startswith(side)}
            lacking = {mark for mark in sided if mark.replace(side, other, 1) not in markers.values()}
            assert lacking <= {"right_scapula", "left_back_tracking", "right_back_tracking"}, name


SETS = {
    "c3d/body/HDM_dg_06-03_03_120.c3d": "cmu-41", "c3d/body/nick_freeform_001.c3d": "cmu-53",
    "c3d/body/kinematics_tennis_serve_2players.c3d": "plug-in-gait", "c3d/edge/parameterOverflow.c3d": "plug-in-gait",
    "c3d/edge/shd01.c3d": "plug-in-gait", "trc/dance/ballet_reduced.trc": "cmu-41",
    "trc/dataWithBlanksForMissingMarkers.trc": "cast", "trc/init100.trc": "helen-hayes",
    "trc/subject01_synthetic_marker_data.trc": "cleveland",
}  # fmt: skip


@pytest.mark.parametrize("file", SETS)
def test_sets_of_real_files(file: str, shared: Path) -> None:
    assert {body.set_name for body in recognise_markers(mcml.read(shared / file).source_names)} == {SETS[file]}


def test_a_marker_trial_has_a_body_to_ask_for(shared: Path) -> None:
    """The pelvis is a leg's length above the toes, and an ankle has a centre that moves with the foot."""
    walk = mcml.read(shared / "trc" / "walk_free_01.trc")
    assert 0.75 < np.nanmedian(walk.height("Root")) < 1.1
    assert np.nanmedian(walk.height("left_toes")) < 0.1
    assert walk.calibration.origins["floor"].kind == "guessed"
    assert np.isfinite(walk.speed("left_hand")).mean() > 0.9
