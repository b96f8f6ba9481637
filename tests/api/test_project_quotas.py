"""Archived projects, in which nothing changes, and quotas, which nothing exceeds."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import func, select

from mcml_service.operations import all_operations
from mcml_service.operations.operation import Effect
from mcml_service.storage.core.schema import metadata
from mcml_service.storage.database import Database
from tests.api.asked import API, filled, request_of, send
from tests.builders import bvh, one_kind, served

ABOUT_PROJECT = {"change_project", "export_project", "invite", "set_member", "remove_member"}
"""Operations of the right to edit or more that change nothing in a project."""

SHORT = ("suggest_labels", "get_analog", "get_standing_trial", "get_matching_library")
"""What reads and cannot be done with clips as short as these."""


def terms(client: TestClient, **change: Any) -> Any:
    answer = client.patch(f"{API}/project", params={"project": "mine"}, json=change)
    assert answer.status_code == 200, answer.text
    return answer.json()


def counts(database: Database) -> dict[str, int]:
    kept = ("thumbnail", "request", "session", "body")
    with database.read() as tx:
        return {
            table.name: tx.connection.execute(select(func.count()).select_from(table)).scalar_one()
            for table in metadata.sorted_tables
            if table.name not in kept
        }


@pytest.mark.slow
@one_kind
def test_nothing_changes_in_an_archived_project(database: Database) -> None:
    """Every operation that edits, by who keeps the repository, is refused and changes nothing; what reads goes on."""
    with served(database) as client:
        things = filled(client, database, "mine", "wombat")
        since = terms(client, archived=True)["archived"]
        assert since is not None
        assert terms(client, archived=True)["archived"] == since
        before = counts(database)
        refused = 0
        for operation in all_operations():
            asked = request_of(operation, things, "wombat") if operation.address else None
            if asked is None or operation.name in ABOUT_PROJECT | {"get_result_picture", "add_share"}:
                continue
            answer = send(client, operation, asked)
            said = (operation.name, answer.status_code, answer.text[:300])
            if operation.effect in (Effect.READS, Effect.STREAMS):
                assert answer.status_code < 300 or operation.name in SHORT, said
            elif answer.status_code == 409:
                assert "archived" in answer.json()["detail"], said
                refused += 1
            else:
                # What this project cannot do at all, archived or not: an analysis of short clips, a model that is none.
                assert answer.status_code in (404, 422) or answer.status_code < 300, said
            assert counts(database) == before, said
        assert refused > 35
        terms(client, archived=False)
        uploaded = client.post(f"{API}/documents", files={"file": ("b.bvh", bvh(4, seed=8))}, data={"project": "mine"})
        assert uploaded.status_code == 201


@pytest.mark.slow
def test_a_project_holds_no_more_documents_than_it_may(database: Database) -> None:
    """Of uploads one after the other, of many files at once, at the same time, and of what comes from elsewhere."""
    with served(database) as client:

        def up(seeds: list[int], project: str = "mine") -> int:
            files = [("file", (f"{seed}.bvh", bvh(4, seed=seed))) for seed in seeds]
            return client.post(f"{API}/documents", files=files, data={"project": project}).status_code

        assert up([1]) == 201
        assert terms(client, most_documents=4)["documents"] == 1
        assert up([2, 3]) == 201
        with ThreadPoolExecutor(4) as threads:
            answers = sorted(threads.map(up, [[4], [5], [6], [7]]))
        assert answers == [201, 409, 409, 409]
        assert terms(client)["documents"] == 4
        listed = client.get(f"{API}/documents", params={"project": "mine"}).json()["items"]
        change = {"if-match": "*"}
        assert client.delete(f"{API}/documents/{listed[0]['id']}", headers=change).status_code == 204
        assert up([8, 9]) in (201, 207, 409)
        assert terms(client)["documents"] == 4
        restored = client.post(f"{API}/documents/{listed[0]['id']}/restore", headers=change)
        assert restored.status_code == 409
        assert "4 documents" in restored.json()["detail"]
        assert up([10], "other") == 201
        away = client.get(f"{API}/documents", params={"project": "other"}).json()["items"][0]["id"]
        moved = client.patch(f"{API}/documents/{away}", json={"project": "mine"}, headers=change)
        assert moved.status_code == 409
        terms(client, most_documents=0)
        assert client.patch(f"{API}/documents/{away}", json={"project": "mine"}, headers=change).status_code == 200
    assert database.check(past=True) == []


def test_a_project_holds_no_more_bytes_than_it_may(database: Database) -> None:
    size = len(bvh(30, seed=1))
    with served(database) as client:

        def up(seed: int) -> int:
            files = {"file": (f"{seed}.bvh", bvh(30, seed=seed))}
            return client.post(f"{API}/documents", files=files, data={"project": "mine"}).status_code

        assert up(1) == 201
        assert terms(client)["bytes"] == size
        terms(client, most_bytes=size + 100)
        assert up(2) == 409
        one = client.get(f"{API}/documents", params={"project": "mine"}).json()["items"][0]["id"]

        def media(length: int) -> int:
            files = {"file": ("b.mp4", b"\0\0\0\x18ftypmp42" + bytes(length - 12))}
            return client.put(f"{API}/documents/{one}/media", files=files, headers={"if-match": "*"}).status_code

        assert media(200) == 409
        assert media(90) == 200
        assert terms(client)["bytes"] == size + 90


@one_kind
def test_owners_of_a_project_archive_it_and_set_no_quota(database: Database) -> None:
    with served(database) as keeper:
        filled(keeper, database, "mine", "wombat")
        with database.write() as tx:
            tx.accounts.add("boss", "owner", "x")
            owner = tx.accounts.add("owner", "member", "x")
            tx.members.put(tx.projects.get("mine"), "owner", "owner")
            token = tx.tokens.add("owners", owner=owner)
        client = TestClient(keeper.app, client=("10.0.0.7", 1), headers={"authorization": f"Bearer {token}"})
        assert terms(client, archived=True)["archived"]
        refused = client.patch(f"{API}/project", params={"project": "mine"}, json={"most_documents": 0})
        assert refused.status_code == 403
        assert client.get(f"{API}/project", params={"project": "mine"}).json()["documents"] == 2
