"""What would be made, looked at before it is: positions of compositions, retargetings and files; and their options."""

from __future__ import annotations

import base64
import io
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml.motion.skeleton import Array
from mcml_service.storage.database import Database
from tests.builders import bvh, store
from tests.operations.test_viewing import TWO_LEGS

API = "/api/v1"


def positions(client: TestClient, uuid: str) -> Array:
    asked = {"space": "positions", "format": "npy"}
    found: Array = np.load(io.BytesIO(client.get(f"{API}/documents/{uuid}/frames", params=asked).content))
    return found


def shown(answer: Any) -> Array:
    motion = answer["motion"]
    data = np.frombuffer(base64.b64decode(motion["data"]), "<f4").reshape(motion["shape"])
    assert len(motion["bones"]) <= len(motion["parents"]) == data.shape[1], "ends of chains follow the joints"
    joints: Array = data[:, : len(motion["bones"])] + np.array(motion["origin"])
    return joints


def post(client: TestClient, path: str, body: Any, **query: object) -> Any:
    answer = client.post(f"{API}/{path}", json=body, params=query)  # type: ignore[arg-type]
    assert answer.is_success, answer.text
    return answer.json()


def test_compositions_are_looked_at(client: TestClient, database: Database) -> None:
    uuid = store(database, {"walk.bvh": bvh(60)})[0]
    body = {"segments": [{"document": uuid, "first": 5, "last": 40}], "preview": True}
    made = post(client, "compose", body, positions="f4", first=3, last=10)
    np.testing.assert_allclose(shown(made), positions(client, uuid)[6:14], atol=1e-4)
    assert "motion" not in post(client, "compose", body)
    assert client.post(f"{API}/compose", json=body, params={"positions": "f4", "first": 90}).status_code == 404
    wide = {"positions": "f4", "last": 5000}
    assert client.post(f"{API}/compose", json=body, params=wide).status_code == 413


def test_segments_have_a_speed(client: TestClient, database: Database) -> None:
    uuid = store(database, {"walk.bvh": bvh(61)})[0]
    body = {"segments": [{"document": uuid, "speed": 2.0}], "preview": True}
    made = post(client, "compose", body, positions="f4")
    assert made["frames"] == 31
    np.testing.assert_allclose(shown(made), positions(client, uuid)[::2], atol=1e-3)


def test_segments_are_mirrored(client: TestClient, database: Database) -> None:
    uuid = store(database, {"stand.bvh": TWO_LEGS}, up="Z")[0]
    body = {"segments": [{"document": uuid, "mirror": True}], "preview": True}
    made = shown(post(client, "compose", body, positions="f4"))
    np.testing.assert_allclose(made, positions(client, uuid), atol=1e-4)
    assert made.shape == (1, 4, 3)


def test_each_segment_may_have_its_own_transition(client: TestClient, database: Database) -> None:
    uuid = store(database, {"walk.bvh": bvh(60)})[0]
    part = {"document": uuid, "first": 1, "last": 20}
    segments = [part, {**part, "transition": 5}, part, {**part, "transition": 0}]
    body = {"segments": segments, "transition": 9, "lengthen": False, "preview": True}
    made = post(client, "compose", body)
    assert [seam["transition"] for seam in made["seams"]] == [5, 9, 0]
    bridged = made["frames"]
    faded = post(client, "compose", {**body, "segments": [part, {**part, "transition": 5, "style": "crossfade"}]})
    assert (bridged, faded["frames"]) == (80 + 5 + 9, 40 - 5)


def test_retargetings_are_looked_at(client: TestClient, database: Database) -> None:
    source = store(database, {"walk.bvh": bvh(30)})[0]
    target = store(database, {"other.bvh": bvh(3, seed=1).replace(b"10.5", b"21.0")})[0]
    body = {"skeleton": target, "preview": True}
    made = post(client, f"documents/{source}/retarget", body, positions="f4", last=4)
    assert shown(made).shape == (4, 3, 3)
    assert made["scale"] != 3.0
    scaled = post(client, f"documents/{source}/retarget", {**body, "scale": 3.0}, positions="f4")
    assert scaled["scale"] == 3.0
    np.testing.assert_allclose(shown(scaled)[:, 0], 3 * positions(client, source)[:, 0], atol=1e-3)
    stored = post(client, f"documents/{source}/retarget", {"skeleton": target}, positions="f4")
    np.testing.assert_allclose(shown(stored), positions(client, stored["document"]), atol=1e-3)
    assert all(1 <= bone["frame"] <= 30 for bone in made["bones"])


def test_joints_turn_from_rest_as_their_sources_do(client: TestClient, database: Database) -> None:
    source = store(database, {"walk.bvh": bvh(30)})[0]
    bent = bvh(3, seed=1).replace(b"OFFSET 0.00 10.5 0.00", b"OFFSET 10.5 0.00 0.00")
    target = store(database, {"bent.bvh": bent})[0]
    body = {"skeleton": target, "preview": True, "scale": 1.0}
    pointed, turned = (
        shown(post(client, f"documents/{source}/retarget", {**body, "match_rest": rest}, positions="f4"))
        for rest in (False, True)
    )
    wanted = positions(client, source)
    np.testing.assert_allclose(np.diff(pointed, axis=1), np.diff(wanted, axis=1), atol=1e-3)
    asked = {"space": "rotations", "format": "npy", "bone": "Root"}
    answer = client.get(f"{API}/documents/{source}/frames", params=asked)
    x, y, z, w = np.load(io.BytesIO(answer.content))[:, 0].T
    first = 10.5 * np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)], axis=1)
    np.testing.assert_allclose(turned[:, 1] - turned[:, 0], first, atol=1e-3)


@pytest.mark.parametrize("last", [None, 7])
def test_files_are_looked_at(client: TestClient, database: Database, last: int | None) -> None:
    content = bvh(30)
    uuid = store(database, {"walk.bvh": content})[0]
    form = {"positions": "f4"} | ({} if last is None else {"last": str(last)})
    answer = client.post(f"{API}/inspect", files=[("file", ("walk.bvh", content))], data=form)
    np.testing.assert_allclose(shown(answer.json()["clips"][0]), positions(client, uuid)[:last], atol=1e-4)
    plain = client.post(f"{API}/inspect", files=[("file", ("walk.bvh", content))])
    assert "motion" not in plain.json()["clips"][0]
    broken = client.post(f"{API}/inspect", files=[("file", ("a.bvh", content[:-200]))]).json()["problems"][0]["problem"]
    assert broken["details"] == {"repairs": ["whole-frames"]}
