"""OpenSim itself reads trials and motions: `pip install --group opensim`, 72 MB, then this file is not skipped.

OPENSIM_MODELS is the folder of a clone of https://github.com/opensim-org/opensim-models, for its own examples.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import mcml
from mcml.motion.bodies.quantities import compute
from mcml.motion.rotations import rotate
from mcml.motion.skeleton import Array
from tests.c3d_writer import c3d_bytes
from tests.formats.test_opensim_trial import read_forces, steps_of
from tests.laboratory.walkers import SAMPLES, Gait, make_c3d
from tests.motion.bodies.made import person
from tests.motion.bodies.test_clinical_angles import Sample, rms_after_constant

opensim = pytest.importorskip("opensim", reason="OpenSim is not installed: pip install --group opensim")
osim_walker = pytest.importorskip("tests.formats.osim_walker")

MASS = 50.0


def make_model(path: Path) -> None:
    """Two feet that float: the forces on them are all that inverse dynamics has to explain."""
    model = opensim.Model()
    for name in ("calcn_l", "calcn_r"):
        body = opensim.Body(name, MASS, opensim.Vec3(0), opensim.Inertia(1, 1, 1))
        model.addBody(body)
        joint = opensim.FreeJoint(f"{name}_free", model.getGround(), body)
        model.addJoint(joint)
    model.finalizeConnections()
    model.printToXML(str(path))


def test_inverse_dynamics_finds_the_forces_of_the_plates(tmp_path: Path) -> None:
    gait = Gait(heading=100.0, up="Z")
    steps = steps_of(gait)
    (tmp_path / "walk.c3d").write_bytes(make_c3d(gait, first=31, steps=steps))
    mcml.convert(tmp_path / "walk.c3d", tmp_path / "walk", to="opensim")
    table = read_forces((tmp_path / "walk.forces.mot").read_text())
    make_model(tmp_path / "feet.osim")
    still = [f"{name}_free_coord_{number}" for name in ("calcn_l", "calcn_r") for number in range(6)]
    times = table["time"][::SAMPLES]
    lines = ["still", "version=1", f"nRows={len(times)}", f"nColumns={len(still) + 1}", "inDegrees=yes", "endheader"]
    lines += ["\t".join(["time", *still]), *(f"{time!r}" + "\t0" * len(still) for time in times.tolist())]
    (tmp_path / "still.mot").write_text("\n".join(lines) + "\n")
    tool = opensim.InverseDynamicsTool()
    tool.setModelFileName(str(tmp_path / "feet.osim"))
    tool.setCoordinatesFileName(str(tmp_path / "still.mot"))
    tool.setExternalLoadsFileName(str(tmp_path / "walk.loads.xml"))
    tool.setStartTime(float(times[1]))
    tool.setEndTime(float(times[-2]))
    tool.setResultsDir(str(tmp_path))
    tool.setOutputGenForceFileName("found.sto")
    assert tool.run()
    found = opensim.TimeSeriesTable(str(tmp_path / "found.sto"))
    at = np.array(found.getIndependentColumn())
    weight = MASS * 9.80665
    for side in ("l", "r"):
        upward = sum(
            np.interp(at, table["time"], table[f"ground_force_{number}_vy"])
            for number, step in enumerate(steps, 1)
            if step.side[0] == side
        )
        forces = found.getDependentColumn(f"calcn_{side}_free_coord_4_force").to_numpy()
        # OpenSim interpolates forces by splines, so edges of steps differ.
        difference = np.abs(forces - (weight - upward))
        assert np.median(difference) < 0.05
        assert np.percentile(difference, 90) < 2
        assert upward.max() > 700


def test_the_markers_are_read_with_their_times(tmp_path: Path) -> None:
    gait = Gait()
    (tmp_path / "walk.c3d").write_bytes(make_c3d(gait, first=31, steps=steps_of(gait)))
    mcml.convert(tmp_path / "walk.c3d", tmp_path / "walk", to="opensim")
    markers = opensim.TimeSeriesTableVec3(str(tmp_path / "walk.markers.trc"))
    assert markers.getNumRows() == 600
    assert "LHEE" in markers.getColumnLabels()
    assert markers.getIndependentColumn()[0] == pytest.approx(0.3)
    heel = markers.getDependentColumn("LHEE")
    assert heel[0][1] == pytest.approx(30, abs=130), "the height of a heel in millimetres"


def test_markers_that_are_missing_at_the_end_of_a_line_are_read(tmp_path: Path) -> None:
    points = np.arange(12, dtype=np.float64).reshape(2, 2, 3)
    (tmp_path / "a.c3d").write_bytes(c3d_bytes(points, np.array([[0, -1], [-1, 0]]), labels=["A", "B"]))
    mcml.convert(tmp_path / "a.c3d", tmp_path / "b.trc")
    markers = opensim.TimeSeriesTableVec3(str(tmp_path / "b.trc"))
    assert np.isnan(markers.getDependentColumn("B")[0][0])
    assert np.isnan(markers.getDependentColumn("A")[1][0])
    assert markers.getDependentColumn("B")[1][0] == 9
    assert len(mcml.read(tmp_path / "b.trc")) == 2


def test_angles_are_read(tmp_path: Path) -> None:
    (tmp_path / "person.bvh").write_bytes(person(3, 40))
    mcml.convert(tmp_path / "person.bvh", tmp_path / "person.mot")
    table = opensim.TimeSeriesTable(str(tmp_path / "person.mot"))
    assert table.getNumRows() == 40
    assert table.getDependentColumn("knee_flexion_l").to_numpy() == pytest.approx(
        mcml.read(tmp_path / "person.bvh").angle("left-knee-flexion"), abs=1e-9
    )


@pytest.mark.parametrize("name", ["walking5", "s4_am_gait04"])
def test_real_trials_are_opened(shared: Path, tmp_path: Path, name: str) -> None:
    mcml.convert(shared / f"lab/{name}.c3d", tmp_path / name, to="opensim")
    loads = opensim.ExternalLoads(str(tmp_path / f"{name}.loads.xml"), True)
    assert loads.getSize() >= 2
    assert opensim.Storage(str(tmp_path / f"{name}.forces.mot")).getSize() > 1000
    assert opensim.TimeSeriesTableVec3(str(tmp_path / f"{name}.markers.trc")).getNumColumns() > 20


RATE, WALKED = 100.0, 80


@pytest.fixture(scope="module")
def walk() -> dict[str, Array]:
    """Degrees of two legs, bent, overstretched and turned."""
    turn = 2 * np.pi * np.arange(WALKED) / RATE
    degrees = {"ground_pelvis_coord_2": -4 + 3 * np.sin(turn)}
    for side, phase in (("l", turn), ("r", turn + np.pi)):
        degrees |= {
            f"hip_flexion_{side}": 15 + 25 * np.sin(phase),
            f"hip_adduction_{side}": 2 + 6 * np.sin(phase + 1),
            f"hip_rotation_{side}": 3 + 8 * np.cos(phase),
            f"knee_angle_{side}": -25 - 31 * np.sin(phase + 2),
            f"ankle_angle_{side}": 5 + 10 * np.sin(2 * phase),
        }
    return degrees


@pytest.fixture(scope="module")
def solution(tmp_path_factory: pytest.TempPathFactory, walk: dict[str, Array]) -> tuple[Path, dict[str, Array]]:
    """(folder, coordinates) of a trial: our TRC of a C3D file, after OpenSim scaled its model by our standing trial."""
    folder = tmp_path_factory.mktemp("walker")
    osim_walker.make_model(folder / "generic.osim", dict.fromkeys(osim_walker.SCALES, 1.0))
    subject = osim_walker.make_model(folder / "subject.osim", osim_walker.SCALES)
    seconds = np.arange(WALKED) / RATE
    places = np.stack([1.2 * seconds, np.full(WALKED, 1.0), 0.02 * np.sin(6 * seconds)], axis=1)
    still = {name: np.zeros(60) for name in walk}
    (folder / "walk.c3d").write_bytes(osim_walker.record(subject, walk, places, RATE))
    (folder / "stand.c3d").write_bytes(osim_walker.record(subject, still, np.tile([0, 1.0, 0], (60, 1)), RATE))
    for name in ("walk", "stand"):
        mcml.convert(folder / f"{name}.c3d", folder / f"{name}.trc", for_="opensim")
    model = osim_walker.scale_model(folder, "generic.osim", "stand.trc")
    return folder, osim_walker.solve_angles(folder, model, "walk.trc")


def test_scaling_and_inverse_kinematics_find_the_angles_of_our_markers(
    solution: tuple[Path, dict[str, Array]], walk: dict[str, Array]
) -> None:
    """Sizes, times and directions of exported markers are right: nothing else gives these angles."""
    folder, found = solution
    for name, degrees in walk.items():
        np.testing.assert_allclose(found[name], degrees, atol=1e-3, err_msg=name)
    scaled = opensim.Model(str(folder / "scaled.osim"))
    knee = scaled.getJointSet().get("knee_l").get_frames(0).get_translation()
    assert knee[1] == pytest.approx(-0.4 * osim_walker.SCALES["femur"], abs=1e-6)


def test_clinical_angles_of_the_markers_are_those_of_inverse_kinematics(
    solution: tuple[Path, dict[str, Array]],
) -> None:
    """Landmarks on both sides of the joints, and hips by regression."""
    folder, found = solution
    motion = mcml.read(folder / "walk.c3d")
    for side in "LR":
        for name, axis, coordinate, sign in (
            ("HipAngles", "x", "hip_flexion", 1),
            ("HipAngles", "y", "hip_adduction", 1),
            ("HipAngles", "z", "hip_rotation", 1),
            ("KneeAngles", "x", "knee_angle", -1),
        ):
            expected = sign * found[f"{coordinate}_{side.lower()}"]
            np.testing.assert_allclose(motion.quantity(side + name, axis), expected, atol=0.01, err_msg=name)


def test_angles_of_the_skeleton_are_those_of_inverse_kinematics(solution: tuple[Path, dict[str, Array]]) -> None:
    folder, found = solution
    osim_walker.trace_skeleton(folder / "walk.npz", folder / "scaled.osim", found)
    require_angles(Sample(folder / "walk.npz"), constant=0.05, rms=(0.03, 0.03, 0.05, 0.03))


@pytest.fixture
def examples(tmp_path: Path) -> Path:
    """A copy of OpenSim's example Gait2354_Simbody, with its model."""
    models = os.environ.get("OPENSIM_MODELS")
    if not models:
        pytest.skip("OPENSIM_MODELS names no clone of https://github.com/opensim-org/opensim-models")
    shutil.copytree(Path(models) / "Pipelines/Gait2354_Simbody", tmp_path / "gait")
    shutil.copy(Path(models) / "Models/Gait2354_Simbody/gait2354_simbody.osim", tmp_path / "gait")
    return tmp_path / "gait"


