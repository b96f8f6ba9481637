"""All changes of a draft as one revision: made, tried, merged with what others did, refused with all conflicts."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml_service.storage.database import Database
from tests.builders import bvh, store

API = "/api/v1/documents"
LABEL = {"name": "walk", "first": 2, "last": 4}


@pytest.fixture
def uuid(database: Database) -> str:
    return store(database, {"walk.bvh": bvh(300)})[0]


def send(client: TestClient, uuid: str, at: object = "*", **changes: Any) -> Any:
    query = {name: changes.pop(name) for name in ("merge", "dry_run") if name in changes}
    match = at if at == "*" else f'"{at}"'
    return client.post(f"{API}/{uuid}/changes", json=changes, params=query, headers={"if-match": str(match)})


def values(client: TestClient, uuid: str, first: int, last: int, column: str, **more: object) -> list[float]:
    bone, channel = column.split(".")
    asked = {"first": first, "last": last, "bone": bone, **more}
    items = client.get(f"{API}/{uuid}/frames", params=asked).json()["items"]  # type: ignore[arg-type]
    return [item["values"][bone].get(channel) for item in items]


def labels(client: TestClient, uuid: str) -> list[tuple[str, int, int]]:
    items = client.get(f"{API}/{uuid}/labels").json()["items"]
    return [(item["name"], item["first"], item["last"]) for item in items]


def block(first: int, *rows: float | None, column: str = "Spine.Rx") -> dict[str, Any]:
    return {"first": first, "columns": [column], "values": [[row] for row in rows]}


def change(address: str, **attributes: str | None) -> dict[str, Any]:
    return {"do": "change", "xpath": address, "attributes": attributes}


BONE = "/mcml/motion/frame[9]/frame_bone[2]"


def test_all_of_a_draft_is_one_revision(client: TestClient, database: Database, uuid: str) -> None:
    middle = values(client, uuid, 256, 256, "Spine.Rx")
    made = send(
        client,
        uuid,
        1,
        frames=[block(255, 1.5, None, -2.25)],
        elements=[change(BONE, Ry="7.5"), {"do": "delete", "xpath": "/mcml/motion/frame[1]"}],
        labels=[LABEL, {"name": "turn", "first": 9, "last": 9}],
        document={"name": "other", "unit": "cm", "properties": [{"name": "age", "value": "23", "unit": "year"}]},
        message="all at once",
    )
    assert made.status_code == 200, made.text
    assert (made.json()["revision"], made.json()["frames"], made.headers["etag"]) == (2, 299, '"2-json"')
    detail = client.get(f"{API}/{uuid}").json()
    assert (detail["name"], detail["unit"], detail["properties"][0]["value"]) == ("other", "cm", "23")
    assert values(client, uuid, 254, 256, "Spine.Rx") == [1.5, *middle, -2.25], "frames moved up"
    assert values(client, uuid, 8, 8, "Spine.Ry") == [7.5]
    assert labels(client, uuid) == [("walk", 1, 3), ("turn", 8, 8)], "and names with them"
    (newest, _) = client.get(f"{API}/{uuid}/revisions").json()["items"]
    assert newest["message"] == "all at once"
    assert database.check() == []
    undone = client.post(f"{API}/{uuid}/undo", headers={"if-match": "*"})
    assert undone.status_code == 200, undone.text
    assert client.get(f"{API}/{uuid}/export?format=bvh&original=false").content == bvh(300)


def test_nothing_to_change_is_no_revision(client: TestClient, uuid: str) -> None:
    same = values(client, uuid, 5, 5, "Spine.Rx")
    assert send(client, uuid, frames=[block(5, *same)], labels=[], document={}).json()["revision"] == 1


def test_numbers_as_bytes(client: TestClient, uuid: str) -> None:
    rows = np.array([[1.0, 2.0], [np.nan, 4.0]])
    before = values(client, uuid, 11, 11, "Spine.Rx")
    data = base64.b64encode(rows.astype("<f8").tobytes()).decode()
    sent = {"first": 10, "columns": ["Spine.Rx", "Spine.Ry"], "data": data}
    assert send(client, uuid, frames=[sent]).status_code == 200
    assert values(client, uuid, 10, 11, "Spine.Rx") == [1.0, *before]
    assert values(client, uuid, 10, 11, "Spine.Ry") == [2.0, 4.0]


def test_nothing_stays_of_what_fails_in_the_middle(client: TestClient, database: Database, uuid: str) -> None:
    bad = send(client, uuid, frames=[block(5, 1.0)], labels=[LABEL], elements=[change(BONE, Rx="much")])
    assert bad.status_code == 422
    assert client.get(f"{API}/{uuid}").json()["revision"] == 1
    assert labels(client, uuid) == []
    assert send(client, uuid, 7, labels=[]).status_code == 412
    assert database.check() == []


@pytest.mark.parametrize(
    "wrong",
    [
        {"first": 1, "columns": ["Spine.Rx"]},
        {"first": 1, "columns": ["Spine.Rx"], "values": [[1, 2]]},
        {"first": 1, "columns": ["Spine.Rx"], "values": []},
        {"first": 1, "columns": ["Spine.Rx"], "data": "AAAA"},
        {"first": 300, "columns": ["Spine.Rx"], "values": [[1], [2]]},
        {"first": 1, "columns": ["Tail.Rx"], "values": [[1]]},
        {"first": 1, "columns": ["Spine.Tx"], "values": [[1]]},
    ],
)
def test_blocks_that_do_not_fit_are_refused(client: TestClient, uuid: str, wrong: dict[str, Any]) -> None:
    assert send(client, uuid, frames=[wrong]).status_code in (404, 422)
    if wrong.get("values"):
        faults = send(client, uuid, frames=[block(2, 1.0), wrong], dry_run=True).json()["faults"]
        assert [(fault["part"], fault["number"]) for fault in faults] == [("frames", 1)]


def test_a_dry_run_lists_every_fault_and_writes_nothing(client: TestClient, database: Database, uuid: str) -> None:
    found = send(
        client,
        uuid,
        dry_run=True,
        elements=[
            change(BONE, Ry="7.5"),
            {"do": "insert", "xpath": "/mcml/motion/frame[3]", "fragment": "<frame_bone\nname='Head'"},
            change("//bone[99]/name"),
            change(BONE, Rx="much"),
        ],
        labels=[{"name": "walk", "first": 1, "last": 301}],
    ).json()
    told = [(fault["part"], fault["number"], fault["line"], fault["address"]) for fault in found["faults"]]
    assert [one[:2] for one in told] == [("elements", 1), ("elements", 2), ("elements", 3), ("labels", None)]
    assert told[0][2] == 2
    assert told[2][3].startswith(BONE)
    assert all(fault["what"] for fault in found["faults"])
    good = send(client, uuid, dry_run=True, elements=[{"do": "delete", "xpath": "/mcml/motion/frame[3]"}]).json()
    assert (good["faults"], good["frames"], good["revision"]) == ([], 299, 1)
    assert client.get(f"{API}/{uuid}").json()["revision"] == 1
    assert database.check() == []


@pytest.mark.slow
def test_disjoint_changes_are_merged(client: TestClient, database: Database, uuid: str) -> None:
    """Frames went meanwhile, other values and names were set: what nobody touched is carried to where it is now."""
    send(
        client,
        uuid,
        1,
        elements=[{"do": "delete", "xpath": "/mcml/motion/frame[1]"}, change(BONE, Rz="1.5")],
        frames=[block(100, 5.0, 6.0)],
        labels=[LABEL],
        document={"unit": "cm"},
    )
    old = values(client, uuid, 50, 52, "Spine.Rx", revision=1)
    made = send(
        client,
        uuid,
        1,
        merge=True,
        elements=[change(BONE, Ry="7.5")],
        frames=[block(50, 1.25, *old[1:], 2.5)],
        labels=[{"name": "turn", "first": 30, "last": 40}],
        document={"up": "Y"},
    )
    assert made.status_code == 200, made.text
    assert (made.json()["merged"], made.json()["revision"]) == (True, 3)
    assert values(client, uuid, 49, 52, "Spine.Rx") == [1.25, *old[1:], 2.5]
    assert (values(client, uuid, 8, 8, "Spine.Ry"), values(client, uuid, 8, 8, "Spine.Rz")) == ([7.5], [1.5])
    assert values(client, uuid, 99, 100, "Spine.Rx") == [5.0, 6.0]
    assert labels(client, uuid) == [("walk", 1, 3), ("turn", 29, 39)]
    detail = client.get(f"{API}/{uuid}").json()
    assert (detail["unit"], detail["up"]) == ("cm", "Y")
    assert database.check() == []


def test_touching_changes_are_refused_with_all_conflicts(client: TestClient, uuid: str) -> None:
    base = values(client, uuid, 100, 102, "Spine.Rx")
    rx = values(client, uuid, 9, 9, "Spine.Rx")
    assert send(client, uuid, labels=[LABEL], document={"unit": "m"}).json()["revision"] == 2
    theirs = {"frames": [block(101, 5.0, 6.0)], "elements": [change(BONE, Rx="3.5")], "document": {"unit": "cm"}}
    assert send(client, uuid, 2, **theirs, labels=[{**LABEL, "last": 8}]).json()["revision"] == 3
    mine = {
        "frames": [block(100, 1.0, 2.0, 6.0)],
        "elements": [change(BONE, Rx="4.5"), change(BONE, Ry="4.5")],
        "document": {"unit": "mm", "up": "Z"},
        "labels": [{**LABEL, "last": 5}],
    }
    refused = send(client, uuid, 2, merge=True, **mine)
    assert refused.status_code == 409
    problem = refused.json()
    assert (problem["code"], problem["details"]["revision"]) == ("changed-meanwhile", 3)
    found = {one["kind"]: one for one in problem["details"]["conflicts"]}
    assert len(problem["details"]["conflicts"]) == len(found) == 4
    frames = found["frames"]
    assert (frames["address"], frames["first"], frames["last"]) == ("Spine.Rx", 101, 101), "the last is as both want it"
    assert (frames["base"], frames["theirs"], frames["mine"]) == (base[1:2], [5.0], [2.0])
    element = found["element"]
    assert (element["address"], element["theirs"], element["mine"]) == (f"{BONE}/@Rx", "3.5", "4.5")
    assert float(element["base"]) == rx[0]
    assert (found["fact"]["base"], found["fact"]["theirs"], found["fact"]["mine"]) == ("m", "cm", "mm")
    assert found["label"]["address"] == "walk"
    assert {"up", BONE} <= set(problem["details"]["mergeable"])
    assert client.get(f"{API}/{uuid}").json()["revision"] == 3, "nothing is written"
    tried = send(client, uuid, 2, merge=True, dry_run=True, **mine).json()
    assert (tried["conflicts"], tried["faults"]) == (problem["details"]["conflicts"], [])


def test_frames_that_are_gone_are_conflicts(client: TestClient, uuid: str) -> None:
    send(client, uuid, 1, elements=[{"do": "delete", "xpath": "/mcml/motion/frame[9]"}])
    refused = send(client, uuid, 1, merge=True, frames=[block(9, 1.0)], elements=[change(BONE, Rx="1")])
    assert [one["theirs"] for one in refused.json()["details"]["conflicts"]] == [None, None]
