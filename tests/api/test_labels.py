"""Labels over HTTP: renamed, moved, split, given by query, as tables."""

from __future__ import annotations

import pytest
from fastapi.testclient import TestClient

from mcml.formats import FORMATS
from mcml_service.demo import body
from mcml_service.storage.database import Database
from tests.builders import bvh, c3d_file, one_kind, store

API = "/api/v1"
ANY = {"if-match": "*"}


@pytest.fixture
def uuid(client: TestClient) -> str:
    labels = {"label": ["hop:10-20", "run:15-40"]}
    answer = client.post(f"{API}/documents", files=[("file", ("walk.bvh", bvh(60)))], data=labels)
    return str(answer.json()["documents"][0]["id"])


def labels(client: TestClient, uuid: str) -> list[tuple[str, int, int]]:
    items = client.get(f"{API}/documents/{uuid}/labels").json()["items"]
    return [(item["name"], item["first"], item["last"]) for item in items]


def named(client: TestClient, name: str) -> object:
    return client.get(f"{API}/xpath", params={"q": f"count(//frame[motion_name='{name}'])"}).json()["value"]


def test_a_label_is_renamed_moved_and_split(client: TestClient, uuid: str) -> None:
    def change(which: str, **body: object) -> int:
        found = client.get(f"{API}/documents/{uuid}/labels", params={"name": which}).json()["items"][0]["id"]
        answer = client.patch(f"{API}/documents/{uuid}/labels/{found}", json=body, headers=ANY)
        assert answer.status_code != 200 or answer.json()["items"]
        return answer.status_code

    assert change("hop", name="left-arm_abduction", first=5) == 200
    assert labels(client, uuid) == [("left-arm-abduction", 5, 20), ("run", 15, 40)]
    order = client.get(f"{API}/xpath", params={"q": "//frame[16]/motion_name"}).json()["items"]
    assert [item["value"].removeprefix("<motion_name>").split("<")[0] for item in order] == [
        "left-arm-abduction",
        "run",
    ]
    assert change("run", split=20) == 200
    assert labels(client, uuid) == [("left-arm-abduction", 5, 20), ("run", 15, 19), ("run", 20, 40)]
    assert named(client, "run") == 26
    assert change("run", last=99) == 404
    assert change("left-arm-abduction", split=5) == 422
    assert change("left-arm-abduction", name="left-shoulder-abduction") == 422
    assert client.patch(f"{API}/documents/{uuid}/labels/99999", json={}, headers=ANY).status_code == 404


@one_kind
def test_names_by_query(client: TestClient, uuid: str) -> None:
    other = client.post(f"{API}/documents", files=[("file", ("run.bvh", bvh(60, seed=3)))]).json()["documents"][0]["id"]
    query = "//frame[frame_bone[@name='Spine']/@Rx > 1]"
    expected = client.get(f"{API}/xpath", params={"q": f"count({query})"}).json()["value"]
    answer = client.post(f"{API}/labels", json={"name": "bent", "xpath": query})
    assert answer.status_code == 200, answer.text
    assert {item["id"] for item in answer.json()["items"]} <= {uuid, other}
    assert named(client, "bent") == expected
    assert client.post(f"{API}/labels", json={"name": "bent", "xpath": query}).json()["items"] == []
    some = f"{query}[position() <= 5]"
    gone = client.get(f"{API}/xpath", params={"q": f"count({some})", "document": uuid}).json()["value"]
    body = {"name": "bent", "xpath": some, "document": [uuid], "remove": True}
    assert len(client.post(f"{API}/labels", json=body).json()["items"]) == (gone > 0)
    assert named(client, "bent") == expected - gone
    assert named(client, "run") == 26, "other names stay"
    history = client.get(f"{API}/documents/{uuid}/revisions").json()["items"]
    assert history[0]["message"] == "bent by query"


def test_a_table_leaves_and_comes_back(client: TestClient, uuid: str) -> None:
    table = client.get(f"{API}/labels")
    assert table.headers["content-type"].startswith("text/csv")
    assert table.text == f"document,label,first,last\r\n{uuid},hop,10,20\r\n{uuid},run,15,40\r\n"
    before = client.get(f"{API}/documents/{uuid}/mcml").content
    for item in client.get(f"{API}/documents/{uuid}/labels").json()["items"]:
        client.delete(f"{API}/documents/{uuid}/labels/{item['id']}", headers=ANY)
    assert labels(client, uuid) == []
    assert client.put(f"{API}/labels", content=table.content).status_code == 200
    assert client.get(f"{API}/documents/{uuid}/mcml").content == before
    again = client.put(f"{API}/labels", content=table.content, params={"replace": True})
    assert again.json()["items"] == [], "what is there already is no change"
    fewer = table.content.replace(f"{uuid},run,15,40\r\n".encode(), b"")
    assert client.put(f"{API}/labels", content=fewer).json()["items"] == []
    client.put(f"{API}/labels", content=fewer, params={"replace": True})
    assert labels(client, uuid) == [("hop", 10, 20)]
    replaced = "name;label;first;last\nwalk;hüpfen;1;3\n".encode()
    answer = client.put(f"{API}/labels", content=replaced, params={"replace": True})
    assert [item["name"] for item in answer.json()["items"]] == ["walk"]
    assert labels(client, uuid) == [("hüpfen", 1, 3)]


