"""Frames to rows and back, without SQL: tracks, runs of frame ids, runs of shapes, spans of motion names."""

from __future__ import annotations

import json
import struct
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, field
from functools import cache, lru_cache
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pcodec import ChunkConfig, DeltaSpec, ModeSpec, standalone

from mcml.errors import StoreError
from mcml.motion.clip import FrameBlock, Shape, full_shape
from mcml.motion.skeleton import CHANNELS, Array
from mcml.numerics.runs import find_equal
from mcml_service.storage.core.schema import CHUNK

PCODEC = 1
"""Codec number of `track.data`: one pcodec stream of the bone's columns, one after the other."""

JOBS_AHEAD = 32
"""Chunks that wait or are being compressed while the next block is read; bounds the memory of an import."""


@cache
def _config(decimals: int | None) -> ChunkConfig:
    steps = DeltaSpec.try_consecutive(1)
    if decimals is None:
        return ChunkConfig(compression_level=6, delta_spec=steps)
    # pcodec need not look for the grid: a fifth faster, and smaller although the level is lower.
    return ChunkConfig(compression_level=4, delta_spec=steps, mode_spec=ModeSpec.try_float_mult(10.0**-decimals))


def compress(columns: Array, decimals: int | None = None) -> bytes:
    """(k, n) columns as bytes. Bit-exact, NaN included. decimals: that most of the numbers have, where it is known."""
    return bytes(standalone.simple_compress(columns.ravel(), _config(decimals)))


def decompress(data: bytes, columns: int, codec: int) -> Array:
    """The (columns, n) array that `compress` was given. StoreError where the bytes are damaged."""
    if codec != PCODEC:
        raise StoreError(f"This program does not know track codec {codec}.", remedy="Update the program.")
    try:
        values = standalone.simple_decompress(data)
        return np.asarray(values, dtype=np.float64).reshape(columns, -1)
    except (RuntimeError, ValueError, TypeError) as error:
        raise StoreError(f"A track is damaged: {error}", remedy="Restore the store from a backup.") from error


def decompress_into(data: bytes, into: Array, codec: int) -> None:
    """As `decompress`, into a contiguous array of the shape (columns, n)."""
    if codec != PCODEC:
        raise StoreError(f"This program does not know track codec {codec}.", remedy="Update the program.")
    try:
        done = standalone.simple_decompress_into(data, into.reshape(-1))
    except (RuntimeError, ValueError, TypeError) as error:
        raise StoreError(f"A track is damaged: {error}", remedy="Restore the store from a backup.") from error
    if not done.finished or done.n_processed != into.size:
        raise StoreError("A track is damaged: it has another length.", remedy="Restore the store from a backup.")


TrackRow: TypeAlias = tuple[Any, ...]
"""A row of `track` without document and commits: the columns TRACK_COLUMNS."""

TRACK_COLUMNS: Final = (
    *("chunk", "bone", "count", "channels", "has_missing", "codec", "data"),
    *(f"{end}_{channel}" for channel in CHANNELS for end in ("min", "max")),
)
DATA_PLACE = TRACK_COLUMNS.index("data")
_NO_ZONES: Final[list[float | None]] = [None] * (2 * len(CHANNELS))


@cache
def channels_of(bits: int) -> list[int]:
    """The channel numbers whose bits are set, ascending: the order of a track's columns."""
    return [channel for channel in range(len(CHANNELS)) if bits >> channel & 1]


@lru_cache(maxsize=256)
def pack_shape(shape: Shape) -> bytes:
    return struct.pack(f"<{2 * len(shape)}H", *(number for pair in shape for number in pair))


def unpack_shape(data: bytes) -> Shape:
    numbers = struct.unpack(f"<{len(data) // 2}H", data)
    return tuple(zip(numbers[::2], numbers[1::2], strict=True))


def is_plain_integer(text: str) -> bool:
    """Whether an id is kept as an integer: in the one spelling that the number has, and of at most 18 characters."""
    return text.isascii() and text.removeprefix("-").isdigit() and len(text) < 19 and str(int(text)) == text


