"""Backups: the whole store as one SQLite file, from and to any kind of database."""

from __future__ import annotations

import os
import sqlite3
from datetime import UTC, datetime
from pathlib import Path

from mcml.errors import ConflictError, SpaceError, StoreError
from mcml_service.actions.keeping.seal_store import seal_store
from mcml_service.storage.copying import copy_rows, find_filled_tables
from mcml_service.storage.core.dialects.sqlite import PRIVATE, copy_file, fold_log
from mcml_service.storage.database import Database
from mcml_service.storage.transaction import Transaction

WITH_CHECKSUMS = "0006"
"""The version of the schema from which on rows have checksums."""


def backup(database: Database, target: Path) -> int:
    """Write a snapshot of the store into a new file while others work; returns its size in bytes."""
    if target.exists():
        raise ConflictError(f"{target} exists.", remedy="Choose a new file name.")
    part = target.with_name(target.name + ".part")
    part.unlink(missing_ok=True)
    copy = Database(f"sqlite:///{part}")
    try:
        copy.migrate()
        copy_rows(database, copy)
        copy.close()
        fold_log(part)
        part.replace(target)
    finally:
        copy.close()
        part.unlink(missing_ok=True)
    return target.stat().st_size


def upgrade(database: Database) -> Path | None:
    """Bring a store to this program's schema, or make a new one.

    Returns the path of the copy of an SQLite store; None if nothing was upgraded, or for a database server, which has
    its own backups. Raises SpaceError without space for the copy: then nothing is upgraded.
    """
    version, wanted = database.schema_versions()
    path = database.dialect.file
    kept = None
    if path is not None and version is not None and wanted is not None and version < wanted:
        kept = path.with_name(f"{path.name}.schema-{version}.{datetime.now(UTC):%Y%m%dT%H%M%SZ}.backup")
        _copy_file(path, kept)
    database.migrate(_mend)
    return kept


def _mend(before: str, tx: Transaction) -> None:
    """Fill in data that rows of an older store lack.

    Migrations change tables, the current program fills them. before: its version of the schema.
    """
    if before < WITH_CHECKSUMS:
        seal_store(tx)


def _copy_file(path: Path, target: Path) -> None:
    """Copy an SQLite store while others use it. Raises SpaceError."""
    os.close(os.open(target, os.O_CREAT | os.O_EXCL | os.O_RDWR, PRIVATE))
    try:
        copy_file(path, target)
    except sqlite3.Error as error:
        target.unlink()
        if getattr(error, "sqlite_errorcode", None) != sqlite3.SQLITE_FULL:
            raise
        raise SpaceError(
            f"There is no room to copy the store to {target}, so it was not upgraded.",
            remedy=f"Make {path.stat().st_size / 1e6:,.0f} MB of room on that disk, then try again.",
        ) from error


def restore(database: Database, source: Path) -> int:
    """Fill an empty store with a backup; returns the number of documents. ConflictError where it is not empty."""
    if not source.is_file():
        raise StoreError(f"{source} is not a file.", remedy="Name a file that `mcml db backup` wrote.")
    with database.read() as tx:
        held = find_filled_tables(tx)
        if held or tx.newest_commit():
            raise ConflictError(
                f"The store is not empty: it has rows in {', '.join(held)}.", remedy="Restore into a new store."
            )
    copy = Database(f"sqlite:///{source}")
    try:
        _require_schema(copy, source)
        copy_rows(copy, database)
    finally:
        copy.close()
    with database.read() as tx:
        return len(tx.documents.everything())


def _require_schema(copy: Database, source: Path) -> None:
    """StoreError unless a backup has this program's schema."""
    version, wanted = copy.schema_versions()
    if version is None:
        raise StoreError(f"{source} is no backup of a store.", remedy="Name a file that `mcml db backup` wrote.")
    if version < (wanted or ""):
        raise StoreError(
            f"The backup's schema is {version}, this program needs {wanted}.",
            remedy=f"Upgrade a copy of it first: mcml db upgrade --database sqlite:///{source}",
        )
    copy.require_schema()
