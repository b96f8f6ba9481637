"""Composed documents: bit by bit where nothing was changed, bounded steps at the seams, provenance, previews."""

from __future__ import annotations

import io
import json
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from service.demo import body
from service.formats import FORMATS
from service.motion.clip import ClipStream
from tests.builders import bvh

API = "/api/v1"


def upload(client: TestClient, name: str, clip: ClipStream, **data: object) -> str:
    content = b"".join(FORMATS["bvh"].write(clip, "bvh"))
    answer = client.post(f"{API}/documents", files=[("file", (f"{name}.bvh", content))], data=data)
    return str(answer.json()["documents"][0]["id"])


@pytest.fixture
def walk(client: TestClient) -> str:
    return upload(client, "walk", body.clip("walk", 170.0, *body.walk(170.0, 5.0, 1.0, 6.0)), label="walk:60-200")


@pytest.fixture
def wave(client: TestClient) -> str:
    return upload(client, "wave", body.clip("wave", 170.0, *body.wave(170.0, 3.5, 1.5)), label="wave:40-120")


def compose(client: TestClient, *segments: dict[str, Any], **more: Any) -> dict[str, Any]:
    answer = client.post(f"{API}/compose", json={"segments": list(segments), **more})
    assert answer.status_code in (200, 201), answer.text
    made: dict[str, Any] = answer.json()
    return made


def values(client: TestClient, uuid: str, **more: str) -> np.ndarray:
    answer = client.get(f"{API}/documents/{uuid}/frames", params={"format": "npy", **more})
    assert answer.status_code == 200, answer.text
    return np.load(io.BytesIO(answer.content))


def test_pieces_in_order_give_the_clip_back(client: TestClient, walk: str) -> None:
    cuts = [1, 2, 60, 61, 200, 300]
    pieces = [{"document": walk, "first": a, "last": b - 1 if b < 300 else 300} for a, b in pairwise(cuts)]
    made = compose(client, *pieces, name="whole", project="made")
    assert made["frames"] == 300
    assert np.array_equal(values(client, made["document"]), values(client, walk))
    assert [(s["first"], s["last"], s["source_first"]) for s in made["segments"]] == [
        (1, 1, 1), (2, 59, 2), (60, 60, 60), (61, 199, 61), (200, 300, 200)
    ]  # fmt: skip
    assert client.get(f"{API}/documents/{made['document']}").json()["project"] == "made"
    named = "count(//frame[motion_name='walk'])"
    assert client.get(f"{API}/xpath", params={"q": named, "document": made["document"]}).json()["value"] == 141
    # What leaves in the format of the source is the source, but for what header and provenance say.
    mine, source = (
        client.get(f"{API}/documents/{uuid}/export", params={"format": "bvh"}).text.split("MOTION")[1]
        for uuid in (made["document"], walk)
    )
    assert np.array_equal(np.array(mine.split()[5:], dtype=float), np.array(source.split()[5:], dtype=float))


def test_seams_do_not_jump(client: TestClient, walk: str, wave: str) -> None:
    made = compose(
        client,
        {"document": walk, "first": 20, "last": 150},
        {"document": wave, "first": 30, "last": 160},
        {"document": walk, "first": 100, "last": 250},
        transition=10,
    )
    assert len(made["seams"]) == 2
    assert all(seam["transition"] >= 10 for seam in made["seams"])
    assert all(max(seam["root_step"], seam["angle_step"]) <= 1.1 for seam in made["seams"])
    assert made["frames"] == 131 + 131 + 151 + sum(seam["transition"] for seam in made["seams"])
    positions = values(client, made["document"], space="positions")
    step = np.linalg.norm(np.diff(positions[:, 0], axis=0), axis=1)
    source = np.linalg.norm(np.diff(values(client, walk, space="positions")[:, 0], axis=0), axis=1)
    assert step.max() <= 1.1 * source.max() + 1e-9
    plain = compose(client, {"document": walk, "first": 1, "last": 20}, {"document": wave}, transition=0, align=False)
    joined = values(client, plain["document"])
    assert np.array_equal(joined, np.vstack([values(client, walk)[:20], values(client, wave)]))


def test_runs_of_a_query_with_previews_and_rates(client: TestClient, walk: str, wave: str) -> None:
    request = {"xpath": "//frame[motion_name='walk' or motion_name='wave']"}
    before = client.get(f"{API}/documents").json()["total"]
    seen = compose(client, request, preview=True, rate=30, transition=0)
    assert "document" not in seen
    assert client.get(f"{API}/documents").json()["total"] == before
    made = compose(client, request, rate=30, transition=0, name="both")
    assert {key: made[key] for key in seen} == seen
    assert made["frames"] == 71 + 41
    assert made["seconds_per_frame"] == pytest.approx(1 / 30)
    assert client.get(f"{API}/documents/{made['document']}").json()["seconds_per_frame"] == pytest.approx(1 / 30)
    first = values(client, made["document"], space="rotations")[:71]
    assert np.allclose(np.abs(np.sum(first * values(client, walk, space="rotations")[59:200:2], axis=-1)), 1, atol=1e-3)


def test_layers_take_bones_of_another_clip(client: TestClient, walk: str, wave: str) -> None:
    arms = ["left_up_arm", "left_low_arm"]
    names = [bone["name"] for bone in client.get(f"{API}/documents/{walk}").json()["bones"]]
    arms = [name for name in names if "left" in name and "arm" in name]
    made = compose(
        client,
        {"document": walk, "first": 1, "last": 100, "layers": [{"document": wave, "first": 11, "bones": arms}]},
    )
    columns = client.get(f"{API}/documents/{walk}/frames?format=npy").headers["x-mcml-columns"].split(",")
    taken = [i for i, name in enumerate(columns) if name.rpartition(".")[0] in arms]
    expected = values(client, walk)[:100]
    expected[:, taken] = values(client, wave)[10:110][:, taken]
    assert len(taken) >= 6
    assert np.array_equal(values(client, made["document"]), expected)


def test_header_and_provenance(client: TestClient, walk: str, wave: str) -> None:
    client.patch(f"{API}/documents/{wave}", json={"description": "of the wave"}, headers={"if-match": "*"})
    made = compose(client, {"document": walk, "last": 50}, header=wave)
    found = client.get(f"{API}/documents/{made['document']}").json()
    assert found["description"] == "of the wave"
    record = json.loads(next(item["value"] for item in found["properties"] if item["name"] == "provenance"))
    assert record["sources"] == [{"document": walk, "revision": 1, "first": 1, "frames": 50}]
    again = compose(client, {"document": walk, "last": 50}, header=wave)
    assert again["document"] != made["document"]


@pytest.mark.parametrize("kind", ["sqlite"], indirect=True)
def test_what_cannot_be_composed(client: TestClient, walk: str) -> None:
    other = client.post(f"{API}/documents", files=[("file", ("a.bvh", bvh(9)))]).json()["documents"][0]["id"]

    def refused(*segments: dict[str, Any], **more: Any) -> int:
        answer = client.post(f"{API}/compose", json={"segments": list(segments), **more})
        assert answer.json().get("detail")
        return answer.status_code

    assert refused({"document": walk}, {"document": other}) == 422
    assert refused({"document": "nobody"}) == 404
    assert refused({"document": walk, "last": 9999}) == 404
    assert refused({"xpath": "//frame[motion_name='nothing']"}) == 422
    assert refused({"first": 1}) == 422
    assert refused() == 422
    assert refused({"document": walk, "layers": [{"document": walk, "bones": ["tail"]}]}) == 422
    assert client.get(f"{API}/documents").json()["total"] == 2
