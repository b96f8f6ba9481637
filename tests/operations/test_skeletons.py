"""Skeletons of stored marker trials: made for each person, and on the way to bodies and formats of joints."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml.formats import FORMATS
from tests.builders import upload
from tests.motion.bodies.made import clip_of, person
from tests.motion.solving.trials import markers_on, pair, trial, with_gaps

API = "/api/v1"


def trc(markers: dict[str, Any]) -> bytes:
    return b"".join(FORMATS["trc"].write(with_gaps(trial(markers)), "trc"))


def stored(client: TestClient, files: dict[str, bytes]) -> list[str]:
    return [item["id"] for item in upload(client, files)["documents"]]


@pytest.fixture
def two_people() -> bytes:
    return trc(pair())


def test_every_person_becomes_a_document(client: TestClient, two_people: bytes) -> None:
    (document,) = stored(client, {"trial.trc": two_people})
    path = f"{API}/documents/{document}/skeletons"
    seen = client.post(path, json={"preview": True})
    assert seen.status_code == 200, seen.text
    assert [(item["person"], item["document"]) for item in seen.json()["items"]] == [("Anna", None), ("Bea", None)]
    made = client.post(path, json={})
    assert made.status_code == 201, made.text
    assert [item["name"] for item in made.json()["items"]] == ["trial Anna", "trial Bea"]
    for item in made.json()["items"]:
        detail = client.get(f"{API}/documents/{item['document']}").json()
        assert detail["frames"] == 12
        rows = client.get(f"{API}/xpath", params={"q": "mo:angle('left-knee-flexion')", "document": item["document"]})
        assert rows.status_code in (200, 422)
    foot = next(joint for joint in made.json()["items"][0]["joints"] if joint["joint"] == "left_foot")
    assert foot["rms"] < 1e-4
    assert foot["unknown"] == 0
    one = client.post(path, json={"people": ["Bea"], "name": "Bea walks"})
    assert [item["name"] for item in one.json()["items"]] == ["Bea walks"]
    assert one.headers["location"].endswith(one.json()["items"][0]["document"])
    unknown = client.post(path, json={"people": ["Carl"]})
    assert unknown.status_code == 404
    assert "Anna, Bea" in unknown.json()["remedy"]


def test_exports_and_retargeting_make_it_on_their_own(client: TestClient) -> None:
    markers = markers_on(clip_of(person(3, 15)))
    document, body = stored(client, {"trial.trc": trc(markers), "body.bvh": person(7, 4)})
    made = client.post(f"{API}/documents/{document}/skeletons", json={}).json()["items"]
    assert [item["name"] for item in made] == ["trial skeleton"]
    answer = client.get(f"{API}/documents/{document}/export", params={"format": "bvh"})
    assert answer.status_code == 200, answer.text
    assert "a skeleton of 21 joints was made from markers" in answer.headers["x-mcml-notices"]
    assert b"Frames: 15" in answer.content
    moved = client.post(f"{API}/documents/{document}/retarget", json={"skeleton": body})
    assert moved.status_code == 201, moved.text
    assert {"left_up_leg", "right_hand"} <= {match["target"] for match in moved.json()["matches"]}
    assert any("was made from markers" in notice for notice in moved.json()["notices"])
    composed = client.post(
        f"{API}/compose", json={"segments": [{"document": body}, {"document": document}], "skeleton": body}
    )
    assert composed.status_code == 201, composed.text


def test_several_people_must_be_chosen_first(client: TestClient, two_people: bytes) -> None:
    document, body = stored(client, {"trial.trc": two_people, "body.bvh": person(7, 4)})
    for answer in (
        client.get(f"{API}/documents/{document}/export", params={"format": "bvh"}),
        client.post(f"{API}/documents/{document}/retarget", json={"skeleton": body}),
    ):
        assert answer.status_code == 422
        assert "several people: Anna, Bea" in answer.json()["detail"]
        assert "mcml skeletons" in answer.json()["remedy"]


def test_a_body_has_one_already(client: TestClient) -> None:
    (document,) = stored(client, {"body.bvh": person(7, 4)})
    answer = client.post(f"{API}/documents/{document}/skeletons", json={})
    assert answer.status_code == 422
    assert "has a skeleton already" in answer.json()["detail"]


def test_gaps_leave_gaps_in_what_is_retargeted(client: TestClient) -> None:
    markers = markers_on(clip_of(person(3, 15)))
    markers["LHJC"] = markers["LHJC"].copy()
    markers["LHJC"][5:8] = np.nan
    document, body = stored(client, {"trial.trc": trc(markers), "body.bvh": person(7, 4)})
    made = client.post(f"{API}/documents/{document}/retarget", json={"skeleton": body}).json()["document"]
    answer = client.get(
        f"{API}/documents/{made}/frames",
        params={"format": "npy", "bone": "left_low_leg", "space": "positions", "missing": "nan"},
    )
    values = np.load(io.BytesIO(answer.content)).reshape(15, -1)
    assert np.isnan(values[5:8]).all()
    assert np.isfinite(values[:5]).all()
    assert np.isfinite(values[8:]).all()
