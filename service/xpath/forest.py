"""The documents of a batch as columns: heads as arrays of nodes, frames as runs of equal structure."""

from __future__ import annotations

from collections.abc import Sequence

from service.storage.columns import Listed
from service.storage.database import Transaction
from service.xpath.caches import Caches
from service.xpath.frame_runs import IdRuns, LabelRuns
from service.xpath.head_rows import HeadRows
from service.xpath.layouts import Layout, ShapeRuns
from service.xpath.numbering import DOCUMENT_SHIFT, FRAME_SHIFT, Ints
from service.xpath.pairs import expand
from service.xpath.timeline import Timeline
from service.xpath.zones import FEW_FRAMES, MANY_FRAMES, Table, joined


class Forest:
    """Documents side by side. Nodes are numbers (`numbering`); a document's place here is the number's first part.

    documents: in order of the answer. whole_heads: whether headers and skeletons can be asked for. All columns are read
    when they are first needed.
    """

    def __init__(self, tx: Transaction, documents: Sequence[Listed], caches: Caches, *, whole_heads: bool) -> None:
        self.tx = tx
        self.documents = documents
        self.caches = caches
        self.whole_heads = whole_heads
        self._columns = caches.batch(documents, whole_heads=whole_heads)
        self.keys = self._columns.keys
        self.frames = self._columns.frames

    def __len__(self) -> int:
        return len(self.documents)

    @property
    def head(self) -> HeadRows:
        if self._columns.head is None:
            self._columns.head = HeadRows(self.caches.heads.read(self.tx, self.documents, whole=self.whole_heads))
        return self._columns.head

    @property
    def layouts(self) -> list[Layout]:
        if self._columns.layouts is None:
            self._columns.layouts = self.caches.layouts.read(self.tx, self.documents)
        return self._columns.layouts

    @property
    def shapes(self) -> ShapeRuns:
        if self._columns.shapes is None:
            self._columns.shapes = ShapeRuns(self.layouts)
        return self._columns.shapes

    @property
    def labels(self) -> LabelRuns:
        if self._columns.labels is None:
            self._columns.labels = LabelRuns(self.caches.labels.read(self.tx, self.documents))
        return self._columns.labels

    @property
    def ids(self) -> IdRuns:
        if self._columns.ids is None:
            self._columns.ids = IdRuns(self.caches.ids.read(self.tx, self.documents))
        return self._columns.ids

    @property
    def timeline(self) -> Timeline:
        if self._columns.timeline is None:
            self._columns.timeline = Timeline(self.shapes)
        return self._columns.timeline

    def has_tracks(self, asked: int = 1) -> bool:
        """Whether all tracks with their zone maps are at hand, or well worth reading: else, as after an edit of a long
        document, a few tracks are found sooner by a query of their own.

        asked: of how many documents tracks are wanted. Where that is most of several, the next question will be, too.
        """
        if self._columns.tracks is not None:
            return True
        frames = int(self.frames.sum())
        if frames <= FEW_FRAMES or (frames <= MANY_FRAMES and 1 < len(self) < 2 * asked):
            return True
        return int(self.frames.max()) <= MANY_FRAMES and self.caches.zones.holds(self.documents)

    @property
    def tracks(self) -> Table:
        """All tracks with their zone maps."""
        if self._columns.tracks is None:
            self._columns.tracks = joined(self.caches.zones.read(self.tx, self.documents))
        return self._columns.tracks

    def all_frames(self, documents: Ints) -> tuple[Ints, Ints]:
        """(index into documents, frame element) of every frame of each document, in order."""
        source, position = expand(self.frames[documents])
        return source, (documents[source] << DOCUMENT_SHIFT) | ((position + 1) << FRAME_SHIFT)
