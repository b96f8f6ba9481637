"""Frames of many clips as one array."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class ClipArrays:
    """Frame ranges of clips, one after the other, with the same columns. `arrays[i]` are the values of range i.

    values: (frames, bones, 3) positions, (frames, bones, 4) rotations x y z w, or (frames, columns) channels and
    quantities; NaN where missing. columns: names of the second axis; units: theirs, empty where the clips' own. starts:
    (ranges + 1) first frame of each range in `values`. names, documents, revisions, first, last (positions from 1),
    seconds_per_frame (NaN if unknown): of each range. warnings: clips that are left out, and guesses.
    """

    values: NDArray[np.floating]
    columns: list[str]
    units: list[str]
    starts: NDArray[np.int64]
    names: list[str]
    documents: list[str]
    revisions: NDArray[np.int64]
    first: NDArray[np.int64]
    last: NDArray[np.int64]
    seconds_per_frame: NDArray[np.float64]
    warnings: list[str]

    def __repr__(self) -> str:
        return f"<ClipArrays {self.values.shape} of {len(self)} ranges>"

    def __len__(self) -> int:
        """The number of ranges."""
        return len(self.names)

    def __getitem__(self, place: int) -> NDArray[np.floating]:
        if not -len(self) <= place < len(self):
            raise IndexError(place)
        place %= len(self)
        return self.values[self.starts[place] : self.starts[place + 1]]

    def __iter__(self) -> Iterator[NDArray[np.floating]]:
        return (self[place] for place in range(len(self)))

    @classmethod
    def of(cls, npz: bytes, warnings: list[str]) -> ClipArrays:
        """From an npz of `POST /arrays`."""
        with np.load(io.BytesIO(npz), allow_pickle=False) as found:
            texts = {name: found[name].tolist() for name in ("columns", "units", "names", "documents")}
            numbers = ("values", "starts", "revisions", "first", "last", "seconds_per_frame")
            return cls(**texts, **{name: found[name] for name in numbers}, warnings=warnings)
