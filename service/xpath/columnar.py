"""Answers from columns: documents in batches, paths in slices of frames, so that memory grows with neither."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from service.mcml.vocabulary import FRAME
from service.storage.database import Transaction
from service.storage.documents import StoredDocument
from service.xpath.columns import Columns
from service.xpath.forest import Forest
from service.xpath.functions import as_booleans, kind_of
from service.xpath.heads import Heads
from service.xpath.nodesets import NodeSets, ordered
from service.xpath.numbering import Ints, first_of_documents
from service.xpath.projection import DOCUMENT, Projection, needs_head, projection
from service.xpath.rules import after
from service.xpath.texts import Strings
from service.xpath.tree import Expression, Path, Step
from service.xpath.values import numbers

BATCH = 1_000_000
"""Nodes of the documents that are looked at together, about."""
HEAD_NODES, NODES_A_FRAME = 1000, 40
SLICE_FRAMES = 4096
"""Frames that the rest of a path is walked from together; whole chunks, so that no track is read twice."""
DOWNWARDS = frozenset({"self", "child", "descendant", "descendant-or-self", "attribute", "namespace"})


class Columnar:
    """An expression over documents, evaluated on columns.

    documents: in order of the answer. check: called often; raises when the query must end. Every method may raise
    TooWideError or TooLongError where an intermediate result is larger than is held at once.
    """

    def __init__(
        self,
        tx: Transaction,
        tree: Expression,
        documents: Sequence[StoredDocument],
        heads: Heads,
        check: Callable[[], None],
    ) -> None:
        self.tx = tx
        self.tree = tree
        self.documents = documents
        self._heads = heads
        self._check = check
        self._whole_heads = needs_head(tree)
        frames = {Projection.HEAD: 0, Projection.FRAMES: 1, Projection.WHOLE: NODES_A_FRAME}[projection(tree)]
        self._weights = [(HEAD_NODES if self._whole_heads else 1) + stored.frames * frames for stored in documents]

    def forests(self) -> Iterator[Forest]:
        """The documents in batches. The first are small: often the first page is all that is wanted."""
        start, allowed = 0, BATCH // 16
        while start < len(self.documents):
            stop, weight = start, 0
            while stop < len(self.documents) and (stop == start or weight + self._weights[stop] <= allowed):
                weight += self._weights[stop]
                stop += 1
            yield Forest(self.tx, self.documents[start:stop], self._heads, whole_heads=self._whole_heads)
            start, allowed = stop, min(BATCH, allowed * 4)

    def chunks(self) -> Iterator[tuple[Forest, Ints]]:
        """The nodes of the answer, in order, some at a time."""
        for forest in self.forests():
            columns = Columns(forest, self._check)
            for nodes in self._walk(columns):
                if len(nodes):
                    yield forest, nodes

    def total(self, function: str) -> float:
        """`count` or `sum` of the nodes of all documents together."""
        if function == "count":
            return float(sum(len(nodes) for _, nodes in self.chunks()))
        return float(sum(float(numbers(forest, nodes).sum()) for forest, nodes in self.chunks()))

    def values(self) -> list[float | str | bool]:
        """The value of each document."""
        result: list[float | str | bool] = []
        for forest in self.forests():
            columns = Columns(forest, self._check)
            found = columns.value(self.tree, columns.documents())
            if isinstance(found, Strings):
                result += found.list()
            elif kind_of(found) == "boolean":
                result += as_booleans(found).tolist()
            else:
                result += np.asarray(found, np.float64).tolist()
        return result

    def _walk(self, columns: Columns) -> Iterator[Ints]:
        tree = self.tree
        start = columns.documents()
        if not (isinstance(tree, Path) and tree.absolute):
            yield columns.nodes(tree, start).flat()[0].nodes
            return
        split = frames_at(tree.steps)
        documents = first_of_documents(np.arange(len(columns.forest)))
        one = NodeSets(np.zeros(len(documents), np.int64), documents, 1)
        found = columns.steps(one, tree.steps[:split])
        if split == len(tree.steps):
            yield found.nodes
            return
        for at in range(0, max(1, len(found.nodes)), SLICE_FRAMES):
            some = found.nodes[at : at + SLICE_FRAMES]
            yield columns.steps(ordered(np.zeros(len(some), np.int64), some, 1), tree.steps[split:]).nodes


def frames_at(steps: Sequence[Step]) -> int:
    """After how many steps a path has reached frames, from which it only goes down; all, if it never does."""
    types = frozenset({DOCUMENT})
    for number, step in enumerate(steps):
        types = after(types, step)
        if types == {FRAME}:
            down = all(following.axis in DOWNWARDS for following in steps[number + 1 :])
            return number + 1 if down else len(steps)
    return len(steps)
