"""Composed documents: bit by bit where nothing was changed, bounded steps at the seams, provenance, previews."""

from __future__ import annotations

import io
import json
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml.formats import FORMATS
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.resizing import scale, turn_up
from mcml_service.demo import body
from tests.builders import bvh, c3d_file, one_kind
from tests.clips.test_references import floating

API = "/api/v1"

pytestmark = one_kind
LEG = ("up_leg", "low_leg", "foot")


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


@pytest.mark.parametrize("style", ["bridge", "crossfade", "inertial"])
def test_walks_in_the_same_phase_name_the_frames_that_are_left(client: TestClient, walk: str, style: str) -> None:
    pieces = {"document": walk, "first": 20, "last": 180}, {"document": walk, "first": 43}
    made = compose(client, *pieces, transition=12, style=style, match_phase=True)
    source, new = (values(client, uuid)[:, 6:] for uuid in (walk, made["document"]))
    assert len(made["segments"]) == 2
    for span in made["segments"]:
        taken = source[span["source_first"] - 1 :][: span["last"] - span["first"] + 1]
        assert np.array_equal(new[span["first"] - 1 : span["last"]], taken)
    [seam] = made["seams"]
    assert sum(seam["left_out"]) > 0
    free = compose(client, *pieces, transition=12, style=style)
    assert free["seams"][0]["left_out"] == [0, 0]


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
    layer = {"document": wave, "first": 11, "last": 40, "at": 21, "bones": arms}
    later = compose(client, {"document": walk, "first": 1, "last": 100, "layers": [layer]})
    expected = values(client, walk)[:100]
    expected[20:50, taken] = values(client, wave)[10:40][:, taken]
    assert np.array_equal(values(client, later["document"]), expected)


def test_header_and_provenance(client: TestClient, walk: str, wave: str) -> None:
    client.patch(f"{API}/documents/{wave}", json={"description": "of the wave"}, headers={"if-match": "*"})
    made = compose(client, {"document": walk, "last": 50}, header=wave)
    found = client.get(f"{API}/documents/{made['document']}").json()
    assert found["description"] == "of the wave"
    record = json.loads(next(item["value"] for item in found["properties"] if item["name"] == "provenance"))
    assert record["sources"] == [{"document": walk, "revision": 1, "first": 1, "frames": 50}]
    again = compose(client, {"document": walk, "last": 50}, header=wave)
    assert again["document"] != made["document"]


def test_what_cannot_be_composed(client: TestClient, walk: str) -> None:
    chain = bvh(9, names=("a", "b"))
    other = client.post(f"{API}/documents", files=[("file", ("a.bvh", chain))]).json()["documents"][0]["id"]

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
    assert refused({"document": walk, "last": 9, "layers": [{"document": walk, "bones": ["Root"], "at": 10}]}) == 422
    assert client.get(f"{API}/documents").json()["total"] == 2


def joints(client: TestClient, uuid: str, *bones: str) -> np.ndarray:
    places = values(client, uuid, space="positions")
    names = [bone["name"] for bone in client.get(f"{API}/documents/{uuid}").json()["bones"]]
    return places.reshape(len(places), -1, 3)[:, [names.index(bone) for bone in bones]]


def test_other_bodies_are_fitted(client: TestClient, walk: str) -> None:
    # A larger person in another unit, with another axis up: the same walk in all.
    large = body.clip("large", 190.0, *body.walk(190.0, 5.0, 1.0, 6.0))
    other = upload(client, "large", turn_up(scale(large, 10.0), "Y", "Z"), unit="mm", up="Z")
    pieces = [{"document": other, "first": 1, "last": 150}, {"document": other, "first": 151, "last": 300}]
    made = compose(client, {"document": walk, "first": 1, "last": 100}, *pieces, transition=10)
    assert len(made["seams"]) == 1, "pieces that follow one another do so on another body too"
    assert any("points up" in notice for notice in made["notices"])
    alone = compose(client, *pieces, skeleton=walk)
    bones = ("left_up_leg", "left_low_leg", "left_foot", "right_hand")
    here, there = joints(client, alone["document"], *bones), joints(client, walk, *bones)
    lengths = [np.linalg.norm(np.diff(places[:, :3], axis=1), axis=2) for places in (here, there)]
    assert np.allclose(lengths[0], lengths[1], rtol=1e-6)
    # Both go the same way: the steps of the taller one are longer before, not after.
    assert np.abs(here - there).max() < 0.05
    document = client.get(f"{API}/documents/{alone['document']}").json()
    assert client.get(f"{API}/documents/{walk}").json().get("unit") == document.get("unit")


def test_bones_of_another_body_at_another_rate(client: TestClient, walk: str) -> None:
    wave = body.clip("wave", 190.0, *body.wave(190.0, 3.5, 1.5))
    other = upload(client, "wave", wave, frame_time=str(float(wave.head.frame_time or 0) * 2))
    layer = {"document": other, "bones": ["right_up_arm", "right_low_arm"]}
    made = compose(client, {"document": walk, "first": 1, "last": 300, "layers": [layer]})
    bones = ("left_up_leg", "left_foot", "right_low_arm")
    moved = np.abs(joints(client, made["document"], *bones) - joints(client, walk, *bones)).max(axis=(0, 2))
    assert moved[:2].max() == 0
    assert moved[2] > 5


