"""Revert the changes of one commit to a document, while later commits stay.

The smallest unit is a row. It can be reverted as long as no later commit has changed it. The content (one row for each
revision) and the header (always written as a whole) are compared value by value, and tracks sample by sample.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sqlalchemy import and_, literal, select, update

from mcml.errors import ConflictError
from mcml_service.storage.core.schema import CURRENT
from mcml_service.storage.core.seals import closing
from mcml_service.storage.core.tables import (
    CLOSED_TRACK,
    REVISIONED,
    content,
    frame_run,
    header,
    shape_run,
    span,
    timeline,
    track,
)
from mcml_service.storage.core.validity import valid
from mcml_service.storage.documents.document_statements import CONTENT
from mcml_service.storage.undo.restoring import copy_rows, show_copies
from mcml_service.storage.undo.undoing_samples import take_back_shapes, take_back_tracks

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement, Table

    from mcml_service.storage.documents.documents import StoredDocument
    from mcml_service.storage.transaction import Transaction

_BY_POSITION = (span, frame_run)
"""Rows with positions of frames: wrong after frames before them are inserted or deleted."""

Row = dict[str, Any]


def undo_rows(tx: Transaction, stored: StoredDocument, at: int) -> None:
    """Make the rows that commit `at` closed current again, in place of those it wrote.

    ConflictError where a later commit has touched them.
    """
    moved = _touches(tx, timeline, stored, at)
    moved_since = _order(tx, stored, at) != _order(tx, stored, CURRENT - 1)
    for table in REVISIONED:
        if table in (content, header):
            continue
        if moved and table in _BY_POSITION and _has_changed_since(tx, table, stored, at):
            raise _make_conflict("frames came or went, and their names or ids were changed")
        if moved_since and table in _BY_POSITION and _touches(tx, table, stored, at):
            raise _make_conflict("names or ids of frames were changed, and frames came or went")
        if table in (track, shape_run) and _is_touched(tx, table, stored, at):
            _take_back_samples(tx, table, stored, at)
        else:
            _take_back(tx, table, stored, at)
    _merge_header(tx, stored, at)
    _merge_content(tx, stored, at)


def _make_conflict(what: str) -> ConflictError:
    return ConflictError(
        f"The revision cannot be reverted alone: {what} since.",
        remedy="Take the later revisions back first, or restore an earlier one as a whole.",
    )


def _rows(tx: Transaction, table: Table, stored: StoredDocument, *conditions: Any) -> list[Row]:
    # Numbers of tracks are not needed here, only which they are.
    columns = [column for column in table.columns if column.name != "data"]
    rows = tx.fetch_all(select(*columns).where(table.c.document == stored.key, *conditions))
    return [dict(row._mapping) for row in rows]


def _find_written(tx: Transaction, table: Table, stored: StoredDocument, at: int) -> list[Row]:
    return _rows(tx, table, stored, table.c.from_commit == at)


def _find_closed(tx: Transaction, table: Table, stored: StoredDocument, at: int) -> list[Row]:
    return _rows(tx, table, stored, *_is_closed_at(table, at))


def _is_closed_at(table: Table, at: int) -> list[ColumnElement[bool]]:
    conditions = [table.c.to_commit == at, table.c.from_commit < at]
    return [CLOSED_TRACK, *conditions] if table is track else conditions


def _touches(tx: Transaction, table: Table, stored: StoredDocument, at: int) -> bool:
    return bool(_find_written(tx, table, stored, at) or _find_closed(tx, table, stored, at))


def _has_changed_since(tx: Transaction, table: Table, stored: StoredDocument, at: int) -> bool:
    later = (table.c.from_commit > at) | ((table.c.to_commit > at) & (table.c.to_commit != CURRENT))
    query = select(literal(1)).where(table.c.document == stored.key, later).limit(1)
    return tx.fetch_one(query) is not None


def _take_back(tx: Transaction, table: Table, stored: StoredDocument, at: int) -> None:
    written, closed = _find_written(tx, table, stored, at), _find_closed(tx, table, stored, at)
    if not written and not closed:
        return
    subject = {"track": "values", "span": "motion names", "bone": "bones"}.get(table.name, "frames")
    if any(row["to_commit"] not in (CURRENT, at) for row in written):
        raise _make_conflict(f"{subject} it set were changed")
    keys = _keys(table)
    if keys:
        later = _rows(tx, table, stored, table.c.from_commit > at, table.c.to_commit == CURRENT)
        if {_key(row, keys) for row in closed} & {_key(row, keys) for row in later}:
            raise _make_conflict(f"{subject} it took away were set")
    of_document = table.c.document == stored.key
    copy_rows(tx, table, of_document, *_is_closed_at(table, at))
    mine = and_(of_document, table.c.from_commit == at, table.c.to_commit == CURRENT)
    tx.run(update(table).where(mine).values(closing(table, tx.commit)))
    show_copies(tx, table, stored)


def _is_touched(tx: Transaction, table: Table, stored: StoredDocument, at: int) -> bool:
    """Whether a later commit has written one of the rows that the commit wrote or closed."""
    written, closed = _find_written(tx, table, stored, at), _find_closed(tx, table, stored, at)
    if any(row["to_commit"] not in (CURRENT, at) for row in written):
        return True
    keys = _keys(table)
    later = _rows(tx, table, stored, table.c.from_commit > at, table.c.to_commit == CURRENT) if closed else []
    return not {_key(row, keys) for row in closed}.isdisjoint(_key(row, keys) for row in later)


def _take_back_samples(tx: Transaction, table: Table, stored: StoredDocument, at: int) -> None:
    """As `_take_back`, sample by sample: other ones of the same rows may have been set since."""
    try:
        if table is track:
            rows = _find_written(tx, table, stored, at) + _find_closed(tx, table, stored, at)
            take_back_tracks(tx, stored, at, {(row["chunk"], row["bone"]) for row in rows})
        else:
            was, became, now = (
                [(row["slot"], row["count"], row["shape"]) for row in _at(tx, table, stored, commit)]
                for commit in (at - 1, at, CURRENT - 1)
            )
            take_back_shapes(tx, stored, (was, became, now))
    except LookupError:
        raise _make_conflict("values it set were changed") from None


def _keys(table: Table) -> list[str]:
    return [column.name for column in table.primary_key if column.name not in ("document", "from_commit", "id")]


def _key(row: Row, names: list[str]) -> tuple[Any, ...]:
    return tuple(row[name] for name in names)


def _at(tx: Transaction, table: Table, stored: StoredDocument, commit: int) -> list[Row]:
    return _rows(tx, table, stored, valid(table, commit))


def _order(tx: Transaction, stored: StoredDocument, commit: int) -> list[tuple[Any, ...]]:
    """Where the frames of the document lay."""
    return sorted(_key(row, ["first", "slot", "count"]) for row in _at(tx, timeline, stored, commit))


def _merge_header(tx: Transaction, stored: StoredDocument, at: int) -> None:
    """Return the header with the elements that the commit changed in their earlier form, others unchanged."""
    if not _find_written(tx, header, stored, at) and not _find_closed(tx, header, stored, at):
        return
    values = ("size", "level", "tag", "attributes", "text")
    before, after, now = (
        {row["pre"]: _key(row, list(values)) for row in _at(tx, header, stored, commit)}
        for commit in (at - 1, at, CURRENT - 1)
    )
    if [row[:3] for row in before.values()] != [row[:3] for row in after.values()] and now != after:
        raise _make_conflict("the header was changed")
    if len(before) == len(after):
        changed = {pre for pre in before if before[pre] != after[pre]}
        if len(now) != len(after) or any(now[pre] != after[pre] for pre in changed):
            raise _make_conflict("elements of the header it set were changed")
        wanted = {pre: before[pre] if pre in changed else now[pre] for pre in now}
    else:
        wanted = before
    rows = [{"pre": pre, **dict(zip(values, row, strict=True))} for pre, row in sorted(wanted.items())]
    tx.heads.write_header_rows(stored.key, rows)


def _merge_content(tx: Transaction, stored: StoredDocument, at: int) -> None:
    """Return the earlier values of skeleton, frames, frame time … that the commit changed."""
    ((before,), (after,), (now,)) = (_at(tx, content, stored, commit) for commit in (at - 1, at, CURRENT - 1))
    merged = {}
    for name in CONTENT:
        if name == "intact":
            continue
        if before[name] != after[name]:
            if now[name] != after[name]:
                raise _make_conflict(f"its {name.replace('_', ' ')} was changed")
            merged[name] = before[name]
    # Without later changes, everything is as before the commit.
    intact = bool(before["intact"]) and tx.documents.commit_of(stored.key, stored.revision) == at
    tx.documents.write_content(stored.key, tx.commit, **merged, intact=intact)