@pytest.mark.parametrize(
    ("line", "number"),
    [
        ("walk,hop,1,99", 3),
        ("walk,hop,0,5", 3),
        ("walk,hop,five,6", 3),
        ("nobody,hop,1,5", 3),
        ("walk,,1,5", 3),
    ],
)
@one_kind
def test_a_wrong_line_is_named_and_nothing_written(client: TestClient, uuid: str, line: str, number: int) -> None:
    answer = client.put(f"{API}/labels", content=f"name,label,first,last\nwalk,jump,1,5\n{line}\n")
    assert answer.status_code == 422
    assert answer.json()["where"] == {"line": number}
    assert labels(client, uuid) == [("hop", 10, 20), ("run", 15, 40)]


@one_kind
def test_names_are_suggested_from_the_motion(client: TestClient, database: Database) -> None:
    clip = body.clip("walk", 170.0, *body.walk(170.0, 4.0, 1.0, 6.0))
    uuid = store(database, {"walk.bvh": b"".join(FORMATS["bvh"].write(clip, "bvh"))})[0]
    before = client.get(f"{API}/documents/{uuid}").json()["revision"]
    found = client.get(f"{API}/documents/{uuid}/labels/suggested", params={"kind": "movements"}).json()["items"]
    assert {"left-leg-flexion", "right-leg-flexion", "left-knee-flexion"} & {item["name"] for item in found}
    assert all(1 <= item["first"] <= item["last"] <= 240 and item["confidence"] >= 0.5 for item in found)
    assert client.get(f"{API}/documents/{uuid}").json()["revision"] == before
    surest = client.get(
        f"{API}/documents/{uuid}/labels/suggested", params={"kind": "movements", "confidence": 0.8}
    ).json()["items"]
    assert surest == [item for item in found if item["confidence"] >= 0.8]
    wanted = [{key: item[key] for key in ("name", "first", "last")} for item in found]
    answer = client.post(f"{API}/documents/{uuid}/labels?strict=true", json=wanted, headers={"if-match": "*"})
    assert answer.status_code == 201, answer.text
    assert client.get(f"{API}/documents/{uuid}").json()["revision"] == before + 1
    markers = store(database, {"a.c3d": c3d_file()})[0]
    refused = client.get(f"{API}/documents/{markers}/labels/suggested", params={"kind": "movements"})
    assert refused.status_code == 422
    assert "Markers" in refused.json()["detail"]


@pytest.mark.slow
@one_kind
def test_activities_are_suggested_in_everyday_words(client: TestClient, database: Database) -> None:
    clip = body.clip("walk", 170.0, *body.walk(170.0, 4.0, 1.0, 6.0))
    uuid = store(database, {"walk.bvh": b"".join(FORMATS["bvh"].write(clip, "bvh"))})[0]
    answer = client.get(f"{API}/documents/{uuid}/labels/suggested").json()
    (walk,) = [item for item in answer["items"] if item["name"] == "walk"]
    assert walk["last"] - walk["first"] > 200
    assert walk["steps"] >= 6
    assert walk["degrees"] is None
    assert answer["warnings"] == []
    surest = client.get(f"{API}/documents/{uuid}/labels/suggested", params={"confidence": 1.0}).json()["items"]
    assert all(item["confidence"] == 1.0 for item in surest)
    found = client.get(f"{API}/xpath", params={"q": "//frame[mo:activity('walk')]", "as": "runs"}).json()["items"]
    assert [(run["first"], run["last"]) for run in found] == [(walk["first"], walk["last"])]
    markers = store(database, {"a.c3d": c3d_file()})[0]
    unknown = client.get(f"{API}/documents/{markers}/labels/suggested").json()
    assert unknown["items"] == []
    assert "No activities are recognised" in unknown["warnings"][0]


@one_kind
def test_movements_are_named_on_import(client: TestClient) -> None:
    clip = body.clip("walk", 170.0, *body.walk(170.0, 4.0, 1.0, 6.0))
    files = [
        ("file", ("walk.bvh", b"".join(FORMATS["bvh"].write(clip, "bvh")))),
        ("file", ("points.c3d", c3d_file())),
    ]
    walk, points = client.post(f"{API}/documents", files=files, data={"movements": "0.5"}).json()["documents"]
    found = client.get(
        f"{API}/documents/{walk['id']}/labels/suggested", params={"kind": "movements", "confidence": 0.5}
    ).json()["items"]
    assert walk["movements"] == len(found) > 0
    assert sorted(labels(client, walk["id"])) == sorted((item["name"], item["first"], item["last"]) for item in found)
    history = client.get(f"{API}/documents/{walk['id']}/revisions").json()["items"]
    assert [item["operation"] for item in history] == ["label", "import"]
    assert points["movements"] is None
    assert "Markers" in points["receipt"]["notices"][-1]["what"]
