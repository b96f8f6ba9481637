"""Proposals for a revision that is not the current one any more."""

from __future__ import annotations

import pytest
from fastapi.testclient import TestClient

from mcml_service.storage.database import Database
from tests.builders import bvh, one_kind, store
from tests.operations.proposing import API, FRAMES, NAMED, do, propose


@pytest.fixture
def uuid(database: Database) -> str:
    return store(database, {"walk.bvh": bvh(FRAMES)}, project="gait")[0]


def test_a_document_that_has_changed_asks_for_a_rebase(client: TestClient, uuid: str) -> None:
    path, match = f"{API}/documents/{uuid}", {"if-match": "*"}
    propose(client, uuid)
    propose(client, uuid, NAMED)
    value = {"frames": [{"first": 8, "columns": ["Root.Rx", "Root.Ry"], "values": [[5.5, None], [6.5, None]]}]}
    propose(client, uuid, {"changes": value})
    do(client, uuid, 1, "approve")
    edit = {"frames": [{"first": 9, "columns": ["Root.Rz"], "values": [[77]]}], "labels": [
        {"name": "turn", "first": 1, "last": 2}]}  # fmt: skip
    assert client.post(f"{path}/changes", json=edit, headers=match).status_code == 200
    listed = client.get(f"{path}/proposals").json()["items"]
    assert [item["outdated"] for item in listed] == [True] * 3
    preview = client.get(f"{path}/proposals/1/preview").json()
    assert preview["notes"][0].startswith("made for revision 1")
    for number in (1, 2, 3):
        refused = do(client, uuid, number, "apply")
        assert (refused.status_code, refused.json()["code"]) == (409, "changed-meanwhile")
    assert do(client, uuid, 1, "approve", revision=2).status_code == 409
    rebased = do(client, uuid, 1, "rebase").json()
    assert (rebased["state"], rebased["revision"], rebased["reviewer"]) == ("open", 2, None)
    assert do(client, uuid, 1, "approve", revision=1).status_code == 409
    assert do(client, uuid, 1, "apply").json()["applied"] == 3
    assert do(client, uuid, 3, "rebase").status_code == 409, "frame 8 was smoothed meanwhile"
    assert do(client, uuid, 2, "rebase").status_code == 200
    assert do(client, uuid, 2, "apply").json()["applied"] == 4
    labels = client.get(f"{path}/labels").json()["items"]
    assert [item["name"] for item in labels] == ["turn", "hop"], "labels by others stay"


@one_kind
def test_values_by_others_stay_after_a_rebase(client: TestClient, uuid: str) -> None:
    path, match = f"{API}/documents/{uuid}", {"if-match": "*"}
    frame = client.get(f"{path}/frames", params={"first": 8, "last": 9}).json()["items"]
    was = [row["values"]["Root"]["Rx"] for row in frame]
    request = {"frames": [{"first": 8, "columns": ["Root.Rx"], "values": [[41.5], [was[1]]]}]}
    propose(client, uuid, {"changes": request})
    others = {"frames": [{"first": 9, "columns": ["Root.Rx"], "values": [[33.5]]}]}
    client.post(f"{path}/changes", json=others, headers=match)
    assert do(client, uuid, 1, "rebase").status_code == 200
    do(client, uuid, 1, "apply")
    frame = client.get(f"{path}/frames", params={"first": 8, "last": 9}).json()["items"]
    assert [row["values"]["Root"]["Rx"] for row in frame] == [41.5, 33.5]


@one_kind
def test_positions_that_mean_other_frames_are_refused(client: TestClient, uuid: str) -> None:
    path, match = f"{API}/documents/{uuid}", {"if-match": "*"}
    propose(client, uuid)
    client.post(f"{path}/frames", json={"edits": [{"do": "delete", "first": 1, "last": 2}]}, headers=match)
    refused = do(client, uuid, 1, "rebase")
    assert (refused.status_code, refused.json()["code"]) == (409, "changed-meanwhile")
    assert "positions mean other frames" in refused.json()["detail"]


@one_kind
def test_frames_of_another_document_are_those_that_were_reviewed(
    client: TestClient, database: Database, uuid: str
) -> None:
    source = store(database, {"b.bvh": bvh(FRAMES, seed=4)}, project="gait")[0]
    insert = {"edits": {"edits": [{"do": "insert", "first": 1, "last": 3, "at": 5, "document": source}]}}
    propose(client, uuid, insert)
    cut = {"edits": [{"do": "delete", "first": 1, "last": 1}]}
    client.post(f"{API}/documents/{source}/frames", json=cut, headers={"if-match": "*"})
    assert do(client, uuid, 1, "apply").json()["code"] == "changed-meanwhile"
    assert do(client, uuid, 1, "rebase").status_code == 200
    assert do(client, uuid, 1, "apply").status_code == 200
