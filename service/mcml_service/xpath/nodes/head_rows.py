"""The heads of the documents of a group, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mcml_service.xpath.nodes.heads import Head, Subtree
from mcml_service.xpath.nodes.numbering import (
    DOCUMENT_SHIFT,
    IS_ELEMENT,
    IS_TEXT,
    MOTION,
    Bools,
    Ints,
    documents_of,
    slots_of,
)
from mcml_service.xpath.nodes.pairs import expand
from mcml_service.xpath.nodes.stored import Stored
from mcml_service.xpath.nodes.texts import Strings

Some: TypeAlias = NDArray[np.signedinteger[Any]]
"""Numbers of rows; those of all rows of a group are kept in 32 bits."""

MCML_ROW = 1
"""Behind the document node."""


class HeadRows(Stored):
    """The heads of a group as one table: kinds, names, parents and ends by row, those of a document from its start on,
    its motion from `motions` on.

    parts: of each document, in order: the document node and `mcml` first, the motion last.
    """

    STORED = ("starts", "motions", "kinds", "names", "parents", "ends", "codes", "values")

    starts: Ints
    motions: Ints
    kinds: NDArray[np.int8]
    names: NDArray[np.int16]
    parents: Some
    ends: Some
    codes: Some
    values: list[str]

    def __init__(self, parts: Sequence[tuple[Subtree, ...]]) -> None:
        every = [part for some in parts for part in some]
        sizes = np.array([len(part) for part in every], np.int64)
        ends = np.cumsum(sizes)
        counts = np.array([len(some) for some in parts], np.int64)
        firsts = np.cumsum(counts) - counts
        places: Ints = np.concatenate([[0], ends]).astype(np.int64)
        self.codes, self.values = _texts(every)
        self.starts = np.append(places[firsts], places[-1])
        self.motions = places[firsts + counts - 1]
        self.kinds = _joined([part.kinds for part in every], np.int8)
        self.names = _joined([part.names for part in every], np.int16)
        document = np.repeat(np.arange(len(parts)), counts)
        within = _joined([part.parents for part in every], np.int64)
        # Nodes without a parent in their part are children of `mcml`; the document node is its own parent here, and the
        # parent axis leaves it out.
        above = np.repeat(self.starts[document] + MCML_ROW, sizes)
        above[self.starts[:-1]] = self.starts[:-1]
        self.parents = np.where(within < 0, above, within + np.repeat(places[:-1], sizes)).astype(np.int32)
        last = _joined([part.ends for part in every], np.int64) + np.repeat(places[:-1], sizes)
        for row in (0, MCML_ROW):
            last[self.starts[:-1] + row] = self.starts[1:] - 1
        self.ends = last.astype(np.int32)
        self._begin()

    def _begin(self) -> None:
        self._heads: dict[int, Head] = {}
        self._named: dict[int, Ints] = {}
        self._by_parent: dict[int, tuple[Ints, Ints]] = {}

    @property
    def nbytes(self) -> int:
        """About how much memory it takes."""
        return 17 * len(self.kinds) + 100 * len(self.values) + 24 * len(self.starts)

    @cached_property
    def texts(self) -> Strings:
        """The strings of all attributes, texts and namespace nodes, "" for other rows."""
        return Strings(self.codes, self.values)

    @cached_property
    def _documents(self) -> Some:
        return np.repeat(np.arange(len(self.motions), dtype=np.int16), np.diff(self.starts))

    def rows(self, nodes: Ints) -> Ints:
        documents, slots = documents_of(nodes), slots_of(nodes)
        rows = self.starts[documents] + slots
        moving = np.flatnonzero(slots >= MOTION)
        rows[moving] += (self.motions - self.starts[:-1] - MOTION)[documents[moving]]
        return rows

    def nodes(self, rows: Some) -> Ints:
        """The numbers of the nodes in rows."""
        documents = self._documents[rows].astype(np.int64)
        slots = rows - self.starts[documents]
        moving = np.flatnonzero(rows >= self.motions[documents])
        slots[moving] += (MOTION + self.starts[:-1] - self.motions)[documents[moving]]
        return np.asarray((documents << DOCUMENT_SHIFT) | slots, np.int64)

    def head(self, document: int) -> Head:
        """The head of one document alone."""
        if document not in self._heads:
            start, stop = int(self.starts[document]), int(self.starts[document + 1])
            rows = slice(start, stop)
            parents, ends = (each[rows].astype(np.int64) - start for each in (self.parents, self.ends))
            parents[0] = -1
            texts = self.texts[np.arange(start, stop)].list()
            self._heads[document] = Head(Subtree(self.kinds[rows], self.names[rows], parents, ends, texts))
        return self._heads[document]

    @cached_property
    def text_rows(self) -> Ints:
        """The rows of all texts, ascending."""
        return np.flatnonzero(self.kinds == IS_TEXT)

    def children_named(self, code: int, rows: Ints) -> tuple[Ints, Ints]:
        """(index into rows, row) of the children of a name, in order."""
        if code not in self._by_parent:
            named = self.named(code)
            order = np.argsort(self.parents[named], kind="stable")
            self._by_parent[code] = self.parents[named][order], named[order]
        parents, children = self._by_parent[code]
        begin = np.searchsorted(parents, rows, side="left")
        source, within = expand(np.searchsorted(parents, rows, side="right") - begin)
        return source, children[begin[source] + within]

    def leaves(self, rows: Ints) -> Bools:
        """Tell which rows are elements with only a text, like most of a head: the text comes after the namespace
        node, two rows later.
        """
        return np.asarray(
            (self.ends[rows] == rows + 2) & (self.kinds[np.minimum(rows + 2, len(self.kinds) - 1)] == IS_TEXT)
        )

    def addresses(self, rows: Ints) -> list[str]:
        """The canonical addresses of nodes."""
        documents = np.searchsorted(self.starts, rows, side="right") - 1
        within = (rows - self.starts[documents]).tolist()
        heads = [self.head(place) for place in documents.tolist()]
        return [head.addresses.get(row) or head.address(row) for head, row in zip(heads, within, strict=True)]

    def named(self, code: int) -> Ints:
        """The rows of all elements of a name, ascending."""
        if code not in self._named:
            self._named[code] = np.flatnonzero((self.names == code) & (self.kinds == IS_ELEMENT))
        return self._named[code]


def _joined(parts: list[np.ndarray], kind: type) -> np.ndarray:
    return np.concatenate([*parts, np.empty(0, kind)]).astype(kind, copy=False)


def _texts(parts: Sequence[Subtree]) -> tuple[Some, list[str]]:
    places: dict[str, int] = {}
    known: dict[int, Some] = {}
    for part in parts:
        if id(part) not in known:
            own = part.strings
            codes = np.array([places.setdefault(text, len(places)) for text in own.values], np.int32)
            known[id(part)] = codes[own.codes]
    found: Any = _joined([known[id(part)] for part in parts], np.int32)
    return found, list(places)
