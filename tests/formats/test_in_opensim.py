"""OpenSim itself reads trials and motions: `pip install --group opensim`, 72 MB, then this file is not skipped."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mcml
from tests.c3d_writer import c3d_bytes
from tests.formats.test_opensim_trial import read_forces, steps_of
from tests.laboratory.walkers import SAMPLES, Gait, make_c3d
from tests.motion.bodies.made import person

opensim = pytest.importorskip("opensim", reason="OpenSim is not installed: pip install --group opensim")

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
