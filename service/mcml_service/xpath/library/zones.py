"""Zone maps: the tracks of documents, and the range of the samples of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from mcml.motion.skeleton import CHANNELS
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.library.intervals import Interval
from mcml_service.xpath.library.tracks import Row
from mcml_service.xpath.nodes.numbering import Floats, Ints
from mcml_service.xpath.nodes.stored import Columns

MANY_FRAMES = 1 << 19
"""Documents of more frames have zone maps that are too large to be kept."""

FEW_FRAMES = 1 << 9
"""Of so few the zone maps are read in a few milliseconds."""

DOCUMENT, CHUNK_NUMBER, BONE, COMMIT, BITS, GAPS, FRAMES = range(7)
"""Rows of `about`: key of the document, numbers of chunk and bone, the commit that wrote the track, the channels that
it has, those of them that some frame lacks, and how many frames it has."""


@dataclass(frozen=True, slots=True)
class Zones:
    """The tracks of one document, by bone, then chunk.

    about: (7, n). least, greatest: (channels, n), NaN where a track lacks the channel.
    """

    about: Ints
    least: Floats
    greatest: Floats

    @property
    def nbytes(self) -> int:
        """About how much memory it takes."""
        return self.about.nbytes + self.least.nbytes + self.greatest.nbytes


def rows_of(about: Ints) -> list[Row]:
    """Return the keys with which tracks are read."""
    return list(zip(*about[:GAPS].tolist(), strict=True))


def read_zones(tx: Transaction, documents: Sequence[Listed], numbers: Sequence[int] | None = None) -> dict[int, Zones]:
    """The zone maps of each document by its key. numbers: only those of these bones."""
    rows = tx.columns.zones([listed.key for listed in documents], numbers)
    rows = rows[np.lexsort((rows[:, CHUNK_NUMBER], rows[:, BONE], rows[:, DOCUMENT]))]
    result = {}
    for listed in documents:
        start, stop = np.searchsorted(rows[:, DOCUMENT], [listed.key, listed.key + 1])
        own = rows[start:stop].T
        least, greatest = own[FRAMES + 1 :: 2], own[FRAMES + 2 :: 2]
        result[listed.key] = Zones(
            own[: FRAMES + 1].astype(np.int64), np.ascontiguousarray(least), np.ascontiguousarray(greatest)
        )
    return result


@dataclass(frozen=True)
class Table:
    """Tracks of several documents, their places ascending. about, least, greatest: as of one document."""

    places: Ints
    about: Ints
    least: Floats
    greatest: Floats

    def __len__(self) -> int:
        return len(self.places)

    @property
    def nbytes(self) -> int:
        """About how much memory it takes."""
        return self.places.nbytes + self.about.nbytes + self.least.nbytes + self.greatest.nbytes

    def columns(self) -> dict[str, Any]:
        """Return the stored form."""
        return {name: getattr(self, name) for name in ("places", "about", "least", "greatest")}

    def __getitem__(self, which: Ints | slice) -> Table:
        return Table(self.places[which], self.about[:, which], self.least[:, which], self.greatest[:, which])

    @property
    def chunks(self) -> Ints:
        """The number of the chunk of each track."""
        return np.asarray(self.about[CHUNK_NUMBER], np.int64)

    def of_bones(self, numbers: Ints) -> Table:
        """The tracks of one bone of each document, by its number."""
        return self[np.flatnonzero(self.about[BONE] == numbers[self.places])]

    def named(self, tracks: Ints) -> Table:
        """Tracks by their numbers (place << 48 | bone << 32 | chunk), which are all there, of all bones."""
        return self[np.searchsorted(self._tracks, tracks)]

    @cached_property
    def _tracks(self) -> Ints:
        return np.asarray((self.places << 48) | (self.about[BONE] << 32) | self.about[CHUNK_NUMBER], np.int64)

    def facing(self, other: Table) -> Table:
        """Return for each track of another table the one with the same frames, or one without channels.

        These are tracks of one bone of each document.
        """
        keys, wanted = self.frames, other.frames
        index = np.searchsorted(keys, wanted)
        found = np.append(keys, -1)[index] == wanted
        about = np.zeros((len(self.about), len(wanted)), np.int64)
        about[:, found] = self.about[:, index[found]]
        least, greatest = np.full((2, len(CHANNELS), len(wanted)), np.nan)
        least[:, found] = self.least[:, index[found]]
        greatest[:, found] = self.greatest[:, index[found]]
        return Table(other.places, about, least, greatest)

    @cached_property
    def frames(self) -> Ints:
        """The frame range of each track as one number (place << 32 | chunk); ascending where each document has one
        bone.
        """
        return np.asarray((self.places << 32) | self.about[CHUNK_NUMBER], np.int64)

    def ends(self, channel: int, frames: Ints) -> Interval:
        """Return the range of the samples of a channel. frames: number of requested frames of each track."""
        some = (self.about[BITS] >> channel & 1).astype(bool)
        gaps = (self.about[GAPS] >> channel & 1).astype(bool)
        always = some & ~gaps & (self.about[FRAMES] >= frames)
        return Interval(self.least[channel], self.greatest[channel], some, always)


def table_of(columns: Columns) -> Table:
    """The table that had these columns."""
    return Table(columns["places"], columns["about"], columns["least"], columns["greatest"])


def joined(zones: Sequence[Zones]) -> Table:
    """The tracks of documents, which are numbered from 0."""
    none = np.empty((len(CHANNELS), 0))
    return Table(
        np.repeat(np.arange(len(zones)), [each.about.shape[1] for each in zones]),
        np.concatenate([np.empty((FRAMES + 1, 0), np.int64), *(each.about for each in zones)], axis=1),
        np.concatenate([none, *(each.least for each in zones)], axis=1),
        np.concatenate([none, *(each.greatest for each in zones)], axis=1),
    )
