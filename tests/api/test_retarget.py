"""Retargeting over HTTP: onto the same body, onto another, with a mapping of one's own."""

from __future__ import annotations

import csv
import io
import json
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml.formats import FORMATS
from mcml.motion.conventions.resizing import turn_up
from mcml_service.demo import body
from tests.builders import bvh, c3d_file, one_kind

API = "/api/v1"

pytestmark = one_kind


def person(client: TestClient, height: float, up: str = "Y") -> str:
    clip = turn_up(body.clip(f"walk_{height:.0f}", height, *body.walk(height, 4.0, 1.0, 6.0)), "Y", up)
    content = b"".join(FORMATS["bvh"].write(clip, "bvh"))
    files = [("file", (f"walk_{height:.0f}.bvh", content))]
    answer = client.post(f"{API}/documents", files=files, data={"unit": "cm", "up": up, "label": "walk"})
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


def test_another_axis_up(client: TestClient) -> None:
    one = person(client, 160.0)
    places = []
    for skeleton in (person(client, 184.0), person(client, 184.0, up="Z")):
        made = client.post(f"{API}/documents/{one}/retarget", json={"skeleton": skeleton}).json()
        places.append(values(client, made["document"], space="positions").reshape(240, -1, 3))
    assert any("Z points up" in notice for notice in made["notices"])
    x, y, z = np.moveaxis(places[0], -1, 0)
    assert np.abs(np.stack([x, -z, y], axis=-1) - places[1]).max() < 1e-6


def test_onto_a_known_rig(client: TestClient) -> None:
    walk = person(client, 172.0)
    rigs = {rig["name"]: rig for rig in client.get(f"{API}/rigs").json()["items"]}
    assert rigs["unreal5"] == {
        "name": "unreal5", "title": "Unreal Engine 5 mannequin", "unit": "cm", "up": "Z", "joints": 80,
    }  # fmt: skip
    made = client.post(f"{API}/documents/{walk}/retarget", json={"to": "unreal5", "name": "on the mannequin"}).json()
    assert max(part["mean"] for part in made["parts"] if part["part"].endswith((" arm", " leg"))) < 0.1
    document = client.get(f"{API}/documents/{made['document']}").json()
    assert (document["name"], document["unit"], document["frames"]) == ("on the mannequin", "cm", 240)
    assert {"pelvis", "upperarm_twist_01_l", "index_02_r"} <= {bone["source_name"] for bone in document["bones"]}
    record = json.loads(next(item["value"] for item in document["properties"] if item["name"] == "provenance"))
    assert [item["document"] for item in record["sources"]] == [walk]
    assert record["parameters"]["to"] == "unreal5"
    exported = client.get(f"{API}/documents/{made['document']}/export", params={"format": "bvh"})
    assert b"JOINT clavicle_l" in exported.content
    # The person stands in centimetres on the ground of the rig.
    places = values(client, made["document"], space="positions").reshape(240, -1, 3)
    assert 150 < np.ptp(places[..., 2], axis=1).mean() < 175
    assert places[..., 2].min() > -10


def test_a_known_rig_in_a_preview_and_for_many(client: TestClient) -> None:
    walk = person(client, 172.0)
    asked = {"to": "rigify", "preview": True}
    seen = client.post(f"{API}/documents/{walk}/retarget", params={"positions": "f4"}, json=asked).json()
    assert (seen["motion"]["metres"], seen["motion"]["up"], "document" in seen) == (1.0, "Z", False)
    answer = client.post(f"{API}/retarget", json=asked | {"selection": {"motion_name": "walk"}})
    assert [json.loads(line)["source"] for line in answer.text.splitlines()] == [walk]


@pytest.mark.parametrize("target", [{}, {"to": "unreal5", "skeleton": "other"}, {"to": "biped9000"}])
def test_one_target_is_named(client: TestClient, target: dict[str, str]) -> None:
    answer = client.post(f"{API}/documents/{person(client, 170.0)}/retarget", json=target)
    assert answer.status_code == 422
    assert ("unreal5" if target.get("to") == "biped9000" else "either `skeleton`") in answer.text


def test_many_at_once(client: TestClient) -> None:
    walks, other = [person(client, height) for height in (150.0, 160.0, 170.0)], person(client, 185.0)
    client.post(f"{API}/documents", files=[("file", ("a.c3d", c3d_file()))], data={"label": "walk"})
    request = {"selection": {"motion_name": "walk"}, "skeleton": other, "project": "large"}

    def lines(**more: object) -> list[dict[str, Any]]:
        answer = client.post(f"{API}/retarget", json=request | more)
        assert answer.headers["content-type"] == "application/x-ndjson"
        return [json.loads(line) for line in answer.text.splitlines()]

    seen = lines(preview=True)
    assert [item["source"] for item in seen[:3]] == walks
    assert ["made" in item for item in seen] == [True, True, True, False]
    assert "markers show no pelvis" in seen[3]["problem"]["detail"]
    made = [item["made"]["document"] for item in lines()[:3]]
    listed = client.get(f"{API}/documents", params={"project": "large"}).json()["items"]
    assert sorted(item["id"] for item in listed) == sorted(made)
    alone = client.post(f"{API}/documents/{walks[0]}/retarget", json={"skeleton": other}).json()["document"]
    assert np.array_equal(values(client, made[0]), values(client, alone))
    empty = request | {"selection": {"motion_name": "nobody does this"}}
    assert client.post(f"{API}/retarget", json=empty).text == ""
    for wrong in ({"mapping": "unknown"}, {"selection": {}}, {"skeleton": "nobody"}):
        assert client.post(f"{API}/retarget", json=request | wrong).status_code in (404, 422)


