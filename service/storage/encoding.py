"""Frames to rows and back, without SQL: tracks, runs of frame ids, runs of shapes, spans of motion names."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pcodec import ChunkConfig, standalone

from service.errors import StoreError
from service.motion.clip import FrameBlock, Shape, full_shape
from service.motion.skeleton import CHANNELS, Array
from service.storage.tables import CHUNK

PCODEC = 1
"""Codec number of `track.data`: one pcodec stream of the bone's columns, one after the other."""

_CONFIG = ChunkConfig(compression_level=4)


def compress(columns: Array) -> bytes:
    """(k, n) columns as bytes. Bit-exact, NaN included."""
    return bytes(standalone.simple_compress(columns.ravel(), _CONFIG))


def decompress(data: bytes, columns: int, codec: int) -> Array:
    """The (columns, n) array that `compress` was given. StoreError where the bytes are damaged."""
    if codec != PCODEC:
        raise StoreError(f"This program does not know track codec {codec}.", remedy="Update the program.")
    try:
        values = standalone.simple_decompress(data)
        return np.asarray(values, dtype=np.float64).reshape(columns, -1)
    except (RuntimeError, ValueError, TypeError) as error:
        raise StoreError(f"A track is damaged: {error}", remedy="Restore the store from a backup.") from error


def track_row(chunk: int, bone: int, channels: Sequence[int], columns: Array) -> dict[str, Any] | None:
    """The row of one bone over one chunk, without document and commits.

    channels: channel of each of the (k, n) `columns`, which are NaN where the frame has no such attribute. Columns
    without any sample are left out; None where none is left.
    """
    missing = np.isnan(columns)
    if missing.any():
        kept = ~missing.all(axis=1)
        columns, missing = columns[kept], missing[kept]
        channels = [channel for channel, keep in zip(channels, kept, strict=True) if keep]
        if not channels:
            return None
        low, high = np.nanmin(columns, axis=1), np.nanmax(columns, axis=1)
        has_missing = sum(1 << channel for channel, gap in zip(channels, missing.any(axis=1), strict=True) if gap)
    else:
        low, high, has_missing = columns.min(axis=1), columns.max(axis=1), 0
    order = np.argsort(channels)
    if (order[1:] < order[:-1]).any():
        columns, low, high = columns[order], low[order], high[order]
        channels = [channels[i] for i in order]
    row: dict[str, Any] = dict(_NO_ZONES)
    for channel, least, greatest in zip(channels, low.tolist(), high.tolist(), strict=True):
        row[f"min_{CHANNELS[channel]}"] = least
        row[f"max_{CHANNELS[channel]}"] = greatest
    row.update(
        chunk=chunk,
        bone=bone,
        count=columns.shape[1],
        channels=sum(1 << channel for channel in channels),
        has_missing=has_missing,
        codec=PCODEC,
        data=compress(np.ascontiguousarray(columns)),
    )
    return row


_NO_ZONES: dict[str, Any] = {f"{end}_{channel}": None for channel in CHANNELS for end in ("min", "max")}


def channels_of(bits: int) -> list[int]:
    """The channel numbers whose bits are set, ascending: the order of a track's columns."""
    return [channel for channel in range(len(CHANNELS)) if bits >> channel & 1]


def pack_shape(shape: Shape) -> bytes:
    return struct.pack(f"<{2 * len(shape)}H", *(number for pair in shape for number in pair))


def unpack_shape(data: bytes) -> Shape:
    numbers = struct.unpack(f"<{len(data) // 2}H", data)
    return tuple(zip(numbers[::2], numbers[1::2], strict=True))


class FrameIdRuns:
    """Frame ids as runs of equal steps; texts that are no plain integers are kept as they are."""

    def __init__(self) -> None:
        self.rows: list[dict[str, Any]] = []
        self._next = 1

    def add(self, ids: NDArray[np.int64] | list[str]) -> None:
        if isinstance(ids, list):
            for start in range(0, len(ids), CHUNK):
                texts = ids[start : start + CHUNK]
                self._append(len(texts), None, None, json.dumps(texts, ensure_ascii=False))
            return
        steps = np.diff(ids)
        changes = np.flatnonzero(np.diff(steps)) + 1
        start = 0
        while start < len(ids):
            if start == len(ids) - 1:
                self._add_run(1, int(ids[start]), 1)
                break
            following = changes[np.searchsorted(changes, start, side="right") :]
            end = int(following[0]) if len(following) else len(steps)
            self._add_run(end - start + 1, int(ids[start]), int(steps[start]))
            start = end + 1

    def _add_run(self, count: int, first_id: int, step: int) -> None:
        if self.rows and self.rows[-1]["first_id"] is not None:
            last = self.rows[-1]
            expected = last["first_id"] + last["count"] * last["step"]
            if expected == first_id and (count == 1 or step == last["step"]):
                last["count"] += count
                self._next += count
                return
        self._append(count, first_id, step, None)

    def _append(self, count: int, first_id: int | None, step: int | None, texts: str | None) -> None:
        self.rows.append({"first": self._next, "count": count, "first_id": first_id, "step": step, "texts": texts})
        self._next += count


