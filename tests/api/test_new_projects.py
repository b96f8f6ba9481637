"""Projects before their first clip."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fastapi.testclient import TestClient
from typer.testing import CliRunner

from mcml_service.cli import app
from mcml_service.storage.database import Database
from tests.builders import bvh, one_kind, upload

API = "/api/v1"


def create(client: TestClient, name: str) -> Any:
    return client.put(f"{API}/project", params={"project": name})


def test_an_empty_project_is_listed_and_has_members_and_quotas(client: TestClient, database: Database) -> None:
    made = create(client, "gait")
    assert made.status_code == 201, made.text
    assert made.json() | {"archived": None} == made.json()
    assert (made.json()["name"], made.json()["documents"], made.json()["bytes"]) == ("gait", 0, 0)
    assert client.get(f"{API}/projects").json()["items"] == ["gait"]
    with database.write() as tx:
        tx.accounts.add("boss", "owner", "x")
        tx.accounts.add("kim", "member", "x")
        key = tx.tokens.add("of boss")
    client.headers["authorization"] = f"Bearer {key}"
    where = {"project": "gait"}
    member = client.put(f"{API}/members/kim", params=where, json={"role": "editor"})
    assert member.status_code == 200, member.text
    assert [(one["name"], one["role"]) for one in member.json()["items"]] == [("boss", "owner"), ("kim", "editor")]
    bounded = client.patch(f"{API}/project", params=where, json={"most_documents": 1})
    assert bounded.json()["most_documents"] == 1
    upload(client, {"a.bvh": bvh(3)}, project="gait")
    refused = client.post(f"{API}/documents", files={"file": ("b.bvh", bvh(4))}, data=where)
    assert refused.status_code == 409, "the quota holds for the first clips"


@one_kind
def test_a_project_is_created_once(client: TestClient) -> None:
    assert create(client, "gait").status_code == 201
    upload(client, {"a.bvh": bvh(3)}, project="gait")
    again = create(client, "gait")
    assert again.status_code == 200
    assert again.json()["documents"] == 1
    events = client.get(f"{API}/activity", params={"kind": "project"}).json()["items"]
    assert [(one["what"], one["subject"]) for one in events] == [("add", "gait")]
    client.patch(f"{API}/project", params={"project": "gait"}, json={"archived": True})
    assert create(client, "gait").status_code == 409


@one_kind
def test_names_that_are_no_names_are_refused(client: TestClient) -> None:
    for name in ("", " ", "a\nb", "x" * 257):
        answer = create(client, name)
        assert answer.status_code == 422, (name, answer.text)
    assert client.get(f"{API}/projects").json()["items"] == []


def test_the_command_creates_it(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'store.db'}"
    done = CliRunner().invoke(app, ["project", "create", "gait", "--database", url])
    assert done.exit_code == 0, done.output
    listed = CliRunner().invoke(app, ["projects", "--database", url])
    assert listed.output.split() == ["gait"]
