"""The ranges of the samples of each bone of a group over all its tracks, and computed sums."""

from __future__ import annotations

from typing import Any

import numpy as np

from mcml_service.xpath.library.zones import BONE, Table
from mcml_service.xpath.nodes.layouts import ShapeRuns
from mcml_service.xpath.nodes.numbering import Floats, Ints
from mcml_service.xpath.nodes.stored import Columns, Stored


class BoneEnds(Stored):
    """names: stored names of bones.

    least, greatest: (channels, bones + 1), NaN without samples; the last are those of all bones.
    """

    STORED = ("names", "least", "greatest")

    names: list[str]
    least: Floats
    greatest: Floats

    def __init__(self, table: Table, shapes: ShapeRuns) -> None:
        self.names, codes = _names(table, shapes)
        count = len(self.names)
        self.least, self.greatest = np.full((2, len(table.least), count + 1), np.nan)
        order = np.argsort(codes, kind="stable")
        starts = np.searchsorted(codes[order], np.arange(count))
        if count:
            self.least[:, :count] = np.fmin.reduceat(table.least[:, order], starts, axis=1)
            self.greatest[:, :count] = np.fmax.reduceat(table.greatest[:, order], starts, axis=1)
        self.least[:, count] = np.fmin.reduce(table.least, axis=1, initial=np.nan)
        self.greatest[:, count] = np.fmax.reduce(table.greatest, axis=1, initial=np.nan)
        self._begin()

    def _begin(self) -> None:
        self._places = {name: place for place, name in enumerate(self.names)}

    @property
    def nbytes(self) -> int:
        """About how much memory it takes."""
        return 2 * self.least.nbytes + 100 * len(self.names)

    def of(self, name: str | None) -> tuple[Floats, Floats]:
        """Least and greatest sample of each channel of the bones of a name, or of all."""
        place = len(self.names) if name is None else self._places.get(name)
        if place is None:
            return np.full(len(self.least), np.nan), np.full(len(self.least), np.nan)
        return self.least[:, place], self.greatest[:, place]


def _names(table: Table, shapes: ShapeRuns) -> tuple[list[str], Ints]:
    """The names of the bones that have tracks, and of each track the place of its bone's."""
    widths = np.array([len(names) for names, _ in shapes.namings], np.int64)
    every = [*(name for names, _ in shapes.namings for name in names), ""]
    namings, bones = shapes.naming_of[table.places], table.about[BONE]
    rows = np.where(bones < widths[namings], (np.cumsum(widths) - widths)[namings] + bones, len(every) - 1)
    used, inverse = np.unique(rows, return_inverse=True)
    places: dict[str, int] = {}
    codes = np.array([places.setdefault(every[row], len(places)) for row in used.tolist()], np.int64)
    return list(places), codes[inverse.reshape(-1)]


class Totals(dict[int, tuple[float, int]]):
    """The sum of all samples of channels in existing frames, and their number."""

    def __init__(self, columns: Columns | None = None) -> None:
        """columns: the stored form."""
        if columns is not None:
            rows = zip(*(columns[name].tolist() for name in ("channels", "sums", "counts")), strict=True)
            super().__init__({channel: (total, count) for channel, total, count in rows})

    @property
    def nbytes(self) -> int:
        """About how much memory it takes."""
        return 1000

    def columns(self) -> dict[str, Any]:
        """Return the stored form."""
        rows = list(self.items())
        return {
            "channels": np.array([channel for channel, _ in rows], np.int64),
            "sums": np.array([total for _, (total, _) in rows], np.float64),
            "counts": np.array([count for _, (_, count) in rows], np.int64),
        }
