"""All rows of a store put into another one, of either kind: backups are made and read so."""

from __future__ import annotations

from sqlalchemy import insert, select

from mcml_service.storage.core.schema import metadata
from mcml_service.storage.core.tables import store
from mcml_service.storage.database import Database
from mcml_service.storage.transaction import Transaction

ROWS = 2000

_COPIED = [table for table in metadata.sorted_tables if table is not store]
"""All tables except the one that describes the store itself, which its migration and `copy_rows` write."""


def find_filled_tables(tx: Transaction) -> list[str]:
    """Names of the tables that hold any row."""
    return [table.name for table in _COPIED if tx.fetch_one(select(table).limit(1)) is not None]


def copy_rows(source: Database, target: Database) -> None:
    """Put all rows of a store into an empty one, in one transaction."""
    with source.read() as old, target.write("backup") as new:
        for table in _COPIED:
            for block in old.stream(select(table).order_by(*table.primary_key), ROWS):
                new.run(insert(table), [dict(row._mapping) for row in block])
        new.pruning.let_go(old.pruning.whole_since())
        new.dialect.after_copy(new.connection, old.dialect.last_keys(old.connection))
