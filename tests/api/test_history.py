"""A revision is the document as it was: its content, its name, its project."""

from __future__ import annotations

import pytest
from fastapi.testclient import TestClient

from mcml_service.storage.database import Database
from tests.builders import ASF, amc, bvh, upload

API = "/api/v1"
ANY = {"if-match": "*"}


@pytest.fixture
def address(client: TestClient) -> str:
    """A document with three revisions: walk in gait, run in gait, run in lab."""
    done = upload(client, {"walk.bvh": bvh(4)}, project="gait", label="walk")
    address = f"{API}/documents/{done['documents'][0]['id']}"  # type: ignore[index]
    for change in ({"name": "run"}, {"project": "lab"}):
        client.patch(address, json=change, headers=ANY).raise_for_status()
    return address


HISTORY = [("walk", "gait"), ("run", "gait"), ("run", "lab")]


def test_a_revision_is_read_under_its_own_name(client: TestClient, address: str) -> None:
    for number, expected in enumerate(HISTORY, 1):
        then = client.get(address, params={"revision": number}).json()
        assert (then["name"], then["project"], then["revision"]) == (*expected, number)
        file = client.get(f"{address}/export", params={"format": "htr", "revision": number})
        assert f"{expected[0]}.htr" in file.headers["content-disposition"]
    now = client.get(address).json()
    assert (now["name"], now["project"]) == HISTORY[-1]


def test_the_history_says_names_and_projects(client: TestClient, address: str) -> None:
    items = client.get(f"{address}/revisions").json()["items"]
    assert [(item["name"], item["project"]) for item in reversed(items)] == HISTORY


@pytest.mark.parametrize("number", [1, 2, 3])
def test_restoring_brings_name_and_project_back(
    client: TestClient, database: Database, address: str, number: int
) -> None:
    then = client.get(address, params={"revision": number}).json()
    text = client.get(f"{address}/mcml", params={"revision": number}).content
    restored = client.post(f"{address}/restore", params={"revision": number}, headers=ANY).json()
    changed = {"revision", "modified", "labels"}
    assert {key: restored[key] for key in restored.keys() - changed} == {
        key: then[key] for key in then.keys() - changed
    }
    assert client.get(f"{address}/mcml").content == text
    name, project = HISTORY[number - 1]
    listed = client.get(f"{API}/documents", params={"project": project, "q": name}).json()
    assert [item["id"] for item in listed["items"]] == [restored["id"]]
    skeletons = client.get(f"{API}/skeletons", params={"project": project}).json()["items"]
    assert [(item["id"], item["documents"]) for item in skeletons] == [(restored["skeleton"], 1)]
    last = client.get(f"{address}/revisions").json()["items"][0]
    assert (last["number"], last["name"], last["project"]) == (4, name, project)
    assert database.check() == []


def test_a_deleted_document_comes_back_as_an_earlier_revision(client: TestClient, address: str) -> None:
    client.delete(address, headers=ANY).raise_for_status()
    restored = client.post(f"{address}/restore", params={"revision": 1}, headers=ANY).json()
    assert (restored["name"], restored["project"], restored["revision"]) == (*HISTORY[0], 5)


def test_a_document_edited_in_its_new_project_goes_back_with_the_old_skeleton(
    client: TestClient, database: Database
) -> None:
    done = upload(client, {"leg.asf": ASF, "leg.amc": amc(3)}, project="gait")
    address = f"{API}/documents/{done['documents'][0]['id']}"  # type: ignore[index]
    before = client.get(f"{address}/mcml").content
    client.patch(address, json={"project": "lab"}, headers=ANY).raise_for_status()
    where = {"xpath": "/mcml/skeleton/bone/bone/length"}
    client.patch(f"{address}/elements", params=where, json={"text": "9"}, headers=ANY).raise_for_status()
    client.post(f"{address}/restore", params={"revision": 1}, headers=ANY).raise_for_status()
    assert client.get(f"{address}/mcml").content == before
    # It lives in its old project: an edit makes a skeleton there.
    client.patch(f"{address}/elements", params=where, json={"text": "8"}, headers=ANY).raise_for_status()
    assert b"<length>8</length>" in client.get(f"{address}/mcml").content
    assert client.get(address).json()["project"] == "gait"
    assert database.check() == []


QUESTIONS = [
    "//frame[2]/frame_bone[@Rx > 0]/@Rx",
    "count(//frame)",
    "string(/mcml/header/filename)",
    "//frame[motion_name='walk']",
    "for $f in //frame return string-length($f/@id)",
    "sum(//@*[. > 3])",
]


@pytest.mark.slow
def test_any_revision_is_asked(client: TestClient, address: str) -> None:
    uuid = address.rpartition("/")[2]
    edits = [
        ("PATCH", "//frame[2]/frame_bone[1]", {"attributes": {"Rx": "33"}}),
        ("DELETE", "//frame[1]", None),
        ("DELETE", "//frame[1]/motion_name", None),
    ]

    def asked(as_: str, **more: object) -> list[str]:
        found = []
        for q in QUESTIONS:
            asking = {"q": q, "document": uuid, "as": as_, **more}
            answer = client.get(f"{API}/xpath", params=asking, headers={"x-request-id": "any"})
            found.append(answer.text)
        return found

    then = {}
    for number, (method, xpath, body) in enumerate(edits, 3):
        then[number] = asked("json"), asked("xml")
        client.request(method, f"{address}/elements", params={"xpath": xpath}, json=body, headers=ANY)
    assert len({str(answers) for answers in then.values()}) == len(edits)
    for number, (pages, streams) in then.items():
        assert asked("json", revision=number) == pages
        assert asked("xml", revision=number) == streams
    old = {"xpath": "//frame[2]/frame_bone[1]/@Rx", "revision": 3}
    assert client.get(f"{address}/elements", params=old).text != "33.0"
    several = client.get(f"{API}/xpath", params={"q": "//frame", "revision": 3})
    assert several.status_code == 422
    assert client.get(f"{API}/xpath", params={"q": "//frame", "document": uuid, "revision": 99}).status_code == 404


def test_an_edit_means_the_revision_it_was_made_for(client: TestClient, address: str) -> None:
    """Merged, an expression says what it said there, though frames came and went since."""
    client.delete(f"{address}/elements", params={"xpath": "//frame[1]"}, headers=ANY).raise_for_status()
    asked = {"xpath": "//frame[position() = 3]/frame_bone[1]", "merge": True}
    body = {"attributes": {"Rx": "77"}}
    done = client.patch(f"{address}/elements", json=body, params=asked, headers={"if-match": '"3"'})
    assert done.json()["address"] == "/mcml/motion/frame[2]/frame_bone[1]", done.text
