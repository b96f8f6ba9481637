"""Samples of many tracks as one array."""

from __future__ import annotations

from functools import cache, partial

import numpy as np

from mcml.numerics.runs import Some, evenly
from mcml_service.storage.core.schema import CHUNK
from mcml_service.storage.documents.encoding import channels_of
from mcml_service.xpath.library.forest import Forest
from mcml_service.xpath.library.zones import BITS, Table, rows_of
from mcml_service.xpath.nodes.numbering import Floats, Ints

MOST_TRACKS = 16_384
"""Limit of tracks of a bone in a group whose samples are cached in one array; with more, samples are read as needed."""
FEW = 16
"""One of this many tracks of a bone is decoded alone rather than all together."""


def track_values(forest: Forest, table: Table, wanted: tuple[int, ...]) -> Floats:
    """(channels, tracks, CHUNK): samples of tracks, NaN where a frame has none."""
    held = np.flatnonzero(table.about[BITS])
    bits = table.about[BITS, held].tolist()
    places = {each: _places(each, wanted) for each in set(bits)}
    values = np.full((len(wanted), len(table), CHUNK), np.nan)
    tracks = forest.caches.tracks.read(forest.tx, rows_of(table.about[:, held]))
    for unit, track, each in zip(held.tolist(), tracks, bits, strict=True):
        here, there = places[each]
        values[here, unit, : track.shape[1]] = track[there]
    return values


def side_by_side(forest: Forest, name: str, channel: int, places: Ints, slots: Ints) -> Floats | None:
    """Return the samples of a channel of the bone with a name in slots of documents, which all have one; None if so few
    of its tracks are needed that they are better read separately. A query that compares a bone with itself in other
    frames needs all of its tracks, a slice of frames at a time.
    """
    if not forest.has_tracks(len(forest)):
        return None
    bone = forest.bone(name)
    at_hand = forest.has_samples(name, channel)
    keys = (places << 32) | (slots // CHUNK)
    asked = 1 + int(np.count_nonzero(np.diff(keys)))
    if len(bone) > MOST_TRACKS or not (at_hand or asked * FEW >= len(bone)):
        return None
    read = partial(_one_channel, forest, bone.table, channel)
    values = forest.samples(name, channel, read)
    rows = np.searchsorted(bone.table.frames, keys)
    return np.asarray(values[rows, slots % CHUNK], np.float64)


def _one_channel(forest: Forest, table: Table, channel: int) -> Floats:
    return np.asarray(track_values(forest, table, (channel,))[0], np.float64)


@cache
def _places(bits: int, wanted: tuple[int, ...]) -> tuple[Some, Some]:
    """Return the indices of a track's channels among the requested ones, and in the track."""
    held = channels_of(bits)
    both = [(place, held.index(channel)) for place, channel in enumerate(wanted) if channel in held]
    here, there = np.array(both, np.int64).reshape(-1, 2).T
    return (evenly(here), evenly(there)) if both else (here, there)
