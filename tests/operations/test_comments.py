"""Comments: of whom they are, what they are about, and that they go with their document."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import text

from mcml_service.actions.keeping.keep_store import backup, restore
from mcml_service.actions.keeping.purge_documents import purge_documents
from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import SECRET, bvh, one_kind, store

API = "/api/v1"


@pytest.fixture
def uuid(database: Database) -> str:
    return store(database, {"walk.bvh": bvh(20)}, project="gait")[0]


@pytest.fixture
def people(database: Database, uuid: str) -> Iterator[dict[str, TestClient]]:
    """A client of each role in the project, and of another reader."""
    app = create_app(Settings(import_processes=1), database, lambda: SECRET)
    with database.write() as tx:
        tx.accounts.add("keeper", "owner", "x")
        secrets = {}
        for name, role in (("rea", "reader"), ("reader two", "reader"), ("ed", "editor"), ("own", "owner")):
            somebody = tx.accounts.add(name, "member", "x")
            tx.members.put(tx.projects.get("gait"), name, role)
            secrets[name] = tx.tokens.add(f"of {name}", owner=somebody)
    with TestClient(app, client=("10.0.0.7", 1)):
        yield {
            name: TestClient(app, client=("10.0.0.7", 1), headers={"authorization": f"Bearer {secret}"})
            for name, secret in secrets.items()
        }


def add(client: TestClient, uuid: str, words: str = "look", **place: Any) -> dict[str, Any]:
    answer = client.post(f"{API}/documents/{uuid}/comments", json={"text": words, **place})
    assert answer.status_code == 201, answer.text
    made: dict[str, Any] = answer.json()
    return made


def listed(client: TestClient, uuid: str, **asked: Any) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = client.get(f"{API}/documents/{uuid}/comments", params=asked).json()["items"]
    return found


def test_what_is_said_is_found_again(client: TestClient, database: Database, uuid: str) -> None:
    whole = add(client, uuid, "걸음\n\tis <b>good</b>")
    part = add(client, uuid, first=3, last=9, bone="Head")
    frame = add(client, uuid, first=20)
    assert (part["first"], part["last"], part["bone"], part["revision"]) == (3, 9, "Head", 1)
    assert (frame["first"], frame["last"]) == (20, 20)
    assert listed(client, uuid) == [whole, part, frame]
    first: Any = client.get(f"{API}/documents/{uuid}/comments", params={"limit": 2}).json()
    assert first["items"] == [whole, part]
    assert listed(client, uuid, limit=2, cursor=first["next_cursor"]) == [frame]
    path = f"{API}/documents/{uuid}/comments/{part['id']}"
    changed = client.patch(path, json={"text": "better"}).json()
    assert (changed["text"], changed["edited"] is None) == ("better", False)
    assert client.put(f"{path}/resolved").json()["resolved"] is not None
    assert client.delete(f"{path}/resolved").json()["resolved"] is None
    assert client.delete(path).status_code == 204
    assert listed(client, uuid) == [whole, frame]
    for answer in (client.patch(path, json={"text": "x"}), client.delete(path), client.put(f"{path}/resolved")):
        assert answer.status_code == 404
    with database.read() as tx:
        kept = tx.connection.execute(text("SELECT text FROM comment ORDER BY id")).scalars().all()
    assert kept == [whole["text"], "", frame["text"]], "what is deleted is not kept"
    assert database.check() == []


@pytest.mark.parametrize(
    ("said", "status"),
    [
        ({"text": ""}, 422),
        ({"text": "x" * 4001}, 422),
        ({"text": "a\0b"}, 422),
        ({"text": "a", "last": 3}, 422),
        ({"text": "a", "first": 4, "last": 3}, 422),
        ({"text": "a", "first": 1, "last": 21}, 404),
        ({"text": "a", "bone": "Tail"}, 404),
        ({"text": "a", "revision": 2}, 404),
    ],
)
def test_what_cannot_be_said(client: TestClient, uuid: str, said: dict[str, Any], status: int) -> None:
    assert client.post(f"{API}/documents/{uuid}/comments", json=said).status_code == status
    assert listed(client, uuid) == []


def test_a_comment_keeps_to_the_revision_that_was_looked_at(client: TestClient, uuid: str) -> None:
    edits = {"edits": [{"do": "keep", "first": 1, "last": 5}]}
    assert client.post(f"{API}/documents/{uuid}/frames", json=edits, headers={"if-match": "*"}).status_code == 200
    assert add(client, uuid, first=15, revision=1)["revision"] == 1
    assert client.post(f"{API}/documents/{uuid}/comments", json={"text": "a", "first": 15}).status_code == 404
    assert add(client, uuid, first=5)["revision"] == 2


@one_kind
def test_who_may_do_what_with_whose_comments(people: dict[str, TestClient], uuid: str) -> None:
    """Said a second time: change its author; resolve its author and editors; delete its author and owners."""
    for name, client in people.items():
        for author, other in people.items():
            comment = add(other, uuid)["id"]
            path = f"{API}/documents/{uuid}/comments/{comment}"
            mine = name == author
            answers = (
                (client.patch(path, json={"text": "y"}), mine),
                (client.put(f"{path}/resolved"), mine or name in ("ed", "own")),
                (client.delete(f"{path}/resolved"), mine or name in ("ed", "own")),
                (client.delete(path), mine or name == "own"),
            )
            for answer, may in answers:
                assert (answer.status_code < 300) == may, (name, author, answer.text)
                assert may or answer.status_code == 403
    other = people["own"].post(
        f"{API}/documents", files={"file": ("b.bvh", io.BytesIO(bvh(3, seed=4)))}, data={"project": "gait"}
    )
    assert other.status_code == 201, other.text
    comment = add(people["rea"], uuid)["id"]
    elsewhere = f"{API}/documents/{other.json()['documents'][0]['id']}/comments/{comment}"
    assert people["rea"].delete(elsewhere).status_code == 404, "a comment is of its document"


@one_kind
def test_mentions_are_of_people_of_the_project(people: dict[str, TestClient], uuid: str, database: Database) -> None:
    with database.write() as tx:
        tx.accounts.add("far", "member", "x")
    said = "@ed, @reader two and @rea; not @far, mail@own or @eduard (@keeper)"
    assert add(people["ed"], uuid, said)["mentions"] == ["ed", "keeper", "rea", "reader two"]


def test_a_purge_takes_comments_along_and_a_backup_has_them(
    client: TestClient, database: Database, uuid: str, tmp_path: Any
) -> None:
    made = add(client, uuid, first=2)
    backup(database, tmp_path / "copy.db")
    other = Database(f"sqlite:///{tmp_path / 'other.db'}")
    other.migrate()
    restore(other, tmp_path / "copy.db")
    with other.write("kim") as tx:
        stored = tx.documents.get(uuid)
        assert [one.number for one in tx.comments.of(stored, 0, 9)] == [made["id"]]
        assert tx.comments.add(stored, 1, "next", None, None, None).number > made["id"]
    other.close()
    purge_documents(database, [uuid])
    with database.read() as tx:
        assert tx.connection.execute(text("SELECT COUNT(*) FROM comment")).scalar_one() == 0


def test_a_damaged_comment_is_told(client: TestClient, database: Database, uuid: str) -> None:
    add(client, uuid)
    with database.write() as tx:
        tx.connection.execute(text("UPDATE comment SET author = 'kim'"))
    assert any("comment" in fault for fault in database.check())
    assert client.get(f"{API}/documents/{uuid}/comments").status_code == 500
