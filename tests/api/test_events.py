"""Events of the store: revisions, labels and jobs as they come, and from where one left off."""

from __future__ import annotations

import json
from typing import Any

import pytest
from fastapi.testclient import TestClient

from mcml_service.actions.reading import read_news
from mcml_service.storage.database import Database
from tests.builders import bvh, store

API = "/api/v1"


def events(client: TestClient, last: str | None = None, **asked: object) -> list[dict[str, Any]]:
    headers = {} if last is None else {"last-event-id": last}
    answer = client.get(f"{API}/events", params={"seconds": 0, **asked}, headers=headers)  # type: ignore[arg-type]
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"].startswith("text/event-stream")
    found = []
    for text in answer.text.strip().split("\n\n"):
        lines = dict(line.split(": ", 1) for line in text.split("\n"))
        found.append({**json.loads(lines["data"]), "id": lines["id"], "event": lines["event"]})
    return found


def told(found: list[dict[str, Any]]) -> list[tuple[Any, ...]]:
    return [(one["event"], one.get("operation"), one.get("revision")) for one in found]


def test_what_happened_since_an_event(client: TestClient, database: Database) -> None:
    first = store(database, {"walk.bvh": bvh(5)})[0]
    (ready,) = events(client)
    assert ready["event"] == "ready", "nothing of before"
    label = [{"name": "walk", "first": 1, "last": 3}]
    client.post(f"{API}/documents/{first}/labels", json=label, headers={"if-match": "*"})
    second = store(database, {"run.bvh": bvh(5, seed=1)}, project="gait")[0]
    client.delete(f"{API}/documents/{second}", headers={"if-match": "*"})
    found = events(client, ready["id"])
    assert told(found) == [
        ("ready", None, None),
        ("label", "label", 2),
        ("document", "import", 1),
        ("document", "delete", 2),
    ]
    assert [one.get("document") for one in found[1:]] == [first, second, second]
    assert (found[2]["name"], found[2]["project"]) == ("run", "gait")
    assert told(events(client, found[-1]["id"])) == [("ready", None, None)], "nothing twice"
    assert told(events(client, since=ready["id"], kind="label"))[1:] == [("label", "label", 2)]
    assert len(events(client, ready["id"], project="gait")) == 3
    assert len(events(client, ready["id"], document=first)) == 2


def test_jobs_that_are_further(client: TestClient, database: Database) -> None:
    uuid = store(database, {"walk.bvh": bvh(5)})[0]
    (ready,) = events(client)
    with database.write() as tx:
        key = tx.projects.get("default")
        job = tx.jobs.add(key, "beats", "beats", "kim", [{"document": uuid, "revision": 1}], {}, runner="me")
    found = events(client, ready["id"])
    assert [(one["event"], one.get("state")) for one in found[1:]] == [("job", "running")]
    with database.write() as tx:
        tx.jobs.cancel(job)
        tx.jobs.tell(job, "me", "half", 0.5)
        assert not tx.jobs.is_wanted(job, "me")
    assert [one.get("stage") for one in events(client, found[-1]["id"])[1:]] == ["cancelling"]
    assert events(client, found[-1]["id"], kind="document")[1:] == []


def test_many_revisions_come_in_turn(client: TestClient, database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    (ready,) = events(client)
    store(database, {f"{n}.bvh": bvh(2, seed=n) for n in range(7)})
    monkeypatch.setattr(read_news, "AT_A_TIME", 2)
    seen: list[str] = []
    last = ready["id"]
    while more := events(client, last)[1:]:
        seen += [one["name"] for one in more]
        last = more[-1]["id"]
    assert sorted(seen) == [str(n) for n in range(7)]
    monkeypatch.setattr(read_news, "MOST_BEHIND", 0)
    assert [one["event"] for one in events(client, ready["id"])] == ["ready", "reset"]


def test_ids_of_others_are_refused(client: TestClient) -> None:
    assert client.get(f"{API}/events", params={"seconds": 0, "since": "seven"}).status_code == 422
    assert client.get(f"{API}/events", params={"seconds": -1}).status_code == 422
