"""Many documents at once, and which frames revisions touched."""

from __future__ import annotations

from typing import Any

import pytest
from fastapi.testclient import TestClient

from mcml_service.storage.database import Database
from tests.builders import bvh, store

API = "/api/v1"


@pytest.fixture
def uuids(database: Database) -> list[str]:
    return sorted(store(database, {f"{n}.bvh": bvh(5 + n, seed=n) for n in range(3)}, project="gait"))


def post(client: TestClient, path: str, body: dict[str, Any]) -> list[str]:
    answer = client.post(f"{API}/selections/{path}", json=body)
    assert answer.status_code == 200, answer.text
    return sorted(item["id"] for item in answer.json()["items"])


def total(client: TestClient) -> int:
    return int(client.get(f"{API}/documents").json()["total"])


def test_an_import_is_taken_back_and_brought_again(client: TestClient, database: Database, uuids: list[str]) -> None:
    assert post(client, "delete", {"project": "gait"}) == uuids
    assert total(client) == 0
    assert post(client, "restore", {"documents": uuids[:2]}) == uuids[:2]
    assert post(client, "restore", {"documents": uuids}) == uuids[2:], "those that are there stay"
    assert total(client) == 3
    assert client.post(f"{API}/selections/delete", json={"documents": [uuids[0], "none"]}).status_code == 404
    assert client.post(f"{API}/selections/delete", json={}).status_code == 422
    assert total(client) == 3, "all or none"
    assert database.check() == []


def test_many_are_changed_as_one(client: TestClient, uuids: list[str]) -> None:
    wanted = {
        "selection": {"documents": uuids},
        "change": {"unit": "cm", "properties": [{"name": "age", "value": "23", "unit": "year"}]},
        "labels": [{"name": "walk"}, {"name": "turn", "first": 6, "last": 9}],
    }
    assert post(client, "change", wanted) == uuids
    for uuid in uuids:
        found = client.get(f"{API}/documents/{uuid}").json()
        assert (found["unit"], found["properties"][0]["value"], found["revision"]) == ("cm", "23", 2)
        spans = [("walk", 1, found["frames"])] + [("turn", 6, found["frames"])] * (found["frames"] > 5)
        assert [(one["name"], one["first"], one["last"]) for one in found["labels"]] == spans
    same = {"selection": {"documents": uuids}, "labels": [{"name": "walk"}]}
    assert post(client, "change", same) == []
    bad = {"selection": {"documents": uuids}, "change": {"unit": "parsec"}}
    assert client.post(f"{API}/selections/change", json=bad).status_code == 422


def touched(client: TestClient, uuid: str) -> list[list[tuple[int, int]] | None]:
    items = client.get(f"{API}/documents/{uuid}/revisions?with=frames").json()["items"]
    ranges = [item["touched"] for item in items]
    return [None if found is None else [(one["first"], one["last"]) for one in found] for found in ranges]


def test_revisions_say_which_frames_they_touched(client: TestClient, database: Database) -> None:
    uuid = store(database, {"walk.bvh": bvh(700)})[0]
    address, headers = f"{API}/documents/{uuid}", {"if-match": "*"}
    client.put(f"{address}/frames?first=250&column=Spine.Rx", json=[1.0] * 20, headers=headers)
    client.post(f"{address}/labels", json=[{"name": "walk", "first": 3, "last": 9}], headers=headers)
    client.patch(address, json={"name": "other"}, headers=headers)
    edits = {"edits": [{"do": "insert", "at": 11, "first": 1, "last": 4}, {"do": "delete", "first": 300, "last": 310}]}
    client.post(f"{address}/frames", json=edits, headers=headers)
    assert touched(client, uuid) == [[(11, 14)], [], [(3, 9)], [(250, 269)], None]
    plain = client.get(f"{address}/revisions").json()["items"]
    assert [item["touched"] for item in plain] == [None] * 5
