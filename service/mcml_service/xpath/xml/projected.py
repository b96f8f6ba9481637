"""What no plan expresses: the documents as XML, without what the expression cannot touch, evaluated by libxml2."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Literal

from mcml.errors import LimitError, QueryError
from mcml.language.addresses import find_frame
from mcml.language.writer import Layout, write_document
from mcml.motion.clip import FrameBlock
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.answer.render import bone_names, labelled_blocks
from mcml_service.xpath.language.labels import without_index
from mcml_service.xpath.language.parse import Query
from mcml_service.xpath.language.reach import Projection, projection
from mcml_service.xpath.language.tree import Call, Expression
from mcml_service.xpath.language.types import type_of
from mcml_service.xpath.limits import Limits
from mcml_service.xpath.nodes.node import Node, Run, in_no_frame, join_runs
from mcml_service.xpath.xml.evaluate import Evaluator, Nodes, Scalar
from mcml_service.xpath.xml.evaluate import Node as Found


class Projected:
    """The answer of an expression over a scope, document by document."""

    def __init__(
        self, evaluator: Evaluator, tx: Transaction, query: Query, documents: Sequence[Listed], limits: Limits
    ) -> None:
        self.evaluator = evaluator
        self.tx = tx
        self.limits = limits
        inner, self.nth = without_index(query.tree)
        self.query = replace(query, tree=inner)
        self.documents = documents
        self._xml = Xml(tx, limits, self.query.tree)

    @property
    def type(self) -> str:
        """ "nodes", "number", "string" or "boolean"."""
        return type_of(self.query.tree)

    def scalars(
        self,
    ) -> tuple[
        Literal["number", "string", "boolean"],
        float | str | bool | None,
        list[tuple[Listed, float | str | bool]],
    ]:
        """(type, the one value, or None and the value of each document).

        count and sum as the outermost function are one number over all documents.
        """
        each = [(stored, self._scalar(stored)) for stored in self.documents]
        kind: Literal["number", "string", "boolean"] = self.type  # type: ignore[assignment]  # no nodes here
        tree = self.query.tree
        if isinstance(tree, Call) and tree.function in ("count", "sum"):
            return kind, float(sum(float(value) for _, value in each)), []
        return (kind, each[0][1], []) if len(each) == 1 else (kind, None, each)

    def _scalar(self, stored: Listed) -> float | str | bool:
        found = self._evaluate(stored, 0, 0)
        if not isinstance(found, Scalar):
            raise QueryError("The expression has no single value.")
        return found.value

    def nodes(self, offset: int, limit: int) -> list[Node]:
        """The nodes of a page."""
        if self.nth is not None:
            if offset:
                return []
            offset, limit = self.nth - 1, 1
        result: list[Node] = []
        for stored in self.documents:
            found = self._evaluate(stored, offset, limit - len(result))
            if not isinstance(found, Nodes):
                raise QueryError("The expression gives a value, not nodes.")
            result += [Node(node.kind, stored, node.address, node.value) for node in found.items]
            offset = max(0, offset - found.total)
            if len(result) >= limit:
                break
        return result

    def runs(self) -> Iterator[Run]:
        """Maximal ranges of frames that nodes are or lie in. QueryError for a node outside the frames."""
        return runs_of_nodes(self._nodes_by_document())

    def _nodes_by_document(self) -> Iterator[tuple[Listed, Sequence[Node | Found]]]:
        if self.nth is not None:
            yield from ((node.stored, [node]) for node in self.nodes(0, 1))
            return
        for stored in self.documents:
            found = self._evaluate(stored, 0, self.limits.max_elements)
            yield stored, found.items if isinstance(found, Nodes) else ()

    def _evaluate(self, stored: Listed, offset: int, limit: int) -> Nodes | Scalar:
        self.limits.check()
        return self.evaluator.evaluate(self.query, self._xml.of(stored), limit=limit, offset=offset, limits=self.limits)


class Xml:
    """Documents as XML, without what an expression cannot touch."""

    def __init__(self, tx: Transaction, limits: Limits, tree: Expression) -> None:
        self.tx = tx
        self.limits = limits
        self.projection = projection(tree)

    def of(self, stored: Listed) -> Iterator[bytes]:
        """The XML in pieces. LimitError for what is too large."""
        self._check_size(stored)
        document = self.tx.heads.document(stored)
        blocks: Iterator[FrameBlock] = iter(())
        if self.projection is not Projection.HEAD:
            bones: list[int] | None = [] if self.projection is Projection.FRAMES else None
            blocks = labelled_blocks(self.tx, stored, 1, stored.frames, bones)
        names = bone_names(self.tx, stored)
        return write_document(document, stored.frames, stored.frame_time, blocks, names, layout=Layout.COMPACT)

    def _check_size(self, stored: Listed) -> None:
        if self.projection is Projection.HEAD:
            return
        bones = len(self.tx.heads.bone_names(stored.key)) if self.projection is Projection.WHOLE else 1
        elements = stored.frames * (1 + bones)
        limit = self.limits.max_elements
        if elements > limit:
            raise LimitError(
                f"The expression can touch about {elements:,} elements of {stored.name!r}, the limit is {limit:,}.",
                remedy="Ask for a motion name or a frame first, ask smaller documents, or raise MCML_QUERY_ELEMENTS.",
                code="query-too-large",
            )


def runs_of_nodes(found: Iterable[tuple[Listed, Sequence[Node | Found]]]) -> Iterator[Run]:
    """Maximal ranges of frames that nodes of documents are or lie in. QueryError for a node outside the frames."""
    return join_runs(_frames_of_nodes(found))


def _frames_of_nodes(found: Iterable[tuple[Listed, Sequence[Node | Found]]]) -> Iterator[Run]:
    for stored, nodes in found:
        for node in nodes:
            position = find_frame(node.address)
            if position is None:
                raise in_no_frame(node.address)
            yield Run(stored, position, position)