def test_one_table_of_many_with_problems_and_outliers_first(client: TestClient) -> None:
    walks, other = [person(client, height) for height in (150.0, 160.0, 170.0)], person(client, 185.0)
    client.post(f"{API}/documents", files=[("file", ("a.c3d", c3d_file()))], data={"label": "walk"})
    request = {"selection": {"motion_name": "walk"}, "skeleton": other, "preview": True}
    answer = client.post(f"{API}/retarget", json=request, params={"format": "json"})
    assert answer.status_code == 200, answer.text
    table = answer.json()
    assert (table["made"], table["failed"]) == (3, 1)
    rows = table["rows"]
    assert "markers show no pelvis" in rows[0]["problem"]
    assert {row["source"] for row in rows[1:]} == set(walks)
    for row in rows[1:]:
        assert max(row[part] for part in ("limbs", "hips", "shoulders", "trunk", "head")) < 0.1
        assert row["foot_slide"] >= 0
    deviations = [row["deviation"] for row in rows[1:]]
    assert deviations == sorted(deviations, reverse=True)
    text = client.post(f"{API}/retarget", json=request, params={"format": "csv"})
    assert text.headers["content-type"].startswith("text/csv")
    lines = list(csv.DictReader(io.StringIO(text.text)))
    assert [line["source"] for line in lines] == [row["source"] for row in rows]
    assert float(lines[1]["trunk (deg)"]) == pytest.approx(rows[1]["trunk"], rel=1e-3, abs=1e-12)
    ended = client.post(f"{API}/retarget", json=request, params={"summary": True}).text.splitlines()
    assert len(ended) == 5
    assert json.loads(ended[-1])["table"]["rows"][0]["problem"] == rows[0]["problem"]


def test_travel_limits_and_hands(client: TestClient) -> None:
    small, large = person(client, 160.0), person(client, 184.0)
    url = f"{API}/documents/{small}/retarget"

    def made(**options: object) -> Any:
        answer = client.post(url, json={"skeleton": large, "preview": True} | options)
        assert answer.status_code == 201 or answer.status_code == 200, answer.text
        return answer.json()

    usual = made()
    assert usual["travel_scale"] == pytest.approx(184 / 160, rel=1e-3)
    assert {part["part"] for part in usual["parts"]} >= {"left arm", "right leg", "hips", "shoulders", "trunk", "head"}
    assert made(travel_scale=1)["travel_scale"] == 1
    assert made(travel_scale=1)["scale"] == usual["scale"]
    assert "hands" in made(keep_hands=True)
    limited = made(limits=[{"joint": "left_low_leg", "axis": "X", "low": -1, "high": 1}])
    (clamped,) = limited["clamped"]
    assert clamped["joint"] == "left_low_leg"
    assert clamped["largest"] > 5
    assert clamped["frames"] == sum(span["last"] - span["first"] + 1 for span in clamped["spans"])
    assert any("left_low_leg" in notice and "limits" in notice for notice in limited["notices"])
    for wrong, words in (
        ("file", "states no limits"),
        ([{"joint": "tail", "axis": "X", "low": 0, "high": 1}], "tail"),
        ([{"joint": "left_low_leg", "axis": "X", "low": 2, "high": 1}], "low is above high"),
    ):
        answer = client.post(url, json={"skeleton": large, "limits": wrong})
        assert answer.status_code == 422, answer.text
        assert words in answer.text


def test_what_cannot_be_retargeted(client: TestClient) -> None:
    walk = person(client, 170.0)
    markers = client.post(f"{API}/documents", files=[("file", ("a.c3d", c3d_file()))]).json()["documents"][0]["id"]
    chain = client.post(f"{API}/documents", files=[("file", ("a.bvh", bvh(5, names=("a", "b"))))]).json()
    url = f"{API}/documents/{walk}/retarget"
    assert client.post(url, json={"skeleton": markers}).status_code == 422
    assert client.post(url, json={"skeleton": chain["documents"][0]["id"]}).status_code == 422
    assert client.post(url, json={"skeleton": "nobody"}).status_code == 404
    assert client.get(f"{API}/documents").json()["total"] == 3
