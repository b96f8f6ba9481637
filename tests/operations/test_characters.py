"""The body of a document over HTTP: a mesh, or the reason why there is none."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from fastapi.testclient import TestClient
from typer.testing import CliRunner

from mcml_service.cli import app
from mcml_service.storage.database import Database
from tests.builders import TRC, bvh, store, upload
from tests.formats.scenes.reading import read_glb
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
    assert chain["remedy"].startswith("Name its joints")
    markers = character(client, {"points.trc": TRC})
    assert markers["mesh"] is None
    assert markers["reason"] == "Markers have no bones that could carry a body."


def test_exports_have_it_where_the_format_can(client: TestClient) -> None:
    walk, chain = (
        upload(client, {name: content})["documents"][0]["id"]
        for name, content in (("walk.bvh", person(1, 6)), ("chain.bvh", bvh(3)))
    )

    def export(uuid: str, **asked: Any) -> Any:
        return client.get(f"{API}/documents/{uuid}/export", params={"character": "own", **asked})

    vertices = len(read_glb(export(walk, format="glb").content).body()[0])
    assert vertices > 1500
    assert len(read_glb(client.get(f"{API}/documents/{walk}/export", params={"format": "glb"}).content).body()[0]) < 300
    assert len(read_glb(export(walk, **{"for": "blender"}).content).body()[0]) == vertices
    refused = export(walk, format="bvh").json()
    assert (refused["status"], refused["detail"]) == (415, "BVH holds no body with a skin.")
    assert "glb, usd, usda" in refused["remedy"]
    assert "not recognised: left_up_arm" in export(chain, format="glb").json()["detail"]
    selection = {"documents": [walk, chain]}
    answer = client.post(f"{API}/exports", json={"selection": selection, "format": "glb", "character": "own"})
    with zipfile.ZipFile(io.BytesIO(answer.content)) as files:
        assert sorted(files.namelist()) == ["refused.txt", "walk.glb"]
        assert len(read_glb(files.read("walk.glb")).body()[0]) == vertices


def test_the_catalogue_says_which_formats_hold_it(client: TestClient) -> None:
    formats = client.get(f"{API}/formats").json()["items"]
    assert {item["name"] for item in formats if item["skins"]} == {"glb", "usd", "usda"}


def test_on_the_command_line(database: Database, tmp_path: Path) -> None:
    store(database, {"walk.bvh": person(1, 6)})
    address = database.dialect.engine.url.render_as_string(hide_password=False)
    done = CliRunner().invoke(app, ["character", "walk", "--json", "--database", address])
    assert done.exit_code == 0
    assert len(json.loads(done.output)["mesh"]["points"]) > 4500
    target = tmp_path / "walk.glb"
    asked = ["export", "walk", "--format", "glb", "--character", "own", "-o", str(target), "--database", address]
    assert CliRunner().invoke(app, asked).exit_code == 0
    assert len(read_glb(target.read_bytes()).body()[0]) > 1500
