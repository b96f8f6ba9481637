"""Frames of many clips as one array: against the frames of each clip, by every face, and refusals."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient
from typer.testing import CliRunner

import mcml
from mcml_service.cli import app
from tests.builders import bvh, one_kind, upload
from tests.conftest import StoreOf
from tests.motion.bodies.made import person

API = "/api/v1"


def fill(client: TestClient) -> list[str]:
    """Four people, and two rigs with other joints, of which one has no frames that a body could be in."""
    files = {f"p{seed}.bvh": person(seed, 40 + seed) for seed in range(4)} | {"other.bvh": bvh(7, seed=3)}
    made: Any = upload(client, files, unit="cm")
    ids = [str(item["id"]) for item in made["documents"]]
    for uuid in ids[:2]:
        labels = [{"name": "reach", "first": 5, "last": 14}, {"name": "reach", "first": 20, "last": 22}]
        assert client.post(f"{API}/documents/{uuid}/labels", json=labels, headers={"if-match": "*"}).status_code == 201
    return ids


@pytest.fixture
def clips(store_of: StoreOf, kind: str) -> tuple[TestClient, list[str]]:
    return store_of(kind, fill)


def arrays_of(client: TestClient, **request: Any) -> dict[str, np.ndarray]:
    answer = client.post(f"{API}/arrays", json=request)
    assert answer.status_code == 200, answer.text
    with np.load(io.BytesIO(answer.content), allow_pickle=False) as found:
        return dict(found)


def frames_of(client: TestClient, uuid: str, **asked: Any) -> dict[str, np.ndarray]:
    answer = client.get(f"{API}/documents/{uuid}/frames", params={"format": "npz", "missing": "nan", **asked})
    assert answer.status_code == 200, answer.text
    with np.load(io.BytesIO(answer.content), allow_pickle=False) as found:
        return dict(found)


@one_kind
@pytest.mark.parametrize("space", ["channels", "positions", "rotations"])
def test_each_range_has_the_frames_of_its_clip(clips: tuple[TestClient, list[str]], space: str) -> None:
    client, ids = clips
    found = arrays_of(client, selection={"documents": ids}, space=space, dtype="f8")
    assert sorted(found["documents"]) == sorted(ids)
    columns = found["columns"].tolist()
    for place, uuid in enumerate(found["documents"]):
        own = frames_of(client, uuid, space=space)
        values = found["values"][found["starts"][place] : found["starts"][place + 1]]
        where = [columns.index(name) for name in own["columns"]]
        np.testing.assert_array_equal(values[:, where], own["values"])
        others = np.delete(values, where, axis=1)
        assert np.isnan(others).all()
        assert (found["first"][place], found["last"][place]) == (1, len(own["values"]))
        assert found["seconds_per_frame"][place] == own["times"][1]
    assert found["starts"][-1] == len(found["values"])


@one_kind
def test_ranges_of_a_query_and_shared_columns(clips: tuple[TestClient, list[str]]) -> None:
    client, ids = clips
    query = "//frame[motion_name='reach']"
    found = arrays_of(client, query=query, bones=["left_hand", "Head"], dtype="f8")
    assert found["columns"].tolist() == ["left_hand", "Head"]
    assert list(zip(found["first"].tolist(), found["last"].tolist(), strict=True)) == [(5, 14), (20, 22)] * 2
    for place, uuid in enumerate(found["documents"]):
        first, last = found["first"][place], found["last"][place]
        own = frames_of(client, uuid, space="positions", bone=["left_hand", "Head"], first=first, last=last)
        order = [own["columns"].tolist().index(name) for name in ("left_hand", "Head")]
        np.testing.assert_array_equal(
            found["values"][found["starts"][place] : found["starts"][place + 1]], own["values"][:, order]
        )
    shared = arrays_of(client, selection={"documents": ids}, columns="shared")
    assert not np.isnan(shared["values"]).any()
    assert 0 < len(shared["columns"]) < len(arrays_of(client, selection={"documents": ids})["columns"])


@one_kind
def test_quantities_are_those_of_frames(clips: tuple[TestClient, list[str]]) -> None:
    client, ids = clips
    names = ["speed:left_hand", "angle:left-knee-flexion"]
    found = arrays_of(client, selection={"documents": ids}, space="channels", quantities=names, dtype="f8")
    assert found["columns"].tolist() == names
    assert found["units"].tolist() == ["m/s", "deg"]
    for place, uuid in enumerate(found["documents"]):
        values = found["values"][found["starts"][place] : found["starts"][place + 1]]
        if uuid == ids[-1]:
            assert np.isnan(values).all(), "a rig without hands"
        else:
            np.testing.assert_array_equal(values, frames_of(client, uuid, quantity=names)["values"])


@one_kind
def test_tables_have_the_same_numbers(clips: tuple[TestClient, list[str]]) -> None:
    client, ids = clips
    request: dict[str, Any] = {"selection": {"documents": ids[:2]}, "bones": ["Head"], "dtype": "f8"}
    found = arrays_of(client, **request)
    answer = client.post(f"{API}/arrays", json=request | {"as": "csv"})
    rows = list(csv.DictReader(io.StringIO(answer.text)))
    assert [float(row["Head.x"]) for row in rows] == found["values"][:, 0, 0].tolist()
    assert list(dict.fromkeys(row["document"] for row in rows)) == found["documents"].tolist()
    parquet = pytest.importorskip("pyarrow.parquet", reason="the extra `arrow` is not installed")
    table = parquet.read_table(io.BytesIO(client.post(f"{API}/arrays", json=request | {"as": "parquet"}).content))
    assert table.column("Head.z").to_pylist() == found["values"][:, 0, 2].tolist()
    assert table.column("frame").to_pylist() == [int(row["frame"]) for row in rows]


@one_kind
@pytest.mark.parametrize(
    ("request_", "status", "words"),
    [
        ({}, 422, "No clips are selected"),
        ({"selection": {"project": "nowhere"}}, 404, "nowhere"),
        ({"query": "//frame[motion_name='swim']"}, 422, "No frames"),
        ({"query": "//frame["}, 422, ""),
        ({"query": "//frame", "bones": ["tail"]}, 422, "No frames"),
        ({"query": "//frame", "quantities": ["speed:left_hand"]}, 422, "beside channels"),
        ({"query": "//frame", "space": "channels", "quantities": ["sped:left_hand"]}, 422, "no quantity"),
    ],
)
def test_refusals_say_what_is_wrong(
    clips: tuple[TestClient, list[str]], request_: dict[str, Any], status: int, words: str
) -> None:
    answer = clips[0].post(f"{API}/arrays", json=request_)
    assert answer.status_code == status
    assert words in answer.json()["detail"]


@one_kind
def test_clips_without_the_bones_are_named(clips: tuple[TestClient, list[str]]) -> None:
    client, ids = clips
    answer = client.post(f"{API}/arrays", json={"selection": {"documents": ids}, "bones": ["left_hand"]})
    assert "other" in answer.headers["x-mcml-notices"]
    assert answer.headers["x-mcml-ranges"] == "4"


def test_command_and_python(tmp_path: Path) -> None:
    store = str(tmp_path / "store.db")
    with mcml.open(store) as repo:
        for seed in range(2):
            path = tmp_path / f"p{seed}.bvh"
            path.write_bytes(person(seed, 30 + seed))
            repo.import_(path, project="gait")
        arrays = repo.arrays(project="gait", bones=["Head"])
        assert arrays.values.shape == (61, 1, 3)
        assert [len(values) for values in arrays] == [30, 31]
        assert arrays[-1] is not None
        assert len(arrays) == 2
        with pytest.raises(IndexError):
            arrays[2]
        own = {name: place for place, name in enumerate(arrays.names)}
        np.testing.assert_allclose(
            arrays[own["p0"]][:, 0], repo.document("p0").frames("Head", space="positions")[:, 0], rtol=1e-6
        )
    output = tmp_path / "all.npz"
    done = CliRunner().invoke(
        app, ["arrays", str(output), "--project", "gait", "--bone", "Head", "--database", f"sqlite:///{store}"]
    )
    assert done.exit_code == 0, done.output
    with np.load(output) as found:
        np.testing.assert_array_equal(found["values"], arrays.values)
    wrong = CliRunner().invoke(app, ["arrays", str(tmp_path / "all.txt"), "--database", f"sqlite:///{store}"])
    assert wrong.exit_code != 0