def test_an_example_of_opensim_is_scaled_and_solved_from_our_files(examples: Path) -> None:
    """The same by files that we wrote as by those of the example, and our angles of the skeleton beside them."""
    widths, coordinates = {}, {}
    for name in ("theirs", "ours"):
        for trial in ("static", "walk1") if name == "ours" else ():
            trc = examples / f"subject01_{trial}.trc"
            mcml.convert(trc, examples / "trial.c3d", up="Y", force=True)
            mcml.convert(examples / "trial.c3d", trc, for_="opensim", force=True)
        opensim.ScaleTool(str(examples / "subject01_Setup_Scale.xml")).run()
        scaled = opensim.Model(str(examples / "subject01_simbody.osim"))
        frames = [scaled.getJointSet().get(each).get_frames(0) for each in ("hip_l", "ankle_r")]
        widths[name] = [frame.get_translation().to_numpy().tolist() for frame in frames]
        # One model for both: markers that it is fitted with move by 0.4 degrees if one coordinate differs by 1e-8 m.
        if name == "theirs":
            shutil.copy(examples / "subject01_simbody.osim", examples / "model.osim")
        tool = opensim.InverseKinematicsTool(str(examples / "subject01_Setup_IK.xml"))
        tool.set_model_file(str(examples / "model.osim"))
        tool.setMarkerDataFileName(str(examples / "subject01_walk1.trc"))
        tool.setOutputMotionFileName(str(examples / f"{name}.mot"))
        tool.set_accuracy(1e-9)
        tool.set_report_errors(False)
        assert tool.run()
        table = opensim.TimeSeriesTable(str(examples / f"{name}.mot"))
        coordinates[name] = {each: table.getDependentColumn(each).to_numpy().copy() for each in table.getColumnLabels()}
    np.testing.assert_allclose(widths["ours"], widths["theirs"], atol=1e-6)
    for name, expected in coordinates["theirs"].items():
        np.testing.assert_allclose(coordinates["ours"][name], expected, atol=0.01, err_msg=name)
    osim_walker.trace_skeleton(examples / "walk.npz", examples / "model.osim", coordinates["ours"])
    require_angles(Sample(examples / "walk.npz"), constant=0.7, rms=(0.5, 0.1, 0.1, 0.5))


def require_angles(sample: Sample, constant: float, rms: Sequence[float]) -> None:
    """Our angles of legs are those of OpenSim. constant: most degrees that they may differ by throughout. rms: of hip
    flexion, adduction, rotation and knee flexion, after this constant."""
    lines = {bone: rotate(turn, np.array([0.0, 1.0, 0.0])) for bone, turn in sample.turns.items()}
    stretch = sample.stretch(lines)
    for side, letter in (("left", "l"), ("right", "r")):
        for (name, coordinate, sign), most in zip(
            (
                ("hip-flexion", "hip_flexion", 1),
                ("hip-adduction", "hip_adduction", 1),
                ("hip-internal-rotation", "hip_rotation", 1),
                ("knee-flexion", "knee_angle", -1),
            ),
            rms,
            strict=True,
        ):
            ours = compute("angle", [f"{side}-{name}"], stretch)
            theirs = sign * sample.degrees(f"{coordinate}_{letter}")
            assert rms_after_constant(ours, theirs) <= most, name
            assert abs(float((ours - theirs).mean())) <= constant, name
