"""Documents as XML, without what an expression cannot touch."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from mcml.errors import LimitError
from mcml.language.addresses import find_frame
from mcml.language.writer import Layout, write_document
from mcml.motion.clip import FrameBlock
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.answer.render import bone_names, labelled_blocks
from mcml_service.xpath.language.reach import Projection
from mcml_service.xpath.limits import Limits
from mcml_service.xpath.nodes.node import Node, Run, in_no_frame, join_runs
from mcml_service.xpath.trees.evaluate import Found


class Xml:
    """Documents as XML, without what an expression cannot touch."""

    def __init__(self, tx: Transaction, limits: Limits, projection: Projection) -> None:
        self.tx = tx
        self.limits = limits
        self.projection = projection

    def of_all(self, documents: Sequence[Listed]) -> Iterator[Iterator[bytes]]:
        """Yield the XML of each document in pieces. Raises LimitError if they are too large together."""
        self._check_size(documents)
        yield from map(self._of, documents)

    def _of(self, stored: Listed) -> Iterator[bytes]:
        document = self.tx.heads.document(stored)
        blocks: Iterator[FrameBlock] = iter(())
        if self.projection is not Projection.HEAD:
            bones: list[int] | None = [] if self.projection is Projection.FRAMES else None
            blocks = labelled_blocks(self.tx, stored, 1, stored.frames, bones)
        names = bone_names(self.tx, stored)
        return write_document(document, stored.frames, stored.frame_time, blocks, names, layout=Layout.COMPACT)

    def _check_size(self, documents: Sequence[Listed]) -> None:
        if self.projection is Projection.HEAD:
            return
        elements = 0
        for stored in documents:
            bones = len(self.tx.heads.bone_names(stored.key)) if self.projection is Projection.WHOLE else 1
            elements += stored.frames * (1 + bones)
        limit = self.limits.max_elements
        if elements > limit:
            whose = repr(documents[0].name) if len(documents) == 1 else f"{len(documents):,} documents together"
            raise LimitError(
                f"The expression can touch about {elements:,} elements of {whose}, the limit is {limit:,}.",
                remedy="Ask for a motion name or a frame first, ask smaller documents, or raise MCML_QUERY_ELEMENTS.",
                code="query-too-large",
            )


def runs_of_nodes(found: Iterable[tuple[Listed, Sequence[Node | Found]]]) -> Iterator[Run]:
    """Yield maximal ranges of the frames of documents' nodes. Raises QueryError for a node outside frames."""
    return join_runs(_frames_of_nodes(found))


def _frames_of_nodes(found: Iterable[tuple[Listed, Sequence[Node | Found]]]) -> Iterator[Run]:
    for stored, nodes in found:
        frames: set[int] = set()
        for node in nodes:
            position = find_frame(node.address)
            if position is None:
                raise in_no_frame(node.address)
            frames.add(position)
        yield from (Run(stored, position, position) for position in sorted(frames))
