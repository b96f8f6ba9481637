"""The documents of a group as columns: heads as arrays of nodes, frames as runs of equal structure."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from functools import cached_property, partial
from typing import Any, Protocol, TypeAlias, TypeVar

import numpy as np
import orjson

from mcml.language.lexical import unescape
from mcml.motion.bodies.pose_index import PoseIndex
from mcml_service.clips.bodies import MADE
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.language.reach import HeadPart
from mcml_service.xpath.library import sample_parts
from mcml_service.xpath.library.body_facts import BodyFacts
from mcml_service.xpath.library.bone_columns import BoneColumns
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.library.disk.packing import Packed
from mcml_service.xpath.library.disk.sidecar import Sidecar
from mcml_service.xpath.library.groups import Group
from mcml_service.xpath.library.stacks import StackedSamples, Stacks
from mcml_service.xpath.library.summaries import BoneEnds, Totals
from mcml_service.xpath.library.zones import FEW_FRAMES, FRAMES, MANY_FRAMES, Table, joined, read_zones, table_of
from mcml_service.xpath.nodes.frame_runs import IdRuns, LabelRuns
from mcml_service.xpath.nodes.head_rows import HeadRows
from mcml_service.xpath.nodes.layouts import Layout, ShapeRuns
from mcml_service.xpath.nodes.numbering import DOCUMENT_SHIFT, FRAME_SHIFT, Bools, Floats, Ints
from mcml_service.xpath.nodes.pairs import expand
from mcml_service.xpath.nodes.timeline import Timeline


class _Sized(Protocol):
    @property
    def nbytes(self) -> int: ...


SAMPLES, OF_BODIES = "samples ", "bodies "
"""How the names on disk of columns of samples begin, and those of quantities of bodies."""

SampleColumn: TypeAlias = tuple[str | None, int]
"""(bone, channel) of samples; None: of all bones."""

Column = TypeVar("Column", bound=_Sized)
Rows = TypeVar("Rows", HeadRows, ShapeRuns, LabelRuns, IdRuns)


class Forest:
    """Several documents together.

    Nodes are numbers (`numbering`); a document's index here is the number's first part. documents: in order of the
    answer. head_part: the available part of their heads. All columns are read on first use, and kept for other queries.
    """

    def __init__(self, tx: Transaction, documents: Group, caches: Caches, *, head_part: HeadPart) -> None:
        self.tx = tx
        self.documents = documents
        self.caches = caches
        self.head_part = head_part
        self.keys = documents.keys
        self.frames = documents.frames
        self._from_disk: dict[SampleColumn, Floats] = {}

    def __len__(self) -> int:
        return len(self.documents)

    def part(self, documents: Sequence[Listed]) -> Forest:
        """Some of the documents alone, numbered from 0."""
        return Forest(self.tx, self.caches.listing.group(list(documents)), self.caches, head_part=self.head_part)

    @cached_property
    def head(self) -> HeadRows:
        part = self.head_part
        return self._lasting(
            HeadRows, f"head {part.name}", lambda: self.caches.heads.read(self.tx, self.documents, part)
        )

    @cached_property
    def layouts(self) -> list[Layout]:
        return self.caches.layouts.read(self.tx, self.documents)

    @cached_property
    def shapes(self) -> ShapeRuns:
        return self._lasting(ShapeRuns, "shapes", lambda: self.layouts)

    @cached_property
    def labels(self) -> LabelRuns:
        return self._lasting(LabelRuns, "labels", lambda: self.caches.labels.read(self.tx, self.documents))

    @cached_property
    def ids(self) -> IdRuns:
        return self._lasting(IdRuns, "ids", lambda: self.caches.ids.read(self.tx, self.documents))

    @cached_property
    def timeline(self) -> Timeline:
        return self._kept("timeline", lambda: Timeline(self.shapes))

    def has_tracks(self, asked: int = 1) -> bool:
        """Tell whether all tracks with their zone maps are cached, or worth reading: otherwise, as after an edit of a
        long document, a separate query finds a few tracks sooner. asked: number of documents whose tracks are needed.
        If these are most of several, the next query will probably need them, too.
        """
        if self.caches.columns.holds(self.documents, "tracks"):
            return True
        frames = int(self.frames.sum())
        if frames <= FEW_FRAMES or (frames <= MANY_FRAMES and 1 < len(self) < 2 * asked):
            return True
        return int(self.frames.max()) <= MANY_FRAMES and self.caches.zones.holds(self.documents)

    @cached_property
    def tracks(self) -> Table:
        """All tracks with their zone maps."""

        def make() -> Table:
            read = lambda: joined(self.caches.zones.read(self.tx, self.documents))  # noqa: E731
            made = self._on_disk("tracks", read, Table.columns, table_of)
            if self._disk is not None and self.ends is None:
                shapes = self.shapes
                self._disk.keep(self.tx, self._key("ends"), lambda: BoneEnds(made, shapes).stored(), shapes.nbytes)
            return made

        return self._kept("tracks", make)

    def bone(self, name: str | None) -> Bone:
        """The tracks of the bone of a name, as XML has it, or of all bones."""
        return Bone(self, name)

    def bone_columns(self, name: str | None) -> BoneColumns:
        """The same, read."""
        return self._kept(("bone", name), lambda: BoneColumns(self._tracks_of(name), shared=name is None))

    @cached_property
    def ends(self) -> BoneEnds | None:
        """The ranges of the samples of every bone, None if they are not stored on disk."""
        if self._disk is None:
            return None
        known: BoneEnds | None = self.caches.columns.find(self.documents, "ends")
        if known is not None:
            return known
        found = self._disk.read(self.tx, self._key("ends"))
        return None if found is None else self._kept("ends", lambda: BoneEnds.restored(found))

    def totals(self, name: str | None) -> Totals:
        """Return cached sums of the samples of the bones with a name."""
        return self._kept(
            ("totals", name), lambda: Totals(None if self._disk is None else self._disk.read(self.tx, self._sums(name)))
        )

    def add_total(self, name: str | None, channel: int, total: tuple[float, int]) -> None:
        """Cache the sum of all samples of a channel in existing frames, and their number."""
        known = self.totals(name)
        known[channel] = total
        if self._disk is not None:
            self._disk.keep(self.tx, self._sums(name), known.columns, known.nbytes)

    def here(self, name: str | None) -> Bools:
        """(tracks, CHUNK): over which slots of these tracks the documents have a frame."""
        return self._sampled(
            (name, "here"), lambda: self.timeline.here(self.bone(name).table.places, self.bone(name).table.chunks)
        )

    def whole(self, name: str | None) -> Bools:
        """Tell which of these tracks have only existing frames."""
        frames = self.bone(name).table.about[FRAMES]
        return self._sampled((name, "whole"), lambda: np.asarray(self.here(name).sum(axis=1) == frames))

    def samples(self, name: str | None, channel: int, read: Callable[[], Floats]) -> Floats:
        """(tracks, CHUNK): the samples of a channel in the tracks of a bone. read: reads them."""
        what = name, channel

        def make() -> Floats:
            if what in self._from_disk:
                return self._from_disk.pop(what)
            made = read()
            if self._disk is not None:
                self._disk.keep(self.tx, self._samples(what), lambda: sample_parts.columns(made), made.nbytes)
            return made

        return self._sampled(what, make)

    def has_samples(self, name: str | None, channel: int) -> bool:
        """Tell whether they are cached, or can be loaded from disk."""
        what = name, channel
        if what in self._from_disk or self.caches.samples.holds(self.documents, what):
            return True
        found = None if self._disk is None else self._disk.read(self.tx, self._samples(what))
        if found is not None:
            self._from_disk[what] = sample_parts.samples_of(found)
        return found is not None

    def reads_bone(self, name: str | None) -> bool:
        """Whether they are read."""
        return self.caches.columns.holds(self.documents, ("bone", name))

    @cached_property
    def stacks(self) -> Stacks:
        """Return the stacks of the samples of all tracks."""
        return self._kept("stacks", lambda: Stacks(self.tracks))

    def stacked(self, channel: int, *, coded: bool) -> StackedSamples:
        """The samples of a channel of all tracks, as far as they have been read."""
        make = partial(StackedSamples, self.stacks.size, len(self.tracks), coded=coded)
        return self._sampled(("stacked", channel, coded), make)

    def of_bodies(self, what: tuple[str, ...], make: Callable[[], Floats]) -> Floats:
        """A number of each frame, or each document, one after the other, kept in memory and on disk. make: works it
        out."""
        part = f"{OF_BODIES}{orjson.dumps(what).decode()}"
        return self._sampled(
            what, lambda: self._on_disk(part, make, lambda column: {"numbers": column}, lambda found: found["numbers"])
        )

    def body_facts(self, make: Callable[[], BodyFacts] | None) -> BodyFacts | None:
        """Return the facts of the bodies, cached in memory and on disk.

        make: computes them; None: only cached facts.
        """
        what = f"facts of bodies {MADE} anatomy"
        known: BodyFacts | None = self.caches.columns.find(self.documents, what)
        if known is None and (make is not None or self._disk is not None):
            found = None if self._disk is None else self._disk.read(self.tx, self._key(what))
            if found is not None:
                return self._kept(what, lambda: BodyFacts.restored(found))
            if make is not None:
                made = known = self._kept(what, make)
                if self._disk is not None:
                    self._disk.keep(self.tx, self._key(what), made.stored, made.nbytes)
        return known

    def pose_index(self, version: str, make: Callable[[], PoseIndex]) -> PoseIndex:
        """Return the index of poses, cached in memory and on disk. version: of its computation. make: builds it."""
        what = f"poses {version}"

        def restored(found: Packed) -> PoseIndex:
            return PoseIndex(**{one.name: found[one.name] for one in fields(PoseIndex)})

        index: PoseIndex = self._kept(what, lambda: self._on_disk(what, make, vars, restored))
        return index

    def has_bone(self, name: str | None) -> bool:
        """Tell whether their ranges are cached."""
        return self.reads_bone(name) or self.ends is not None

    def _tracks_of(self, name: str | None) -> Table:
        if name is None:
            return self.tracks
        if len(self) > 1:
            return self._on_disk(f"bone {name}", lambda: self._chosen(name), Table.columns, table_of)
        return self._chosen(name)

    def _chosen(self, name: str) -> Table:
        numbers = self.shapes.numbers_of(unescape(name))
        if len(self) == 1 and not self.has_tracks():
            return joined([read_zones(self.tx, self.documents, numbers.tolist())[self.keys[0]]])
        return self.tracks.of_bones(numbers)

    def all_frames(self, documents: Ints) -> tuple[Ints, Ints]:
        """(index into documents, frame element) of every frame of each document, in order."""
        source, position = expand(self.frames[documents])
        return source, (documents[source] << DOCUMENT_SHIFT) | ((position + 1) << FRAME_SHIFT)

    def _sampled(self, what: object, make: Callable[[], Column]) -> Column:
        return self.caches.samples.get(self.documents, what, make, lambda column: column.nbytes)

    @cached_property
    def _disk(self) -> Sidecar | None:
        return self.caches.sidecar if self.documents.lasting else None

    def _key(self, what: str) -> tuple[bytes, str]:
        return self.documents.fingerprint, what

    def _samples(self, what: SampleColumn) -> tuple[bytes, str]:
        return self._key(name_samples(what))

    def _sums(self, name: str | None) -> tuple[bytes, str]:
        return self._key("totals of all" if name is None else f"totals {name}")

    def _on_disk(
        self,
        what: str,
        make: Callable[[], Column],
        columns: Callable[[Column], Mapping[str, Any]],
        restored: Callable[[Packed], Column],
    ) -> Column:
        if self._disk is None:
            return make()
        return self._disk.part(self.tx, self._key(what), make, columns, restored)

    def _lasting(self, kind: type[Rows], what: str, read: Callable[[], Any]) -> Rows:
        """Return rows of a kind, made from data that is read, cached in memory and on disk."""
        return self._kept(what, lambda: self._on_disk(what, lambda: kind(read()), kind.stored, kind.restored))

    def _kept(self, what: object, make: Callable[[], Column]) -> Column:
        return self.caches.columns.get(self.documents, what, make, lambda column: column.nbytes)


class Bone:
    """The tracks of the bones with a name for one query: their ranges may be known without reading them."""

    def __init__(self, forest: Forest, name: str | None) -> None:
        self._forest = forest
        self._name = name

    def __len__(self) -> int:
        return len(self.columns)

    @cached_property
    def columns(self) -> BoneColumns:
        return self._forest.bone_columns(self._name)

    @property
    def table(self) -> Table:
        """The tracks with their zone maps."""
        return self.columns.table

    @property
    def least(self) -> Floats:
        """The least of all samples of each channel, NaN without samples."""
        return self._ends[0]

    @property
    def greatest(self) -> Floats:
        """The greatest."""
        return self._ends[1]

    def total(self, channel: int) -> tuple[float, int] | None:
        """Return the cached sum of all samples of a channel in existing frames, and their number; None if not
        cached.
        """
        return self._forest.totals(self._name).get(channel)

    def keep_total(self, channel: int, total: tuple[float, int]) -> None:
        """Keep it."""
        self._forest.add_total(self._name, channel, total)

    def facing(self, lead: Bone) -> Table:
        """For each track of another bone the one of the same frames."""
        return self.columns.facing(lead.columns)

    def over(self, lead: Bone, values: Floats) -> Floats:
        """Values of these tracks over those of another bone, NaN where this one has no track."""
        return self.columns.over(lead.columns, values)

    def sums(self, channel: int, make: Callable[[Table], Floats]) -> Floats:
        """The sum of the samples of each track. make: works it out."""
        return self.columns.sums(channel, make)

    @cached_property
    def _ends(self) -> tuple[Floats, Floats]:
        ends = None if self._forest.reads_bone(self._name) else self._forest.ends
        if ends is None:
            return self.columns.least, self.columns.greatest
        return ends.of(None if self._name is None else unescape(self._name))


def name_samples(column: SampleColumn) -> str:
    """The name of a column of samples on disk."""
    return f"{SAMPLES}{orjson.dumps(column).decode()}"
