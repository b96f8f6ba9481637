"""The tracks of the bones with a name in a group of documents, and values derived from their samples by queries."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol
from weakref import WeakKeyDictionary

import numpy as np

from mcml_service.xpath.library.intervals import Interval
from mcml_service.xpath.library.zones import Table
from mcml_service.xpath.nodes.numbering import Floats


class BoneColumns:
    """table: the tracks with their zone maps.

    least, greatest: of all samples of each channel, NaN without samples. A bone with an unknown name has no tracks.
    """

    def __init__(self, table: Table, *, shared: bool = False) -> None:
        """shared: the table is kept elsewhere, too."""
        self.table = table
        self.least: Floats = np.fmin.reduce(table.least, axis=1, initial=np.nan)
        self.greatest: Floats = np.fmax.reduce(table.greatest, axis=1, initial=np.nan)
        self._own = 0 if shared else table.nbytes
        self._facing: WeakKeyDictionary[BoneColumns, Table] = WeakKeyDictionary()
        self._sums: dict[int, Floats] = {}

    def __len__(self) -> int:
        return len(self.table)

    @property
    def nbytes(self) -> int:
        """Approximate memory in bytes, including values derived by queries."""
        return 500 + 2 * self._own + 8 * len(self.table)

    def facing(self, lead: BoneColumns) -> Table:
        """For each track of another bone the one of the same frames."""
        found = self._facing.get(lead)
        if found is None:
            found = self._facing[lead] = self.table.facing(lead.table)
        return found

    def over(self, lead: BoneColumns, values: Floats) -> Floats:
        """Values of the tracks, (tracks, n), over those of another bone; NaN where this one has no track."""
        own, wanted = self.table.frames, lead.table.frames
        if np.array_equal(own, wanted):
            return values
        rows = np.searchsorted(own, wanted)
        there = np.append(own, -1)[rows] == wanted
        result = np.full((len(wanted), values.shape[1]), np.nan)
        result[there] = values[rows[there]]
        return result

    def sums(self, channel: int, make: Callable[[Table], Floats]) -> Floats:
        """The sum of the samples of each track. make: works it out."""
        if channel not in self._sums:
            self._sums[channel] = make(self.table)
        return self._sums[channel]


class Ends(Protocol):
    """The ranges of the samples of each channel of a bone."""

    @property
    def least(self) -> Floats: ...

    @property
    def greatest(self) -> Floats: ...


def summary(columns: Sequence[Ends], channel: int) -> Interval:
    """Return the range of the samples of a channel in each of several groups, without information on missing
    samples.
    """
    low = np.array([each.least[channel] for each in columns])
    high = np.array([each.greatest[channel] for each in columns])
    return Interval(low, high, ~np.isnan(low), np.zeros(len(columns), bool))
