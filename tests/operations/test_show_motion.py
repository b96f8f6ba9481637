"""Motion that is not stored: the same positions as the document has that the request makes."""

from __future__ import annotations

import base64
import io

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml.motion.skeleton import Array
from tests.builders import bvh, upload

API = "/api/v1"
NAMES = ("Hips", "LeftUpLeg", "LeftLeg")


def stored(client: TestClient, name: str, frames: int) -> str:
    return str(upload(client, {name: bvh(frames, names=NAMES)})["documents"][0]["id"])  # type: ignore[index]


def shown(client: TestClient, path: str, body: dict[str, object], **more: object) -> Array:
    answer = client.post(f"{API}{path}", json=body | {"preview": True}, params={"positions": "f4", **more})
    assert answer.status_code == 200, answer.text
    motion = answer.json()["motion"]
    found: Array = np.frombuffer(base64.b64decode(motion["data"]), "<f4").reshape(motion["shape"])
    return found


def kept(client: TestClient, uuid: str) -> Array:
    asked = {"space": "positions", "format": "npy", "dtype": "f4", "origin": "subtract", "tips": True}
    found: Array = np.load(io.BytesIO(client.get(f"{API}/documents/{uuid}/frames", params=asked).content))
    return found


def test_a_composition_is_shown_as_it_would_be_stored(client: TestClient) -> None:
    one, two = stored(client, "one.bvh", 30), stored(client, "two.bvh", 25)
    body: dict[str, object] = {
        "segments": [{"document": one, "first": 3, "last": 20}, {"document": two}],
        "transition": 5,
        "name": "both",
    }
    seen = shown(client, "/compose", body)
    before = client.get(f"{API}/documents").json()["total"]
    assert before == 2, "nothing was stored"
    made = client.post(f"{API}/compose", json=body).json()["document"]
    assert np.allclose(seen, kept(client, made), atol=1e-4)
    assert np.array_equal(shown(client, "/compose", body, step=7), seen[::7])
    assert np.array_equal(shown(client, "/compose", body, first=4, last=20, step=3), seen[3:20:3])


@pytest.mark.parametrize("step", [1, 4])
def test_a_motion_on_another_body_is_shown_as_it_would_be_stored(client: TestClient, step: int) -> None:
    one, body = stored(client, "one.bvh", 30), stored(client, "body.bvh", 1)
    asked: dict[str, object] = {"skeleton": body, "name": "one on body"}
    seen = shown(client, f"/documents/{one}/retarget", asked, step=step)
    made = client.post(f"{API}/documents/{one}/retarget", json=asked).json()["document"]
    assert np.allclose(seen, kept(client, made)[::step], atol=1e-4)


def test_a_list_is_entered_anywhere(client: TestClient) -> None:
    for number in range(5):
        stored(client, f"clip{number}.bvh", 1)
    names = [item["name"] for item in client.get(f"{API}/documents").json()["items"]]
    answer = client.get(f"{API}/documents", params={"offset": 2, "limit": 2}).json()
    assert [item["name"] for item in answer["items"]] == names[2:4]
    assert answer["total"] == 5
    rest = client.get(f"{API}/documents", params={"limit": 2, "cursor": answer["next_cursor"]}).json()
    assert [item["name"] for item in rest["items"]] == names[4:]
    newest = client.get(f"{API}/documents", params={"offset": 4, "sort": "newest"}).json()
    assert [item["name"] for item in newest["items"]] == ["clip0"]
