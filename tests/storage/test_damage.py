"""Rows that are not what was written: told by document, bone and frames, while other documents go on."""

from __future__ import annotations

from pathlib import Path

import pytest
from sqlalchemy import text, update

from mcml.errors import DamageError, StoreError
from mcml_schemas.querying.queries import QueryRequest
from mcml_service.actions.editing.single_element import Change
from mcml_service.actions.editing.whole_document import add_labels, restore_revision
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.keeping import keep_store
from mcml_service.actions.keeping.check_uploads import compare_all
from mcml_service.actions.keeping.keep_store import backup, restore
from mcml_service.settings import Settings
from mcml_service.storage.core import tables
from mcml_service.storage.core.schema import metadata
from mcml_service.storage.database import Database
from mcml_service.storage.layout import LAYOUT
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.queries import Queries
from tests.builders import ASF, MCML, amc, bvh, store
from tests.edits import change_element


def damage(database: Database, table: str, column: str, value: str, where: str) -> None:
    with database.write() as tx:
        tx.connection.execute(text(f'UPDATE "{table}" SET {column} = {value} WHERE {where}'))


def content(database: Database, uuid: str, format: str = "mcml") -> bytes:
    with database.read() as tx:
        export = export_document(tx, tx.documents.get(uuid), ExportOptions(format, original=False))
        return b"".join(export.content)


def key_of(database: Database, uuid: str) -> int:
    with database.read() as tx:
        return tx.documents.get(uuid).key


@pytest.mark.parametrize(
    ("table", "column", "value", "where", "said"),
    [
        ("track", "data", "(SELECT data FROM track WHERE document = {key} AND bone = 2 AND chunk = 1)",
         "bone = 1 AND chunk = 1", "bone 'Spine', frames 257 to 300"),
        ("track", "codec", "3", "bone = 0 AND chunk = 0", "bone 'Root', frames 1 to 256"),
        ("header", "text", "'x'", "tag = 'filename'", "its header"),
        ("bone", "name", "'x'", "bone = 1", "the name of a bone"),
        ("timeline", "slot", "1", "first = 1", "the order of its frames"),
        ("frame_run", "step", "2", "first = 1", "the ids of its frames"),
        ("shape_run", "count", "299", "slot = 0", "which bones its frames have"),
        ("span", "last", "7", "name = 'walk'", "a motion name, of frames 1 to 7"),
        ("content", "frames", "299", "skeleton > 0", "its frames, skeleton or frame time"),
    ],
)  # fmt: skip
def test_what_is_damaged_is_told_and_others_go_on(
    database: Database, table: str, column: str, value: str, where: str, said: str
) -> None:
    whole = store(database, {"b.bvh": bvh(300, seed=2)})[0]
    uuid = store(database, {"a.bvh": bvh(300)})[0]
    with database.write() as tx:
        add_labels(tx, tx.documents.get(uuid), [("walk", 1, 300)])
    key, before = key_of(database, uuid), content(database, whole)
    damage(database, table, column, value.format(key=key), f"document = {key} AND {where}")
    with pytest.raises(DamageError, match="damaged") as caught:
        content(database, uuid)
    assert f"The document 'a' ({uuid})" in caught.value.what
    assert said in caught.value.what
    assert caught.value.what in database.check()
    assert content(database, whole) == before


def test_a_skeleton_that_is_damaged_is_told(database: Database) -> None:
    uuid = store(database, {"a.bvh": bvh(3)})[0]
    damage(database, "skeleton_element", "text", "'x'", "tag = 'name' AND pre > 4")
    with pytest.raises(DamageError, match="skeleton"):
        content(database, uuid)
    assert any("used by a: its elements are not those that were written" in fault for fault in database.check())


@pytest.mark.parametrize(("column", "value"), [('"max_Rx"', "1e9"), ("has_missing", "255"), ("channels", "7")])
def test_questions_over_a_damaged_zone_map_are_told(database: Database, column: str, value: str) -> None:
    store(database, {"a.bvh": bvh(300)})
    damage(database, "track", column, value, "bone = 1 AND chunk = 1")
    engine = Queries(database, Settings())
    with pytest.raises(DamageError, match=r"bone 'Spine', frames 257 to 300"):
        engine.answer(QueryRequest(q="//frame_bone[@name='Spine'][@Rx > 1e8]"))
    engine.close()
    assert len(database.check()) > 0


def test_every_edit_leaves_its_checksums(database: Database) -> None:
    """Rows that are closed, copied and brought back in SQL among them."""
    uuid = store(database, {"a.bvh": bvh(600)})[0]
    for number in (1, 300, 599):
        with database.write() as tx:
            place = f"/mcml/motion/frame[{number}]/frame_bone[2]"
            change_element(tx, tx.documents.get(uuid), place, Change({"Rx": "1.5"}))
    with database.write() as tx:
        restore_revision(tx, tx.documents.get(uuid), 2)
    with database.write() as tx:
        tx.documents.rename(key_of(database, uuid), "other")
    assert database.check(past=True) == []


def test_deep_checks_read_the_files_again(database: Database) -> None:
    uuid = store(database, {"a.bvh": bvh(300)})[0]
    legs = {"leg.asf": ASF, "leg.amc": amc(4)}
    store(database, legs)
    store(database, {"leg.amc": amc(9)}, skeleton=key_uuid(database, "leg"))
    store(database, {"hand.mcml": MCML})
    with database.read() as tx:
        assert [(found.faults, found.unread) for found in compare_all(tx, Settings())] == [((), None)] * 4
    other = store(database, {"b.bvh": bvh(300, seed=7)})[0]
    with database.write() as tx:
        copy_tracks(tx, key_of(database, other), key_of(database, uuid))
    with database.read() as tx:
        faults = [fault for found in compare_all(tx, Settings()) for fault in found.faults]
    assert "bone 'Spine', frames 1 to 256: other numbers than in its file" in faults
    assert "bone 'Spine', frames 257 to 300: other numbers than in its file" in faults


