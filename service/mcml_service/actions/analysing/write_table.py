"""A table of a result as CSV."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import Any

from mcml.errors import UnsupportedError
from mcml_service.actions.exporting.write_tables import About, batches_of, write_csv
from mcml_service.storage.work.results import StoredPart


def write_table(part: StoredPart) -> Iterator[bytes]:
    """Write the rows of a table as CSV: names of columns with units in parentheses, unknown values empty.

    Lists within a cell are JSON. Raises UnsupportedError for a part that is no table.
    """
    if part.kind != "table":
        raise UnsupportedError(f"{part.name!r} is a {part.kind}, no table.", remedy="Ask for it as JSON.")
    columns, rows = part.data["columns"], part.data["rows"]
    names = [f"{each['name']} ({each['unit']})" if each.get("unit") else str(each["name"]) for each in columns]
    has_text = [any(isinstance(row[place], str | list | dict) for row in rows) for place in range(len(names))]
    if not rows:
        return write_csv(iter([{name: [] for name in names}]), About())
    return write_csv(batches_of((_cells(row, has_text) for row in rows), names), About())


def _cells(row: Sequence[Any], has_text: Sequence[bool]) -> tuple[Any, ...]:
    """Cells of a row. Columns with a text have texts alone, so that none is run by a spreadsheet."""
    return tuple(_text(value) if text else value for value, text in zip(row, has_text, strict=True))


def _text(value: Any) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
