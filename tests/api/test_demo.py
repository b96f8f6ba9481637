"""The demo library: stored once, part by part, by editors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient
from typer.testing import CliRunner

from mcml_service.cli import app
from mcml_service.storage.database import Database
from tests.builders import one_kind

API = "/api/v1"


def load(client: TestClient, **query: Any) -> Any:
    answer = client.post(f"{API}/demo", params=query)
    assert answer.status_code == 200, answer.text
    return answer.json()


def names(client: TestClient, project: str) -> list[str]:
    answer = client.get(f"{API}/documents", params={"project": project, "limit": 100}).json()
    return sorted(item["name"] for item in answer["items"])


@pytest.mark.slow
@one_kind
def test_a_second_load_stores_nothing(client: TestClient) -> None:
    first = load(client, part=["walks", "people"])
    assert [(each["part"], each["project"]) for each in first["parts"]] == [("walks", "demo-walk"), ("people", "demo")]
    assert first["stored"] == sum(each["stored"] for each in first["parts"]) == 22
    assert first["existing"] == 0
    before = names(client, "demo"), names(client, "demo-walk")
    assert [len(each) for each in before] == [15, 7]
    again = load(client, part=["walks", "people"])
    assert (again["stored"], again["existing"]) == (0, 22)
    assert (names(client, "demo"), names(client, "demo-walk")) == before


@one_kind
def test_only_missing_clips_are_stored(client: TestClient) -> None:
    load(client, part="walks")
    lost = client.get(f"{API}/documents", params={"project": "demo-walk"}).json()["items"][0]
    assert client.delete(f"{API}/documents/{lost['id']}", headers={"if-match": "*"}).status_code == 204
    again = load(client, part="walks")
    assert (again["stored"], again["existing"]) == (1, 6)
    assert lost["name"] in names(client, "demo-walk")


@pytest.mark.slow
@one_kind
def test_a_project_of_its_own_and_another_seed(client: TestClient) -> None:
    load(client, part="people", project="mine")
    assert client.get(f"{API}/projects").json()["items"] == ["mine"]
    other = load(client, part="people", project="mine", seed=2)
    assert other["stored"] == 15, "another seed makes other clips"
    refused = client.post(f"{API}/demo", params={"part": "songs"})
    assert refused.status_code == 422
    assert "part" in refused.text


@pytest.mark.slow
@one_kind
def test_the_command_and_the_server_load_the_same(client: TestClient, tmp_path: Path) -> None:
    load(client, part="walks")
    path = f"sqlite:///{tmp_path / 'mine.db'}"
    done = CliRunner().invoke(app, ["demo", "--database", path])
    assert done.exit_code == 0, done.output
    assert "demo-walk: 7 clips stored" in done.output
    again = CliRunner().invoke(app, ["demo", "--database", path])
    assert "demo-walk: 0 clips stored, 7 existed" in again.output
    database = Database(path)
    with database.read() as tx:
        stored = {name: tx.projects.find(name) for name in ("demo", "demo-reach", "demo-dance", "demo-face")}
    database.close()
    assert None not in stored.values()
