"""Revert samples, also if later commits have written other samples of the same tracks, or other frames of the same run.

A track holds 256 frames of one bone, and a run of frames with the same channels many more: both are rewritten for a
single sample. The changes of a commit are found by comparison, sample by sample, and so are later changes of the same
samples.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mcml.motion.clip import Shape
from mcml.motion.skeleton import CHANNELS, Array
from mcml.numerics.runs import find_equal
from mcml_service.storage.core.tables import shape_run

if TYPE_CHECKING:
    from mcml_service.storage.documents.documents import StoredDocument
    from mcml_service.storage.transaction import Transaction

Track = tuple[list[int], Array]
"""(channels, (k, n) columns): one bone in one chunk."""

Run = tuple[int, int, int]
"""(first slot, slots, number of the shape)."""


def merge_track(before: Track | None, after: Track | None, now: Track | None) -> Track | None:
    """Return the current samples, with those that changed from before to after reverted.

    None for a bone without samples. Raises LookupError if one of these was changed since.
    """
    length = max(track[1].shape[1] for track in (before, after, now) if track is not None)
    (first, two, three) = (_whole(track, length) for track in (before, after, now))
    changed = ~_same(first, two)
    if (changed & ~_same(two, three)).any():
        raise LookupError
    merged = np.where(changed, first, three)
    channels = np.flatnonzero(~np.isnan(merged).all(axis=1)).tolist()
    return (channels, merged[channels]) if channels else None


def _whole(track: Track | None, length: int) -> Array:
    """Return (channels, n) with NaN for missing samples."""
    whole = np.full((len(CHANNELS), length), np.nan)
    if track is not None:
        whole[track[0], : track[1].shape[1]] = track[1]
    return whole


def _same(one: Array, other: Array) -> NDArray[np.bool_]:
    """Bit by bit, but that every missing sample is the same."""
    same: NDArray[np.bool_] = one.view(np.int64) == other.view(np.int64)
    return same | (np.isnan(one) & np.isnan(other))


def take_back_tracks(tx: Transaction, stored: StoredDocument, at: int, places: set[tuple[int, int]]) -> None:
    """Revert the samples that commit `at` wrote at these (chunk, bone).

    Raises LookupError if they were changed since.
    """
    before, after = tx.at_commit(at - 1).tracks, tx.at_commit(at).tracks
    for chunk, bone in sorted(places):
        was, became, now = (tracks.chunk(stored.key, chunk, bone) for tracks in (before, after, tx.tracks))
        channels, columns = merge_track(was, became, now) or ([], np.empty((0, 0)))
        tx.tracks.rewrite_chunk(stored.key, chunk, bone, channels, columns)


def merge_runs(before: list[Run], after: list[Run], now: list[Run], merge: Callable[[int, int, int], int]) -> list[Run]:
    """The same for which shape the frames of slots have.

    merge: the number of the shape for a frame that had one before, another after, and a third one now; it raises
    LookupError where they do not go together.
    """
    slots = max((first + count for runs in (before, after, now) for first, count, _ in runs), default=0)
    old, two, three = (_by_slot(runs, slots) for runs in (before, after, now))
    changed = old != two
    merged = np.where(changed, old, three)
    touched = changed & (two != three)
    for shapes in np.unique(np.stack([old, two, three])[:, touched], axis=1).T.tolist():
        merged[touched & (old == shapes[0]) & (two == shapes[1]) & (three == shapes[2])] = merge(*shapes)
    runs = [(start, end - start, int(merged[start])) for start, end in find_equal(merged).tolist()]
    return [run for run in runs if run[2] >= 0]


def merge_shape(before: Shape, after: Shape, now: Shape) -> Shape:
    """Return the current attributes, with those added or removed from before to after reverted.

    Raises LookupError if one of these, or the set of bones, was changed since.
    """
    if not [bone for bone, _ in before] == [bone for bone, _ in after] == [bone for bone, _ in now]:
        raise LookupError
    merged = []
    for (bone, first), (_, two), (_, three) in zip(before, after, now, strict=True):
        changed = first ^ two
        if (two ^ three) & changed:
            raise LookupError
        merged.append((bone, three ^ changed))
    return tuple(merged)


def take_back_shapes(tx: Transaction, stored: StoredDocument, runs: tuple[list[Run], list[Run], list[Run]]) -> None:
    """Merge the shapes of frames before a commit, after it and now, and write them. Raises LookupError."""
    shapes = tx.tracks.shapes(stored.key)

    def merge(*numbers: int) -> int:
        if -1 in numbers:
            raise LookupError
        before, after, now = (shapes[number] for number in numbers)
        return tx.tracks.shape_number(stored.key, merge_shape(before, after, now))

    rows = [{"slot": slot, "count": count, "shape": number} for slot, count, number in merge_runs(*runs, merge)]
    tx.tracks.close(shape_run, stored.key)
    tx.tracks.write_shape_runs(stored.key, rows, tx.commit)


def _by_slot(runs: list[Run], slots: int) -> NDArray[np.int64]:
    numbers = np.full(slots, -1, dtype=np.int64)
    for first, count, shape in runs:
        numbers[first : first + count] = shape
    return numbers