def test_markers_are_brought_to_one_unit(client: TestClient) -> None:
    answers = [
        client.post(f"{API}/documents", files=[("file", ("m.c3d", c3d_file()))], data={"unit": unit}).json()
        for unit in ("mm", "cm")
    ]
    small, large = (answer["documents"][0]["id"] for answer in answers)
    made = compose(client, {"document": large}, skeleton=small)
    assert np.allclose(values(client, made["document"]), values(client, large) * 10, equal_nan=True)
    assert any("units differ" in notice for notice in made["notices"])


def test_a_saved_mapping(client: TestClient, walk: str) -> None:
    other = upload(client, "large", body.clip("large", 190.0, *body.walk(190.0, 5.0, 1.0, 6.0)))
    url, project = f"{API}/mappings/legs", {"project": "p"}
    pairs = [{"source": f"{side}_{part}", "target": f"{side}_{part}"} for side in ("left", "right") for part in LEG]
    spare = {"source": "tail", "target": "tail"}
    assert client.put(url, json={"pairs": [pairs[0], pairs[0]]}, params=project).status_code == 422
    saved = client.put(url, json={"pairs": [*pairs, spare]}, params=project)
    assert (saved.status_code, saved.headers["etag"], saved.json()["version"]) == (201, '"1"', 1)
    assert client.put(url, json={"pairs": pairs}, params=project).status_code == 428
    assert client.put(url, json={"pairs": pairs}, params=project, headers={"if-match": '"7"'}).status_code == 412
    again = client.put(url, json={"pairs": [spare, *pairs]}, params=project, headers={"if-match": '"1"'})
    assert (again.status_code, again.json()["version"]) == (200, 2)
    listed = client.get(f"{API}/mappings").json()["items"]
    assert listed == [client.get(url, params=project).json()]
    assert listed[0]["pairs"] == [spare, *pairs]

    made = compose(client, {"document": other, "mapping": "legs"}, skeleton=walk, project="p")
    named = [tuple(pair.values()) for pair in pairs]
    asked = {"skeleton": walk, "mapping": "legs", "project": "p", "preview": True}
    found = client.post(f"{API}/documents/{other}/retarget", json=asked).json()
    assert sorted((match["source"], match["target"]) for match in found["matches"]) == sorted(named)
    # Arms that nothing moves keep their rest pose.
    arm = joints(client, made["document"], "left_up_arm", "left_low_arm")
    assert np.ptp(np.diff(arm, axis=1), axis=0).max() < 1e-6
    wrong = client.post(f"{API}/compose", json={"segments": [{"document": other, "mapping": "legs"}]})
    assert wrong.status_code == 404, "another project has no such mapping"
    assert client.delete(url, params=project, headers={"if-match": '"1"'}).status_code == 412
    assert client.delete(url, params=project, headers={"if-match": '"2"'}).status_code == 204
    assert client.get(url, params=project).status_code == 404


def test_a_document_in_parts(client: TestClient, walk: str) -> None:
    def split(**request: Any) -> list[dict[str, Any]]:
        answer = client.post(f"{API}/documents/{walk}/split", json=request)
        assert answer.status_code == 201, answer.text
        items: list[dict[str, Any]] = answer.json()["items"]
        return items

    parts = split(at=[151, 61], project="parts")
    assert [(item["first"], item["last"]) for item in parts] == [(1, 60), (61, 150), (151, 300)]
    assert np.array_equal(np.concatenate([values(client, item["document"]) for item in parts]), values(client, walk))
    named = {"q": "count(//frame[motion_name='walk'])", "project": "parts"}
    assert client.get(f"{API}/xpath", params=named).json()["value"] == 141
    (part,) = split(label="walk")
    assert (part["first"], part["last"], part["name"]) == (60, 200, "walk 60-200")
    (part,) = split(first=101, last=140, name="turn")
    assert (part["first"], part["last"], part["name"]) == (101, 140, "turn")
    assert np.array_equal(values(client, part["document"]), values(client, walk)[100:140])
    (part,) = split(first=290)
    assert (part["first"], part["last"]) == (290, 300)
    for wrong in ({"at": [301]}, {"label": "run"}, {"first": 301}, {"first": 20, "last": 10}):
        assert client.post(f"{API}/documents/{walk}/split", json=wrong).status_code == 404
    for wrong in ({}, {"at": [1]}, {"at": [5], "label": "walk"}, {"at": [5], "last": 9}):
        assert client.post(f"{API}/documents/{walk}/split", json=wrong).status_code == 422


def test_a_skeleton_without_lengths_at_rest_is_known_by_its_frames(client: TestClient, walk: str) -> None:
    """Where its joints are comes with its motion: as the skeleton of the result, and as the first segment."""
    content = floating(4)
    answer = client.post(f"{API}/documents", files=[("file", ("floating.bvh", content))])
    other = str(answer.json()["documents"][0]["id"])
    for request in ({"skeleton": other}, {}):
        pieces = [{"document": walk, "first": 1, "last": 40}]
        if not request:
            pieces.insert(0, {"document": other, "first": 1, "last": 10})
        made = compose(client, *pieces, preview=True, **request)
        assert made["frames"] >= 40
