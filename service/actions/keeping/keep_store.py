"""Backups: the whole store as one SQLite file, from and to any kind of database."""

from __future__ import annotations

import sqlite3
from pathlib import Path

from sqlalchemy import func, insert, select

from service.errors import ConflictError, StoreError
from service.storage.database import Database
from service.storage.schema import metadata
from service.storage.tables import document, store

ROWS = 2000


def backup(database: Database, target: Path) -> int:
    """Write a snapshot of the store into a new file while others go on working; returns its size in bytes."""
    if target.exists():
        raise ConflictError(f"{target} exists.", remedy="Choose a new file name.")
    part = target.with_name(target.name + ".part")
    part.unlink(missing_ok=True)
    copy = Database(f"sqlite:///{part}")
    try:
        copy.migrate()
        _copy(database, copy)
        copy.close()
        # One file that can be moved: without a log beside it.
        connection = sqlite3.connect(part)
        connection.execute("PRAGMA journal_mode=DELETE")
        connection.close()
        part.replace(target)
    finally:
        copy.close()
        part.unlink(missing_ok=True)
    return target.stat().st_size


def restore(database: Database, source: Path) -> int:
    """Fill an empty store with a backup; returns the number of documents. ConflictError where it is not empty."""
    if not source.is_file():
        raise StoreError(f"{source} is not a file.", remedy="Name a file that `mcml db backup` wrote.")
    with database.read() as tx:
        held = [table.name for table in _COPIED if tx.connection.execute(select(table).limit(1)).first() is not None]
        if held or tx.newest_commit():
            raise ConflictError(
                f"The store is not empty: it has rows in {', '.join(held)}.", remedy="Restore into a new store."
            )
    copy = Database(f"sqlite:///{source}")
    try:
        _require_schema(copy, source)
        _copy(copy, database)
    finally:
        copy.close()
    with database.read() as tx:
        return int(tx.connection.execute(select(func.count()).select_from(document)).scalar_one())


_COPIED = [table for table in metadata.sorted_tables if table is not store]
"""All tables but what a store says of itself, which its migration and `_copy` write."""


def _require_schema(copy: Database, source: Path) -> None:
    """StoreError unless a backup has this program's schema."""
    found, wanted = copy.schema_versions()
    if found is None:
        raise StoreError(f"{source} is no backup of a store.", remedy="Name a file that `mcml db backup` wrote.")
    if found < (wanted or ""):
        raise StoreError(
            f"The backup's schema is {found}, this program needs {wanted}.",
            remedy=f"Upgrade a copy of it first: mcml db upgrade --database sqlite:///{source}",
        )
    copy.require_schema()


def _copy(source: Database, target: Database) -> None:
    with source.read() as old, target.write("backup") as new:
        for table in _COPIED:
            rows = old.connection.execute(
                select(table).order_by(*table.primary_key).execution_options(yield_per=ROWS)
            ).mappings()
            for block in rows.partitions(ROWS):
                new.connection.execute(insert(table), [dict(row) for row in block])
        new.pruning.let_go(old.pruning.whole_since())
        new.dialect.after_copy(new.connection, old.dialect.last_keys(old.connection))
