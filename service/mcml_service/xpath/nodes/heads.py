"""The head of a document, all that is not in a frame, as arrays of nodes in document order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from mcml.language.addresses import address_attribute, address_namespace, address_text, number_steps
from mcml.language.elements import Element, mcml_attributes
from mcml.language.vocabulary import MCML, MOTION
from mcml.language.writer import attribute_bytes, text_bytes
from mcml_service.xpath.nodes.numbering import (
    IS_ATTRIBUTE,
    IS_DOCUMENT,
    IS_ELEMENT,
    IS_NAMESPACE,
    IS_TEXT,
    code_names,
    name_codes,
)
from mcml_service.xpath.nodes.texts import Strings, of_texts

XML_NAMESPACE = "http://www.w3.org/XML/1998/namespace"


@dataclass(frozen=True)
class Subtree:
    """Nodes in document order, each element followed by its namespace node, its attributes, its text, its children.

    kinds, names: as in `numbering`. parents: the row of the parent, below 0 for nodes whose parent is outside. ends:
    the last row inside each node. texts: the string of attributes and texts, "" for others.
    """

    kinds: NDArray[np.int8]
    names: NDArray[np.int16]
    parents: NDArray[np.int64]
    ends: NDArray[np.int64]
    texts: list[str]

    def __len__(self) -> int:
        return len(self.texts)

    @property
    def nbytes(self) -> int:
        """About how much memory it takes."""
        return 500 + 60 * len(self.texts)

    @cached_property
    def strings(self) -> Strings:
        """The texts, each different one once."""
        return of_texts(self.texts)


@dataclass(frozen=True, slots=True)
class Head:
    """Rows of the document node, `mcml` and all before the motion; then the motion without frames.

    addresses: cached addresses of elements, by row.
    """

    part: Subtree
    addresses: dict[int, str] = field(default_factory=dict)
    _kept: list[tuple[list[int], list[str], list[int]]] = field(default_factory=list)

    def address(self, row: int) -> str:
        """The canonical address of the node in a row, an XPath that finds it.

        An element that has siblings of its name is numbered among them.
        """
        known = self.addresses.get(row)
        if known is not None:
            return known
        kinds, names, ends = self._lists()
        kind = kinds[row]
        if kind == IS_DOCUMENT:
            return "/"
        parent = int(self.part.parents[row])
        above = self.address(parent).rstrip("/")
        if kind in (IS_ATTRIBUTE, IS_TEXT):
            return address_attribute(above, names[row]) if kind == IS_ATTRIBUTE else address_text(above)
        if kind == IS_NAMESPACE:
            return address_namespace(above)
        siblings = []
        child = parent + 1
        while child <= ends[parent]:
            if kinds[child] == IS_ELEMENT:
                siblings.append(child)
            child = ends[child] + 1
        steps = number_steps([names[sibling] for sibling in siblings])
        self.addresses.update((sibling, f"{above}/{step}") for sibling, step in zip(siblings, steps, strict=True))
        return self.addresses[row]

    def xml(self, row: int) -> str:
        """An element outside of the motion, with all it holds."""
        kinds, names, ends = self._lists()
        parts: list[str] = []
        open_: list[tuple[int, str]] = []
        in_tag = False
        for place in range(row, ends[row] + 1):
            while open_ and place > open_[-1][0]:
                parts.append("/>" if in_tag else f"</{open_[-1][1]}>")
                open_.pop()
                in_tag = False
            kind, text = kinds[place], self.part.texts[place]
            if kind == IS_ATTRIBUTE:
                parts.append(f' {names[place]}="{attribute_bytes(text).decode()}"')
            elif kind == IS_TEXT:
                parts.append(">" * in_tag + text_bytes(text).decode())
                in_tag = False
            elif kind == IS_ELEMENT:
                parts.append(">" * in_tag + f"<{names[place]}")
                in_tag = True
                open_.append((ends[place], names[place]))
        while open_:
            parts.append("/>" if in_tag else f"</{open_.pop()[1]}>")
            if in_tag:
                open_.pop()
                in_tag = False
        return "".join(parts)

    def _lists(self) -> tuple[list[int], list[str], list[int]]:
        """Kinds, names and ends of all rows: single items of lists are read much faster than those of arrays."""
        if not self._kept:
            known = code_names()
            names = [known[code] for code in self.part.names.tolist()]
            self._kept.append((self.part.kinds.tolist(), names, self.part.ends.tolist()))
        return self._kept[0]


def flatten(forest: Sequence[Element]) -> Subtree:
    """The nodes of trees, their roots without a parent."""
    codes = name_codes()
    kinds: list[int] = []
    names: list[int] = []
    parents: list[int] = []
    ends: list[int] = []
    texts: list[str] = []

    def add(kind: int, name: int, parent: int, text: str) -> int:
        kinds.append(kind)
        names.append(name)
        parents.append(parent)
        ends.append(len(texts))
        texts.append(text)
        return len(texts) - 1

    stack: list[tuple[Element | None, int]] = [(tree, -1) for tree in reversed(forest)]
    while stack:
        element, parent = stack.pop()
        if element is None:
            ends[parent] = len(texts) - 1
            continue
        row = add(IS_ELEMENT, codes[element.tag], parent, "")
        add(IS_NAMESPACE, codes["xml"], row, XML_NAMESPACE)
        for name, value in element.attributes.items():
            add(IS_ATTRIBUTE, codes[name], row, value)
        if element.text:
            add(IS_TEXT, 0, row, element.text)
        stack.append((None, row))
        stack.extend((child, row) for child in reversed(element.children))
    return Subtree(
        np.array(kinds, np.int8),
        np.array(names, np.int16),
        np.array(parents, np.int64),
        np.array(ends, np.int64),
        texts,
    )


@lru_cache(maxsize=16)
def first_part(version: str) -> Subtree:
    """Document node and `mcml`: the other parts hang from `mcml`, and both end with the last of them."""
    mcml = flatten([Element(MCML, mcml_attributes(version), "", [])])
    return Subtree(
        np.concatenate([np.array([IS_DOCUMENT], np.int8), mcml.kinds]),
        np.concatenate([np.zeros(1, np.int16), mcml.names]),
        np.concatenate([np.array([-1]), np.maximum(mcml.parents + 1, 0)]),
        np.concatenate([np.zeros(1, np.int64), mcml.ends + 1]),
        ["", *mcml.texts],
    )


def motion_part(frames: int, frame_time: str | None) -> Subtree:
    """Return `motion` with its content other than frames."""
    known, rows = _motion(frame_time is not None)
    texts = list(known.texts)
    for row, text in zip(rows, (str(frames), frame_time), strict=False):
        texts[row] = text or ""
    return replace(known, texts=texts)


@lru_cache(maxsize=2)
def _motion(timed: bool) -> tuple[Subtree, list[int]]:
    """One motion, and the rows of its texts."""
    children = [Element(name, {}, "0", []) for name in ("frames", "frametime")[: 1 + timed]]
    made = flatten([Element(MOTION, {}, "", children)])
    return made, np.flatnonzero(made.kinds == IS_TEXT).tolist()
