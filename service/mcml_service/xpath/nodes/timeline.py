"""Where the frames of slots are."""

from __future__ import annotations

import numpy as np

from mcml_service.storage.core.schema import CHUNK
from mcml_service.xpath.nodes.layouts import ShapeRuns
from mcml_service.xpath.nodes.numbering import FRAME_SHIFT, Bools, Ints, frames_of


def slots_of_chunks(chunks: Ints) -> Ints:
    """(n, CHUNK): the slots of each chunk."""
    return np.asarray(chunks[:, None] * CHUNK + np.arange(CHUNK), np.int64)


class Timeline:
    """Where in their documents the frames of slots are. moved: places of documents whose frames are not in the order of
    their slots."""

    def __init__(self, runs: ShapeRuns) -> None:
        slots = (runs.places << 32) | runs.slots
        order = np.argsort(slots)
        # A run of no frames comes before all others, so that each slot has one to look at.
        self._starts, self._count = np.append(-1, slots[order]), np.append(0, runs.counts[order])
        self._first = np.append(0, frames_of(runs.keys[order] << FRAME_SHIFT))
        self.moved = np.unique(runs.places[1:][np.diff(slots) < 0])

    @property
    def nbytes(self) -> int:
        """About how much memory it takes."""
        return self._starts.nbytes + self._count.nbytes + self._first.nbytes

    def positions(self, places: Ints, slots: Ints) -> Ints:
        """Return the position of the frame in each slot, 0 for slots without a frame."""
        keys = (places << 32) | slots
        piece = np.searchsorted(self._starts, keys, side="right") - 1
        within = keys - self._starts[piece]
        return np.where(within < self._count[piece], self._first[piece] + within, 0)

    def here(self, places: Ints, chunks: Ints) -> Bools:
        """Return (units, CHUNK): mask of the slots with frames."""
        first = (places << 32) | (chunks * CHUNK)
        piece = np.searchsorted(self._starts, first, side="right") - 1
        within = first - self._starts[piece]
        whole = within + CHUNK <= self._count[piece]
        found = np.ones((len(places), CHUNK), bool)
        # Most documents are one piece, which ends in their last chunk.
        alone = np.append(self._starts, np.iinfo(np.int64).max)[piece + 1] >= first + CHUNK
        ending = np.flatnonzero(alone & ~whole)
        found[ending] = np.arange(CHUNK) < (self._count[piece] - within)[ending, None]
        part = np.flatnonzero(~alone & ~whole)
        found[part] = self.positions(places[part, None], slots_of_chunks(chunks[part])) > 0
        return found
