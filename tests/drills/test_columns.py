"""A column can be added to any table: the migration is made, and filled stores of every past version are upgraded."""

from __future__ import annotations

import re
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest
from sqlalchemy import select, update

from mcml_service.actions.keeping import keep_store
from mcml_service.resources import migrations_path
from mcml_service.storage.core import tables
from mcml_service.storage.core.seals import SEALS
from mcml_service.storage.database import Database
from tests import postgres
from tests.builders import bvh, store
from tests.storage.test_migrations import fill, upgrade

ROOT = Path(__file__).resolve().parents[2]
VERSIONS = sorted(path.name[:4] for path in (migrations_path() / "versions").glob("[0-9]*_*.py"))


@pytest.mark.parametrize("path", sorted(migrations_path().rglob("*.py")), ids=lambda path: path.stem)
def test_migrations_know_nothing_of_the_program(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert re.search(r"import (mcml|mcml_service|mcml_schemas)\b|from (mcml|mcml_service|mcml_schemas)\b", text) is None
    assert "environ" not in text


@pytest.mark.slow
@pytest.mark.parametrize("versions", [VERSIONS[::9], pytest.param(VERSIONS, marks=pytest.mark.fuzz)], ids=len)
def test_every_table_takes_a_column(
    kind: str, tmp_path: Path, request: pytest.FixtureRequest, versions: list[str]
) -> None:
    """On an empty store and on stores of some versions; in `make fuzz` of all."""
    with ExitStack() as stack:
        urls = []
        for version in (None, *versions):
            if kind == "sqlite":
                url = f"sqlite:///{tmp_path / f'{version}.db'}"
            else:
                url = stack.enter_context(postgres.new_database(request.getfixturevalue("postgres_server")))
            if version is not None:
                _filled(url, version)
            urls.append(url)
        command = [sys.executable, "-m", "tests.drills.add_columns", str(tmp_path / "migrations"), *urls]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]


def _filled(url: str, version: str) -> None:
    """A store as the first program left it, brought to a version; the newest one has files too."""
    database = Database(url)
    upgrade(database, VERSIONS[0])
    fill(database)
    upgrade(database, version)
    if version >= keep_store.WITH_CHECKSUMS:
        _seal(database)
    database.close()


def _seal(database: Database) -> None:
    """Checksums as programs since then wrote them, of the tables that `fill` fills."""
    with database.dialect.writing() as connection:
        for table in (tables.commit, tables.project, tables.document, tables.revision):
            seal = SEALS[table]
            keys = [column.name for column in table.primary_key]
            for row in connection.execute(select(*(table.c[name] for name in (*keys, *seal.columns)))).all():
                held = (table.c[name] == value for name, value in zip(keys, row, strict=False))
                total = seal.of(tuple(row[len(keys) :]))
                connection.execute(update(table).where(*held).values(checksum=total))


@pytest.mark.slow
def test_a_store_of_today_takes_a_column(database: Database, database_url: str, tmp_path: Path) -> None:
    store(database, {"walk.bvh": bvh(300), "run.bvh": bvh(20)}, project="gait")
    database.close()
    command = [sys.executable, "-m", "tests.drills.add_columns", str(tmp_path / "migrations"), database_url]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
