"""The heads of the documents of a batch, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from service.xpath.heads import Head
from service.xpath.numbering import DOCUMENT_SHIFT, IS_ELEMENT, IS_TEXT, MOTION, Bools, Ints, documents_of, slots_of
from service.xpath.pairs import expand
from service.xpath.texts import Strings, of_texts


class HeadRows:
    """The heads of a batch as one table: kinds, names, parents and ends by row; `nodes` are ascending."""

    def __init__(self, heads: Sequence[Head]) -> None:
        sizes = [len(head.part) for head in heads]
        self.starts: Ints = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
        self.motions: Ints = self.starts[:-1] + np.array([head.motion for head in heads], np.int64)
        document = np.repeat(np.arange(len(heads)), sizes)
        within = np.arange(self.starts[-1]) - self.starts[document]
        motion = self.motions[document] - self.starts[document] if heads else within
        slot = np.where(within < motion, within, within - motion + MOTION)
        self.nodes: Ints = (document << DOCUMENT_SHIFT) | slot
        offset = self.starts[:-1].tolist()
        parts = [head.part for head in heads]
        self.kinds = _joined([part.kinds for part in parts], np.int8)
        self.names = _joined([part.names for part in parts], np.int16)
        # The document node is its own parent here; the parent axis leaves it out.
        self.parents = _joined([np.maximum(p.parents, 0) + o for p, o in zip(parts, offset, strict=True)], np.int64)
        self.ends = _joined([part.ends + start for part, start in zip(parts, offset, strict=True)], np.int64)
        self._parts = parts
        self.heads = heads
        self._named: dict[int, Ints] = {}
        self._by_parent: dict[int, tuple[Ints, Ints]] = {}

    def rows(self, nodes: Ints) -> Ints:
        documents, slots = documents_of(nodes), slots_of(nodes)
        rows = self.starts[documents] + slots
        moving = np.flatnonzero(slots >= MOTION)
        rows[moving] += (self.motions - self.starts[:-1] - MOTION)[documents[moving]]
        return rows

    @cached_property
    def texts(self) -> Strings:
        """The strings of all attributes, texts and namespace nodes, "" for other rows."""
        return of_texts([text for part in self._parts for text in part.texts])

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
        """Which rows are elements with nothing but a text, as most of a head are: it stands behind the namespace node,
        two rows on."""
        return np.asarray(
            (self.ends[rows] == rows + 2) & (self.kinds[np.minimum(rows + 2, len(self.kinds) - 1)] == IS_TEXT)
        )

    def addresses(self, rows: Ints) -> list[str]:
        """The canonical addresses of nodes."""
        documents = np.searchsorted(self.starts, rows, side="right") - 1
        within = (rows - self.starts[documents]).tolist()
        heads = [self.heads[place] for place in documents.tolist()]
        return [head.addresses.get(row) or head.address(row) for head, row in zip(heads, within, strict=True)]

    def named(self, code: int) -> Ints:
        """The rows of all elements of a name, ascending."""
        if code not in self._named:
            self._named[code] = np.flatnonzero((self.names == code) & (self.kinds == IS_ELEMENT))
        return self._named[code]


def _joined(parts: list[np.ndarray], kind: type) -> np.ndarray:
    return np.concatenate([*parts, np.empty(0, kind)]).astype(kind, copy=False)