class FrameIdRuns:
    """Frame ids as runs of equal steps; texts that are not plain integers are kept unchanged."""

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

    def parts(self) -> list[NDArray[np.int64] | list[str]]:
        """The ids again, run by run."""
        return [
            row["first_id"] + row["step"] * np.arange(row["count"], dtype=np.int64)
            if row["texts"] is None
            else json.loads(row["texts"])
            for row in self.rows
        ]

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
    """Frame blocks of any length in, rows of whole chunks out; feed it in order, then `close` it and take the `rest`.

    decimals: number of decimals of most numbers in the source, if known: gives smaller tracks, faster. executor:
    compresses tracks. Chunks of short clips wait for `compress`: pcodec releases the lock for 25 µs at a time, and is
    slower while another thread reads than after it.
    """

    executor: Executor
    decimals: int | None = None
    frames: int = 0
    ids: FrameIdRuns = field(default_factory=FrameIdRuns)
    spans: Spans = field(default_factory=Spans)
    shapes: dict[Shape, int] = field(default_factory=dict)
    shape_rows: list[dict[str, Any]] = field(default_factory=list)
    _pending: list[FrameBlock] = field(default_factory=list)
    _waiting: int = 0
    _is_long: bool = False
    _held: list[tuple[int, Array, tuple[tuple[int, int], ...]]] = field(default_factory=list)
    _jobs: deque[Future[list[TrackRow]]] = field(default_factory=deque)

    def add(self, block: FrameBlock) -> Iterator[list[TrackRow]]:
        """Take a block; yields the track rows of chunks that are done, in order, some blocks later."""
        if not len(block):
            return
        self.ids.add(block.ids)
        self.spans.add(len(block), block.motion_names)
        self._add_shapes(block)
        self.frames += len(block)
        self._pending.append(block)
        self._waiting += len(block)
        if self._waiting >= CHUNK:
            self._submit(whole=True)
        while len(self._jobs) > JOBS_AHEAD:
            yield self._jobs.popleft().result()

    def close(self) -> None:
        """No block follows."""
        self.spans.finish()
        self._submit(whole=False)

    def compress(self) -> None:
        """Let the chunks that wait be compressed."""
        self._jobs += [self.executor.submit(encode_chunk, *chunk, self.decimals) for chunk in self._held]
        self._held.clear()

    def rest(self) -> Iterator[list[TrackRow]]:
        """The rows of all chunks that are still on their way."""
        self.compress()
        while self._jobs:
            yield self._jobs.popleft().result()

    def _submit(self, *, whole: bool) -> None:
        if not self._waiting:
            return
        values, columns = join_blocks(self._pending)
        first_chunk = (self.frames - self._waiting) // CHUNK
        end = len(values) // CHUNK * CHUNK if whole else len(values)
        for start in range(0, end, CHUNK):
            part = values[start : min(start + CHUNK, end)]
            self._held.append((first_chunk + start // CHUNK, part, columns))
        self._is_long = self._is_long or len(self._held) > JOBS_AHEAD
        if self._is_long:
            self.compress()
        self._waiting = len(values) - end
        rest = self._pending[-1]
        self._pending = [FrameBlock(values[end:].copy(), columns, rest.shapes, [])] if self._waiting else []

    def _add_shapes(self, block: FrameBlock) -> None:
        numbers = [self.shapes.setdefault(shape, len(self.shapes)) for shape in block.shapes]
        if block.shape_of is None:
            runs = [(numbers[0], len(block))]
        else:
            bounds = find_equal(block.shape_of).tolist()
            runs = [(numbers[int(block.shape_of[begin])], end - begin) for begin, end in bounds]
        slot = self.frames
        for number, count in runs:
            if self.shape_rows and self.shape_rows[-1]["shape"] == number:
                self.shape_rows[-1]["count"] += count
            else:
                self.shape_rows.append({"slot": slot, "count": count, "shape": number})
            slot += count
        if (
            block.shape_of is None
            and block.shapes[0] == full_shape(block.columns)
            and not np.isfinite(block.values).all()
        ):
            raise StoreError("A block of frames holds a value that is not a finite number.")


def join_blocks(blocks: Sequence[FrameBlock]) -> tuple[Array, tuple[tuple[int, int], ...]]:
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


def encode_chunk(
    chunk: int, values: Array, columns: Sequence[tuple[int, int]], decimals: int | None = None
) -> list[TrackRow]:
    """Return the rows of all bones over one chunk.

    values: (n, D), NaN where a frame has no such attribute. columns: (bone, channel) of each. Channels without any
    sample are left out of their row, and bones without any have none. decimals: as for `compress`.
    """
    turned = np.ascontiguousarray(values.T)
    # These are NaN where a sample is missing.
    low, high = turned.min(axis=1), turned.max(axis=1)
    gaps = np.isnan(low)
    if gaps.any():
        low, high = np.fmin.reduce(turned, axis=1), np.fmax.reduce(turned, axis=1)
    lows, highs, has_gap = low.tolist(), high.tolist(), gaps.tolist()
    rows = []
    for bone in _bones(tuple(columns)):
        zones = _NO_ZONES.copy()
        bits, missing, place = bone.bits, 0, bone.place
        for index, channel in zip(bone.indices, bone.channels, strict=True):
            least = lows[index]
            if least != least:
                bits &= ~(1 << channel)
                place = [other for other in bone.indices if lows[other] == lows[other]]
                continue
            zones[2 * channel], zones[2 * channel + 1] = least, highs[index]
            missing |= has_gap[index] << channel
        if bits:
            data = compress(turned[place], decimals)
            rows.append((chunk, bone.number, turned.shape[1], bits, missing, PCODEC, data, *zones))
    return rows


@dataclass(frozen=True)
class _Bone:
    """A bone in a layout of columns, channels ascending.

    indices: of its columns; place: the same, as a slice if they are adjacent (a view, not a copy). bits: its channels.
    """

    number: int
    channels: list[int]
    indices: list[int]
    place: slice | list[int]
    bits: int


@lru_cache(maxsize=64)
def _bones(columns: tuple[tuple[int, int], ...]) -> list[_Bone]:
    by_bone: dict[int, list[int]] = {}
    for index, (bone, _channel) in enumerate(columns):
        by_bone.setdefault(bone, []).append(index)
    result = []
    for bone, own in by_bone.items():
        indices = sorted(own, key=lambda index: columns[index][1])
        channels = [columns[index][1] for index in indices]
        neighbours = indices == list(range(indices[0], indices[0] + len(indices)))
        place = slice(indices[0], indices[0] + len(indices)) if neighbours else indices
        bits = sum(1 << channel for channel in channels)
        result.append(_Bone(bone, channels, indices, place, bits))
    return result
