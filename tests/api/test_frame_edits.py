"""Ranges of frames over HTTP and on the command line."""

from __future__ import annotations

import io

import numpy as np
import pytest
from fastapi.testclient import TestClient

from tests.builders import bvh, one_kind

API = "/api/v1"
ANY = {"if-match": "*"}


@pytest.fixture
def uuid(client: TestClient) -> str:
    answer = client.post(f"{API}/documents", files=[("file", ("walk.bvh", bvh(600)))], data={"label": "hop:100-200"})
    return str(answer.json()["documents"][0]["id"])


def values(client: TestClient, uuid: str, **more: str) -> np.ndarray:
    answer = client.get(f"{API}/documents/{uuid}/frames", params={"format": "npy", **more})
    return np.load(io.BytesIO(answer.content))


def count(client: TestClient, q: str) -> object:
    return client.get(f"{API}/xpath", params={"q": f"count({q})"}).json()["value"]


def test_edits_are_one_revision_and_can_be_taken_back(client: TestClient, uuid: str) -> None:
    before = values(client, uuid)
    edits = [
        {"do": "keep", "first": 51, "last": 350},
        {"do": "reverse", "first": 1, "last": 10},
        {"do": "move", "first": 291, "last": 300, "to": 1},
        {"do": "insert", "first": 1, "last": 2, "at": 301},
        {"do": "delete", "first": 100, "last": 101},
    ]
    answer = client.post(f"{API}/documents/{uuid}/frames", json={"edits": edits}, headers={"if-match": '"1"'})
    assert answer.status_code == 200, answer.text
    assert answer.json() == {
        "revision": 2,
        "frames": 300,
        "notes": [],
        "replaced": [],
        "first_kept": None,
        "motion": None,
        "kept": [],
        "curves": [],
    }
    assert answer.headers["etag"] == '"2-json"'
    rows = list(range(50, 350))
    rows = rows[9::-1] + rows[10:]
    rows = rows[290:] + rows[:290]
    rows += rows[:2]
    del rows[99:101]
    assert np.array_equal(values(client, uuid), before[rows])
    named = [place for place, row in enumerate(rows) if 99 <= row <= 199]
    assert count(client, "//frame[motion_name='hop']") == len(named)
    stale = client.post(f"{API}/documents/{uuid}/frames", json={"edits": edits}, headers={"if-match": '"1"'})
    assert stale.status_code == 412
    history = client.get(f"{API}/documents/{uuid}/revisions").json()["items"]
    assert [item["operation"] for item in history] == ["frames", "import"]
    client.post(f"{API}/documents/{uuid}/restore", params={"revision": 1}, headers=ANY)
    assert np.array_equal(values(client, uuid), before)
    assert client.get(f"{API}/documents/{uuid}/export", params={"format": "bvh"}).content == bvh(600)


def test_all_or_nothing(client: TestClient, uuid: str) -> None:
    edits = [{"do": "delete", "first": 1, "last": 599}, {"do": "delete", "first": 1, "last": 5}]
    answer = client.post(f"{API}/documents/{uuid}/frames", json={"edits": edits}, headers=ANY)
    assert answer.status_code == 404
    assert client.get(f"{API}/documents/{uuid}").json()["revision"] == 1
    wrong = {"edits": [{"do": "explode", "first": 1, "last": 5}]}
    assert client.post(f"{API}/documents/{uuid}/frames", json=wrong, headers=ANY).status_code == 422
    assert client.post(f"{API}/documents/{uuid}/frames", json={"edits": edits}).status_code == 428


