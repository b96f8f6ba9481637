"""Retargeting over HTTP: onto the same body, onto another, with a mapping of one's own."""

from __future__ import annotations

import io
import json

import numpy as np
import pytest
from fastapi.testclient import TestClient

from service.demo import body
from service.formats import FORMATS
from tests.builders import bvh, c3d_file

API = "/api/v1"


def person(client: TestClient, height: float) -> str:
    clip = body.clip(f"walk_{height:.0f}", height, *body.walk(height, 4.0, 1.0, 6.0))
    content = b"".join(FORMATS["bvh"].write(clip, "bvh"))
    files = [("file", (f"walk_{height:.0f}.bvh", content))]
    answer = client.post(f"{API}/documents", files=files, data={"unit": "cm", "label": "walk"})
    return str(answer.json()["documents"][0]["id"])


def values(client: TestClient, uuid: str, **more: str) -> np.ndarray:
    answer = client.get(f"{API}/documents/{uuid}/frames", params={"format": "npy", **more})
    return np.load(io.BytesIO(answer.content))


def test_onto_a_larger_body_and_back(client: TestClient) -> None:
    small, large = person(client, 160.0), person(client, 184.0)
    seen = client.post(f"{API}/documents/{small}/retarget", json={"skeleton": large, "preview": True})
    assert seen.status_code == 200, seen.text
    assert "document" not in seen.json()
    made = client.post(f"{API}/documents/{small}/retarget", json={"skeleton": large, "name": "large", "project": "p"})
    assert made.status_code == 201, made.text
    found = made.json()
    assert found["scale"] == pytest.approx(184 / 160, rel=1e-3)
    assert found["unmatched_source"] == found["unmatched_target"] == []
    assert max(bone["largest"] for bone in found["bones"]) < 0.1
    scaled = values(client, found["document"], space="positions")
    # Offsets are written with four decimals, so that the two bodies are similar to that.
    assert np.abs(scaled - values(client, small, space="positions") * 184 / 160).max() < 0.02
    document = client.get(f"{API}/documents/{found['document']}").json()
    assert (document["name"], document["project"], document["unit"]) == ("large", "p", "cm")
    record = json.loads(next(item["value"] for item in document["properties"] if item["name"] == "provenance"))
    assert [item["document"] for item in record["sources"]] == [small, large]
    assert client.get(f"{API}/xpath", params={"q": "count(//frame[motion_name='walk'])"}).json()["value"] == 3 * 240
    back = client.post(f"{API}/documents/{found['document']}/retarget", json={"skeleton": small}).json()
    assert np.abs(values(client, back["document"]) - values(client, small)).max() < 1e-3
    for format in ("bvh", "asf-amc", "htr"):
        assert client.get(f"{API}/documents/{found['document']}/export", params={"format": format}).status_code == 200


def test_feet_are_cleaned(client: TestClient) -> None:
    small, large = person(client, 150.0), person(client, 190.0)
    request = {"skeleton": large, "clean_feet": True, "preview": True}
    found = client.post(f"{API}/documents/{small}/retarget", json=request).json()
    assert found["feet"]
    for foot in found["feet"]:
        assert foot["after"] <= 0.2 * foot["before"] + 1e-9


def test_a_mapping_of_ones_own(client: TestClient) -> None:
    one, two = person(client, 170.0), person(client, 180.0)
    names = [bone["name"] for bone in client.get(f"{API}/documents/{one}").json()["bones"]]
    mapping = [{"source": name, "target": name} for name in names if "arm" not in name]
    found = client.post(f"{API}/documents/{one}/retarget", json={"skeleton": two, "mapping": mapping}).json()
    assert set(found["unmatched_target"]) == {name for name in names if "arm" in name}
    wrong = [{"source": "tail", "target": names[0]}]
    answer = client.post(f"{API}/documents/{one}/retarget", json={"skeleton": two, "mapping": wrong})
    assert answer.status_code == 422
    assert "tail" in answer.json()["detail"]


@pytest.mark.parametrize("kind", ["sqlite"], indirect=True)
def test_what_cannot_be_retargeted(client: TestClient) -> None:
    walk = person(client, 170.0)
    markers = client.post(f"{API}/documents", files=[("file", ("a.c3d", c3d_file()))]).json()["documents"][0]["id"]
    chain = client.post(f"{API}/documents", files=[("file", ("a.bvh", bvh(5, names=("a", "b"))))]).json()
    url = f"{API}/documents/{walk}/retarget"
    assert client.post(url, json={"skeleton": markers}).status_code == 422
    assert client.post(url, json={"skeleton": chain["documents"][0]["id"]}).status_code == 422
    assert client.post(url, json={"skeleton": "nobody"}).status_code == 404
    assert client.get(f"{API}/documents").json()["total"] == 3
