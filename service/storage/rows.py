"""Elements as rows in document order (pre, size, level), and back."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
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


@dataclass(frozen=True)
class SkeletonRows:
    """A skeleton as the store has it. hash: of its content; equal trees have equal ones."""

    hash: str
    rows: tuple[dict[str, Any], ...]


def skeleton_rows(forest: Sequence[Element]) -> SkeletonRows:
    """The rows of the `root` element, where there is one, and the `skeleton` element."""
    rows = to_rows(forest, level=1)
    content = [(row["level"], row["tag"], row["attributes"], row["text"]) for row in rows]
    return SkeletonRows(hashlib.sha256(orjson.dumps(content)).hexdigest(), tuple(rows))