@one_kind
def test_a_curve_by_bone_and_channel(client: TestClient, uuid: str) -> None:
    def curves() -> np.ndarray:
        both = {"bone": ["Spine"], "first": 5, "last": 8}
        found = client.get(f"{API}/documents/{uuid}/frames", params=both).json()["items"]
        return np.array([[row["values"]["Spine"][name] for name in ("Rx", "Rz")] for row in found])

    url, spot = f"{API}/documents/{uuid}/frames", {"first": 5, "last": 8, "bone": "Spine"}
    assert client.put(url, params=spot | {"channel": "Rx"}, json=[1, 2, 3, 4], headers=ANY).status_code == 200
    assert curves()[:, 0].tolist() == [1, 2, 3, 4]
    pairs = [[5, 6], [7, 8], [9, 10], [11, 12]]
    assert client.put(url, params=spot | {"channel": ["Rz", "Rx"]}, json=pairs, headers=ANY).status_code == 200
    assert curves()[:, ::-1].tolist() == pairs
    for wrong in ([1, 2, 3], [[1, 2]] * 4, [], [1, [2]]):
        assert client.put(url, params=spot | {"channel": "Rx"}, json=wrong, headers=ANY).status_code == 422
    assert client.put(url, params=spot, json=[1, 2, 3, 4], headers=ANY).status_code == 422


@pytest.mark.parametrize("form", ["json", "npy"])
@one_kind
def test_channels_as_arrays(client: TestClient, uuid: str, form: str) -> None:
    columns = client.get(f"{API}/documents/{uuid}/frames?format=npy").headers["x-mcml-columns"].split(",")
    before = values(client, uuid)
    new = np.linspace(-10, 10, 300)
    params = {"first": 200}
    if form == "json":
        body = {"columns": ["Spine.Rx"], "values": new[:, None].tolist()}
        answer = client.put(f"{API}/documents/{uuid}/frames", params=params, json=body, headers=ANY)
    else:
        stream = io.BytesIO()
        np.save(stream, new)
        answer = client.put(
            f"{API}/documents/{uuid}/frames",
            params=params | {"column": "Spine.Rx"},
            content=stream.getvalue(),
            headers=ANY | {"content-type": "application/octet-stream"},
        )
    assert answer.status_code == 200, answer.text
    assert answer.json() == {
        "revision": 2,
        "frames": 600,
        "notes": [],
        "replaced": [],
        "first_kept": None,
        "motion": None,
        "kept": [],
        "curves": [],
    }
    after = before.copy()
    after[199:499, columns.index("Spine.Rx")] = new
    assert np.array_equal(values(client, uuid), after)
    assert count(client, "//frame_bone[@name='Spine'][@Rx >= -10][@Rx <= 10][../@id >= 200][../@id < 500]") == 300


@one_kind
def test_arrays_that_do_not_fit(client: TestClient, uuid: str) -> None:
    def put(body: object, **params: object) -> int:
        answer = client.put(f"{API}/documents/{uuid}/frames", params=params, json=body, headers=ANY)  # type: ignore[arg-type]
        assert answer.json().get("detail")
        return answer.status_code

    assert put({"columns": ["Spine.Rx"], "values": [[1.0], [2.0]]}, first=600) == 404
    assert put({"columns": ["Tail.Rx"], "values": [[1.0]]}) == 422
    assert put({"columns": ["Spine.Rx", "Spine.Ry"], "values": [[1.0]]}) == 422
    assert put({"columns": ["Spine.Rx"], "values": [["x"]]}) == 422
    assert put({"columns": ["Spine.Rx"], "values": []}) == 422
    assert put([]) == 422
    assert put({"columns": ["Spine.Rx"], "values": [[1.0]], "frames": 3}) == 422
    assert put({"columns": ["Spine.Rx"], "values": [[1.0]]}, first=9, last=2) == 422
    uneven = {"columns": ["Spine.Rx"], "values": [[1.0], []]}
    answer = client.put(f"{API}/documents/{uuid}/frames", json=uneven, headers=ANY)
    assert answer.json()["detail"] == "The numbers cannot be read: the rows have different lengths."
    junk = client.put(
        f"{API}/documents/{uuid}/frames",
        params={"column": "Spine.Rx"},
        content=b"junk",
        headers=ANY | {"content-type": "application/octet-stream"},
    )
    assert junk.status_code == 422
    assert client.get(f"{API}/documents/{uuid}").json()["revision"] == 1
