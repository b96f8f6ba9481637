"""Tracks side by side: the samples of frames as one array."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import chain
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from service.motion.skeleton import Array
from service.storage.encoding import channels_of

Column: TypeAlias = tuple[int, int]
"""Number of a bone, and of a channel."""
Some: TypeAlias = slice | NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Stretch:
    """Some frames of one chunk. columns: what the rows of the parts hold, one after the other. parts: samples (channels,
    n), where one ends before the frames do NaN. offsets: which frames of the chunk. places: where they stand in the
    block."""

    columns: tuple[Column, ...]
    parts: Sequence[Array]
    offsets: Some
    places: Some


def gathered(
    stretches: Sequence[Stretch], frames: int, columns: Sequence[Column] = ()
) -> tuple[Array, tuple[Column, ...]]:
    """(the samples (frames, columns), NaN where there is none, and what the columns are).

    columns: those that there are in any case, in this order; others that occur follow.
    """
    layouts = [stretch.columns for stretch in stretches]
    different = [layout for layout in dict.fromkeys((tuple(columns), *layouts)) if layout]
    # Nearly always all are alike.
    whole = different[0] if len(different) == 1 else tuple(dict.fromkeys(chain.from_iterable(different)))
    complete = all(len(layout) == len(whole) for layout in layouts)
    values = np.empty((frames, len(whole))) if complete else np.full((frames, len(whole)), np.nan)
    for stretch, layout in zip(stretches, layouts, strict=True):
        if not layout:
            continue
        chosen = _chosen(stretch)
        some = chosen[0] if len(chosen) == 1 else np.concatenate(chosen)
        order = _order(layout, whole)
        if len(layout) == len(whole):
            values[stretch.places] = (some if layout == whole else some[order]).T
            continue
        rows = stretch.places
        values[rows if isinstance(rows, slice) else rows[:, None], order] = some.T
    return values, whole


def evenly(numbers: NDArray[np.int64]) -> Some:
    """The same as a slice where they ascend by equal distances, which arrays read and write several times faster."""
    first, last, count = int(numbers[0]), int(numbers[-1]), len(numbers)
    if count == 1:
        return slice(first, first + 1)
    step = (last - first) // max(1, count - 1) or 1
    regular = slice(first, last + 1, step)
    return regular if np.array_equal(np.arange(first, last + 1, step), numbers) else numbers


def _chosen(stretch: Stretch) -> list[Array]:
    """The samples of each part at the frames."""
    offsets = stretch.offsets
    length = offsets.stop if isinstance(offsets, slice) else int(offsets.max()) + 1
    return [
        samples[:, offsets]
        if samples.shape[1] >= length
        else np.pad(samples, ((0, 0), (0, length - samples.shape[1])), constant_values=np.nan)[:, offsets]
        for samples in stretch.parts
    ]


@lru_cache(maxsize=256)
def _order(layout: tuple[Column, ...], whole: tuple[Column, ...]) -> NDArray[np.intp]:
    """Where in a layout each column of the whole is, if it has all; else where in the whole each of its own is."""
    searched, wanted = (layout, whole) if len(layout) == len(whole) else (whole, layout)
    place = {column: index for index, column in enumerate(searched)}
    return np.array([place[column] for column in wanted], np.intp)


@lru_cache(maxsize=256)
def columns_of(tracks: tuple[tuple[int, int], ...]) -> tuple[Column, ...]:
    """The columns of tracks side by side. tracks: number of the bone and channels as bits of each."""
    return tuple((bone, channel) for bone, bits in tracks for channel in channels_of(bits))
