"""Who is at a document now: two people, their windows, what others may know of it, and when it ends."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from fastapi.testclient import TestClient

from mcml_service.actions.keeping.purge_documents import purge_documents
from mcml_service.api.authentication import SHARED
from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.core.identifiers import now
from mcml_service.storage.database import Database
from mcml_service.storage.team.presence import LASTS
from mcml_service.storage.team.tables import presence
from tests.builders import SECRET, bvh, one_kind, store

API = "/api/v1"
HOME = "http://127.0.0.1:8000"


@pytest.fixture
def walk(database: Database) -> str:
    return store(database, {"walk.bvh": bvh(5)}, project="gait")[0]


@pytest.fixture
def people(database: Database, walk: str) -> Iterator[dict[str, TestClient]]:
    """Browsers of kim and lee, readers of the project; of sam, who has none; of who came by a token of nobody's."""
    app = create_app(Settings(), database, lambda: SECRET)
    with TestClient(app):
        clients = {}
        with database.write() as tx:
            tx.accounts.add("boss", "owner", "x")
        for name in ("kim", "lee", "sam", "tool"):
            with database.write() as tx:
                if name == "tool":
                    secret = tx.tokens.add(name)
                else:
                    secret = tx.tokens.add(f"of {name}", owner=tx.accounts.add(name, "member", "x"))
                if name in ("kim", "lee"):
                    tx.members.put(tx.projects.get("gait"), name, "reader")
            headers = {"authorization": f"Bearer {secret}"}
            clients[name] = TestClient(app, base_url=HOME, client=("10.0.0.7", 1), headers=headers)
        yield clients


def said(client: TestClient, document: str, **body: Any) -> list[tuple[str, str]]:
    answer = client.put(f"{API}/documents/{document}/presence", json=body)
    assert answer.status_code == 200, answer.text
    return [(one["name"], one["doing"]) for one in answer.json()["items"]]


def test_people_hear_of_each_other(people: dict[str, TestClient], walk: str) -> None:
    assert said(people["kim"], walk) == [], "not of themselves"
    assert said(people["lee"], walk, doing="editing", tab="one") == [("kim", "viewing")]
    assert said(people["lee"], walk, doing="viewing", tab="two") == [("kim", "viewing")]
    assert said(people["kim"], walk) == [("lee", "editing")], "in one of the windows"
    assert said(people["lee"], walk, doing="viewing", tab="one") == [("kim", "viewing")]
    assert said(people["kim"], walk) == [("lee", "viewing")]
    for tab in ("one", "two"):
        gone = people["lee"].delete(f"{API}/documents/{walk}/presence", params={"tab": tab})
        assert gone.status_code == 204
    assert said(people["kim"], walk) == []


@one_kind
def test_who_is_nobody_hears_and_is_not_told_of(people: dict[str, TestClient], walk: str) -> None:
    said(people["kim"], walk)
    assert said(people["tool"], walk, doing="editing") == [("kim", "viewing")]
    listed = people["tool"].get(f"{API}/documents/{walk}/presence").json()["items"]
    assert [one["name"] for one in listed] == ["kim"]
    assert listed[0]["since"] <= now()


@one_kind
def test_names_are_for_who_may_read_the_document(people: dict[str, TestClient], database: Database, walk: str) -> None:
    said(people["kim"], walk)
    path = f"/documents/{walk}/presence"
    assert people["sam"].get(API + path).status_code == 404
    assert people["sam"].put(API + path, json={}).status_code == 404
    made = people["tool"].post(f"{API}/shares", json={"name": "for them", "documents": [walk]}).json()
    guest = TestClient(people["sam"].app, base_url=HOME, client=("10.0.0.9", 1), headers={"origin": HOME})
    assert guest.post(SHARED, json={"secret": made["path"].partition("#")[2]}).status_code == 201
    assert guest.get(SHARED + path).status_code == 403
    assert guest.put(SHARED + path, json={}).status_code == 403
    with database.write() as tx:
        tx.accounts.change("kim", closed=now())
    assert said(people["lee"], walk) == []


def test_somebody_of_whom_nothing_is_heard_is_gone(
    people: dict[str, TestClient], database: Database, walk: str
) -> None:
    with database.write() as tx:
        stored = tx.documents.get(walk)
        tx.presence.keep(stored, "kim", "one", "viewing", at=1000.0)
        (first,) = tx.presence.of(stored, at=1000.0 + LASTS - 1)
        tx.presence.keep(stored, "kim", "one", "viewing", at=1000.0 + LASTS - 1)
        assert tx.presence.of(stored, at=1000.0 + LASTS) == [first], "since when it began"
        assert tx.presence.of(stored, at=1000.0 + 2 * LASTS) == []
        tx.presence.keep(stored, "lee", "", "editing", at=1000.0 + 2 * LASTS)
        assert [one.name for one in tx.presence.of(stored, at=0.0)] == ["lee"], "what is over is not kept"


@one_kind
def test_a_store_without_accounts_keeps_nothing(client: TestClient, database: Database) -> None:
    uuid = store(database, {"walk.bvh": bvh(5)})[0]
    assert said(client, uuid, doing="editing") == []
    assert client.get(f"{API}/documents/{uuid}/presence").json() == {"items": []}


@one_kind
def test_what_is_no_presence_is_refused(client: TestClient, database: Database) -> None:
    uuid = store(database, {"walk.bvh": bvh(5)})[0]
    for body in ({"doing": "sleeping"}, {"tab": "a b"}, {"tab": "x" * 37}):
        assert client.put(f"{API}/documents/{uuid}/presence", json=body).status_code == 422


def test_a_document_that_is_purged_takes_it_along(people: dict[str, TestClient], database: Database, walk: str) -> None:
    said(people["kim"], walk)
    purge_documents(database, [walk])
    with database.read() as tx:
        assert tx.connection.execute(presence.select()).all() == []
    assert people["kim"].put(f"{API}/documents/{walk}/presence", json={}).status_code == 404