def key_uuid(database: Database, name: str) -> str:
    from mcml_service.storage.lists.filtering import DocumentFilter

    with database.read() as tx:
        return tx.documents.page(DocumentFilter(name=name), after=None, limit=1)[0].uuid


def copy_tracks(tx: Transaction, source: int, target: int) -> None:
    """Other numbers with checksums of their own, as a program with a fault would write them."""
    columns = [column.name for column in tables.track.columns if "checksum" not in column.name]
    held = tx.connection.execute(tables.track.select().where(tables.track.c.document == source)).mappings().all()
    tx.connection.execute(tables.track.delete().where(tables.track.c.document == target))
    tx.insert_rows(tables.track, [{name: row[name] for name in columns} | {"document": target} for row in held])


def as_before_checksums(database: Database) -> None:
    """The store as a program that knew no checksums left it."""
    with database.write() as tx:
        for table in metadata.sorted_tables:
            for column in table.columns:
                if "checksum" in column.name or column.name in ("min_weight", "max_weight", "vertices"):
                    tx.connection.execute(text(f'ALTER TABLE "{table.name}" DROP COLUMN {column.name}'))
        for later in (
            *("store", "joint_alias", "session", "request", "thumbnail", "saved", "document_media", "body"),
            *("project_terms", "shared_document", "share", "identity", "proposal", "comment", "event"),
            *("webhook_delivery", "webhook", "attempt", "presence"),
            *("membership", "token_project", "token_grant", "invitation", "account"),
        ):
            tx.connection.execute(text(f"DROP TABLE {later}"))
        for index in ("ix_revision_commit", "ix_document_there"):
            tx.connection.execute(text(f"DROP INDEX {index}"))
        tx.connection.execute(text("UPDATE alembic_version SET version_num = '0005'"))


def test_an_upgrade_compares_with_the_files_before_it_believes_what_is_there(
    database: Database, caplog: pytest.LogCaptureFixture
) -> None:
    uuid = store(database, {"a.bvh": bvh(300)})[0]
    others = [store(database, {"b.bvh": bvh(30, seed=2)})[0], store(database, {"leg.asf": ASF, "leg.amc": amc(4)})[0]]
    with database.write() as tx:
        change_element(tx, tx.documents.get(others[0]), "/mcml/motion/frame[1]/frame_bone[2]", Change({"Rx": "1.5"}))
    before = [content(database, other) for other in others]
    as_before_checksums(database)
    key = key_of_row(database, "a")
    swapped = f"(SELECT data FROM track WHERE document = {key} AND bone = 2 AND chunk = 1)"
    damage(database, "track", "data", swapped, f"document = {key} AND bone = 1 AND chunk = 1")
    with pytest.raises(StoreError, match="schema is 0005"):
        database.require_schema()
    keep_store.upgrade(database)
    assert f"a ({uuid}): bone 'Spine', frames 257 to 300: other numbers than in its file" in caplog.text
    with pytest.raises(DamageError, match="bone 'Spine', frames 257 to 300"):
        content(database, uuid)
    (fault,) = database.check(past=True)
    assert "bone 'Spine', frames 257 to 300" in fault
    assert [content(database, other) for other in others] == before


def key_of_row(database: Database, name: str) -> int:
    with database.read() as tx:
        return int(
            tx.connection.execute(text("SELECT id FROM document WHERE name = :name"), {"name": name}).scalar_one()
        )


def test_a_program_with_another_layout_refuses_the_store(database: Database) -> None:
    for name in LAYOUT:
        with database.write() as tx:
            tx.connection.execute(update(tables.store).where(tables.store.c.name == name).values(value="1024"))
        for ask in (database.migrate, database.require_schema):
            with pytest.raises(StoreError, match=f"The store's {name}: 1024; this program's") as caught:
                ask()
            assert caught.value.remedy is not None
        with database.write() as tx:
            tx.connection.execute(update(tables.store).where(tables.store.c.name == name).values(value=LAYOUT[name]))
    database.require_schema()


def test_a_store_of_a_newer_program_says_so_everywhere(database: Database) -> None:
    damage(database, "alembic_version", "version_num", "'9999'", "1 = 1")
    for ask in (database.migrate, database.require_schema):
        with pytest.raises(StoreError, match="The store is newer than this program: its schema is 9999"):
            ask()


def test_a_file_that_is_no_database_is_told(tmp_path: Path) -> None:
    path = tmp_path / "store.db"
    path.write_bytes(b"no database" * 1000)
    database = Database(f"sqlite:///{path}")
    with pytest.raises(DamageError, match="not a database"):
        database.require_schema()


@pytest.mark.slow
def test_backups_carry_checksums(database: Database, tmp_path: Path) -> None:
    uuid = store(database, {"a.bvh": bvh(30)})[0]
    before = content(database, uuid)
    backup(database, tmp_path / "copy.db")
    again = Database(f"sqlite:///{tmp_path / 'again.db'}")
    again.migrate()
    restore(again, tmp_path / "copy.db")
    assert again.check(past=True) == []
    assert content(again, uuid) == before
    again.close()
