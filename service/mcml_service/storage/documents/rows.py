"""Elements as rows in document order (pre, size, level), and back."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import orjson

from mcml.errors import DamageError
from mcml.language.elements import Element

ELEMENT_COLUMNS: Final = ("pre", "size", "level", "tag", "attributes", "text")

ElementRow: TypeAlias = tuple[int, int, int, str, str, str]
"""The columns ELEMENT_COLUMNS."""


def to_rows(forest: Sequence[Element], level: int) -> list[ElementRow]:
    """Pre-order rows of the trees; `size` counts descendants, `pre` starts at 0, roots have the given level."""
    elements: list[tuple[Element, int]] = []
    stack = [(tree, level) for tree in reversed(forest)]
    while stack:
        element, depth = stack.pop()
        elements.append((element, depth))
        if element.children:
            stack += [(child, depth + 1) for child in reversed(element.children)]
    # From the last one back: how many were seen below each level that no parent has claimed yet.
    sizes: list[int] = []
    seen: Counter[int] = Counter()
    for _, depth in reversed(elements):
        size = seen.pop(depth + 1, 0)
        seen[depth] += size + 1
        sizes.append(size)
    return [
        (
            pre,
            sizes[~pre],
            depth,
            element.tag,
            orjson.dumps(element.attributes).decode() if element.attributes else "{}",
            element.text,
        )
        for pre, (element, depth) in enumerate(elements)
    ]


def to_elements(rows: Iterable[Any]) -> list[Element]:
    """The trees that `to_rows` was given; rows (level, tag, attributes, text) in order of `pre`."""
    forest: list[Element] = []
    path: list[Element] = []
    base: int | None = None
    for level, tag, attributes, text in rows:
        element = Element(tag, orjson.loads(attributes), text)
        base = level if base is None else base
        del path[level - base :]
        (path[-1].children if path else forest).append(element)
        path.append(element)
    return forest


@dataclass(frozen=True)
class SkeletonRows:
    """A skeleton as the store has it. hash: of its content; equal trees have equal ones."""

    hash: str
    rows: tuple[ElementRow, ...]


def skeleton_rows(forest: Sequence[Element]) -> SkeletonRows:
    """Return the rows of the `root` element, if there is one, and the `skeleton` element."""
    rows = to_rows(forest, level=1)
    return SkeletonRows(_hash([row[2:] for row in rows]), tuple(rows))


def to_skeleton(rows: Sequence[Any], hashed: str) -> list[Element]:
    """As `to_elements`. DamageError where the rows have not the hash that was kept of them."""
    if _hash(rows) != hashed:
        raise DamageError(
            "A skeleton is damaged in the store: its elements are not those that were written.",
            remedy="Run `mcml db check`, and restore the store from a backup.",
        )
    return to_elements(rows)


def _hash(rows: Sequence[Any]) -> str:
    """rows: (level, tag, attributes, text)."""
    return hashlib.sha256(orjson.dumps(rows)).hexdigest()
