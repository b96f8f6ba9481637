"""Markers over HTTP: uploaded, asked, exported, refused."""

from __future__ import annotations

import io

import numpy as np
from fastapi.testclient import TestClient

from mcml.formats import FORMATS
from mcml.formats.format import ReadOptions, SourceFile
from tests.builders import TRC, bvh, c3d_file, one_kind

API = "/api/v1"

pytestmark = one_kind


def upload(client: TestClient, name: str, content: bytes) -> str:
    answer = client.post(f"{API}/documents", files=[("file", (name, content))])
    assert answer.status_code == 201, answer.text
    receipt = answer.json()["documents"][0]["receipt"]
    assert receipt["markers"] or name.endswith(".bvh")
    return str(answer.json()["documents"][0]["id"])


def ask(client: TestClient, q: str, **more: str) -> object:
    return client.get(f"{API}/xpath", params={"q": q, **more}).json().get("value")


def table(content: bytes) -> tuple[np.ndarray, list[str]]:
    clip = FORMATS["c3d"].read({"c3d": SourceFile("a.c3d", io.BytesIO(content))}, ReadOptions())
    values = np.concatenate([block.values for block in clip.blocks()])
    return values.reshape(len(values), len(clip.head.skeleton), 4), list(clip.head.skeleton.names)


def test_markers_are_bones_that_xpath_finds(client: TestClient) -> None:
    content = c3d_file(frames=600, points=4)
    values, names = table(content)
    uuid = upload(client, "hand.c3d", content)
    assert ask(client, "count(//skeleton/bone | //root)") == 4
    x, residual = values[:, 1, 0], values[:, 1, 3]
    assert ask(client, f"count(//frame_bone[@name='{names[1]}'][@Tx > 2])") == int((x > 2).sum())
    assert ask(client, f"count(//frame_bone[@name='{names[1]}'][@residual > 5])") == int((residual > 5).sum())
    assert ask(client, f"count(//frame[not(frame_bone[@name='{names[1]}']/@Tx)])") == int(np.isnan(x).sum())
    assert ask(client, "count(//frame_bone)") == 600 * 4, "missing samples keep their place"
    positions = client.get(f"{API}/documents/{uuid}/frames", params={"format": "npy"}).content
    stored = np.load(io.BytesIO(positions)).reshape(600, 4, 4)
    assert np.array_equal(stored, values, equal_nan=True)


def test_exports_of_markers(client: TestClient) -> None:
    content = c3d_file(frames=300)
    uuid = upload(client, "hand.c3d", content)
    export = f"{API}/documents/{uuid}/export"
    assert client.get(export, params={"format": "c3d"}).content == content
    made = client.get(export, params={"format": "c3d", "original": False}).content
    assert made != content
    assert np.array_equal(table(made)[0], table(content)[0], equal_nan=True)
    trc = client.get(export, params={"format": "trc"})
    assert trc.content.startswith(b"PathFileType")
    assert "residual" in trc.headers["x-mcml-notices"]
    again = upload(client, "again.trc", trc.content)
    count = "count(//frame_bone[@Ty > 1])"
    assert ask(client, count, document=again) == ask(client, count, document=uuid)
    refused = client.get(export, params={"format": "bvh"})
    assert refused.status_code == 422
    assert "no skeleton" in refused.json()["detail"]


def test_a_body_leaves_as_markers(client: TestClient) -> None:
    uuid = upload(client, "walk.bvh", bvh(300))
    stated = client.patch(f"{API}/documents/{uuid}", json={"unit": "cm"}, headers={"if-match": "*"})
    assert stated.status_code == 200
    export = f"{API}/documents/{uuid}/export"
    points = upload(client, "walk.trc", client.get(export, params={"format": "trc"}).content)
    positions = [
        np.load(io.BytesIO(client.get(f"{API}/documents/{one}/frames", params=dict(format="npy", **more)).content))
        for one, more in ((uuid, {"space": "positions"}), (points, {}))
    ]
    assert np.array_equal(positions[0].reshape(300, -1), positions[1])
    assert client.get(export, params={"format": "c3d"}).content[1:2] == b"P"


def test_looking_first_stores_nothing(client: TestClient) -> None:
    found = client.post(f"{API}/inspect", files=[("file", ("hand.trc", TRC))]).json()
    assert found["problems"] == []
    assert [joint["name"] for joint in found["clips"][0]["joints"]] == ["R.Wrist", "*0", "R.Wrist#2"]
    assert client.get(f"{API}/documents").json()["total"] == 0


def test_damaged_files_are_refused(client: TestClient) -> None:
    whole = c3d_file()
    for name, content in {"cut.c3d": whole[:300], "zero.c3d": whole[:512] + bytes(4000)}.items():
        answer = client.post(f"{API}/documents", files=[("file", (name, content))])
        assert answer.status_code == 422, answer.text
        assert answer.json()["where"]["file"] == name
        assert answer.json()["remedy"]
    assert client.get(f"{API}/documents").json()["total"] == 0
