"""Stores of an older program: only `db upgrade` and `serve` upgrade them, and keep an SQLite store as it was."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest
import uvicorn
from typer.testing import CliRunner

import mcml
from mcml.errors import McmlError, StoreError
from mcml_service.actions.keeping.keep_store import upgrade
from mcml_service.cli import app
from mcml_service.storage.database import Database
from tests.builders import bvh, store
from tests.storage.test_migrations import upgrade as upgrade_to

OLD = "0018"
COMMANDS = [
    ["ls"], ["import", "a.bvh"], ["xpath", "//frame"], ["purge", "x"], ["demo"], ["token", "list"],
    ["token", "add", "x"], ["jobs", "list"], ["db", "backup", "b.db"], ["db", "restore", "a.bvh"], ["db", "check"],
    ["db", "derive"],
    ["db", "prune", "--older-than", "1"], ["db", "compact"], ["account", "role", "kim", "reader"], ["doctor"],
    ["export"], ["projects"], ["project", "export", "x"],
]  # fmt: skip


@pytest.fixture
def older(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A store of the schema before the newest, with a document."""
    path = tmp_path / "store.db"
    database = Database(f"sqlite:///{path}")
    upgrade_to(database, OLD)
    with database.write() as tx:
        tx.accounts.add("kim", "owner", "no hash")
    database.close()
    with sqlite3.connect(path) as connection:
        connection.execute("PRAGMA journal_mode=DELETE")
    connection.close()
    monkeypatch.chdir(tmp_path)
    Path("a.bvh").write_bytes(bvh(3))
    return path


def kept(path: Path) -> list[Path]:
    return sorted(path.parent.glob("store.db.schema-*"))


def schema(path: Path) -> str:
    with sqlite3.connect(path) as connection:
        found = str(connection.execute("SELECT version_num FROM alembic_version").fetchone()[0])
    connection.close()
    return found


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_other_commands_say_what_to_run(older: Path, words: list[str]) -> None:
    done = CliRunner().invoke(app, [*words, "--database", f"sqlite:///{older}"])
    assert done.exit_code == 1
    error = done.exception
    told = f"{error.what} {error.remedy}" if isinstance(error, McmlError) else done.output.replace("\n", " ")
    assert f"schema is {OLD}" in told
    assert "mcml db upgrade" in told
    assert (schema(older), kept(older)) == (OLD, [])


def test_the_python_package_says_so_too(older: Path) -> None:
    with pytest.raises(StoreError, match=f"schema is {OLD}"):
        mcml.open(str(older))
    assert schema(older) == OLD


@pytest.mark.parametrize("words", [["db", "upgrade"], ["serve", "--port", "0"]], ids=" ".join)
def test_those_that_upgrade_keep_the_store_as_it_was(
    older: Path, words: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    served: list[object] = []
    monkeypatch.setattr(uvicorn, "run", lambda *given, **named: served.append(given))
    done = CliRunner().invoke(app, [*words, "--database", f"sqlite:///{older}"])
    assert done.exit_code == 0, done.output
    assert bool(served) == (words[0] == "serve")
    (copy,) = kept(older)
    assert str(copy) in done.output.replace("\n", "")
    assert (schema(copy), copy.stat().st_mode & 0o777) == (OLD, 0o600)
    with sqlite3.connect(copy) as connection:
        assert connection.execute("SELECT name FROM account").fetchall() == [("kim",)]
    connection.close()
    again = CliRunner().invoke(app, ["db", "upgrade", "--database", f"sqlite:///{older}"])
    assert "nothing to do" in again.output
    assert kept(older) == [copy]
    assert CliRunner().invoke(app, ["ls", "--database", f"sqlite:///{older}"]).exit_code == 0


def test_without_room_for_the_copy_nothing_is_upgraded(older: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    connect = sqlite3.connect

    def small(path: Path) -> sqlite3.Connection:
        # No page can be added, as on a full disk.
        made = connect(path)
        if path != older:
            made.execute("PRAGMA max_page_count=1")
        return made

    database = Database(f"sqlite:///{older}")
    database.schema_versions()
    monkeypatch.setattr("mcml_service.actions.keeping.keep_store.sqlite3.connect", small)
    with pytest.raises(McmlError) as told:
        upgrade(database)
    assert "not upgraded" in told.value.what
    assert "MB of room" in (told.value.remedy or "")
    database.close()
    monkeypatch.undo()
    assert (schema(older), kept(older)) == (OLD, [])


def test_a_new_store_is_made_by_whatever_asks_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.bvh").write_bytes(bvh(3))
    url = f"sqlite:///{tmp_path}/new/store.db"
    assert CliRunner().invoke(app, ["import", "a.bvh", "--database", url]).exit_code == 0
    assert list(tmp_path.glob("new/*.backup")) == []
    database = Database(url)
    database.require_schema()
    assert store(database, {"b.bvh": bvh(4)})
    database.close()
