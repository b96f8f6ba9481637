"""Backups of every kind of store into every kind, with rows in each table; what comes back works on."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import func, insert, select, text

from mcml.errors import ConflictError, StoreError
from mcml_schemas.querying.queries import QueryRequest
from mcml_service.actions.editing.whole_document import add_labels
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.keeping.keep_store import backup, restore
from mcml_service.actions.keeping.purge_documents import purge_documents
from mcml_service.settings import Settings
from mcml_service.storage.core.schema import metadata
from mcml_service.storage.core.tables import document, skeleton
from mcml_service.storage.core.tables import store as about_itself
from mcml_service.storage.database import Database
from mcml_service.storage.documents.bodies import StoredBody
from mcml_service.storage.projects.quotas import Quota
from mcml_service.storage.team.tables import delivery
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.queries import Queries
from tests import postgres
from tests.actions.test_move_project import fill
from tests.builders import bvh, store

KINDS = ("sqlite", "postgresql")


@contextmanager
def new_store(kind: str, file: Path, request: pytest.FixtureRequest) -> Iterator[Database]:
    """A new, empty store of a kind."""
    with ExitStack() as stack:
        url = f"sqlite:///{file}"
        if kind == "postgresql":
            template = request.getfixturevalue("postgres_template")
            url = stack.enter_context(postgres.new_database(template, "template_store"))
        made = Database(url)
        made.migrate()
        stack.callback(made.close)
        yield made


@pytest.fixture(scope="module")
def filled(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Database]]:
    """By kind, a store with rows in each table."""
    folder = tmp_path_factory.mktemp("filled")
    with ExitStack() as stack:
        made = {kind: stack.enter_context(new_store(kind, folder / f"{kind}.db", request)) for kind in KINDS}
        for database in made.values():
            fill_every_table(database)
        yield made


def fill_every_table(database: Database) -> None:
    """Rows in each table, and keys of documents and skeletons that are gone and had the greatest."""
    fill(database, 1)
    with database.write("kim") as tx:
        uuid = tx.connection.execute(select(document.c.uuid).where(document.c.name == "a")).scalar_one()
        stored, project = tx.documents.get(uuid), tx.projects.get("mine")
        fill_people(tx, project)
        tx.shares.add("a link", [uuid], ["bvh"], "kim", timedelta(days=1), latest=True)
        if not tx.thumbnails.has(stored.key, stored.revision):
            tx.thumbnails.add(stored.key, stored.revision, b"\1\2", {"up": "y"})
        tx.bodies.add([(stored, StoredBody({"up": "y"}, (b"\3",)))])
        tx.presence.keep(stored, "kim", "a tab", "viewing")
        tx.requests.begin("kim", "once", "upload", "0" * 64)
        tx.attempts.add({"address": "10.0.0.1"})
        tx.quotas.put(project, Quota(most_bytes=1 << 40))
        hook = tx.webhooks.add("https://lab.example/hook", ["document"], project)[1]
        message = {"webhook": hook.number, "message": "m", "type": "document.add", "payload": "{}", "created": "2026"}
        tx.connection.execute(insert(delivery).values(**message, state="waiting", attempts=0, due=0.5))
        tx.jobs.add(project, "reach", "걸음", "kim", [], {})
        first = tx.results.add(project, "reach", "all", "kim", [], {}, {})[0]
        tx.results.add_part(first, "points", "points", {"a": 1}, {"all": np.arange(9.0)}, stored.key)
        tx.pruning.let_go(3)
    purge_documents(database, store(database, {"gone.bvh": bvh(3, names=("Hips", "Tail"))}, project="mine"))


def fill_people(tx: Transaction, project: int) -> None:
    kim = tx.accounts.add("kim", "owner", "no hash")
    tx.members.put(project, "kim", "owner")
    tx.accounts.identify(kim, "https://id.example", "kim")
    tx.accounts.invite("editor", "kim", timedelta(days=1), project)
    tx.tokens.add("of kim", owner=kim, projects=[project])
    tx.sessions.open_for(kim)


def rows_of(database: Database) -> dict[str, list[Any]]:
    with database.read() as tx:
        return {
            table.name: [
                tuple(bytes(value) if isinstance(value, memoryview) else value for value in row)
                for row in tx.connection.execute(select(table).order_by(*table.primary_key))
            ]
            for table in metadata.sorted_tables
            if table is not about_itself
        }


def greatest(database: Database) -> dict[str, int]:
    """The greatest keys of documents and skeletons."""
    with database.read() as tx:
        return {
            table.name: tx.connection.execute(select(func.max(table.c.id))).scalar_one()
            for table in (document, skeleton)
        }


@pytest.mark.slow
@pytest.mark.parametrize("source", KINDS)
@pytest.mark.parametrize("target", KINDS)
def test_a_store_goes_into_every_kind(
    source: str, target: str, filled: dict[str, Database], tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    before, file = rows_of(filled[source]), tmp_path / "backup.db"
    assert [name for name, rows in before.items() if not rows] == [], "each table has rows"
    backup(filled[source], file)
    with new_store(target, tmp_path / "restored.db", request) as restored:
        assert restore(restored, file) == len(before["document"])
        assert rows_of(restored) == before
        assert restored.check(past=True) == []
        with restored.read() as tx:
            assert tx.pruning.whole_since() >= 3
        works_on(restored, before)


def works_on(database: Database, before: dict[str, list[Any]]) -> None:
    """It numbers on behind every key that was ever given, and takes imports, edits and queries."""
    if database.name == "postgresql":
        for table in metadata.sorted_tables:
            keys = list(table.primary_key.columns)
            if len(keys) == 1 and keys[0].type.python_type is int and not keys[0].foreign_keys:
                asked = f"SELECT nextval(pg_get_serial_sequence('\"{table.name}\"', '{keys[0].name}'))"
                with database.write() as tx:
                    given = tx.connection.execute(text(asked)).scalar_one()
                assert given > max(row[0] for row in before[table.name]), table.name
    # The document that was purged had the key behind the greatest one, as had its skeleton.
    gone = {name: max(row[0] for row in before[name]) + 1 for name in ("document", "skeleton")}
    uuid = store(database, {"new.bvh": bvh(5, names=("Root", "New"))}, project="mine")[0]
    assert all(key > gone[name] for name, key in greatest(database).items())
    with database.write("kim") as tx:
        add_labels(tx, tx.documents.get(uuid), [("after", 1, 2)])
    with database.write("kim") as tx:
        tx.members.put(tx.projects.get("theirs"), "kim", "editor")
    engine = Queries(database, Settings())
    try:
        assert engine.answer(QueryRequest(q="count(//frame[motion_name='after'])")).value == 2
    finally:
        engine.close()
    with database.read() as tx:
        content = export_document(tx, tx.documents.get(uuid), ExportOptions("bvh", original=False)).content
        assert b"".join(content) == bvh(5, names=("Root", "New"))
    assert database.check(past=True) == []


@pytest.mark.slow
def test_a_store_that_holds_anything_is_not_filled(
    database: Database, filled: dict[str, Database], tmp_path: Path
) -> None:
    backup(filled["sqlite"], tmp_path / "backup.db")
    with database.write() as tx:
        tx.accounts.add("ann", "owner", "no hash")
    before = rows_of(database)
    with pytest.raises(ConflictError, match="rows in account"):
        restore(database, tmp_path / "backup.db")
    assert rows_of(database) == before


def test_what_is_no_backup_or_an_old_one_is_told(database: Database, tmp_path: Path) -> None:
    Database(f"sqlite:///{tmp_path}/empty.db").size()
    with pytest.raises(StoreError, match="no backup"):
        restore(database, tmp_path / "empty.db")
    old = Database(f"sqlite:///{tmp_path}/old.db")
    old.migrate()
    with old.write() as tx:
        tx.connection.execute(text("UPDATE alembic_version SET version_num = '0007'"))
    old.close()
    with pytest.raises(StoreError, match="schema is 0007") as told:
        restore(database, tmp_path / "old.db")
    assert f"--database sqlite:///{tmp_path}/old.db" in (told.value.remedy or "")
