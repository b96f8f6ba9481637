"""The head of a document, all that is not in a frame, as arrays of nodes in document order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from service.mcml.addresses import address_attribute, address_namespace, address_text, number_steps
from service.mcml.elements import Element, mcml_attributes
from service.mcml.vocabulary import MCML, MOTION
from service.mcml.writer import attribute_bytes, text_bytes
from service.storage.columns import Listed
from service.storage.database import Transaction
from service.xpath.numbering import (
    IS_ATTRIBUTE,
    IS_DOCUMENT,
    IS_ELEMENT,
    IS_NAMESPACE,
    IS_TEXT,
    code_names,
    name_codes,
)

XML_NAMESPACE = "http://www.w3.org/XML/1998/namespace"


@dataclass(frozen=True, slots=True)
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


@dataclass(frozen=True, slots=True)
class Head:
    """Rows of the document node, `mcml` and all before the motion; from row `motion` on, the motion without frames.

    addresses: those of elements that somebody asked for, by row.
    """

    part: Subtree
    motion: int
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


def _assemble(version: str, parts: Sequence[Subtree], frames: int, frame_time: str | None) -> Head:
    before = _frame_of_parts(version)
    motion = _motion(frames, frame_time)
    # `mcml` is in row 1; the document node and it end with the last row.
    offset = len(before)
    pieces = [before]
    for part in parts:
        pieces.append(_moved(part, offset, parent=1))
        offset += len(part)
    pieces.append(_moved(motion, offset, parent=1))
    total = offset + len(motion)
    ends = np.concatenate([piece.ends for piece in pieces])
    ends[:2] = total - 1
    whole = Subtree(
        np.concatenate([piece.kinds for piece in pieces]),
        np.concatenate([piece.names for piece in pieces]),
        np.concatenate([piece.parents for piece in pieces]),
        ends,
        [text for piece in pieces for text in piece.texts],
    )
    return Head(whole, offset)


@lru_cache(maxsize=16)
def _frame_of_parts(version: str) -> Subtree:
    """Document node and `mcml`."""
    mcml = flatten([Element(MCML, mcml_attributes(version), "", [])])
    document = Subtree(np.array([IS_DOCUMENT], np.int8), np.zeros(1, np.int16), np.array([-1]), np.zeros(1, int), [""])
    moved = _moved(mcml, 1, parent=0)
    return Subtree(
        np.concatenate([document.kinds, moved.kinds]),
        np.concatenate([document.names, moved.names]),
        np.concatenate([document.parents, moved.parents]),
        np.concatenate([document.ends, moved.ends]),
        document.texts + moved.texts,
    )


@lru_cache(maxsize=1024)
def _motion(frames: int, frame_time: str | None) -> Subtree:
    children = [Element("frames", {}, str(frames), [])]
    if frame_time is not None:
        children.append(Element("frametime", {}, frame_time, []))
    return flatten([Element(MOTION, {}, "", children)])


def _moved(part: Subtree, offset: int, parent: int) -> Subtree:
    parents = np.where(part.parents < 0, parent, part.parents + offset)
    return replace(part, parents=parents, ends=part.ends + offset)


class Heads:
    """Heads of documents, the parts read before kept: they never change under their keys, so none can be out of date.

    limit: nodes kept, about 100 bytes each. Threads may share it.
    """

    def __init__(self, limit: int = 1 << 20) -> None:
        self._limit = limit
        self._size = 0
        self._heads: dict[tuple[int, int], Head] = {}
        self._skeletons: dict[int, Subtree] = {}

    def read(self, tx: Transaction, documents: Sequence[Listed], *, whole: bool) -> list[Head]:
        """The head of each document. whole: with header and skeleton; else only document, `mcml` and motion."""
        if not whole:
            return [_assemble(stored.version, (), stored.frames, stored.frame_time) for stored in documents]
        known, skeletons = self._heads, self._skeletons
        unread = {listed.key: listed for listed in documents if (listed.key, listed.revision) not in known}
        missing = [key for key in dict.fromkeys(listed.skeleton for listed in unread.values()) if key not in skeletons]
        if not unread:
            return [known[listed.key, listed.revision] for listed in documents]
        forests = {key: flatten(forest) for key, forest in tx.columns.skeletons(missing).items()}
        skeletons = {**skeletons, **forests} if forests else skeletons
        found: dict[tuple[int, int], Head] = {}
        for key, element in tx.columns.headers(list(unread)).items():
            listed = unread[key]
            parts = (flatten([element]), skeletons[listed.skeleton])
            found[key, listed.revision] = _assemble(listed.version, parts, listed.frames, listed.frame_time)
        if found:
            known = {**known, **found}
            self._remember(known, skeletons, sum(len(head.part) for head in found.values()))
        return [known[listed.key, listed.revision] for listed in documents]

    def _remember(self, heads: dict[tuple[int, int], Head], skeletons: dict[int, Subtree], added: int) -> None:
        # Threads that read at the same time may lose what the other read; it is read again when it is needed.
        self._size += added
        if self._size > self._limit:
            self._heads, self._skeletons, self._size = {}, {}, 0
        else:
            self._heads, self._skeletons = heads, skeletons
