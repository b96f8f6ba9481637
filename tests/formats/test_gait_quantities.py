"""Computed quantities of C3D files: kinds of files, what is assumed, what is missing, and what they never do."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest

import mcml
from mcml.errors import NotFoundError
from mcml.files.motion import Motion
from mcml.formats.gait_properties import read_properties
from mcml.formats.measurements import Measurement
from mcml.motion.skeleton import Array
from tests.c3d_writer import texts
from tests.laboratory.gait_bodies import LegPose, turn
from tests.laboratory.gait_files import FRAMES, POSES, gait_file, measures_of, two_people, walk
from tests.laboratory.walkers import Gait, make_c3d, make_steps, true_events

KNEE = POSES["L"].knee
Read = Callable[[bytes], Motion]


@pytest.fixture
def read(tmp_path: Path) -> Read:
    def read_file(content: bytes) -> Motion:
        path = tmp_path / "trial.c3d"
        path.write_bytes(content)
        return mcml.read(path)

    return read_file


def angles(motion: Motion, name: str) -> Array:
    return np.stack([motion.quantity(name, axis) for axis in "xyz"], axis=1)


def listed(motion: Motion) -> dict[str, Measurement]:
    return {each.name: each for each in motion.measurements}


def without(measures: Mapping[str, float], *stems: str) -> dict[str, float]:
    return {name: value for name, value in measures.items() if not name.endswith(stems)}


def test_angles_of_plain_files(read: Read) -> None:
    motion = read(gait_file(walk(), measures_of()))
    for name in ("LKneeAngles", "cgm1:LKneeAngles"):
        np.testing.assert_allclose(angles(motion, name), [KNEE] * FRAMES, atol=2e-3)
    np.testing.assert_allclose(angles(motion, "LPelvisAngles"), [[10.0, 0, 0]] * FRAMES, atol=2e-3)
    knee = listed(motion)["LKneeAngles"]
    assert knee.known
    assert (knee.unit, knee.group, knee.axes) == ("deg", "ANGLES", ("x", "y", "z"))
    assert knee.notes[0] == "computed by the Conventional Gait Model 1 from markers"
    assert "cgm1:LKneeAngles" not in listed(motion)


@pytest.mark.parametrize(
    "how",
    [
        {"group": "ANNA"},
        {"group": "PROCESSING", "prefix": "Anna:", "subjects": ["Anna"]},
        {"group": "ANNA", "prefix": "Anna:", "subjects": ["Anna"]},
        {"group": "PROCESSING", "unit": "m"},
        {"group": "PROCESSING", "first": 286},
    ],
)
def test_measures_and_markers_of_other_kinds_of_files(read: Read, how: dict[str, object]) -> None:
    scale = 0.001 if how.get("unit") == "m" else 1.0
    markers = {name: place * scale for name, place in walk().items()}
    motion = read(gait_file(markers, measures_of(), **how))  # type: ignore[arg-type]
    np.testing.assert_allclose(angles(motion, "LKneeAngles"), [KNEE] * FRAMES, atol=5e-3)


def test_a_subject_before_the_names_of_measures(read: Read) -> None:
    measures = {f"Anna{name}": value for name, value in measures_of().items()}
    motion = read(gait_file(walk(), measures, prefix="Anna:", subjects=["Anna"]))
    np.testing.assert_allclose(angles(motion, "LKneeAngles"), [KNEE] * FRAMES, atol=2e-3)


def test_angles_of_measures_in_degrees(read: Read) -> None:
    turned = {"L": LegPose(turns={"TibialTorsion": np.radians(-20.0), "ThighRotation": np.radians(8.0)}),
              "R": LegPose()}  # fmt: skip
    degrees = measures_of(turned) | {"LTibialTorsion": -20.0, "LThighRotation": 8.0}
    motion = read(gait_file(walk(poses=turned), degrees))
    np.testing.assert_allclose(angles(motion, "LKneeAngles"), [KNEE] * FRAMES, atol=5e-3)
    assert any("degrees" in note for note in listed(motion)["LKneeAngles"].notes)


def test_measures_in_metres(read: Read) -> None:
    lengths = {name: value if name == "Bodymass" else value / 1000 for name, value in measures_of().items()}
    motion = read(gait_file(walk(), lengths))
    np.testing.assert_allclose(angles(motion, "LKneeAngles"), [KNEE] * FRAMES, atol=2e-3)
    assert any("measures are taken as m:" in note for note in listed(motion)["LKneeAngles"].notes)


def test_an_unknown_diameter_is_assumed_and_said(read: Read) -> None:
    motion = read(gait_file(walk(), without(measures_of(), "MarkerDiameter")))
    np.testing.assert_allclose(angles(motion, "LKneeAngles"), [KNEE] * FRAMES, atol=2e-3)
    assert "marker diameter not stated, 14 mm assumed" in listed(motion)["LKneeAngles"].notes
    assert not any("diameter" in note for note in listed(motion)["LPelvisAngles"].notes)


@pytest.mark.parametrize("width", [None, 0.0])
def test_missing_measures_are_named(read: Read, width: float | None) -> None:
    measures = without(measures_of(), "KneeWidth") | ({} if width is None else {"LKneeWidth": width})
    motion = read(gait_file(walk(), measures))
    knee = listed(motion)["LKneeAngles"]
    assert not knee.known
    assert "measure LKneeWidth" in knee.reason
    assert listed(motion)["LPelvisAngles"].known
    with pytest.raises(NotFoundError, match="LKneeWidth"):
        motion.quantity("LKneeAngles", "x")


def test_missing_markers_leave_gaps_and_are_never_filled(read: Read) -> None:
    markers = walk()
    markers["LTIB"][10:13] = np.nan
    motion = read(gait_file(markers, measures_of()))
    knee, hip = motion.quantity("LKneeAngles", "x"), motion.quantity("LHipAngles", "x")
    assert np.flatnonzero(np.isnan(knee)).tolist() == [10, 11, 12]
    assert np.isfinite(hip).all()


@pytest.mark.parametrize("quarter", range(4))
def test_the_direction_of_the_walk(read: Read, quarter: int) -> None:
    turned = turn("z", 90.0 * quarter)
    motion = read(gait_file({name: place @ turned.T for name, place in walk().items()}, measures_of()))
    np.testing.assert_allclose(angles(motion, "LPelvisAngles"), [[10.0, 0, 0]] * FRAMES, atol=2e-3)


def test_a_sacrum_stands_in_for_the_back_spines(read: Read) -> None:
    markers = walk()
    markers["SACR"] = (markers.pop("LPSI") + markers.pop("RPSI")) / 2
    motion = read(gait_file(markers, measures_of()))
    np.testing.assert_allclose(angles(motion, "LKneeAngles"), [KNEE] * FRAMES, atol=2e-3)


def test_other_names_of_the_same_markers(read: Read) -> None:
    other = {"LASI": "LASIS", "RASI": "RASIS", "LPSI": "LPSIS", "RPSI": "RPSIS"}
    markers = {other.get(name, name): place for name, place in walk().items()}
    motion = read(gait_file(markers, measures_of()))
    np.testing.assert_allclose(angles(motion, "LKneeAngles"), [KNEE] * FRAMES, atol=2e-3)


def test_a_foot_without_a_heel_is_known(read: Read) -> None:
    markers = {name: place for name, place in walk().items() if not name.endswith("HEE")}
    with_heels, bare = read(gait_file(walk(), measures_of())), read(gait_file(markers, measures_of()))
    np.testing.assert_array_equal(angles(bare, "LAnkleAngles"), angles(with_heels, "LAnkleAngles"))
    assert any("no offsets of a standing trial" in note for note in listed(bare)["LAnkleAngles"].notes)


def test_a_standing_trial_has_a_level_sole(read: Read) -> None:
    """In a standing trial the line from heel to toe is the foot, whatever offsets the file has."""
    motion = read(gait_file(walk(way=0.0, poses={"L": LegPose(toe=(1, 0, -0.6)), "R": LegPose()}), measures_of()))
    notes = listed(motion)["LFootProgressAngles"].notes
    assert any("a standing trial" in note for note in notes)
    assert any("which the file does not tell" in note for note in notes)
    walking = read(gait_file(walk(poses={"L": LegPose(toe=(1, 0, -0.6)), "R": LegPose()}), measures_of()))
    assert abs(motion.quantity("LAnkleAngles", "x") - walking.quantity("LAnkleAngles", "x")).min() > 5


def test_a_distance_of_0_to_the_trochanter_is_a_missing_one(read: Read) -> None:
    measures = without(measures_of(), "AsisTrocanterDistance")
    zero = read(gait_file(walk(), measures | {"LAsisTrocanterDistance": 0.0, "RAsisTrocanterDistance": 0.0}))
    np.testing.assert_array_equal(angles(zero, "LHJC"), angles(read(gait_file(walk(), measures)), "LHJC"))


@pytest.mark.parametrize("is_used", [True, False])
def test_stored_offsets_tell_whether_medial_markers_were_used(read: Read, is_used: bool) -> None:
    """A medial marker of the ankle that is 20 degrees off turns the shank, if the laboratory used it."""
    standing = walk(way=0.0)
    with_medial = dict(standing)
    for side, k in (("L", 1), ("R", -1)):
        with_medial[f"{side}MED"] = standing[f"{side}ANK"] + np.array([-30.0, -80.0 * k, 0.0])
    plain = read(gait_file(standing, measures_of()))
    offsets = find_offsets(plain if not is_used else read(gait_file(with_medial, measures_of())))
    motion = read(gait_file(with_medial, measures_of() | offsets))
    plain = read(gait_file(standing, measures_of()))
    away = np.abs(angles(motion, "LAnkleAngles") - angles(plain, "LAnkleAngles")).max()
    assert away > 5 if is_used else away == 0
    told = any("without the medial markers" in note for note in listed(motion)["LAnkleAngles"].notes)
    assert told != is_used


def find_offsets(motion: Motion) -> dict[str, float]:
    """The measures that a standing trial tells, as a laboratory stores them."""
    return {each.name: each.value for each in motion.measure_standing().measures if each.is_offset}


def test_properties_state_measures_that_a_file_lacks() -> None:
    stated = [("gait LKneeWidth", "10.4", "cm"), ("gait rkneewidth", "104", ""), ("gait LStaticPlantFlex", "12", "deg"),
              ("gait RStaticPlantFlex", "0.2", "rad"), ("gait Bodymass", "61", "kg"), ("gait LHatSize", "9", ""),
              ("gait LAnkleWidth", "wide", ""), ("gait RAnkleWidth", "nan", ""), ("gait foot", "Flat", ""),
              ("LLegLength", "800", "")]  # fmt: skip
    measures, foot = read_properties(stated)
    assert foot == "foot flat"
    assert measures == pytest.approx({"LKneeWidth": 104.0, "RKneeWidth": 104.0, "LStaticPlantFlex": np.radians(12),
                                      "RStaticPlantFlex": 0.2, "Bodymass": 61.0})  # fmt: skip


def test_measures_of_the_file_as_properties_change_no_note(read: Read) -> None:
    """Only measures that people state are named, though those of the file are properties, too."""
    motion = read(gait_file(walk(), measures_of() | {"LKneeWidth": 100.1234567}))
    assert "gait LKneeWidth" in {name for name, _, _ in motion._clip.head.properties}
    assert not any("properties" in note for note in listed(motion)["LKneeAngles"].notes)


def test_own_angles_of_the_file_come_first(read: Read) -> None:
    markers = walk() | {"LKneeAngles": np.full((FRAMES, 3), 77.0)}
    typed = {"POINT:ANGLES": texts("LKneeAngles")}
    motion = read(gait_file(markers, measures_of(), more=typed))
    assert (motion.quantity("LKneeAngles", "x") == 77.0).all()
    np.testing.assert_allclose(angles(motion, "cgm1:LKneeAngles"), [KNEE] * FRAMES, atol=2e-3)
    assert listed(motion)["LKneeAngles"].notes == ("as computed by the laboratory",)
    assert listed(motion)["cgm1:LKneeAngles"].known
    assert listed(motion)["RKneeAngles"].notes[0].startswith("computed by the Conventional Gait Model 1")


def test_own_angles_of_a_file_whose_labels_name_the_subject(read: Read) -> None:
    markers = walk() | {"LKneeAngles": np.full((FRAMES, 3), 77.0)}
    typed = {"POINT:ANGLES": texts("Anna:LKneeAngles")}
    motion = read(gait_file(markers, measures_of(), prefix="Anna:", subjects=["Anna"], more=typed))
    assert (motion.quantity("LKneeAngles", "x") == 77.0).all()
    assert (motion.quantity("Anna:LKneeAngles", "x") == 77.0).all()


@pytest.mark.parametrize(("size", "unit"), [(1500.0, "Nmm/kg"), (90_000.0, "Nmm")])
def test_moments_are_per_kilogram_if_they_are_small(read: Read, size: float, unit: str) -> None:
    values = np.zeros((FRAMES, 3))
    values[5] = [size, 0.0, 0.0]
    markers = walk() | {"LAnkleMoment": values, "LNormalisedGRF": values}
    typed = {"POINT:MOMENTS": texts("LAnkleMoment"), "POINT:MOMENT_UNITS": texts("Nmm"),
             "POINT:FORCES": texts("LNormalisedGRF"), "POINT:FORCE_UNITS": texts("N")}  # fmt: skip
    motion = read(gait_file(markers, measures_of(), more=typed))
    assert listed(motion)["LAnkleMoment"].unit == unit
    assert any("the file states Nmm" in note for note in listed(motion)["LAnkleMoment"].notes) == ("kg" in unit)
    assert listed(motion)["LNormalisedGRF"].unit == "N"


def test_several_people_have_their_own_quantities(read: Read) -> None:
    people = two_people()
    markers = {f"{who}:{name}": place for who, (own, _) in people.items() for name, place in own.items()}
    measures = {f"{who}{name}": value for who, (_, own) in people.items() for name, value in own.items()}
    both = read(gait_file(markers, measures, subjects=list(people)))
    for who, (own, own_measures) in people.items():
        alone = read(gait_file(own, own_measures))
        for name in ("LKneeAngles", "RHipAngles", "LPelvisAngles", "LHJC", "cgm1:LKneeAngles"):
            np.testing.assert_array_equal(angles(both, f"{who}:{name}"), angles(alone, name), err_msg=f"{who} {name}")
        assert listed(both)[f"{who}:LKneeAngles"].notes == listed(alone)["LKneeAngles"].notes
    assert not np.allclose(angles(both, "Anna:LKneeAngles"), angles(both, "Bert:LKneeAngles"))
    assert "LKneeAngles" not in listed(both)
    with pytest.raises(NotFoundError, match="several people: begin the name with one of Anna:, Bert:"):
        both.quantity("LKneeAngles", "x")
    with pytest.raises(NotFoundError, match="no quantity 'Carl:LKneeAngles'"):
        both.quantity("Carl:LKneeAngles", "x")


def test_forces_on_the_feet_of_several_people(read: Read) -> None:
    gait = Gait()
    strikes = true_events(gait)
    steps = make_steps(gait, [(side, strikes[side, "strike"][2]) for side in ("left", "right")])
    alone = read(make_c3d(gait, steps=steps))
    both = read(make_c3d(gait, steps=steps, people=("Anna:", "Bert:")))
    for who in ("Anna", "Bert"):
        for side in ("left", "right"):
            assert np.isfinite(alone.force(side, "z")).any()
            np.testing.assert_array_equal(both.force(f"{who}:{side}", "z"), alone.force(side, "z"))
    assert {"Anna:left", "Bert:right"} <= listed(both).keys()
    with pytest.raises(mcml.Error, match="several people"):
        both.force("left", "z")


def test_measures_of_nobody_are_of_none_of_several_people(read: Read) -> None:
    both = {f"{who}:{name}": place for who, (own, _) in two_people().items() for name, place in own.items()}
    motion = read(gait_file(both, measures_of()))
    knee = listed(motion)["Anna:LKneeAngles"]
    assert not knee.known
    assert "missing: " in knee.reason


def test_names_that_are_no_quantities(read: Read) -> None:
    motion = read(gait_file(walk(), measures_of()))
    for name in ("LKneeAngle", "cgm1:Nothing", "cgm2:LKneeAngles", ""):
        with pytest.raises(NotFoundError):
            motion.quantity(name, "x")


def test_files_without_a_body_list_nothing(read: Read) -> None:
    motion = read(gait_file({f"M{place}": np.full((FRAMES, 3), 10.0 * place) for place in range(9)}, measures_of()))
    assert motion.measurements == ()


def test_clips_without_a_file_have_what_needs_no_measures(read: Read, tmp_path: Path) -> None:
    """A TRC with Y up: the pelvis is known, the knee lacks measures, and landmarks on both sides need none."""
    upright = turn("x", -90.0)
    markers = walk(way=-40.0)
    for side in "LR":
        for joint, centre in (("KNE", "KNM"), ("ANK", "MED")):
            markers[side + centre] = markers[side + joint] + np.array([0, -100.0 if side == "L" else 100.0, 0])
    read(gait_file({name: place @ upright.T for name, place in markers.items()}, {}))
    path = tmp_path / "walk.trc"
    mcml.convert(tmp_path / "trial.c3d", path)
    trc = mcml.read(path)
    np.testing.assert_allclose(np.abs(angles(trc, "LPelvisAngles")), [[10.0, 0, 180.0]] * FRAMES, atol=2e-3)
    knee = listed(trc)["LKneeAngles"]
    assert knee.known
    assert any("landmarks" in note for note in knee.notes)
    assert np.isfinite(trc.quantity("LKneeAngles", "x")).all()
    with pytest.raises(NotFoundError, match="measure LKneeWidth"):
        trc.quantity("cgm1:LKneeAngles", "x")
