"""What projects keep: collections that stand for ids, questions, colours."""

from __future__ import annotations

import io
import zipfile
from typing import Any

import pytest
from fastapi.testclient import TestClient

from mcml_service.storage.database import Database
from tests.builders import bvh, store

API = "/api/v1"


@pytest.fixture
def uuids(database: Database) -> list[str]:
    done = store(database, {f"{name}.bvh": bvh(5, seed=n) for n, name in enumerate("abc")}, project="gait")
    return sorted(done)


def names(client: TestClient, **asked: object) -> list[str]:
    answer = client.get(f"{API}/documents", params=asked)  # type: ignore[arg-type]
    assert answer.status_code == 200, answer.text
    return [item["name"] for item in answer.json()["items"]]


def test_collections_stand_wherever_ids_are_taken(client: TestClient, database: Database, uuids: list[str]) -> None:
    chosen = [item["id"] for item in client.get(f"{API}/documents").json()["items"]][:2]
    made = client.put(f"{API}/collections/calm?project=gait", json={"documents": chosen})
    assert (made.status_code, made.json()["total"], made.headers["etag"]) == (201, 2, '"1"')
    by_rule = {"where": {"project": "gait", "q": "c"}, "description": "by rule"}
    assert client.put(f"{API}/collections/ruled", json=by_rule).json()["total"] == 1
    assert names(client, collection="gait/calm") == ["a", "b"]
    assert names(client, collection="ruled") == ["c"]
    assert names(client, collection="gait/calm", xpath="count(//frame) > 9") == []
    ask = {"q": "count(//frame)", "document": ["collection:gait/calm", "collection:ruled"]}
    assert client.get(f"{API}/xpath", params=ask).json()["value"] == 15
    export = {"selection": {"documents": ["collection:gait/calm"]}, "format": "bvh"}
    with zipfile.ZipFile(io.BytesIO(client.post(f"{API}/exports", json=export).content)) as archive:
        assert sorted(archive.namelist()) == ["a.bvh", "b.bvh"]
    client.delete(f"{API}/documents/{chosen[0]}", headers={"if-match": "*"})
    assert client.get(f"{API}/collections/calm?project=gait").json()["documents"] == chosen[1:]
    assert names(client, collection="gait/calm") == ["b"]
    listed = client.get(f"{API}/collections").json()["items"]
    assert [(item["project"], item["name"], item.get("documents")) for item in listed] == [
        ("default", "ruled", None),
        ("gait", "calm", None),
    ]
    for path in ("documents?collection=none", "xpath?q=//frame&document=collection:none", "collections/none"):
        assert client.get(f"{API}/{path}").status_code == 404, path
    assert database.check() == []


@pytest.mark.parametrize(
    ("path", "one", "two"),
    [
        ("collections/calm", {"documents": []}, {"where": {"q": "x"}}),
        ("queries/bent legs", {"q": "//frame"}, {"q": "//bone", "description": "bones", "variables": {"a": 1.5}}),
        ("colours", {"items": {"walk": "sky"}}, {"items": {"walk": "#CE5A04", "한": "plum"}}),
    ],
)
def test_what_is_kept_is_changed_by_its_version(
    client: TestClient, path: str, one: dict[str, Any], two: dict[str, Any]
) -> None:
    address = f"{API}/{path}"
    assert client.put(address, json=one).status_code == 201
    assert client.put(address, json=two).status_code == 428
    assert client.put(address, json=two, headers={"if-match": '"7"'}).status_code == 412
    changed = client.put(address, json=two, headers={"if-match": '"1"'})
    assert (changed.status_code, changed.json()["version"]) == (200, 2)
    kept = client.get(address).json()
    assert {key: kept[key] for key in two if key != "where"} == {key: two[key] for key in two if key != "where"}
    if path != "colours":
        assert client.delete(address, headers={"if-match": '"1"'}).status_code == 412
        assert client.delete(address, headers={"if-match": '"2"'}).status_code == 204
        assert client.get(address).status_code == 404


def test_collections_of_conditions_keep_how_they_are_shown(client: TestClient) -> None:
    view = {"sort": "-duration", "layout": "list", "folders": "property:subject"}
    made = client.put(f"{API}/collections/long", json={"where": {"length": "1.."}, "view": view})
    assert (made.status_code, made.json()["view"]) == (201, view)
    (listed,) = client.get(f"{API}/collections").json()["items"]
    assert listed["view"] == view


def test_lists_of_questions_have_pages(client: TestClient) -> None:
    for name in "cab":
        client.put(f"{API}/queries/{name}", json={"q": "//frame"})
    first = client.get(f"{API}/queries?limit=2").json()
    rest = client.get(f"{API}/queries", params={"limit": 2, "cursor": first["next_cursor"]}).json()
    assert [item["name"] for item in first["items"] + rest["items"]] == ["a", "b", "c"]
    assert client.get(f"{API}/queries?project=other").json()["items"] == []


@pytest.mark.parametrize(
    ("path", "wrong"),
    [
        ("queries/q", {"q": "//["}),
        ("collections/c", {}),
        ("collections/c", {"documents": [], "where": {}}),
        ("collections/c", {"documents": [], "view": {"sort": "name"}}),
        ("collections/c", {"where": {}, "view": {"sort": "name; drop"}}),
        ("collections/c", {"where": {}, "view": {"layout": "wall"}}),
        ("collections/c", {"where": {"length": "long"}}),
        ("colours", {"items": {"walk": "no colour"}}),
    ],
)
def test_what_makes_no_sense_is_refused(client: TestClient, path: str, wrong: dict[str, Any]) -> None:
    assert client.put(f"{API}/{path}", json=wrong).status_code == 422


def test_a_project_without_colours_has_none(client: TestClient) -> None:
    assert client.get(f"{API}/colours").json() == {
        "items": {}, "project": "default", "version": 0, "author": "", "changed": "",
    }  # fmt: skip
