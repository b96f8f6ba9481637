"""The documents of a batch as columns: heads as arrays of nodes, frames as runs of equal structure."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from service.errors import StoreError
from service.storage.columns import Listed
from service.storage.database import Transaction
from service.xpath.frame_runs import IdRuns, LabelRuns
from service.xpath.heads import Head
from service.xpath.layouts import Layout, ShapeRuns
from service.xpath.numbering import (
    DOCUMENT_SHIFT,
    FRAME_SHIFT,
    IS_ELEMENT,
    MAX_DOCUMENTS,
    MAX_FRAMES,
    MOTION,
    Ints,
    documents_of,
    slots_of,
)
from service.xpath.pairs import expand
from service.xpath.shared import Shared


class Forest:
    """Documents side by side. Nodes are numbers (`numbering`); a document's place here is the number's first part.

    documents: in order of the answer. whole_heads: whether headers and skeletons can be asked for. All columns are read
    when they are first needed.
    """

    def __init__(self, tx: Transaction, documents: Sequence[Listed], shared: Shared, *, whole_heads: bool) -> None:
        if len(documents) > MAX_DOCUMENTS or any(stored.frames > MAX_FRAMES for stored in documents):
            raise StoreError("More documents or frames than nodes can be numbered for.")
        self.tx = tx
        self.documents = documents
        self.keys = [stored.key for stored in documents]
        self.frames: Ints = np.array([stored.frames for stored in documents], np.int64)
        self.shared = shared
        self.whole_heads = whole_heads

    def __len__(self) -> int:
        return len(self.documents)

    @cached_property
    def head(self) -> HeadRows:
        return HeadRows(self.shared.heads.read(self.tx, self.documents, whole=self.whole_heads))

    @cached_property
    def layouts(self) -> list[Layout]:
        return self.shared.layouts.read(self.tx, self.documents)

    @cached_property
    def shapes(self) -> ShapeRuns:
        return ShapeRuns(self.layouts)

    @cached_property
    def labels(self) -> LabelRuns:
        return LabelRuns(self.shared.labels.read(self.tx, self.documents))

    @cached_property
    def ids(self) -> IdRuns:
        return IdRuns(self.shared.ids.read(self.tx, self.documents))

    def all_frames(self, documents: Ints) -> tuple[Ints, Ints]:
        """(index into documents, frame element) of every frame of each document, in order."""
        source, position = expand(self.frames[documents])
        return source, (documents[source] << DOCUMENT_SHIFT) | ((position + 1) << FRAME_SHIFT)


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
        base = np.where(slots < MOTION, self.starts[documents], self.motions[documents] - MOTION)
        return np.asarray(base + slots, np.int64)

    def texts(self, rows: Ints) -> list[str]:
        """The strings of attributes, texts and namespace nodes."""
        documents = np.searchsorted(self.starts, rows, side="right") - 1
        within = rows - self.starts[documents]
        parts = self._parts
        return [parts[d].texts[row] for d, row in zip(documents.tolist(), within.tolist(), strict=True)]

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

    def address(self, row: int) -> str:
        """The canonical address of an element, attribute or text."""
        document = int(np.searchsorted(self.starts, row, side="right")) - 1
        return self.heads[document].address(row - int(self.starts[document]))

    def named(self, code: int) -> Ints:
        """The rows of all elements of a name, ascending."""
        if code not in self._named:
            self._named[code] = np.flatnonzero((self.names == code) & (self.kinds == IS_ELEMENT))
        return self._named[code]


def _joined(parts: list[np.ndarray], kind: type) -> np.ndarray:
    return np.concatenate([*parts, np.empty(0, kind)]).astype(kind, copy=False)
