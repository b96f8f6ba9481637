"""Restore rows of an earlier commit: rows that were valid then become valid again, and nothing else is written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import and_, insert, literal, select, update

from mcml_service.storage.core.schema import CURRENT
from mcml_service.storage.core.seals import carry_checksum, closing
from mcml_service.storage.core.tables import REVISIONED
from mcml_service.storage.core.validity import valid

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement, Table

    from mcml_service.storage.documents.documents import StoredDocument
    from mcml_service.storage.transaction import Transaction


def copy_rows(tx: Transaction, table: Table, *which: ColumnElement[bool]) -> None:
    """Copy closed rows, valid from this transaction's commit on; the copies are invisible before `show_copies`."""
    made = {"from_commit": literal(tx.commit), "to_commit": literal(-1), "checksum": carry_checksum(table, tx.commit)}
    names = [column.name for column in table.columns if column.name not in (*made, "id")]
    copies = select(*(table.c[name] for name in names), *made.values()).where(*which)
    tx.run(insert(table).from_select([*names, *made], copies))


def show_copies(tx: Transaction, table: Table, stored: StoredDocument) -> None:
    """Make the copied rows of a document current."""
    copied = and_(table.c.document == stored.key, table.c.to_commit == -1)
    tx.run(update(table).where(copied).values(to_commit=CURRENT))


def reopen_rows(tx: Transaction, stored: StoredDocument, at: int) -> None:
    """Make the rows of a document that were valid at commit `at` current, from this transaction's commit on.

    Rows that are still current do not change, so a restore writes only later changes.
    """
    now = tx.commit
    for table in REVISIONED:
        of_document = table.c.document == stored.key
        current = table.c.to_commit == CURRENT
        # Rows that were closed since are copied first, so that closing the present ones cannot catch the copies.
        copy_rows(tx, table, of_document, valid(table, at), table.c.to_commit != CURRENT)
        later = and_(of_document, current, table.c.from_commit > at)
        tx.run(update(table).where(later).values(closing(table, now)))
        show_copies(tx, table, stored)
    header_now = tx.heads.header(stored.key)
    tx.heads.refresh_properties(stored.key, header_now)
