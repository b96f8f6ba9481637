"""The documents of a group as columns: heads as arrays of nodes, frames as runs of equal structure."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import Protocol, TypeVar

import numpy as np

from service.mcml.lexical import unescape
from service.storage.columns import Listed
from service.storage.database import Transaction
from service.xpath.language.reach import HeadPart
from service.xpath.library.bone_columns import BoneColumns
from service.xpath.library.caches import Caches
from service.xpath.library.groups import Group
from service.xpath.library.stacks import StackedSamples, Stacks
from service.xpath.library.zones import FEW_FRAMES, FRAMES, MANY_FRAMES, Table, joined, read_zones
from service.xpath.nodes.frame_runs import IdRuns, LabelRuns
from service.xpath.nodes.head_rows import HeadRows
from service.xpath.nodes.layouts import Layout, ShapeRuns
from service.xpath.nodes.numbering import DOCUMENT_SHIFT, FRAME_SHIFT, Bools, Floats, Ints
from service.xpath.nodes.pairs import expand
from service.xpath.nodes.timeline import Timeline


class _Sized(Protocol):
    @property
    def nbytes(self) -> int: ...


Column = TypeVar("Column", bound=_Sized)


class Forest:
    """Documents side by side. Nodes are numbers (`numbering`); a document's place here is the number's first part.

    documents: in order of the answer. head_part: what of their heads can be asked for. All columns are read
    when they are first needed, and kept for other questions.
    """

    def __init__(self, tx: Transaction, documents: Group, caches: Caches, *, head_part: HeadPart) -> None:
        self.tx = tx
        self.documents = documents
        self.caches = caches
        self.head_part = head_part
        self.keys = documents.keys
        self.frames = documents.frames

    def __len__(self) -> int:
        return len(self.documents)

    def part(self, documents: Sequence[Listed]) -> Forest:
        """Some of the documents alone, numbered from 0."""
        return Forest(self.tx, self.caches.listing.group(list(documents)), self.caches, head_part=self.head_part)

    @cached_property
    def head(self) -> HeadRows:
        part = self.head_part
        return self._kept(("head", part), lambda: HeadRows(self.caches.heads.read(self.tx, self.documents, part)))

    @cached_property
    def layouts(self) -> list[Layout]:
        return self.caches.layouts.read(self.tx, self.documents)

    @cached_property
    def shapes(self) -> ShapeRuns:
        return self._kept("shapes", lambda: ShapeRuns(self.layouts))

    @cached_property
    def labels(self) -> LabelRuns:
        return self._kept("labels", lambda: LabelRuns(self.caches.labels.read(self.tx, self.documents)))

    @cached_property
    def ids(self) -> IdRuns:
        return self._kept("ids", lambda: IdRuns(self.caches.ids.read(self.tx, self.documents)))

    @cached_property
    def timeline(self) -> Timeline:
        return self._kept("timeline", lambda: Timeline(self.shapes))

    def has_tracks(self, asked: int = 1) -> bool:
        """Whether all tracks with their zone maps are at hand, or well worth reading: else, as after an edit of a long
        document, a few tracks are found sooner by a query of their own.

        asked: of how many documents tracks are wanted. Where that is most of several, the next question will be, too.
        """
        if self.caches.columns.holds((self.documents.number, "tracks")):
            return True
        frames = int(self.frames.sum())
        if frames <= FEW_FRAMES or (frames <= MANY_FRAMES and 1 < len(self) < 2 * asked):
            return True
        return int(self.frames.max()) <= MANY_FRAMES and self.caches.zones.holds(self.documents)

    @cached_property
    def tracks(self) -> Table:
        """All tracks with their zone maps."""
        return self._kept("tracks", lambda: joined(self.caches.zones.read(self.tx, self.documents)))

    def bone(self, name: str | None) -> BoneColumns:
        """The tracks of the bone of a name, as XML has it, or of all bones."""
        return self._kept(("bone", name), lambda: BoneColumns(self._tracks_of(name), shared=name is None))

    def here(self, name: str | None) -> Bools:
        """(tracks, CHUNK): over which slots of these tracks the documents have a frame."""
        return self._sampled(
            (name, "here"), lambda: self.timeline.here(self.bone(name).table.places, self.bone(name).table.chunks)
        )

    def whole(self, name: str | None) -> Bools:
        """Which of these tracks have only frames that are there still."""
        frames = self.bone(name).table.about[FRAMES]
        return self._sampled((name, "whole"), lambda: np.asarray(self.here(name).sum(axis=1) == frames))

    def samples(self, lead: str | None, name: str | None, channel: int, read: Callable[[], Floats]) -> Floats:
        """(tracks, CHUNK): the samples of a channel over the tracks of the leading bone. read: reads them."""
        return self._sampled((lead, name, channel), read)

    def has_samples(self, lead: str | None, name: str | None, channel: int) -> bool:
        """Whether they are at hand."""
        return self.caches.samples.holds((self.documents.number, (lead, name, channel)))

    @cached_property
    def stacks(self) -> Stacks:
        """Where the samples of all tracks lie side by side."""
        return self._kept("stacks", lambda: Stacks(self.tracks))

    def stacked(self, channel: int, *, coded: bool) -> StackedSamples:
        """The samples of a channel of all tracks, as far as they were read."""
        make = partial(StackedSamples, self.stacks.size, len(self.tracks), coded=coded)
        return self._sampled(("stacked", channel, coded), make)

    def has_bone(self, name: str | None) -> bool:
        """Whether they are at hand."""
        return self.caches.columns.holds((self.documents.number, ("bone", name)))

    def _tracks_of(self, name: str | None) -> Table:
        if name is None:
            return self.tracks
        numbers = self.shapes.numbers_of(unescape(name))
        if len(self) == 1 and not self.has_tracks():
            return joined([read_zones(self.tx, self.documents, numbers.tolist())[self.keys[0]]])
        return self.tracks.of_bones(numbers)

    def all_frames(self, documents: Ints) -> tuple[Ints, Ints]:
        """(index into documents, frame element) of every frame of each document, in order."""
        source, position = expand(self.frames[documents])
        return source, (documents[source] << DOCUMENT_SHIFT) | ((position + 1) << FRAME_SHIFT)

    def _sampled(self, what: object, make: Callable[[], Column]) -> Column:
        return self.caches.samples.get((self.documents.number, what), make, lambda column: column.nbytes)

    def _kept(self, what: object, make: Callable[[], Column]) -> Column:
        return self.caches.columns.get((self.documents.number, what), make, lambda column: column.nbytes)
