"""Least and greatest samples of channels over frame ranges, for drawing curves of whole clips.

Ranges of 256 frames and their multiples are answered from zone maps, if their order is as stored; all others are read.
Both give the same result.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.files.read_numbers import chosen_bones
from mcml.motion.skeleton import CHANNELS, Array
from mcml.numerics.runs import find_true
from mcml_service.clips.read_clip import read_clip
from mcml_service.storage.core.schema import CHUNK
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

_FACTS = 7
"""Columns of a zone map before its numbers: document, chunk, bone, commit, channels, whether some miss, count."""


@dataclass(frozen=True)
class Reduced:
    """columns: BONE.CHANNEL. step: frames a row. values: (rows, columns, 2) least and greatest, NaN without samples."""

    columns: list[str]
    step: int
    values: Array


def step_of(frames: int, pixels: int) -> int:
    """Return the number of frames in a row, so that there are at most `pixels` rows: a multiple of 256 if it is
    larger.
    """
    step = max(1, -(-frames // pixels))
    return step if step < CHUNK else -(-step // CHUNK) * CHUNK


def reduce_frames(
    tx: Transaction, stored: StoredDocument, first: int, last: int | None, pixels: int, bones: list[str] | None
) -> Reduced:
    """NotFoundError for frames or bones that the document has not."""
    source = read_clip(tx, stored, first=first, last=last, labelled=False)
    wanted = chosen_bones(source.names, bones)
    columns = [column for column in source.clip.head.skeleton.columns() if column[0] in wanted]
    frames = source.clip.frames or 0
    step = step_of(frames, pixels)
    rows = -(-frames // step)
    values = np.full((rows, len(columns), 2), np.nan)
    known = np.zeros(rows, dtype=bool)
    if step % CHUNK == 0 and frames:
        numbers = {name: number for number, name in tx.heads.bone_names(stored.key).items()}
        bone_columns = [(numbers[source.names[joint]], channel) for joint, channel in columns]
        known = _from_zones(tx, stored, (source.first, source.last, step), bone_columns, values)
    for start, stop in find_true(~known).tolist():
        low = source.first + start * step
        high = min(source.first + stop * step - 1, source.last)
        part = read_clip(tx, stored, first=low, last=high, labelled=False)
        at = 0
        for block in part.clip.blocks():
            place = {column: index for index, column in enumerate(block.columns)}
            samples = block.values[:, [place[column] for column in columns]]
            _add(values[start:stop], samples, at, step)
            at += len(block)
    labels = [f"{source.names[joint]}.{CHANNELS[channel]}" for joint, channel in columns]
    return Reduced(labels, step, values)


def reduce_values(samples: Array, pixels: int) -> tuple[int, Array]:
    """Return the frames a row (see `step_of`), and the extremes (rows, D, 2) of samples (F, D); NaN without samples."""
    step = step_of(len(samples), pixels)
    values = np.full((-(-len(samples) // step), samples.shape[1], 2), np.nan)
    if len(samples):
        _add(values, samples, 0, step)
    return step, values


def _add(values: Array, samples: Array, at: int, step: int) -> None:
    """Let rows of extremes cover samples (n, D), the first of which is number `at` of all."""
    starts = np.arange(at // step, (at + len(samples) - 1) // step + 1)
    cuts = np.maximum(starts * step - at, 0)
    with np.errstate(invalid="ignore"):
        for end, take in ((0, np.fmin), (1, np.fmax)):
            values[starts, :, end] = take(values[starts, :, end], take.reduceat(samples, cuts, axis=0))


def _from_zones(
    tx: Transaction,
    stored: StoredDocument,
    frames: tuple[int, int, int],
    columns: list[tuple[int, int]],
    values: Array,
) -> NDArray[np.bool_]:
    """Fill the rows whose frames are whole stored tracks; return these rows."""
    first, last, step = frames
    pieces = tx.tracks.pieces(stored.key, first, last)
    zones = tx.columns.zones([stored.key], sorted({bone for bone, _ in columns}))
    chunks, bones, counts = (zones[:, index].astype(np.int64) for index in (1, 2, 6))
    lengths: dict[int, int] = {}
    for chunk, count in zip(chunks.tolist(), counts.tolist(), strict=True):
        lengths[chunk] = max(lengths.get(chunk, 0), count)
    known = np.zeros(len(values), dtype=bool)
    row_of: dict[int, int] = {}
    for row in range(len(values)):
        low, high = first + row * step, min(first + (row + 1) * step - 1, last)
        piece = next((own for own in pieces if own.first <= low and high < own.first + own.count), None)
        if piece is None or (piece.slot + low - piece.first) % CHUNK:
            continue
        slot, end = piece.slot + low - piece.first, piece.slot + high - piece.first + 1
        tail = end - end % CHUNK
        if end == tail or end - tail == lengths.get(end // CHUNK):
            known[row] = True
            row_of.update(dict.fromkeys(range(slot // CHUNK, -(-end // CHUNK)), row))
    place = {column: index for index, column in enumerate(columns)}
    rows = np.array([row_of.get(chunk, -1) for chunk in chunks.tolist()], dtype=np.int64)
    for (bone, channel), index in place.items():
        mine = (bones == bone) & (rows >= 0)
        for end, take in ((0, np.fmin), (1, np.fmax)):
            take.at(values[:, index, end], rows[mine], zones[mine, _FACTS + 2 * channel + end])
    return known
