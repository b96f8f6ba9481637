"""A program of `test_columns`: every table gets a column, as if somebody had added it, and stores are upgraded.

`python -m tests.drills.add_columns FOLDER URL ...`; FOLDER becomes the migrations with the new one.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from sqlalchemy import Column, String, inspect

from mcml_service.actions.editing.whole_document import change_document
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.keeping import keep_store
from mcml_service.resources import migrations_path
from mcml_service.storage import database as databases
from mcml_service.storage.core.schema import metadata
from mcml_service.storage.database import Database
from mcml_service.storage.lists.filtering import DocumentFilter
from tests.builders import bvh, store
from tests.drills.migration import make_migration

ADDED = "drill"


def main(folder: Path, urls: list[str]) -> None:
    for table in metadata.tables.values():
        table.append_column(Column(ADDED, String(8)))
    shutil.copytree(migrations_path(), folder, ignore=shutil.ignore_patterns("__pycache__"))
    make_migration("drill", folder)
    databases.migrations_path = lambda: folder
    for url in urls:
        database = Database(url)
        keep_store.upgrade(database)
        check(database)
        database.close()


def check(database: Database) -> None:
    """Every table has the column, and the program works with the store."""
    with database.dialect.reading() as connection:
        there = inspect(connection)
        lacking = [name for name in metadata.tables if ADDED not in {one["name"] for one in there.get_columns(name)}]
    assert lacking == [], lacking
    assert (faults := faults_of(database)) == [], faults
    with database.read() as tx:
        old = tx.documents.page(DocumentFilter(), after=None, limit=10)
        before = {
            one.name: b"".join(export_document(tx, one, ExportOptions("mcml")).content) for one in old if one.frames
        }
    (uuid,) = store(database, {"new.bvh": bvh(5)}, project="drill")
    with database.write() as tx:
        change_document(tx, tx.documents.get(uuid), name="newer")
    with database.read() as tx:
        found = export_document(tx, tx.documents.get(uuid), ExportOptions("bvh", original=False))
        assert b"".join(found.content) == bvh(5)
    assert before.items() <= texts_of(database).items()
    assert (faults := faults_of(database)) == [], faults


def faults_of(database: Database) -> list[str]:
    """What is wrong in a store, but for the document that `test_migrations.fill` leaves without content."""
    return [fault for fault in database.check() if "(u)" not in fault]


def texts_of(database: Database) -> dict[str, bytes]:
    """Each document with frames as MCML."""
    with database.read() as tx:
        stored = [one for one in tx.documents.page(DocumentFilter(), after=None, limit=10) if one.frames]
        return {one.name: b"".join(export_document(tx, one, ExportOptions("mcml")).content) for one in stored}


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
