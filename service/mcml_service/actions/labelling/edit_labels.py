"""Labels changed one by one, by query, and as tables."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from mcml.errors import DocumentError, NotFoundError, Place
from mcml.language import motion_names
from mcml_schemas.querying.queries import QueryRequest, RunItem
from mcml_service.actions.editing.frame_splicing import check_range
from mcml_service.actions.editing.whole_document import add_labels
from mcml_service.cells import read_cell, safe_cell
from mcml_service.storage.database import Database
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.spans import StoredSpan
from mcml_service.storage.lists.filtering import DocumentFilter
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.queries import Queries

HEADINGS = ("document", "label", "first", "last")


def change_label(
    tx: Transaction,
    stored: StoredDocument,
    key: int,
    *,
    name: str | None = None,
    first: int | None = None,
    last: int | None = None,
    split: int | None = None,
    strict: bool = False,
) -> list[StoredSpan]:
    """Give a label another name or other frames, or split it before the frame `split`. Answers what it has become."""
    current = next((span for span in tx.spans.of(stored.key) if span.key == key), None)
    if current is None:
        raise NotFoundError(f"The document has no label {key}.", remedy="List its labels; numbers change with edits.")
    wanted = current.name if name is None else motion_names.canonical(name, strict=strict)
    start, end = current.first if first is None else first, current.last if last is None else last
    check_range(stored, start, end)
    ranges = [(start, end)]
    if split is not None:
        if not start < split <= end:
            raise DocumentError(
                f"The label is on frames {start} to {end}; it cannot be split before frame {split}.",
                remedy=f"Split it before a frame from {start + 1} to {end}.",
            )
        ranges = [(start, split - 1), (split, end)]
    tx.spans.close([current.key])
    rows = [{"name": wanted, "rank": current.rank, "first": a, "last": b} for a, b in ranges]
    tx.spans.write(stored.key, rows, tx.commit)
    tx.documents.add_revision(
        stored, "label", f"{current.name} {current.first}-{current.last}: {_describe(wanted, ranges)}"
    )
    return [span for span in tx.spans.of(stored.key) if (span.name, span.rank) == (wanted, current.rank)
            and (span.first, span.last) in ranges]  # fmt: skip


def name_frames(tx: Transaction, stored: StoredDocument, name: str, first: int, last: int) -> list[str]:
    """Add a label to frames first to last that do not have it already; the caller makes the revision.

    Returns a description.
    """
    wanted = motion_names.canonical(name)
    if any((span.name, span.first, span.last) == (wanted, first, last) for span in tx.spans.of(stored.key)):
        return []
    tx.spans.add(stored.key, wanted, first, last)
    return [f"named {wanted} {first}-{last}"]


def _describe(name: str, ranges: Iterable[tuple[int, int]]) -> str:
    return f"{name} {', '.join(f'{first}-{last}' for first, last in ranges)}"


def label_by_query(
    database: Database,
    queries: Queries,
    request: QueryRequest,
    name: str,
    *,
    author: str,
    remove: bool,
    strict: bool,
    instead_of: str | None = None,
) -> list[StoredDocument]:
    """Name the frames that an expression selects, or take the name off them. One transaction; answers what changed.

    instead_of: a name that is taken off the same frames.
    """
    wanted = motion_names.canonical(name, strict=strict)
    other = None if instead_of is None else motion_names.canonical(instead_of)
    runs: dict[str, list[tuple[int, int, int]]] = {}
    cursor: str | None = None
    while True:
        answer = queries.answer(request.model_copy(update={"as_": "runs", "cursor": cursor, "limit": 1000}))
        for item in answer.items or ():
            if isinstance(item, RunItem):
                runs.setdefault(item.document, []).append((item.first, item.last, item.revision))
        cursor = answer.next_cursor
        if cursor is None:
            break
    changed = []
    with database.write(author) as tx:
        for uuid, frame_ranges in runs.items():
            stored = tx.documents.get(uuid)
            tx.documents.lock(stored.key)
            stored = tx.documents.get(uuid)
            if any(revision != stored.revision for _, _, revision in frame_ranges):
                raise DocumentError(f"{stored.name} was edited meanwhile.", remedy="Repeat the request.")
            ranges = [(first, last) for first, last, _ in frame_ranges]
            touched = other not in (None, wanted) and _take_off(tx, stored, other, ranges)
            touched |= (_take_off if remove else _put_on)(tx, stored, wanted, ranges)
            if touched:
                tx.documents.add_revision(stored, "unlabel" if remove else "label", f"{wanted} by query")
                changed.append(tx.documents.get(uuid))
    return changed


def _put_on(tx: Transaction, stored: StoredDocument, name: str, ranges: list[tuple[int, int]]) -> bool:
    """Name the frames of the ranges that do not carry the name already."""
    added = False
    for first, last in ranges:
        position = first
        for span in [*sorted(s for s in tx.spans.of(stored.key, first, last) if s.name == name), None]:
            end = last if span is None else span.first - 1
            if position <= end:
                tx.spans.add(stored.key, name, position, end)
                added = True
            if span is not None:
                position = max(position, span.last + 1)
    return added


def _take_off(tx: Transaction, stored: StoredDocument, name: str, ranges: list[tuple[int, int]]) -> bool:
    touched = False
    for first, last in ranges:
        for span in tx.spans.of(stored.key, first, last):
            if span.name != name:
                continue
            touched = True
            tx.spans.close([span.key])
            left = [(span.first, first - 1), (last + 1, span.last)]
            rows = [{"name": name, "rank": span.rank, "first": a, "last": b} for a, b in left if a <= b]
            tx.spans.write(stored.key, rows, tx.commit)
    return touched


def label_rows(tx: Transaction, documents: Iterable[StoredDocument]) -> Iterator[tuple[str, str, int, int]]:
    """The labels of documents: document, label, first, last."""
    for stored in documents:
        for span in tx.spans.of(stored.key):
            yield stored.uuid, span.name, span.first, span.last


def label_table(rows: Iterable[tuple[str, str, int, int]], *, raw: bool = False) -> str:
    """Rows of labels as CSV; `write_label_table` reads it again.

    raw: do not escape names that spreadsheets read as formulas.
    """
    shown = str if raw else safe_cell
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(HEADINGS)
    writer.writerows((document, shown(name), first, last) for document, name, first, last in rows)
    return text.getvalue()


@dataclass(frozen=True)
class _Line:
    number: int
    document: str
    label: tuple[str, int, int]


def write_label_table(
    tx: Transaction, content: bytes, project: str | None = None, *, strict: bool = False, replace: bool = False
) -> list[StoredDocument]:
    """Import labels of many documents from a CSV table; all or none.

    Returns the changed documents; existing labels are not added again.

    Columns: `document` (an id) or `name`, `label`, `first`, `last`. replace: delete the existing labels of the
    documents in the table. Raises DocumentError with the line.
    """
    key, lines = _parse_table(content)
    by_document: dict[str, list[_Line]] = {}
    for line in lines:
        by_document.setdefault(line.document, []).append(line)
    changed = []
    for document, mine in by_document.items():
        stored = _document(tx, document, key, mine[0].number, project)
        tx.documents.lock(stored.key)
        for line in mine:
            _, first, last = line.label
            if not 1 <= first <= last <= stored.frames:
                raise DocumentError(
                    f"Frames {first} to {last} are not in a document of {stored.frames} frames.",
                    at=Place(line=line.number),
                    remedy="Frame numbers are positions, from 1, both ends included.",
                )
        spans = {(span.name, span.first, span.last): span.key for span in tx.spans.of(stored.key)}
        labels = [line.label for line in mine]
        wanted = [(motion_names.canonical(name, strict=strict), first, last) for name, first, last in labels]
        gone = [key for label, key in spans.items() if label not in wanted] if replace else []
        new = [label for label in dict.fromkeys(wanted) if label not in spans]
        if new or gone:
            tx.spans.close(gone)
            if not add_labels(tx, stored, new, strict=strict):
                tx.documents.add_revision(stored, "unlabel", "labels of a table")
            changed.append(tx.documents.get(stored.uuid))
    return changed


def _document(tx: Transaction, text: str, key: str, line: int, project: str | None) -> StoredDocument:
    if key == "document":
        document = tx.documents.find(text)
        matches = [document] if document else []
    else:
        matches = tx.documents.page(DocumentFilter(project=project, name=text), after=None, limit=2)
    if len(matches) != 1:
        reason = f"More than one document is named {text!r}." if matches else f"There is no document {text!r}."
        raise DocumentError(reason, at=Place(line=line), remedy="Use ids in a column `document`.")
    return matches[0]


def _parse_table(content: bytes) -> tuple[str, list[_Line]]:
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DocumentError("The table is not UTF-8.", remedy="Save it as CSV in UTF-8.") from error
    head = text.partition("\n")[0]
    rows = csv.reader(io.StringIO(text), delimiter=max(",;\t", key=head.count))
    names = [cell.strip().lower() for cell in next(rows, [])]
    key = next((name for name in ("document", "name") if name in names), "")
    if not key or not {"label", "first", "last"} <= set(names):
        raise DocumentError(
            "The table lacks a column.", at=Place(line=1), remedy="Begin with a line: document,label,first,last"
        )
    lines = []
    for number, cells in enumerate(rows, 2):
        if not any(read_cell(cell.strip()) for cell in cells):
            continue
        row = dict(zip(names, (read_cell(cell.strip()) for cell in cells), strict=False))
        if not (row.get(key) and row.get("label") and row.get("first", "").isdigit() and row.get("last", "").isdigit()):
            raise DocumentError(
                "The line does not say document, label, first and last.",
                at=Place(line=number),
                remedy="Frames are whole numbers, positions from 1.",
            )
        lines.append(_Line(number, row[key], (row["label"], int(row["first"][:12]), int(row["last"][:12]))))
    return key, lines
