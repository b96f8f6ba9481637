"""Elements as rows in document order (pre, size, level), and back."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from typing import Any

import orjson

from service.mcml.elements import Element


def to_rows(forest: Sequence[Element], level: int) -> list[dict[str, Any]]:
    """Pre-order rows of the trees; `size` counts descendants, `pre` starts at 0, roots have the given level."""
    rows: list[dict[str, Any]] = []
    stack: list[tuple[Element, int, bool]] = [(tree, level, False) for tree in reversed(forest)]
    open_rows: list[int] = []
    while stack:
        element, depth, closing = stack.pop()
        if closing:
            index = open_rows.pop()
            rows[index]["size"] = len(rows) - index - 1
            continue
        open_rows.append(len(rows))
        rows.append(
            {
                "pre": len(rows),
                "size": 0,
                "level": depth,
                "tag": element.tag,
                "attributes": orjson.dumps(element.attributes).decode(),
                "text": element.text,
            }
        )
        stack.append((element, depth, True))
        stack.extend((child, depth + 1, False) for child in reversed(element.children))
    return rows


def to_elements(rows: Iterable[Any]) -> list[Element]:
    """The trees that `to_rows` was given; rows (with .level .tag .attributes .text) in order of `pre`."""
    forest: list[Element] = []
    path: list[Element] = []
    base: int | None = None
    for row in rows:
        element = Element(row.tag, orjson.loads(row.attributes), row.text)
        base = row.level if base is None else base
        del path[row.level - base :]
        (path[-1].children if path else forest).append(element)
        path.append(element)
    return forest


def digest(rows: Sequence[dict[str, Any]]) -> str:
    """SHA-256 of the rows' content: equal trees, equal digests."""
    content = [(row["level"], row["tag"], row["attributes"], row["text"]) for row in rows]
    return hashlib.sha256(orjson.dumps(content)).hexdigest()
