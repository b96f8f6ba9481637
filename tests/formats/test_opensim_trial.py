"""Trials for OpenSim: forces of plates with y up and x forwards, given to the feet that stand on them."""

from __future__ import annotations

import io
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fastapi.testclient import TestClient
from hypothesis import given
from hypothesis import strategies as st

import mcml
from mcml.errors import ConversionError
from mcml.motion.pictures.figures import axis_of
from mcml.motion.skeleton import Array
from tests import fuzz
from tests.builders import one_kind, upload
from tests.laboratory.walkers import SAMPLES, Gait, Step, make_c3d, make_steps, true_events

GAITS = st.builds(
    Gait,
    heading=st.sampled_from([0.0, 90.0, 180.0, -90.0, 20.0, -70.0]),
    up=st.sampled_from(["X", "Y", "Z"]),
    rate=st.sampled_from([100.0, 250.0]),
)


def steps_of(gait: Gait, count: int = 3) -> list[Step]:
    strikes = sorted(
        (at, side) for (side, kind), times in true_events(gait).items() if kind == "strike" for at in times
    )
    return make_steps(gait, [(side, at) for at, side in strikes if 0.5 < at < gait.seconds - 1.5][:count])


def write(content: bytes, folder: Path, **options: object) -> tuple[dict[str, Array], ET.Element, list[str]]:
    """(columns of the forces, external loads, lines of the TRC)."""
    (folder / "walk.c3d").write_bytes(content)
    paths = mcml.convert(folder / "walk.c3d", folder / "walk", to="opensim", **options)  # type: ignore[arg-type]
    assert [path.name for path in paths] == ["walk.markers.trc", "walk.forces.mot", "walk.loads.xml"]
    return read_forces(paths[1].read_text()), ET.fromstring(paths[2].read_text()), paths[0].read_text().splitlines()


def read_forces(text: str) -> dict[str, Array]:
    head, _, body = text.partition("endheader\n")
    lines = body.splitlines()
    rows = np.array([[float(cell) for cell in line.split("\t")] for line in lines[1:]])
    assert f"nRows={len(rows)}\n" in head
    assert f"nColumns={rows.shape[1]}\n" in head
    return dict(zip(lines[0].split("\t"), rows.T, strict=True))


