"""glTF, USD and OpenSim's tables by URL and in batches, as the other formats."""

from __future__ import annotations

import io
import zipfile

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml.formats import NEEDED, WRITERS
from tests.builders import FACE, TRC, bvh, upload
from tests.formats.scenes.reading import read_glb
from tests.motion.bodies.made import person

pytestmark = pytest.mark.above_store

API = "/api/v1"
BEGINNINGS = {
    "glb": b"glTF",
    "usd": b"PXR-USDC",
    "usda": b"#usda",
    "mot": b"walk.bvh\nversion=1\n",
    "sto": b"walk.bvh\n",
}


def stored(client: TestClient, files: dict[str, bytes], **form: object) -> str:
    (document,) = upload(client, files, **form)["documents"]
    return str(document["id"])


@pytest.mark.parametrize("format", BEGINNINGS)
def test_they_are_asked_for_by_url(client: TestClient, format: str) -> None:
    uuid = stored(client, {"walk.bvh": person(1, 30)}, unit="cm", up="Y")
    answer = client.get(f"{API}/documents/{uuid}/export", params={"format": format})
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"].partition(";")[0] == WRITERS[format].media_type
    assert f"walk.{format}" in answer.headers["content-disposition"]
    assert answer.content.startswith(BEGINNINGS[format])
    assert "states no" not in answer.headers.get("x-mcml-notices", "")


def test_a_face_leaves_as_its_table_and_a_body_does_not(client: TestClient) -> None:
    face = stored(client, {"face.mcml": FACE})
    answer = client.get(f"{API}/documents/{face}/export", params={"format": "arkit"})
    assert answer.headers["content-type"].partition(";")[0] == "text/csv"
    assert "face.csv" in answer.headers["content-disposition"]
    assert answer.text.splitlines()[1] == "00:00:00:00.000,5,0.25,0.0,0.2,0.1,-0.1"
    body = stored(client, {"walk.bvh": person(1, 3)})
    refused = client.get(f"{API}/documents/{body}/export?format=arkit")
    assert refused.status_code == 422
    assert "blend shapes" in refused.json()["detail"]


def test_what_is_not_stated_is_told(client: TestClient) -> None:
    uuid = stored(client, {"walk.bvh": person(1, 30)})
    for format in BEGINNINGS:
        answer = client.get(f"{API}/documents/{uuid}/export", params={"format": format})
        assert "the document states no up axis" in answer.headers["x-mcml-notices"], format
    refused = client.get(f"{API}/documents/{uuid}/export?format=trc")
    assert refused.status_code == 422
    assert "unit of length" in refused.json()["detail"]


def test_parts_units_and_axes_are_as_of_other_formats(client: TestClient) -> None:
    uuid = stored(client, {"walk.bvh": person(1, 30)}, unit="cm", up="Y")
    address = f"{API}/documents/{uuid}/export"
    whole = read_glb(client.get(address, params={"format": "glb"}).content).positions()
    positions = client.get(f"{API}/documents/{uuid}/frames", params={"format": "npy", "space": "positions"})
    np.testing.assert_allclose(whole, np.load(io.BytesIO(positions.content)) / 100, atol=1e-5)
    part = read_glb(client.get(address, params={"format": "glb", "first": 5, "last": 9}).content).positions()
    np.testing.assert_allclose(part, whole[4:9], atol=1e-5)
    turned = client.get(address, params={"format": "glb", "unit": "mm", "up": "Z"})
    # What the file states is what its readers turn back.
    np.testing.assert_allclose(read_glb(turned.content).positions(), whole, atol=1e-5)
    named = read_glb(client.get(address, params={"format": "glb", "names": "asf"}).content)
    assert "lfemur" in [node.get("name") for node in named.model["nodes"]]


def test_many_at_once(client: TestClient) -> None:
    bodies = [stored(client, {"walk.bvh": person(seed, 8)}) for seed in (1, 2)]
    empty = stored(client, {"still.bvh": bvh(0)})
    points = stored(client, {"hand.trc": TRC})
    request = {"selection": {"documents": [*bodies, empty, points]}, "format": "glb"}
    with zipfile.ZipFile(io.BytesIO(client.post(f"{API}/exports", json=request).content)) as archive:
        names = archive.namelist()
        assert {"walk.glb", f"walk-{bodies[1][-6:]}.glb", "still.glb", "hand.glb"} == set(names)
        for name in names:
            read_glb(archive.read(name))
    with zipfile.ZipFile(
        io.BytesIO(client.post(f"{API}/exports", json=request | {"format": "mot"}).content)
    ) as archive:
        assert len(archive.namelist()) == 3
        refused = archive.read("refused.txt").decode()
        assert "no pelvis with both hips" in refused
        assert "no angle of this body" in refused


