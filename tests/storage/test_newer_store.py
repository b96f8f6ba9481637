"""A store that a newer program has upgraded: whatever opens it says so, and changes nothing."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest
from fastapi.testclient import TestClient
from typer.testing import CliRunner

from mcml.errors import McmlError, StoreError
from mcml_service.app import create_app
from mcml_service.cli import app
from mcml_service.settings import Settings
from mcml_service.storage.database import Database

COMMANDS = [
    ["ls"], ["import", "a.bvh"], ["xpath", "//frame"], ["purge", "x"], ["demo"], ["serve"], ["doctor"],
    ["token", "list"], ["jobs", "list"], ["db", "upgrade"], ["db", "backup", "b.db"], ["db", "restore", "b.db"],
    ["db", "check"], ["db", "prune", "--older-than", "1"], ["db", "compact"],
]  # fmt: skip
SAID = "The store is newer than this program: its schema is 9999"


@pytest.fixture
def newer(sqlite_template: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "store.db"
    path.write_bytes(sqlite_template.read_bytes())
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE alembic_version SET version_num = '9999'")
    connection.close()
    monkeypatch.chdir(tmp_path)
    for name in ("a.bvh", "b.db"):
        Path(name).write_bytes(b"HIERARCHY")
    return path


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_every_command_says_so(newer: Path, words: list[str]) -> None:
    before = newer.read_bytes()
    done = CliRunner().invoke(app, [*words, "--database", f"sqlite:///{newer}"])
    assert done.exit_code == 1
    error = done.exception
    # The doctor goes on, and prints what it finds.
    told = f"{error.what} {error.remedy}" if isinstance(error, McmlError) else done.output.replace("\n", " ")
    assert SAID in told
    assert "Update the program." in told
    assert "db upgrade" not in told
    assert newer.read_bytes() == before


def test_no_server_starts(newer: Path) -> None:
    database = Database(f"sqlite:///{newer}")
    with pytest.raises(StoreError, match=SAID), TestClient(create_app(Settings(host="127.0.0.1"), database)):
        pass
    database.close()
