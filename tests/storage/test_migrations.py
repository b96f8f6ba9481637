"""Migrations on filled stores: what was stored before is there afterwards, whole."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from alembic import command
from alembic.config import Config
from sqlalchemy import text

from mcml_service.actions.editing.whole_document import change_document, restore_revision
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.keeping import keep_store
from mcml_service.resources import migrations_path
from mcml_service.storage.database import Database
from tests import postgres
from tests.builders import bvh, store


@pytest.fixture
def empty(kind: str, tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Database]:
    """A store without any table."""
    if kind == "sqlite":
        database = Database(f"sqlite:///{tmp_path / 'old.db'}")
        yield database
        database.close()
        return
    server = request.getfixturevalue("postgres_server")
    with postgres.new_database(server) as url:
        database = Database(url)
        yield database
        database.close()


def upgrade(database: Database, version: str) -> None:
    config = Config()
    config.set_main_option("script_location", str(migrations_path()))
    with database.dialect.writing() as connection:
        config.attributes["connection"] = connection
        command.upgrade(config, version)


def fill(database: Database) -> None:
    """Two projects, a document with three revisions, and a skeleton, as the first program wrote them."""
    rows: dict[str, list[dict[str, Any]]] = {
        "commit": [{"number": n, "time": f"2026-01-0{n}T00:00:00.000Z", "author": "kim"} for n in (1, 2, 3)],
        "project": [{"id": n, "name": name, "created": "2026"} for n, name in ((1, "gait"), (2, "lab"))],
        "document": [
            {"id": 7, "uuid": "u", "project": 2, "state": "ready", "name": "걸음", "format": "bvh", "next_slot": 0}
            | {"created_commit": 1, "deleted_commit": 2**63 - 1, "receipt": b""}
        ],
        "revision": [
            {"document": 7, "number": n, "commit": n, "parent": n - 1 or None, "operation": "x", "message": f"m{n}"}
            for n in (1, 2, 3)
        ],
    }
    with database.dialect.writing() as connection:
        for table, some in rows.items():
            names = ", ".join(f'"{name}"' for name in some[0])
            places = ", ".join(f":{name}" for name in some[0])
            connection.execute(text(f'INSERT INTO "{table}" ({names}) VALUES ({places})'), some)
            if connection.dialect.name == "postgresql" and "id" in some[0]:
                # Rows with stated numbers leave the counter where it was.
                counter = f"pg_get_serial_sequence('\"{table}\"', 'id')"
                connection.execute(text(f"SELECT setval({counter}, {max(row['id'] for row in some)})"))


def test_revisions_of_before_get_the_present_name_and_project(empty: Database) -> None:
    upgrade(empty, "0001")
    fill(empty)
    keep_store.upgrade(empty)
    empty.require_schema()
    with empty.read() as tx:
        found = tx.connection.execute(text("SELECT * FROM revision ORDER BY number")).mappings().all()
    kept = ("document", "number", "commit", "parent", "operation", "message", "name", "project")
    assert [tuple(row[name] for name in kept) for row in found] == [
        (7, n, n, n - 1 or None, "x", f"m{n}", "걸음", 2) for n in (1, 2, 3)
    ]


def test_a_migrated_store_works_on(empty: Database) -> None:
    upgrade(empty, "0001")
    fill(empty)
    keep_store.upgrade(empty)
    with empty.write() as tx:
        for table in ("revision", "document"):
            tx.connection.execute(text(f"DELETE FROM {table}"))
    uuid = store(empty, {"walk.bvh": bvh(300)}, project="gait")[0]
    with empty.write() as tx:
        change_document(tx, tx.documents.get(uuid), name="run", project="lab")
    with empty.write() as tx:
        restored = restore_revision(tx, tx.documents.get(uuid), 1)
        assert (restored.name, restored.project, restored.revision) == ("walk", "gait", 3)
        assert b"".join(export_document(tx, restored, ExportOptions("bvh", original=False)).content) == bvh(300)
    assert empty.check() == []
