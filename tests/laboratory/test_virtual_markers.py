"""Virtual markers: a standing trial tells where markers are that walking trials lack."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import mcml
from mcml.files.motion import Motion
from mcml.laboratory.gait_model.virtual_markers import VirtualMarker
from mcml.motion.skeleton import Array
from tests.laboratory.gait_bodies import LegPose, make_body, turn
from tests.laboratory.gait_files import STANDING, WALKING, gait_file

Read = Callable[..., Motion]

CLUSTERS = {"Upper": (260, 50, 20), "Front": (150, 20, 60), "Rear": (170, 45, -50)}
"""Millimetres upwards from the lower joint, outwards and across, in the axes of the segment."""


@pytest.fixture
def read(tmp_path: Path) -> Read:
    def read_file(markers: Mapping[str, Array], name: str, **more: object) -> Motion:
        path = tmp_path / f"{name}.c3d"
        path.write_bytes(gait_file(markers, {}, **more))  # type: ignore[arg-type]
        return mcml.read(path)

    return read_file


def person(poses: Mapping[str, LegPose], frames: int = 30, way: float = 0.0, tilt: float = 0.0) -> dict[str, Array]:
    """Markers (n, 3) as laboratories with clusters have them: of the pelvis, of joints, of segments and of feet."""
    own, _, centres = make_body(poses, turn("y", tilt))
    markers = {f"{side}.ASIS": own[f"{side}ASI"] for side in "LR"} | {
        f"{side}.PSIS": own[f"{side}PSI"] for side in "LR"
    }
    for side in "LR":
        hip, knee, ankle = (centres[f"{side}{name}"] for name in ("HJC", "KJC", "AJC"))
        lateral, outer = own[f"{side}KNE"], own[f"{side}ANK"]
        markers |= {f"{side}.Knee.Lat": lateral, f"{side}.Knee.Med": 2 * knee - lateral}
        markers |= {f"{side}.Ankle.Lat": outer, f"{side}.Ankle.Med": 2 * ankle - outer}
        markers |= {f"{side}.Heel": own[f"{side}HEE"], f"{side}.Toe.Tip": own[f"{side}TOE"]}
        for part, up, low, out in (("Thigh", hip, knee, lateral), ("Shank", knee, ankle, outer)):
            axes = segment_axes(up - low, (out - low).reshape(3))
            markers |= {f"{side}.{part}.{name}": low + axes @ place for name, place in CLUSTERS.items()}
    travel = np.outer(np.arange(frames), [way, 0.0, 0.0])
    return {name: place.reshape(1, 3) + travel for name, place in markers.items()}


def segment_axes(up: Array, out: Array) -> Array:
    """(3, 3) along a segment, outwards, and across, as columns."""
    along = up / np.linalg.norm(up)
    outwards = out - (out @ along) * along
    outwards /= np.linalg.norm(outwards)
    return np.stack([along, outwards, np.cross(along, outwards)], axis=1)


def without(markers: Mapping[str, Array], *words: str) -> dict[str, Array]:
    return {name: place for name, place in markers.items() if not any(word in name for word in words)}


def angles(motion: Motion, name: str) -> Array:
    return np.stack([motion.quantity(name, axis) for axis in "xyz"], axis=1)


@pytest.mark.parametrize("gone", [("Med",), ("Med", "Lat")])
def test_a_walk_without_markers_of_joints_has_the_angles_of_one_with_them(read: Read, gone: tuple[str, ...]) -> None:
    whole = person(WALKING, way=40.0, tilt=8.0)
    walking = read(without(whole, *gone), "walk")
    calibrated = walking.with_standing_trial(read(person(STANDING), "static"))
    true = read(whole, "whole")
    for side in "LR":
        for name in ("Hip", "Knee", "Ankle", "FootProgress"):
            expected = angles(true, f"landmarks:{side}{name}Angles")
            np.testing.assert_allclose(angles(calibrated, f"{side}{name}Angles"), expected, atol=0.01)
    lacks = [each.reason for each in walking.measurements if each.name == "LKneeAngles"]
    assert all(lacks)
    (knee,) = [each for each in calibrated.measurements if each.name == "LKneeAngles"]
    assert any("virtual markers by the standing trial 'static'" in note for note in knee.notes)
    assert not any("may be wrong" in note for note in calibrated.notices)


def test_markers_without_telling_names_are_known_by_their_places(read: Read) -> None:
    names = {f"{side}.{part}.{word}": f"Q{side}{part[0]}{number}" for side in "LR" for part in ("Thigh", "Shank")
             for number, word in enumerate(CLUSTERS)}  # fmt: skip

    def rename(markers: Mapping[str, Array]) -> dict[str, Array]:
        return {names.get(name, name): place for name, place in markers.items()}

    whole = person(WALKING, way=40.0)
    standing = read(rename(person(STANDING)), "static")
    carriers = standing.measure_standing().virtual["LKneeMedial"].places
    assert set(carriers) == {"QLT0", "QLT1", "QLT2", "L.Knee.Lat"}
    calibrated = read(rename(without(whole, "Med")), "walk").with_standing_trial(standing)
    expected = angles(read(whole, "whole"), "landmarks:LKneeAngles")
    np.testing.assert_allclose(angles(calibrated, "LKneeAngles"), expected, atol=0.01)


def test_a_marker_that_was_moved_is_told(read: Read) -> None:
    walking = person(WALKING, way=40.0)
    walking["L.Thigh.Front"] = walking["L.Thigh.Front"] + [30.0, 20.0, 10.0]
    calibrated = read(without(walking, "Med"), "walk").with_standing_trial(read(person(STANDING), "static"))
    told = [note for note in calibrated.notices if "may be wrong" in note]
    assert len(told) == 1
    assert told[0].startswith("LKneeMedial may be wrong: the markers that carry it are ")


def test_exchanged_labels_leave_the_joint_unknown_in_their_frames(read: Read) -> None:
    walking = without(person(WALKING, way=40.0), "Med", "Lat")
    thigh, shank = (walking[f"L.{name}.Rear"].copy() for name in ("Thigh", "Shank"))
    walking["L.Thigh.Rear"][12:18], walking["L.Shank.Rear"][12:18] = shank[12:18], thigh[12:18]
    knee = angles(read(walking, "walk").with_standing_trial(read(person(STANDING), "static")), "LKneeAngles")
    assert np.flatnonzero(np.isnan(knee).any(axis=1)).tolist() == list(range(12, 18))


def test_too_few_markers_of_a_segment_leave_it_unknown_and_are_told(read: Read) -> None:
    walking = without(person(WALKING, way=40.0), "Med", "Lat", "L.Thigh.Front", "L.Thigh.Rear")
    calibrated = read(walking, "walk").with_standing_trial(read(person(STANDING), "static"))
    assert "LKneeMedial stays unknown: fewer than three markers of its segment are in both trials" in calibrated.notices
    lacks = {each.name: each.reason for each in calibrated.measurements}
    assert lacks["LKneeAngles"].startswith("missing")
    assert lacks["RKneeAngles"] == ""


def test_a_gap_of_one_marker_is_bridged_and_of_two_is_not(read: Read) -> None:
    whole = person(WALKING, way=40.0)
    walking = {name: place.copy() for name, place in without(whole, "Med").items()}
    walking["L.Thigh.Upper"][5:15] = np.nan
    walking["L.Thigh.Front"][10:20] = np.nan
    knee = angles(read(walking, "walk").with_standing_trial(read(person(STANDING), "static")), "LKneeAngles")
    expected = angles(read(whole, "whole"), "landmarks:LKneeAngles")
    known = np.r_[0:10, 15:30]
    np.testing.assert_allclose(knee[known], expected[known], atol=0.01)
    assert np.isnan(knee[10:15]).all()


@given(seed=st.integers(0, 10_000), count=st.integers(3, 6))
def test_a_rigid_segment_carries_its_marker_anywhere(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    places = rng.normal(0, 90, (count, 3))
    spread = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    assume(spread[1] > 40)
    marker = VirtualMarker({f"m{k}": tuple(place) for k, place in enumerate(places.tolist())})
    turns, shifts = Rotation.random(12, random_state=seed), rng.normal(0, 1500, (12, 3))
    seen = {f"m{k}": turns.apply(place) + shifts for k, place in enumerate(places)}
    found, away = marker.locate(seen)
    np.testing.assert_allclose(found, shifts, atol=1e-7)
    assert away.max() < 1e-7
    # In a mirror no rotation fits, unless all are in one plane: the distance tells.
    mirrored = {name: place * [1.0, 1.0, -1.0] for name, place in seen.items()}
    if count > 3 and spread[2] > 40:
        assert marker.locate(mirrored)[1].min() > 5


def test_markers_on_one_line_carry_nothing() -> None:
    marker = VirtualMarker({"a": (0.0, 0.0, 0.0), "b": (50.0, 1.0, 0.0), "c": (100.0, 0.0, 0.0), "d": (0.0, 90.0, 5.0)})
    assert marker.known_by(["a", "b", "c"]) is None
    assert marker.known_by(["a", "b"]) is None
    assert marker.known_by(["a", "c", "d"]) is not None
    seen = {name: np.array([place, place]) for name, place in marker.places.items()}
    seen["d"][1] = np.nan
    found, away = marker.locate(seen)
    assert np.isfinite(found).all(axis=1).tolist() == [True, False]
    assert np.isfinite(away).tolist() == [True, False]


def test_a_public_trial_agrees_with_its_own_medial_markers(shared: Path, read: Read) -> None:
    """One of its frames stands in for the standing trial, in which nobody stands; skin moves by some millimetres."""
    file = shared / "lab" / "walking5.c3d"
    if not file.exists():
        pytest.skip("the trials of laboratories are not here (set MCML_SHARED to their folder)")
    motion = mcml.read(file)
    gait = motion._measurements.gait.of(None)._markers
    markers = {name: places for name, places in gait.label_all(None).items() if np.isfinite(places).any()}
    medial = [gait.labels[f"{side}{joint}Medial"] for side in "LR" for joint in ("Knee", "Ankle")]
    whole = np.flatnonzero(np.isfinite(np.stack(list(markers.values()))).all(axis=(0, 2)))[0]
    standing = read({name: np.repeat(place[[whole]], 30, axis=0) for name, place in markers.items()}, "static")
    walking = read({name: place for name, place in markers.items() if name not in medial}, "walk")
    calibrated = walking.with_standing_trial(standing)
    for side in "LR":
        away = angles(calibrated, f"landmarks:{side}KneeAngles") - angles(motion, f"landmarks:{side}KneeAngles")
        assert (np.sqrt(np.nanmean(away**2, axis=0)) <= 1.0).all()
    assert not any("may be wrong" in note for note in calibrated.notices)


def test_a_trial_without_a_file_of_its_own_says_how_forward_is_found(tmp_path: Path) -> None:
    for name, markers in (("static", person(STANDING)), ("walk", without(person(WALKING, way=40.0), "Med"))):
        (tmp_path / f"{name}.c3d").write_bytes(gait_file(markers, {}))
        mcml.convert(tmp_path / f"{name}.c3d", tmp_path / f"{name}.trc")
    calibrated = mcml.read(tmp_path / "walk.trc").with_standing_trial(mcml.read(tmp_path / "static.trc"))
    notes = {each.name: each.notes for each in calibrated.measurements}
    assert "forward is the axis along which the pelvis travels in the clip, or that it faces" in notes["LPelvisAngles"]
    assert not any("nan" in note or "never seen" in note for some in notes.values() for note in some)
    np.testing.assert_allclose(angles(calibrated, "LKneeAngles")[:, 0], WALKING["L"].knee[0], atol=1.0)
