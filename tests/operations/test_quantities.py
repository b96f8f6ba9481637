"""Quantities of the body as columns beside channels: those of the whole document, whichever frames are asked."""

from __future__ import annotations

import csv
import io
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml.formats import FORMATS
from mcml.motion.bodies.quantities import QUANTITIES
from mcml_service.demo import body as made_body
from mcml_service.storage.database import Database
from tests.builders import bvh, one_kind, store
from tests.motion.bodies.made import person
from tests.xpath.motion_twin import read_documents

pytestmark = one_kind
ASKED = (
    "time", "unit", "leg", "height:left_hand", "position:left_hand,up", "position:left_hand,left,Root",
    "distance:left_hand,right_hand", "angle:left-knee-flexion", "angle:Root,left_low_leg,left_foot",
    "angle:left-wrist-flexion", "angle:right-hip-internal-rotation", "angle:left-hip-flexion",
    "tilt:Root,neck1", "speed:right_hand", "speed:right_hand,Root", "acceleration:Root",
    "heading", "contact:left_toes",
)  # fmt: skip


@pytest.fixture
def uuid(database: Database) -> str:
    (uuid,) = store(database, {"person.bvh": person(4, 60)})
    return uuid


def asked(client: TestClient, uuid: str, **query: Any) -> Any:
    answer = client.get(f"/api/v1/documents/{uuid}/frames", params={"format": "npz", **query})
    assert answer.status_code == 200, answer.text
    return np.load(io.BytesIO(answer.content))


@pytest.mark.parametrize(("first", "last", "step"), [(1, 60, 1), (1, 1, 1), (17, 33, 1), (50, 60, 3), (60, 60, 1)])
def test_they_are_those_of_the_whole_document(
    client: TestClient, database: Database, uuid: str, first: int, last: int, step: int
) -> None:
    assert {text.partition(":")[0] for text in ASKED} == {
        name for name in QUANTITIES if not QUANTITIES[name].of_file and name != "activity"
    }
    found = asked(client, uuid, quantity=ASKED, first=first, last=last, step=step)
    (twin,) = read_documents(database)
    assert found["columns"].tolist() == list(ASKED)
    for place, text in enumerate(ASKED):
        name, _, rest = text.partition(":")
        wanted = twin.quantity(name, *(rest.split(",") if rest else ()))[first - 1 : last : step]
        np.testing.assert_array_equal(found["values"][:, place], wanted, err_msg=text)
    units = dict(zip(ASKED, found["units"].tolist(), strict=True))
    assert units["height:left_hand"] == "m"
    assert units["speed:right_hand,Root"] == "m/s"
    assert units["contact:left_toes"] == ""


def test_activities_of_some_frames_are_those_of_the_whole_document(client: TestClient, database: Database) -> None:
    clip = made_body.clip("walk", 170.0, *made_body.walk(170.0, 4.0, 1.0, 6.0))
    (uuid,) = store(database, {"walk.bvh": b"".join(FORMATS["bvh"].write(clip, "bvh"))})
    whole = asked(client, uuid, quantity="activity:walk")["values"]
    assert 0.5 < whole.mean() <= 1
    for first, last in ((1, 5), (100, 140), (240, 240)):
        part = asked(client, uuid, quantity="activity:walk", first=first, last=last)["values"]
        np.testing.assert_array_equal(part, whole[first - 1 : last])
    refused = client.get(f"/api/v1/documents/{uuid}/frames", params={"format": "npz", "quantity": "activity:hop"})
    assert refused.status_code == 422
    assert "no activity" in refused.json()["detail"]


def test_they_stand_after_the_channels_of_bones(client: TestClient, uuid: str) -> None:
    plain = asked(client, uuid, bone="Head")
    both = asked(client, uuid, bone="Head", quantity=["height:Head", "time", "height:Head"])
    assert both["columns"].tolist() == [*plain["columns"].tolist(), "height:Head", "time"]
    assert both["units"].tolist() == ["", "", "", "m", "s"]
    np.testing.assert_array_equal(both["values"][:, :3], plain["values"])
    assert "units" not in plain


def test_forms(client: TestClient, uuid: str) -> None:
    """The same numbers in each."""
    url = f"/api/v1/documents/{uuid}/frames"
    query: dict[str, Any] = {"quantity": ["speed:Root,Head", "height:Head"], "first": 5, "last": 20}
    wanted = asked(client, uuid, **query)["values"]
    npy = client.get(url, params={**query, "format": "npy"})
    np.testing.assert_array_equal(np.load(io.BytesIO(npy.content)), wanted)
    assert npy.headers["x-mcml-columns"] == "speed:Root%2CHead,height:Head"
    assert npy.headers["x-mcml-units"] == "m/s,m"
    table = client.get(url, params={**query, "format": "csv"})
    rows = list(csv.DictReader(io.StringIO(table.text)))
    assert list(rows[0]) == ["frame", "id", "time", "speed:Root,Head", "height:Head"]
    assert [row["frame"] for row in rows] == [str(number) for number in range(5, 21)]
    np.testing.assert_array_equal([[float(row["speed:Root,Head"]), float(row["height:Head"])] for row in rows], wanted)
    pa = pytest.importorskip("pyarrow")
    arrow = pa.ipc.open_stream(client.get(url, params={**query, "format": "arrow"}).content).read_all()
    assert arrow.schema.field("height:Head").metadata == {b"unit": b"m"}
    np.testing.assert_array_equal(arrow["height:Head"].to_numpy(), wanted[:, 1])


def test_what_is_not_known_is_nan_and_empty_in_tables(client: TestClient, database: Database) -> None:
    (uuid,) = store(database, {"chain.bvh": bvh(4)})
    assert np.isnan(asked(client, uuid, quantity=["height:Head", "leg"])["values"]).all()
    url = f"/api/v1/documents/{uuid}/frames"
    rows = list(csv.reader(io.StringIO(client.get(url, params={"format": "csv", "quantity": "leg"}).text)))
    assert [row[3] for row in rows] == ["leg", "", "", "", ""]


@pytest.mark.parametrize(
    ("query", "status", "words"),
    [
        ({"quantity": "altitude:Head"}, 422, ["no quantity 'altitude'", "height"]),
        ({"quantity": "height"}, 422, ["does not take 0 arguments", "joint"]),
        ({"quantity": "height:Head,Root"}, 422, ["does not take 2 arguments"]),
        ({"quantity": "angle:left-knee-flexoin"}, 422, ["not the name of an angle", "left-knee-flexion"]),
        ({"quantity": "angle:Root,Head"}, 422, ["three joints"]),
        ({"quantity": "position:Head,w"}, 422, ["no axis", "front"]),
        ({"quantity": "height:tail"}, 404, ["no bone 'tail'", "There are: Root"]),
        ({"quantity": "time", "space": "positions"}, 422, ["beside channels"]),
        ({"quantity": "time", "format": "json"}, 422, ["beside channels"]),
        ({"quantity": "time", "format": "block", "reduce": "minmax"}, 422, ["beside channels"]),
    ],
)
def test_errors(client: TestClient, uuid: str, query: dict[str, str], status: int, words: list[str]) -> None:
    answer = client.get(f"/api/v1/documents/{uuid}/frames", params={"format": "npz", **query})
    assert answer.status_code == status
    problem = answer.json()
    for word in words:
        assert word in f"{problem['detail']} {problem['remedy']}"