class Spans:
    """Motion names as spans: (name, first, last, rank), positions from 1, both ends included."""

    def __init__(self) -> None:
        self.rows: list[dict[str, Any]] = []
        self._open: dict[tuple[str, int], int] = {}
        self._previous: tuple[str, ...] = ()
        self._next = 1

    def add(self, count: int, names: Sequence[tuple[str, ...]] | None) -> None:
        if names is None:
            if self._previous:
                self._change((), self._next)
            self._next += count
            return
        for frame in names:
            if frame != self._previous:
                self._change(frame, self._next)
            self._next += 1

    def _change(self, frame: tuple[str, ...], position: int) -> None:
        wanted = {(name, rank) for rank, name in enumerate(frame)}
        for key in [key for key in self._open if key not in wanted]:
            self._close(key, position - 1)
        for key in wanted:
            self._open.setdefault(key, position)
        self._previous = frame

    def _close(self, key: tuple[str, int], last: int) -> None:
        first = self._open.pop(key)
        self.rows.append({"name": key[0], "rank": key[1], "first": first, "last": last})

    def finish(self) -> None:
        for key in list(self._open):
            self._close(key, self._next - 1)
        self.rows.sort(key=lambda row: (row["first"], row["rank"]))


@dataclass
class ClipEncoder:
    """Frame blocks of any length in, rows of whole chunks out; feed it in order, then call `finish`.

    executor: where tracks are compressed (pcodec lets other threads run).
    """

    executor: Executor
    frames: int = 0
    ids: FrameIdRuns = field(default_factory=FrameIdRuns)
    spans: Spans = field(default_factory=Spans)
    shapes: dict[Shape, int] = field(default_factory=dict)
    shape_rows: list[dict[str, Any]] = field(default_factory=list)
    _pending: list[FrameBlock] = field(default_factory=list)
    _waiting: int = 0

    def add(self, block: FrameBlock) -> Iterator[list[dict[str, Any]]]:
        """Take a block; yields the track rows of each chunk that became complete."""
        if not len(block):
            return
        self.ids.add(block.ids)
        self.spans.add(len(block), block.motion_names)
        self._add_shapes(block)
        self.frames += len(block)
        self._pending.append(block)
        self._waiting += len(block)
        if self._waiting >= CHUNK:
            yield from self._emit(whole=True)

    def finish(self) -> Iterator[list[dict[str, Any]]]:
        self.spans.finish()
        yield from self._emit(whole=False)

    def _emit(self, *, whole: bool) -> Iterator[list[dict[str, Any]]]:
        if not self._waiting:
            return
        values, columns = _joined(self._pending)
        first_chunk = (self.frames - self._waiting) // CHUNK
        end = len(values) // CHUNK * CHUNK if whole else len(values)
        starts = range(0, end, CHUNK)
        jobs = [
            self.executor.submit(_encode_chunk, first_chunk + start // CHUNK, values[start : min(start + CHUNK, end)], columns)
            for start in starts
        ]
        for job in jobs:
            yield job.result()
        self._waiting = len(values) - end
        rest = self._pending[-1]
        self._pending = [FrameBlock(values[end:].copy(), columns, rest.shapes, [])] if self._waiting else []

    def _add_shapes(self, block: FrameBlock) -> None:
        numbers = [self.shapes.setdefault(shape, len(self.shapes)) for shape in block.shapes]
        if block.shape_of is None:
            runs = [(numbers[0], len(block))]
        else:
            ends = np.flatnonzero(np.diff(block.shape_of)) + 1
            starts = np.concatenate([[0], ends]).tolist()
            stops = np.concatenate([ends, [len(block)]]).tolist()
            runs = [(numbers[int(block.shape_of[a])], b - a) for a, b in zip(starts, stops, strict=True)]
        slot = self.frames
        for number, count in runs:
            if self.shape_rows and self.shape_rows[-1]["shape"] == number:
                self.shape_rows[-1]["count"] += count
            else:
                self.shape_rows.append({"slot": slot, "count": count, "shape": number})
            slot += count
        if block.shape_of is None and block.shapes[0] == full_shape(block.columns) and not np.isfinite(block.values).all():
            raise StoreError("A block of frames holds a value that is not a finite number.")


def _joined(blocks: list[FrameBlock]) -> tuple[Array, tuple[tuple[int, int], ...]]:
    """The values of several blocks as one array, columns in the union of their layouts."""
    columns = blocks[0].columns
    if all(block.columns == columns for block in blocks):
        return (blocks[0].values if len(blocks) == 1 else np.concatenate([block.values for block in blocks])), columns
    union = dict.fromkeys(column for block in blocks for column in block.columns)
    place = {column: index for index, column in enumerate(union)}
    values = np.full((sum(map(len, blocks)), len(union)), np.nan)
    row = 0
    for block in blocks:
        values[row : row + len(block), [place[column] for column in block.columns]] = block.values
        row += len(block)
    return values, tuple(union)


def _encode_chunk(chunk: int, values: Array, columns: tuple[tuple[int, int], ...]) -> list[dict[str, Any]]:
    by_bone: dict[int, list[int]] = {}
    for index, (bone, _channel) in enumerate(columns):
        by_bone.setdefault(bone, []).append(index)
    turned = np.ascontiguousarray(values.T)
    rows = (
        track_row(chunk, bone, [columns[index][1] for index in indices], turned[indices])
        for bone, indices in by_bone.items()
    )
    return [row for row in rows if row is not None]
