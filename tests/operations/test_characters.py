"""The body of a document over HTTP: a mesh, or the reason why there is none."""

from __future__ import annotations

from typing import Any

import numpy as np
from fastapi.testclient import TestClient

from tests.builders import TRC, bvh, upload
from tests.motion.bodies.made import person

API = "/api/v1"


def character(client: TestClient, files: dict[str, bytes], **form: Any) -> dict[str, Any]:
    (document,) = upload(client, files, **form)["documents"]
    answer = client.get(f"{API}/documents/{document['id']}/character")
    assert answer.status_code == 200
    found: dict[str, Any] = answer.json()
    return found


def test_a_person_has_a_mesh_in_the_units_of_the_document(client: TestClient) -> None:
    found = character(client, {"walk.bvh": person(1, 20)})
    mesh = found["mesh"]
    assert found["reason"] is None
    points = np.array(mesh["points"]).reshape(-1, 3)
    triangles = np.array(mesh["triangles"]).reshape(-1, 3)
    joints, weights = (np.array(mesh[name]).reshape(-1, 4) for name in ("joints", "weights"))
    assert len(points) == len(joints) == len(weights)
    assert triangles.min() == 0
    assert triangles.max() == len(points) - 1
    assert 1500 <= len(triangles) <= 6000
    assert (weights >= 0).all()
    assert np.abs(weights.sum(axis=1) - 1).max() < 1e-9
    assert joints.max() < len(mesh["bind_positions"]) == len(mesh["bind_rotations"])
    assert 150 < np.ptp(points[:, 1]) < 200, "centimetres"


def test_it_is_cached_for_a_revision_alone(client: TestClient) -> None:
    (document,) = upload(client, {"walk.bvh": person(1, 4)})["documents"]
    path = f"{API}/documents/{document['id']}/character"
    newest, stated = client.get(path), client.get(path, params={"revision": 1})
    assert "immutable" in stated.headers["cache-control"]
    assert "immutable" not in newest.headers.get("cache-control", "")
    assert client.get(path, headers={"if-none-match": newest.headers["etag"]}).status_code == 304


def test_others_have_a_reason(client: TestClient) -> None:
    chain = character(client, {"chain.bvh": bvh(3)})
    assert chain["mesh"] is None
    assert chain["reason"].startswith("A body needs joints that are not recognised: left_up_arm, right_up_arm")
    assert "docs/names.md" in chain["remedy"]
    markers = character(client, {"points.trc": TRC})
    assert markers["mesh"] is None
    assert markers["reason"] == "Markers have no bones that could carry a body."
