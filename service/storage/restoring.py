"""Bringing rows of an earlier commit back: what was valid then becomes valid again, and nothing else is written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import and_, insert, literal, select, update

from service.storage.moments import valid
from service.storage.tables import (
    CURRENT,
    bone,
    content,
    frame_run,
    header,
    shape_run,
    span,
    timeline,
    track,
)

if TYPE_CHECKING:
    from service.storage.database import Transaction
    from service.storage.documents import StoredDocument

REVISIONED = (content, header, bone, timeline, frame_run, shape_run, span, track)


def reopen_rows(tx: Transaction, stored: StoredDocument, at: int) -> None:
    """Make the rows of a document that were valid at commit `at` current, from this transaction's commit on.

    Rows that are still current stay as they are, so a restore writes only what changed since.
    """
    now = tx.commit
    for table in REVISIONED:
        of_document = table.c.document == stored.key
        current = table.c.to_commit == CURRENT
        names = [column.name for column in table.columns if column.name not in ("from_commit", "to_commit", "id")]
        # Rows that were closed since are copied first, so that closing the present ones cannot catch the copies.
        copies = select(
            *(table.c[name] for name in names), literal(now).label("from_commit"), literal(-1).label("to_commit")
        ).where(of_document, valid(table, at), table.c.to_commit != CURRENT)
        tx.connection.execute(insert(table).from_select([*names, "from_commit", "to_commit"], copies))
        later = and_(of_document, current, table.c.from_commit > at)
        tx.connection.execute(update(table).where(later).values(to_commit=now))
        tx.connection.execute(update(table).where(of_document, table.c.to_commit == -1).values(to_commit=CURRENT))
    header_now = tx.heads.header(stored.key)
    tx.heads.refresh_properties(stored.key, header_now)
