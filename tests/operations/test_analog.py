"""Analog channels of documents at their own rate: the samples of the file, in the order of the frames."""

from __future__ import annotations

import csv
import io
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient
from typer.testing import CliRunner

from mcml.formats.c3d.analog import read_channels
from mcml_service.cli import app
from mcml_service.storage.database import Database
from tests.builders import bvh, one_kind, upload
from tests.laboratory.walkers import SAMPLES, Gait, make_c3d, make_steps

pytestmark = one_kind
API = "/api/v1/documents"
GAIT = Gait(seconds=4)
FILE = make_c3d(GAIT, first=31, steps=make_steps(GAIT, [("left", 1.1), ("right", 1.65)]))
FRAMES = 400


def stored(client: TestClient, content: bytes, name: str = "walk.c3d") -> str:
    return str(upload(client, {name: content})["documents"][0]["id"])  # type: ignore[index]


def rows_of(client: TestClient, uuid: str, **query: Any) -> tuple[list[str], np.ndarray]:
    answer = client.get(f"{API}/{uuid}/analog", params=query)
    assert answer.status_code == 200, answer.text
    lines = list(csv.reader(io.StringIO(answer.text)))
    return lines[0], np.array([[float(cell or "nan") for cell in line] for line in lines[1:]])


@pytest.mark.parametrize(("first", "last"), [(1, FRAMES), (1, 1), (17, 333), (FRAMES, FRAMES)])
def test_samples_are_those_of_the_file(client: TestClient, first: int, last: int) -> None:
    channels = read_channels(io.BytesIO(FILE))
    names, rows = rows_of(client, stored(client, FILE), first=first, last=last)
    assert names == ["frame", "time", *channels.labels]
    wanted = channels.read(first - 1, last - first + 1)
    assert np.array_equal(rows[:, 2:], wanted)
    assert rows[:, 0].tolist() == np.repeat(np.arange(first, last + 1), SAMPLES).tolist()
    assert rows[:, 1] == pytest.approx((first - 1) / 100 + np.arange(len(wanted)) / (100 * SAMPLES))


def test_channels_are_chosen_and_may_stay_as_stored(client: TestClient) -> None:
    uuid = stored(client, FILE)
    channels = read_channels(io.BytesIO(FILE))
    names, rows = rows_of(client, uuid, channel=["Fz2", "Fx1"], scaled="false")
    assert names == ["frame", "time", "Fz2", "Fx1"]
    places = [channels.labels.index(name) for name in names[2:]]
    assert np.array_equal(rows[:, 2:], channels.read_raw(channels=places))


def test_samples_follow_their_frames(client: TestClient) -> None:
    uuid = stored(client, FILE)
    edits = {"edits": [{"do": "delete", "first": 101, "last": 150}, {"do": "reverse", "first": 1, "last": 20}]}
    assert client.post(f"{API}/{uuid}/frames", json=edits, headers={"if-match": "*"}).status_code == 200
    _, rows = rows_of(client, uuid, channel="Fz1")
    whole = read_channels(io.BytesIO(FILE)).read()[:, 2].reshape(FRAMES, SAMPLES)
    order = [*range(19, -1, -1), *range(20, 100), *range(150, FRAMES)]
    assert np.array_equal(rows[:, 2].reshape(-1, SAMPLES), whole[order], equal_nan=True)


def test_made_frames_have_no_samples(client: TestClient) -> None:
    uuid, other = stored(client, FILE), stored(client, make_c3d(GAIT), "other.c3d")
    insert = {"do": "insert", "at": 3, "document": other, "first": 1, "last": 2}
    answer = client.post(f"{API}/{uuid}/frames", json={"edits": [insert]}, headers={"if-match": "*"})
    assert answer.status_code == 200, answer.text
    _, rows = rows_of(client, uuid, channel="Fz1", last=6)
    assert np.isnan(rows[:, 2]).reshape(-1, SAMPLES).all(axis=1).tolist() == [False, False, True, True, False, False]


def test_tables_of_arrow_have_units(client: TestClient) -> None:
    arrow = pytest.importorskip("pyarrow")
    uuid = stored(client, FILE)
    answer = client.get(f"{API}/{uuid}/analog", params={"channel": ["Fz1", "Mx1"], "format": "arrow"})
    table = arrow.ipc.open_stream(answer.content).read_all()
    assert table.num_rows == FRAMES * SAMPLES
    assert [table.schema.field(name).metadata for name in ("Fz1", "Mx1")] == [{b"unit": b"N"}, {b"unit": b"Nmm"}]


def test_what_has_none_is_refused(client: TestClient) -> None:
    uuid = stored(client, FILE)
    unknown = client.get(f"{API}/{uuid}/analog", params={"channel": "EMG"})
    assert unknown.status_code == 404
    assert "It has: Fx1, Fy1" in unknown.text
    for name, content in (("markers.c3d", make_c3d(GAIT)), ("arm.bvh", bvh(4))):
        answer = client.get(f"{API}/{stored(client, content, name)}/analog")
        assert answer.status_code == 404
        assert "Only C3D files whose upload is kept" in answer.text


def test_the_command_writes_the_same(database: Database, client: TestClient) -> None:
    uuid = stored(client, FILE)
    text = client.get(f"{API}/{uuid}/analog", params={"channel": "Fz1", "last": 3}).text
    options = ["--channel", "Fz1", "--last", "3", "--database", str(database.url)]
    shown = CliRunner().invoke(app, ["analog", uuid, *options])
    assert shown.exit_code == 0, shown.output
    assert shown.output.split() == text.split()
