"""The rest pose of a document, on every face: one declaration made them all."""

from __future__ import annotations

import json

import numpy as np
import pytest
from fastapi.testclient import TestClient
from typer.testing import CliRunner

import mcml
from mcml_service.cli import app
from mcml_service.local_store import Local
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import bvh, store

WANTED = [[0.0, 0.0, 0.0], [0.0, 10.5, 0.0], [0.0, 21.0, 0.0]]


@pytest.fixture
def uuid(database: Database) -> str:
    return store(database, {"walk.bvh": bvh(5)})[0]


def test_over_http(client: TestClient, uuid: str) -> None:
    answer = client.get(f"/api/v1/documents/{uuid}/rest")
    assert answer.json() == {"joints": ["Root", "Spine", "Head"], "parents": [-1, 0, 1], "positions": WANTED}
    known = {"if-none-match": answer.headers["etag"]}
    assert client.get(f"/api/v1/documents/{uuid}/rest", headers=known).status_code == 304
    assert client.get(f"/api/v1/documents/{uuid}/rest?revision=9").status_code == 404


def test_in_python(database: Database, uuid: str) -> None:
    with mcml.Repository(Local(database, Settings())) as repo:
        np.testing.assert_array_equal(repo.operations.get_rest_pose(id=uuid).positions, WANTED)


def test_on_the_command_line(database: Database, uuid: str) -> None:
    address = database.dialect.engine.url.render_as_string(hide_password=False)
    done = CliRunner().invoke(app, ["rest", "walk", "--json", "--database", address])
    assert (done.exit_code, json.loads(done.output)["positions"]) == (0, WANTED)
