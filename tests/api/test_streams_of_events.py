"""Streams of events do not outlive the rights with which they began."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from fastapi.testclient import TestClient

from mcml_service.api import events
from mcml_service.api.authentication import SHARED
from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.core.identifiers import now
from mcml_service.storage.database import Database
from mcml_service.storage.transaction import Transaction
from tests.builders import SECRET, bvh, one_kind, store

pytestmark = one_kind
API = "/api/v1"
HOME = "http://127.0.0.1:8000"


@pytest.fixture(autouse=True)
def quickly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(events, "NEWS_SECONDS", 0.001)
    monkeypatch.setattr(events, "RIGHTS_SECONDS", 0.0)


@pytest.fixture
def kim(database: Database) -> Iterator[TestClient]:
    """A browser of an account that is a reader of one project."""
    app = create_app(Settings(), database, lambda: SECRET)
    with database.write() as tx:
        tx.accounts.add("lee", "owner", "x")
        person = tx.accounts.add("kim", "member", "x")
    store(database, {"walk.bvh": bvh(5)}, project="gait")
    with database.write() as tx:
        tx.members.put(tx.projects.get("gait"), "kim", "reader")
        cookie = {"mcml_session": tx.sessions.open_for(person)}
    with TestClient(app, base_url=HOME, client=("10.0.0.7", 1), headers={"origin": HOME}, cookies=cookie) as client:
        yield client


def meanwhile(monkeypatch: pytest.MonkeyPatch, database: Database, change: Callable[[Transaction], Any]) -> list[int]:
    """Let something happen when a stream looks for news for the third time; a list that has an entry a look."""
    look, looks = events._look, [0]

    def looked(*arguments: Any) -> list[str]:
        looks.append(len(looks))
        if len(looks) == 4:
            with database.write() as tx:
                change(tx)
        return look(*arguments)

    monkeypatch.setattr(events, "_look", looked)
    return looks


CHANGES: dict[str, Callable[[Transaction], Any]] = {
    "a session": lambda tx: tx.sessions.end_all(tx.accounts.get("kim").key),
    "an account": lambda tx: tx.accounts.change("kim", closed=now()),
    "a membership": lambda tx: tx.members.remove(tx.projects.get("gait"), "kim"),
    "another role": lambda tx: tx.members.put(tx.projects.get("gait"), "kim", "editor"),
}


@pytest.mark.parametrize("ended", CHANGES)
def test_a_stream_ends_with_its_rights(
    database: Database, kim: TestClient, monkeypatch: pytest.MonkeyPatch, ended: str
) -> None:
    looks = meanwhile(monkeypatch, database, CHANGES[ended])
    answer = kim.get(f"{API}/events")
    assert answer.text.startswith("id: ")
    assert len(looks) == 4, "it went on until then, and no longer"


def test_a_stream_ends_with_its_token(database: Database, kim: TestClient, monkeypatch: pytest.MonkeyPatch) -> None:
    with database.write() as tx:
        token = tx.tokens.add("render", owner=tx.accounts.get("lee"))
    looks = meanwhile(monkeypatch, database, lambda tx: tx.tokens.remove("render"))
    kim.cookies.clear()
    kim.get(f"{API}/events", headers={"authorization": f"Bearer {token}"})
    assert len(looks) == 4


def test_an_open_store_that_closes_ends_streams(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    looks = meanwhile(monkeypatch, database, lambda tx: tx.tokens.add("render"))
    with TestClient(create_app(Settings(host="127.0.0.1"), database), base_url=HOME, client=("127.0.0.1", 1)) as local:
        assert local.get(f"{API}/events").status_code == 200
        assert len(looks) == 4
        assert local.get(f"{API}/events").status_code == 401


def test_a_stream_ends_in_time_and_goes_on_where_it_was(
    database: Database, kim: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(events, "STREAM_SECONDS", 0.0)
    first = kim.get(f"{API}/events").text
    store(database, {"run.bvh": bvh(5, seed=1)}, project="gait")
    last = first.partition("id: ")[2].partition("\n")[0]
    assert '"name":"run"' in kim.get(f"{API}/events", headers={"last-event-id": last}).text


def test_a_stream_of_a_job_ends_too(database: Database, kim: TestClient, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(events, "STREAM_SECONDS", 0.0)
    with database.write() as tx:
        job = tx.jobs.add(tx.projects.get("gait"), "beats", "beats", "kim", [], {}, runner="nobody")
    said = kim.get(f"{API}/jobs/{job}/events").text
    assert said.count("event: ") == said.count("event: progress") == 1


def test_links_to_documents_follow_nothing(database: Database, kim: TestClient) -> None:
    uuid = store(database, {"run.bvh": bvh(5, seed=1)}, project="gait")[0]
    with database.write() as tx:
        token = tx.tokens.add("render", owner=tx.accounts.get("lee"))
    bearer = {"authorization": f"Bearer {token}"}
    made = kim.post(f"{API}/shares", json={"name": "for them", "documents": [uuid]}, headers=bearer).json()
    assert kim.post(SHARED, json={"secret": made["path"].partition("#")[2]}).status_code == 201
    for path in ("/events?seconds=0", "/jobs/00000000-0000-4000-8000-000000000000/events"):
        assert kim.get(SHARED + path).status_code == 403, path
