"""Checksums written over all that a store holds: once, when it comes from a program that had none."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import zstandard
from sqlalchemy import Table, bindparam, inspect, select, tuple_, update

from mcml_service.storage.core import tables
from mcml_service.storage.core.seals import SEALS, Row, add_checksums
from mcml_service.storage.transaction import Transaction

ROWS = 2000


def seal_rows(tx: Transaction) -> None:
    """Give each row the checksum of its current content. Receipts are compressed again."""
    held = set(inspect(tx.connection).get_table_names())
    for table in (*SEALS, tables.track):
        if table.name in held:
            _seal(tx, table)
    _pack_receipts(tx)


def spoil(tx: Transaction, table: Table, **key: Any) -> None:
    """Let no program read these rows again as if they were sound."""
    chosen = update(table).where(*(table.c[name] == value for name, value in key.items()))
    tx.run(chosen.values({"data_checksum" if table is tables.track else "checksum": -1}))


def _seal(tx: Transaction, table: Table) -> None:
    keys = [column.name for column in table.primary_key]
    names = tuple(column.name for column in table.columns if "checksum" not in column.name)
    for rows in _batches(tx, table, names, keys):
        made, values = add_checksums(table, names, rows)
        sums = made[len(names) :]
        places = [names.index(key) for key in keys]
        statement = update(table).where(*(table.c[key] == bindparam(f"key_{key}") for key in keys))
        statement = statement.values({name: bindparam(f"new_{name}") for name in sums})
        tx.run(
            statement,
            [
                {f"key_{key}": row[place] for key, place in zip(keys, places, strict=True)}
                | {f"new_{name}": value for name, value in zip(sums, row[len(names) :], strict=True)}
                for row in values
            ],
        )


def _batches(tx: Transaction, table: Table, names: Sequence[str], keys: Sequence[str]) -> Iterator[list[Row]]:
    """Yield all rows by their primary key in batches, so that rows being read are not being changed."""
    key = tuple_(*(table.c[name] for name in keys))
    query = select(*(table.c[name] for name in names)).order_by(*(table.c[name] for name in keys)).limit(ROWS)
    last: tuple[Any, ...] | None = None
    while True:
        rows = [tuple(row) for row in tx.fetch_all(query if last is None else query.where(key > last))]
        if not rows:
            return
        yield rows
        last = tuple(rows[-1][list(names).index(name)] for name in keys)


def _pack_receipts(tx: Transaction) -> None:
    for rows in _batches(tx, tables.document, ("id", "receipt"), ["id"]):
        for key, receipt in rows:
            if receipt:
                text = zstandard.ZstdDecompressor().decompress(receipt)
                made = zstandard.ZstdCompressor(level=3, write_checksum=True).compress(text)
                tx.run(update(tables.document).where(tables.document.c.id == key).values(receipt=made))
