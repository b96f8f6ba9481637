"""Events of what was done: each in the transaction that did it, seen by who sees what it was done to."""

from __future__ import annotations

import io
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import select, text, update

from mcml.errors import ConflictError
from mcml_service.actions.keeping.keep_room import forget_activity
from mcml_service.actions.keeping.purge_documents import purge_documents
from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.core.tables import document, revision
from mcml_service.storage.database import Database
from mcml_service.storage.projects.activity import EventFilter, event
from tests.builders import SECRET, bvh, one_kind, store

API = "/api/v1"
ANY = {"if-match": "*"}


def activity(client: TestClient, **asked: Any) -> list[dict[str, Any]]:
    answer = client.get(f"{API}/activity", params={"limit": 1000, **asked})
    assert answer.status_code == 200, answer.text
    found: list[dict[str, Any]] = answer.json()["items"]
    return found


def told(found: list[dict[str, Any]]) -> list[tuple[str, str, str]]:
    return [(one["kind"], one["what"], one["subject"]) for one in found]


@pytest.fixture
def people(database: Database) -> Iterator[dict[str, TestClient]]:
    """Who keeps the repository, and who is what in the project `mine`; `theirs` has nobody."""
    app = create_app(Settings(import_processes=1), database, lambda: SECRET)
    store(database, {"a.bvh": bvh(5)}, project="mine")
    store(database, {"b.bvh": bvh(5, seed=1)}, project="theirs")
    with database.write("setup") as tx:
        roles = {"keeper": "owner", "watcher": "reader", "rea": "reader", "ed": "editor", "own": "owner"}
        secrets = {}
        for name, role in roles.items():
            everywhere = role if name in ("keeper", "watcher") else "member"
            somebody = tx.accounts.add(name, everywhere, "x")
            if everywhere == "member":
                tx.members.put(tx.projects.get("mine"), name, role)
            secrets[name] = tx.tokens.add(f"of {name}", owner=somebody)
    with TestClient(app, client=("10.0.0.7", 1)):
        yield {
            name: TestClient(app, client=("10.0.0.7", 1), headers={"authorization": f"Bearer {secret}"})
            for name, secret in secrets.items()
        }


def test_every_revision_has_its_event_whatever_made_it(client: TestClient, database: Database) -> None:
    """However it was imported: one by one, many together, or by the API."""
    first, second = store(database, {f"{number}.bvh": bvh(5, seed=number) for number in range(2)})
    files = [("file", (f"many {number}.bvh", io.BytesIO(bvh(4, seed=9 + number)))) for number in range(12)]
    assert client.post(f"{API}/documents", files=files).status_code == 201
    client.patch(f"{API}/documents/{first}", json={"name": "other"}, headers=ANY)
    client.post(f"{API}/documents/{first}/labels", json=[{"name": "walk", "first": 1, "last": 2}], headers=ANY)
    client.delete(f"{API}/documents/{second}", headers=ANY)
    client.post(f"{API}/documents/{second}/restore", headers=ANY)
    with database.read() as tx:
        made = select(document.c.uuid, revision.c.number, revision.c.operation).join(document)
        revisions = {tuple(row) for row in tx.connection.execute(made)}
    found = activity(client, kind="document")
    assert {(one["document"], one["revision"], one["what"]) for one in found} == revisions
    assert len(found) == len(revisions) == 18
    assert [one["id"] for one in found] == sorted((one["id"] for one in found), reverse=True)
    origins = [one["origin"] for one in reversed(found)]
    assert origins == ["command line"] * 2 + ["127.0.0.1"] * 16
    pages: Any = client.get(f"{API}/activity", params={"limit": 5}).json()
    rest = activity(client, cursor=pages["next_cursor"])
    assert pages["items"] + rest == activity(client)


def test_what_fails_leaves_no_event(client: TestClient, database: Database) -> None:
    uuid = store(database, {"a.bvh": bvh(5)})[0]
    before = activity(client)
    assert client.post(f"{API}/documents", files={"file": ("b.bvh", io.BytesIO(bvh(5)[:300]))}).status_code == 422
    assert client.patch(f"{API}/documents/{uuid}", json={"name": ""}, headers=ANY).status_code == 422

    def without_an_owner() -> None:
        with database.write() as tx:
            tx.documents.add_revision(tx.documents.get(uuid), "edit")
            tx.accounts.change(tx.accounts.add("kim", "owner", "x").name, role="reader")

    with pytest.raises(ConflictError):
        without_an_owner()
    assert activity(client) == before


def test_filters(client: TestClient, database: Database) -> None:
    one = store(database, {"a.bvh": bvh(5)}, project="gait")[0]
    two = store(database, {"b.bvh": bvh(5, seed=1)}, project="dance")[0]
    client.post(f"{API}/documents/{one}/comments", json={"text": "look"})
    with database.write("kim") as tx:
        tx.connection.execute(update(event).where(event.c.about == two).values(time="2020-01-31T10:00:00.000Z"))
        tx.comments.add(tx.documents.get(two), 1, "oh", None, None, None)
    assert {item["document"] for item in activity(client, project="gait")} == {one}
    assert [item["document"] for item in activity(client, document=two, kind="document")] == [two]
    assert told(activity(client, author="kim")) == [("comment", "add", "2")]
    assert len(activity(client, kind="comment")) == 2
    assert told(activity(client, document=two, since="2020-02-01")) == [("comment", "add", "2")]
    assert len(activity(client, document=two, since="2020-01-31T10:00:00.000Z")) == 2
    assert activity(client, project="none") == []
    assert client.get(f"{API}/activity", params={"since": "yesterday"}).status_code == 422