@pytest.mark.slow
@given(GAITS, st.sampled_from([1, 91]))
@fuzz.examples(6)
def test_forces_are_those_of_the_ground_in_the_axes_of_opensim(
    tmp_path_factory: pytest.TempPathFactory, gait: Gait, first: int
) -> None:
    steps = steps_of(gait)
    table, loads, trc = write(make_c3d(gait, first=first, steps=steps), tmp_path_factory.mktemp("trial"))
    assert table["time"] == pytest.approx((first - 1) / gait.rate + steps[0].times, abs=1e-9)
    assert float(trc[6].split("\t")[1]) == pytest.approx(table["time"][0])
    assert float(trc[-1].split("\t")[1]) == pytest.approx(table["time"][-SAMPLES])
    forces = loads.findall(".//ExternalForce")
    wanted = {f"{step.side}_foot_plate_{number}" for number, step in enumerate(steps, 1)}
    assert {force.get("name") for force in forces} == wanted
    assert loads.findtext(".//datafile") == "walk.forces.mot"
    for force in forces:
        number = int((force.get("name") or "")[-1])
        step = steps[number - 1]
        assert force.findtext("applied_to_body") == f"calcn_{step.side[0]}"
        prefixes = [force.findtext(name) for name in ("force_identifier", "point_identifier", "torque_identifier")]
        newtons, point, torque = (np.stack([table[f"{each}{axis}"] for axis in "xyz"], axis=1) for each in prefixes)
        upward = step.force @ axis_of(gait.up)
        loaded = upward >= 20
        assert np.abs(newtons[:, 1] - np.where(loaded, upward, 0)).max() < 0.01
        assert np.linalg.norm(newtons, axis=1) == pytest.approx(
            np.where(loaded, np.linalg.norm(step.force, axis=1), 0), abs=0.01
        )
        assert not point[~loaded].any()
        assert point[loaded][:, 1] == pytest.approx(0, abs=1e-6)
        assert torque[:, 1] == pytest.approx(np.where(loaded, 3.0, 0), abs=0.01)
        # The foot brakes first: x is forwards, within half a right angle.
        assert newtons[loaded][0, 0] < 0 < newtons[loaded][-1, 0]
        heel = _marker(trc, f"{step.side[0].upper()}HEE")
        at = np.flatnonzero(loaded)[SAMPLES]
        assert np.hypot(*(point[at] - heel[at // SAMPLES])[[0, 2]]) < 0.1, "points and markers have the same axes"
    left, right = (_marker(trc, f"{letter}ASI") for letter in "LR")
    assert (right - left)[0, 2] > 0.1, "z is to the right"


def _marker(trc: list[str], name: str) -> Array:
    """(n, 3) metres of a marker."""
    place = trc[3].split("\t").index(name)
    unit = trc[2].split("\t")[trc[1].split("\t").index("Units")]
    rows = np.array([[float(cell) for cell in line.split("\t")[place : place + 3]] for line in trc[6:] if line])
    return rows * {"mm": 0.001, "m": 1.0}[unit]


def test_a_plate_under_both_feet_has_columns_for_each(tmp_path: Path) -> None:
    gait = Gait(on_belt=True)
    steps = steps_of(gait, 2)
    # One plate measures both steps, one after the other.
    one, other = steps
    both = Step(
        one.side,
        one.times,
        one.force + np.where(one.force.any(axis=1)[:, None], 0, other.force),
        np.where(np.isfinite(one.centre_of_pressure), one.centre_of_pressure, other.centre_of_pressure),
        3.0,
    )
    gap = (one.times > one.times[np.isfinite(one.centre_of_pressure[:, 0])][-1] - 0.12) & (
        one.times < one.times[np.isfinite(one.centre_of_pressure[:, 0])][-1] + 0.02
    )
    both.force[gap] = 0
    table, loads, _ = write(make_c3d(gait, steps=[both]), tmp_path)
    names = [force.get("name") for force in loads.findall(".//ExternalForce")]
    assert names == [f"{one.side}_foot_plate_1", f"{other.side}_foot_plate_1"]
    first, second = table["ground_force_1_vy"], table["ground_force_2_vy"]
    assert first.any()
    assert second.any()
    assert not (first * second).any()
    assert first + second == pytest.approx(np.where(both.force[:, 2] >= 20, both.force[:, 2], 0), abs=0.01)


def test_a_range_of_frames_keeps_its_times(tmp_path: Path) -> None:
    gait = Gait()
    steps = steps_of(gait)
    table, _, trc = write(make_c3d(gait, first=11, steps=steps), tmp_path, frames="101-400")
    assert len(table["time"]) == 300 * SAMPLES
    assert table["time"][0] == pytest.approx(1.1)
    assert float(trc[6].split("\t")[1]) == pytest.approx(1.1)
    assert table["ground_force_1_vy"] == pytest.approx(
        np.where(steps[0].force[:, 2] >= 20, steps[0].force[:, 2], 0)[400:1600], abs=0.01
    )


def test_what_has_no_forces_is_refused(tmp_path: Path) -> None:
    gait = Gait()
    (tmp_path / "walk.c3d").write_bytes(make_c3d(gait))
    with pytest.raises(ConversionError, match="no force plates that can be used") as caught:
        mcml.convert(tmp_path / "walk.c3d", tmp_path / "walk", to="opensim")
    assert caught.value.remedy == "Export the markers alone as TRC."
    (tmp_path / "plates.c3d").write_bytes(make_c3d(gait, steps=steps_of(gait)))
    with pytest.raises(ConversionError, match="of the captured size"):
        mcml.convert(tmp_path / "plates.c3d", tmp_path / "plates", to="opensim", fps=50)
    mcml.convert(tmp_path / "plates.c3d", tmp_path / "plates.trc")
    with pytest.raises(ConversionError, match="forces are those of a C3D file"):
        mcml.convert(tmp_path / "plates.trc", tmp_path / "again", to="opensim")


@one_kind
def test_documents_leave_with_forces_until_frames_are_made(client: TestClient) -> None:
    gait = Gait()
    steps = steps_of(gait)
    uuid = upload(client, {"walk.c3d": make_c3d(gait, steps=steps)})["documents"][0]["id"]  # type: ignore[index]
    answer = client.get(f"/api/v1/documents/{uuid}/export", params={"format": "opensim"})
    assert answer.status_code == 200, answer.text
    with zipfile.ZipFile(io.BytesIO(answer.content)) as archive:
        assert archive.namelist() == ["walk.markers.trc", "walk.forces.mot", "walk.loads.xml"]
        table = read_forces(archive.read("walk.forces.mot").decode())
    assert table["ground_force_1_vy"].max() == pytest.approx(800, abs=1)
    edits = {"edits": [{"do": "reverse", "first": 10, "last": 20}]}
    assert client.post(f"/api/v1/documents/{uuid}/frames", json=edits, headers={"if-match": "*"}).status_code == 200
    refused = client.get(f"/api/v1/documents/{uuid}/export", params={"format": "opensim"})
    assert refused.status_code == 422
    assert "missing, made or in another order" in refused.text
