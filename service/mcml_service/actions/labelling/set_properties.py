"""Properties of many documents from one table."""

from __future__ import annotations

import csv
import io
import re
from dataclasses import dataclass

from mcml.errors import DocumentError, Place
from mcml.files.import_options import parse_property
from mcml.language.elements import to_head
from mcml_service.actions.editing.whole_document import change_document
from mcml_service.cells import read_cell
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.lists.filtering import DocumentFilter
from mcml_service.storage.transaction import Transaction

KEYS = ("document", "name")
"""Allowed first columns: ids of documents, or their names."""

_HEADING = re.compile(r"(?P<name>.+?)\s*(?:[(\[](?P<unit>[^()\[\]]*)[)\]])?\s*")

Property = tuple[str, str, str]


@dataclass(frozen=True)
class Row:
    """A line of the table. line: from 1, for errors."""

    line: int
    document: str
    properties: tuple[Property, ...]


def parse_table(content: bytes) -> tuple[str, list[Row]]:
    """Return the first column ("document" or "name"), and the rows of a CSV table.

    The first line names the columns: `document` or `name`, then properties, each with its unit in parentheses:
    `name,age (year),height (cm)`. Commas, semicolons or tabs between cells; an empty cell keeps a property; a cell such
    as `172 cm` has its own unit. Raises DocumentError with the line.
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DocumentError("The table is not UTF-8.", remedy="Save it as CSV in UTF-8.") from error
    first = text.partition("\n")[0]
    delimiter = max(",;\t", key=first.count)
    lines = list(csv.reader(io.StringIO(text), delimiter=delimiter))
    if not lines or not lines[0] or lines[0][0].strip().lower() not in KEYS:
        raise DocumentError(
            "The first column of the table is neither `document` nor `name`.",
            at=Place(line=1),
            remedy="Begin with a line such as: name,age (year),height (cm)",
        )
    heads = [_HEADING.fullmatch(cell.strip()) for cell in lines[0][1:]]
    if not heads or not all(heads):
        raise DocumentError(
            "A column of the table has no name.", at=Place(line=1), remedy="Name every column after its property."
        )
    named = [(head["name"], head["unit"] or "") for head in heads if head is not None]
    rows = []
    for number, cells in enumerate(lines[1:], 2):
        if not any(cell.strip() for cell in cells):
            continue
        if len(cells) > len(named) + 1:
            raise DocumentError(
                f"The line has {len(cells)} cells, the table {len(named) + 1} columns.",
                at=Place(line=number),
                remedy="Put cells with commas into quotation marks.",
            )
        filled = [(head, cell) for head, cell in zip(named, cells[1:], strict=False) if cell.strip()]
        rows.append(Row(number, read_cell(cells[0].strip()), tuple(_property(*head, cell) for head, cell in filled)))
    return lines[0][0].strip().lower(), rows


def _property(name: str, unit: str, cell: str) -> Property:
    text = read_cell(cell.strip())
    parsed = parse_property(f"{name}={text}")
    return (name, parsed[1], parsed[2]) if parsed[2] else (name, text, unit)


def set_properties(tx: Transaction, content: bytes, project: str | None = None) -> list[StoredDocument]:
    """Set the properties of documents from a table, in addition to existing ones; all or none.

    Returns the changed documents. project: in which documents are looked up by name. Raises DocumentError for an
    unknown or ambiguous name.
    """
    key, rows = parse_table(content)
    changed = []
    for row in rows:
        stored = tx.documents.find(row.document) if key == "document" else _find_named(tx, row, project)
        if stored is None:
            raise DocumentError(
                f"There is no document {row.document!r}.", at=Place(line=row.line), remedy="List the documents."
            )
        tx.documents.lock(stored.key)
        old = {item[0]: item for item in to_head(tx.heads.document(stored)).properties}
        new = old | {item[0]: item for item in row.properties}
        if new != old:
            changed.append(change_document(tx, stored, properties=new.values(), message="properties of a table"))
    return changed


def _find_named(tx: Transaction, row: Row, project: str | None) -> StoredDocument | None:
    documents = tx.documents.page(DocumentFilter(project=project, name=row.document), after=None, limit=2)
    if len(documents) > 1:
        raise DocumentError(
            f"More than one document is named {row.document!r}.",
            at=Place(line=row.line),
            remedy="Say which project, or use ids in a column `document`.",
        )
    return documents[0] if documents else None