@one_kind
def test_who_sees_which_events(people: dict[str, TestClient], database: Database) -> None:
    keeper, own = people["keeper"], people["own"]
    mine = activity(keeper, project="mine", kind="document")[0]["document"]
    shared = own.post(f"{API}/shares", json={"name": "for the client", "documents": [mine]})
    assert shared.status_code == 201
    own.post(f"{API}/documents/{mine}/comments", json={"text": "look"})
    own.put(f"{API}/members/rea", params={"project": "mine"}, json={"role": "editor"})
    own.put(f"{API}/members/rea", params={"project": "mine"}, json={"role": "reader"})
    keeper.patch(f"{API}/accounts/watcher", json={"closed": True})
    keeper.patch(f"{API}/accounts/watcher", json={"closed": False})
    everything = activity(keeper)
    assert {"account", "token", "share", "member", "document", "comment"} == {one["kind"] for one in everything}
    assert ("member", "set", "rea as editor") in told(everything)
    assert ("account", "close", "watcher") in told(everything)
    of_mine = [one for one in everything if one["project"] == "mine"]
    for name, client in people.items():
        found = activity(client)
        if name == "watcher":
            assert {one["project"] for one in found} == {"mine", "theirs"}
        elif name != "keeper":
            wanted = of_mine if name != "rea" else [one for one in of_mine if one["kind"] != "share"]
            assert [one["id"] for one in found] == [one["id"] for one in wanted], name
            assert {one["kind"] for one in found} <= {"document", "comment", "member", "share"}
        decides = name in ("keeper", "own")
        assert all((one["origin"] is not None) == decides for one in found), name
    assert "10.0.0.7" in {one["origin"] for one in everything}


@one_kind
def test_what_was_done_to_a_document_moves_with_it(people: dict[str, TestClient], database: Database) -> None:
    keeper, rea = people["keeper"], people["rea"]
    one = next(item["document"] for item in activity(keeper, project="mine", kind="document"))
    assert [item["document"] for item in activity(rea, kind="document")] == [one]
    moved = keeper.patch(f"{API}/documents/{one}", json={"project": "theirs"}, headers=ANY)
    assert moved.status_code == 200
    assert activity(rea, kind="document") == []
    assert len(activity(keeper, project="theirs", document=one)) == 2


def test_a_purge_leaves_no_name(client: TestClient, database: Database) -> None:
    uuid = store(database, {"secret walk.bvh": bvh(5)})[0]
    client.post(f"{API}/documents/{uuid}/comments", json={"text": "quokka"})
    purge_documents(database, [uuid], "kim")
    found = activity(client, document=uuid)
    assert [(one["what"], one["author"], one["name"]) for one in found] == [
        ("purge", "kim", None),
        ("add", "local", None),
        ("import", "local", None),
    ]
    with database.read() as tx:
        rows = str(tx.connection.execute(select(event)).all())
    assert "secret" not in rows
    assert "quokka" not in rows


def test_what_is_too_old_is_forgotten_and_no_number_comes_again(client: TestClient, database: Database) -> None:
    store(database, {f"{number}.bvh": bvh(4, seed=number) for number in range(4)})
    with database.write() as tx:
        newest = tx.activity.newest()
        old = event.c.id <= newest - 1
        tx.connection.execute(update(event).where(old).values(time="2020-01-31T10:00:00.000Z"))
    assert forget_activity(database, 30) == 3
    with database.write() as tx:
        tx.connection.execute(text("UPDATE event SET time = '2020-01-31T10:00:00.000Z'"))
    assert forget_activity(database, 30) == 0, "the last one stays"
    store(database, {"more.bvh": bvh(4, seed=7)})
    assert [one["id"] for one in activity(client)] == [newest + 1, newest]


def test_jobs_tell_who_asked_for_them(database: Database) -> None:
    with database.write("kim") as tx:
        project = tx.projects.get_or_add("gait")
        ended = tx.jobs.add(project, "beats", "one", "kim", [], {}, runner="me")
        waits = tx.jobs.add(project, "beats", "two", "kim", [], {})
    with database.write("jobs") as tx:
        tx.jobs.end(ended, "me", "failed")
    with database.write("sam") as tx:
        tx.jobs.cancel(waits)
        tx.jobs.cancel(waits)
    with database.read() as tx:
        events = tx.activity.page(EventFilter(kind="job"), None, 9)
    found = [(one.what, one.subject, one.author) for one in events]
    assert found == [
        ("cancelled", "two", "sam"),
        ("failed", "one", "kim"),
        ("add", "two", "kim"),
        ("add", "one", "kim"),
    ]


def test_numbers_follow_visibility(database: Database) -> None:
    """Who has seen an event has missed none before it, though many write at once."""

    def write(number: int) -> None:
        for turn in range(5):
            store(database, {f"{number} {turn}.bvh": bvh(4, seed=10 * number + turn)})

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(write, range(4)))
    with database.read() as tx:
        commits = select(event.c.id, revision.c.commit).join(document, document.c.uuid == event.c.about)
        found = tx.connection.execute(commits.join(revision).order_by(event.c.id)).all()
    assert len(found) == 20
    assert [commit for _, commit in found] == sorted(commit for _, commit in found)
