"""Tracks side by side: the samples of frames as one array."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import chain
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml.numerics.runs import Some
from mcml_service.storage.documents.encoding import channels_of, decompress, decompress_into

Column: TypeAlias = tuple[int, int]
"""Number of a bone, and of a channel."""


@dataclass(frozen=True, slots=True)
class Block:
    """All tracks over one chunk of a document.

    columns: bone and channel of each row of the values; values: (columns, frames), NaN where a track ends before
    others.
    """

    columns: tuple[Column, ...]
    values: Array


@dataclass(frozen=True, slots=True)
class Stretch:
    """Some frames of one chunk. offsets: indices in the block. places: indices in the whole."""

    block: Block
    offsets: Some
    places: Some


def side_by_side(tracks: Sequence[tuple[int, int, int, int, bytes]]) -> Block:
    """The block of tracks over one chunk. StoreError where the data of one is damaged.

    tracks: (bone, channels as bits, frames, codec, data) of each, by their bones.
    """
    columns = _columns(tuple([(bone, bits) for bone, bits, *_ in tracks]))
    lengths = {count for _, _, count, *_ in tracks}
    frames = max(lengths, default=0)
    values = np.full((len(columns), frames), np.nan) if len(lengths) > 1 else np.empty((len(columns), frames))
    first = 0
    for _, bits, count, codec, data in tracks:
        own = values[first : first + len(channels_of(bits))]
        if count == frames:
            decompress_into(data, own, codec)
        else:
            own[:, :count] = decompress(data, len(own), codec)
        first += len(own)
    return Block(columns, values)


def gathered(
    stretches: Sequence[Stretch], frames: int, columns: Sequence[Column] = ()
) -> tuple[Array, tuple[Column, ...]]:
    """Return (the samples (frames, columns), NaN where there is none, and the columns).

    columns: those that are always present, in this order; others follow.
    """
    layouts = [stretch.block.columns for stretch in stretches]
    different = [layout for layout in dict.fromkeys((tuple(columns), *layouts)) if layout]
    # Nearly always all are alike.
    whole = different[0] if len(different) == 1 else tuple(dict.fromkeys(chain.from_iterable(different)))
    complete = all(len(layout) == len(whole) for layout in layouts)
    values = np.empty((frames, len(whole))) if complete else np.full((frames, len(whole)), np.nan)
    for stretch, layout in zip(stretches, layouts, strict=True):
        if not layout:
            continue
        some = _choose(stretch)
        rows, order = stretch.places, _order(layout, whole)
        if isinstance(rows, slice):
            # Transpose row by row: a transpose of the whole array, with a stride of 256 numbers, takes twice as long.
            values[rows].T[order] = some
        else:
            values[rows[:, None], order] = some.T
    return values, whole


def _choose(stretch: Stretch) -> Array:
    """The samples of the frames, (columns, frames)."""
    offsets, values = stretch.offsets, stretch.block.values
    length = offsets.stop if isinstance(offsets, slice) else int(offsets.max()) + 1
    if values.shape[1] < length:
        values = np.pad(values, ((0, 0), (0, length - values.shape[1])), constant_values=np.nan)
    return values[:, offsets]


@lru_cache(maxsize=256)
def _order(layout: tuple[Column, ...], whole: tuple[Column, ...]) -> NDArray[np.intp]:
    """Where in the whole each column of a layout is."""
    place = {column: index for index, column in enumerate(whole)}
    return np.array([place[column] for column in layout], np.intp)


@lru_cache(maxsize=256)
def _columns(tracks: tuple[tuple[int, int], ...]) -> tuple[Column, ...]:
    return tuple((bone, channel) for bone, bits in tracks for channel in channels_of(bits))
