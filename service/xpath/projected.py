"""What no plan expresses: the documents as XML, without what the expression cannot touch, evaluated by libxml2."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

from service.errors import LimitError, QueryError
from service.mcml.writer import Layout, write_document
from service.motion.clip import FrameBlock
from service.storage.database import Transaction
from service.storage.documents import StoredDocument
from service.storage.motion_names import names_of_frames
from service.xpath.evaluate import Node as Found
from service.xpath.evaluate import Nodes, Scalar
from service.xpath.indexed import frame_of, scope_documents
from service.xpath.nodes import Node, Run, Scope
from service.xpath.parse import Query, parse
from service.xpath.projection import Projection, projection
from service.xpath.tree import Call, Filter, type_of
from service.xpath.tree import Literal as Constant

if TYPE_CHECKING:
    from service.xpath.run import Queries


class Projected:
    """The answer of an expression over a scope, document by document."""

    def __init__(self, engine: Queries, tx: Transaction, query: Query, scope: Scope) -> None:
        self.engine = engine
        self.tx = tx
        self.scope = scope
        self._documents: list[StoredDocument] | None = None
        self.query, self.nth = _without_index(query)
        self.deadline = time.monotonic() + engine.settings.query_seconds
        self.projection = projection(self.query.tree)

    @property
    def type(self) -> str:
        """ "nodes", "number", "string" or "boolean"."""
        return type_of(self.query.tree)

    @property
    def documents(self) -> list[StoredDocument]:
        # No cached_property: before Python 3.12 that lets one thread compute at a time.
        if self._documents is None:
            self._documents = scope_documents(self.tx, self.scope)
        return self._documents

    def scalars(
        self,
    ) -> tuple[
        Literal["number", "string", "boolean"],
        float | str | bool | None,
        list[tuple[StoredDocument, float | str | bool]],
    ]:
        """(type, the one value, or None and the value of each document).

        count and sum as the outermost function are one number over all documents.
        """
        each = [(stored, self._scalar(stored)) for stored in self.documents]
        kind: Literal["number", "string", "boolean"] = self.type  # type: ignore[assignment]
        tree = self.query.tree
        if isinstance(tree, Call) and tree.function in ("count", "sum"):
            return kind, float(sum(float(value) for _, value in each)), []
        return (kind, each[0][1], []) if len(each) == 1 else (kind, None, each)

    def _scalar(self, stored: StoredDocument) -> float | str | bool:
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
        for stored, nodes in self._nodes_by_document():
            waiting: Run | None = None
            for node in nodes:
                position = frame_of(node.address)
                if position is None:
                    raise QueryError(
                        f"{node.address} is not in a frame, so it is in no run of frames.",
                        remedy="Ask with as=json, or for nodes in frames.",
                    )
                if waiting is not None and position <= waiting.last + 1:
                    waiting = Run(stored, waiting.first, max(waiting.last, position))
                    continue
                if waiting is not None:
                    yield waiting
                waiting = Run(stored, position, position)
            if waiting is not None:
                yield waiting

    def _nodes_by_document(self) -> Iterator[tuple[StoredDocument, Sequence[Node | Found]]]:
        if self.nth is not None:
            yield from ((node.stored, [node]) for node in self.nodes(0, 1))
            return
        for stored in self.documents:
            found = self._evaluate(stored, 0, self.engine.settings.query_elements)
            yield stored, found.items if isinstance(found, Nodes) else ()

    def _evaluate(self, stored: StoredDocument, offset: int, limit: int) -> Nodes | Scalar:
        self._check_size(stored)
        left = self.deadline - time.monotonic()
        if left <= 0:
            seconds = self.engine.settings.query_seconds
            raise LimitError(
                f"The query took longer than {seconds:g} s.",
                remedy="Ask fewer documents, or ask for a motion name first.",
                code="query-timeout",
            )
        return self.engine.evaluator.evaluate(self.query, self._xml(stored), limit=limit, offset=offset, seconds=left)

    def _check_size(self, stored: StoredDocument) -> None:
        if self.projection is Projection.HEAD:
            return
        bones = len(self.tx.heads.bone_names(stored.key)) if self.projection is Projection.WHOLE else 1
        elements = stored.frames * (1 + bones)
        limit = self.engine.settings.query_elements
        if elements > limit:
            raise LimitError(
                f"The expression can touch about {elements:,} elements of {stored.name!r}, the limit is {limit:,}.",
                remedy="Ask for a motion name or a frame first, ask smaller documents, or raise MCML_QUERY_ELEMENTS.",
                code="query-too-large",
            )

    def _xml(self, stored: StoredDocument) -> Iterator[bytes]:
        document = self.tx.heads.document(stored)
        names = self.tx.heads.bone_names(stored.key)
        by_number = [names.get(number, "") for number in range(max(names, default=-1) + 1)]

        def blocks() -> Iterator[FrameBlock]:
            if self.projection is Projection.HEAD:
                return
            bones: list[int] | None = [] if self.projection is Projection.FRAMES else None
            position = 1
            for block in self.tx.tracks.blocks(stored.key, 1, stored.frames, bones=bones):
                end = position + len(block) - 1
                labels = names_of_frames(self.tx.spans.of(stored.key, position, end), range(position, end + 1))
                yield replace(block, motion_names=labels)
                position = end + 1

        return write_document(document, stored.frames, stored.frame_time, blocks(), by_number, layout=Layout.COMPACT)


def _without_index(query: Query) -> tuple[Query, int | None]:
    """`(…)[n]` counts over all documents: the expression inside, and n."""
    tree = query.tree
    if isinstance(tree, Filter) and len(tree.predicates) == 1 and isinstance(tree.predicates[0], Constant):
        value = tree.predicates[0].value
        inner = query.text.strip()
        while inner.endswith(")"):
            # Parentheses around the whole: the tree says that a predicate comes last.
            inner = inner[1:-1].strip()
        if isinstance(value, float) and value >= 1 and value.is_integer():
            return replace(parse(inner[: inner.rindex("[")]), warnings=query.warnings), int(value)
    return query, None