def test_they_are_listed(client: TestClient, monkeypatch: pytest.MonkeyPatch) -> None:
    items = {item["name"]: item for item in client.get(f"{API}/formats").json()["items"]}
    assert {name: (item["reads"], item["writes"]) for name, item in items.items() if name in BEGINNINGS} == {
        "glb": (True, True),
        "usd": (True, True),
        "usda": (False, True),
        "mot": (False, True),
        "sto": (False, True),
    }
    assert items["bvh"]["reads"]
    assert items["glb"]["convention"] == "any"
    for name in NEEDED:
        monkeypatch.setitem(NEEDED, name, "a_module_that_is_not_there")
    items = {item["name"]: item for item in client.get(f"{API}/formats").json()["items"]}
    assert not items["usd"]["writes"]


def test_tables_of_opensim_are_not_read(client: TestClient) -> None:
    uuid = stored(client, {"walk.bvh": person(1, 5)})
    for format in ("mot", "sto"):
        content = client.get(f"{API}/documents/{uuid}/export", params={"format": format}).content
        answer = client.post(f"{API}/documents", files=[("file", (f"back.{format}", content))])
        assert answer.status_code >= 400
        assert "written, not read" in answer.text


def test_a_preset_decides_format_unit_and_axes(client: TestClient) -> None:
    uuid = stored(client, {"walk.bvh": person(1, 30)}, unit="cm", up="Z")
    address = f"{API}/documents/{uuid}/export"
    answer = client.get(address, params={"for": "blender"})
    assert answer.headers["x-mcml-notices"].endswith("for Blender: BVH, lengths in m, Y up")
    again = stored(client, {"again.bvh": answer.content})
    asked = {"format": "npy", "space": "positions"}
    before, after = (
        np.load(io.BytesIO(client.get(f"{API}/documents/{each}/frames", params=asked).content))
        for each in (uuid, again)
    )
    np.testing.assert_allclose(after[..., 1], before[..., 2] / 100, atol=1e-6)
    wins = client.get(address, params={"for": "blender", "format": "htr", "unit": "mm", "fps": 30})
    assert "for Blender: HTR" in wins.headers["x-mcml-notices"]
    assert b"mm" in wins.content
    assert client.get(address).status_code == 422
    assert client.get(address, params={"for": "lathe"}).status_code == 415


def test_an_export_has_a_height_and_stays_in_place(client: TestClient) -> None:
    uuid = stored(client, {"walk.bvh": person(1, 30)}, unit="cm", up="Y")
    address = f"{API}/documents/{uuid}"
    known = client.get(f"{address}/calibration").json()["height"]
    assert known["origin"] in ("measured", "guessed")
    query = {"format": "bvh", "height": 1.75, "in_place": True, "first": 3, "last": 20}
    answer = client.get(f"{address}/export", params=query)
    assert "1.75 m" in answer.headers["x-mcml-notices"]
    again = stored(client, {"tall.bvh": answer.content}, unit="cm", up="Y")
    height = client.get(f"{API}/documents/{again}/calibration").json()["height"]
    assert height["metres"] == pytest.approx(1.75, rel=1e-4)
    asked = {"format": "npy", "space": "positions"}
    places = np.load(io.BytesIO(client.get(f"{API}/documents/{again}/frames", params=asked).content))
    assert len(places) == 18
    assert np.ptp(places[:, 0, [0, 2]], axis=0).max() < 1e-3
    both = client.get(f"{address}/export", params={"format": "bvh", "height": 1.75, "scale": 2})
    assert both.status_code == 422
    many = {"selection": {"documents": [uuid]}, "for": "blender", "height": 1.75, "in_place": True}
    assert client.post(f"{API}/exports", json=many).status_code == 200


def test_presets_are_listed_and_export_many(client: TestClient) -> None:
    bodies = stored(client, {"walk.bvh": person(1, 30)}, unit="cm", up="Y")
    points = stored(client, {"points.trc": TRC})
    presets = {preset["name"]: preset for preset in client.get(f"{API}/formats").json()["presets"]}
    assert presets["opensim"]["markers"] == {"format": "trc", "unit": "m", "up": "Y", "fps": None}
    request = {"selection": {"documents": [bodies, points]}, "for": "blender"}
    names = zipfile.ZipFile(io.BytesIO(client.post(f"{API}/exports", json=request).content)).namelist()
    assert sorted(names) == ["points.glb", "walk.bvh"]
