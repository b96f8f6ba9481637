"""Frames: written as chunk rows, read as blocks of arrays for any range of positions and any bones."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import BigInteger, and_, bindparam, delete, func, select, update

from mcml.errors import NotFoundError, StoreError
from mcml.motion.clip import FrameBlock, Shape
from mcml.motion.skeleton import Array
from mcml_service.storage.core.schema import CHUNK, CURRENT
from mcml_service.storage.core.seals import closing, unsound, verify
from mcml_service.storage.core.sql_expressions import OneOf
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import frame_run, shape, shape_run, timeline, track
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.validity import of_document
from mcml_service.storage.documents.blocks import Stretch, gathered, side_by_side
from mcml_service.storage.documents.damage import describe_track_damage
from mcml_service.storage.documents.encoding import (
    DATA_PLACE,
    TRACK_COLUMNS,
    FrameIdRuns,
    TrackRow,
    channels_of,
    decompress,
    encode_chunk,
    is_plain_integer,
    pack_shape,
    unpack_shape,
)

BLOCK_FRAMES = 8 * CHUNK
"""Frames read with one query; bounds the memory of a stream."""


@dataclass(frozen=True)
class Piece:
    """`count` frames at positions from `first` are in slots from `slot`."""

    first: int
    slot: int
    count: int


_TRACK_ROW = ("document", "from_commit", "to_commit", *TRACK_COLUMNS)
_FIRST, _LAST = bindparam("first", type_=BigInteger), bindparam("last", type_=BigInteger)

# Prepared once: building a statement takes longer than running a short one. Each returns rows that overlap first to
# last.
_PIECES = Prepared(
    select(timeline.c.first, timeline.c.slot, timeline.c.count)
    .where(of_document(timeline), timeline.c.first <= _LAST, timeline.c.first + timeline.c.count > _FIRST)
    .order_by(timeline.c.first),
    timeline,
)
_SHAPE_RUNS = Prepared(
    select(shape_run.c.slot, shape_run.c.count, shape.c.bones)
    .join(shape, and_(shape.c.document == shape_run.c.document, shape.c.shape == shape_run.c.shape))
    .where(of_document(shape_run), shape_run.c.slot <= _LAST, shape_run.c.slot + shape_run.c.count > _FIRST)
    .order_by(shape_run.c.slot),
    shape_run,
    shape,
)
_FRAME_RUNS = Prepared(
    select(frame_run.c.first, frame_run.c.count, frame_run.c.first_id, frame_run.c.step, frame_run.c.texts)
    .where(of_document(frame_run), frame_run.c.first <= _LAST, frame_run.c.first + frame_run.c.count > _FIRST)
    .order_by(frame_run.c.first),
    frame_run,
)
_TRACKS = Prepared(
    select(
        track.c.chunk, track.c.bone, track.c.channels, track.c.count, track.c.codec, track.c.data, track.c.data_checksum
    ).where(of_document(track), track.c.chunk >= _FIRST, track.c.chunk <= _LAST)
)
_TRACKS_OF_BONES = _TRACKS.where(OneOf(track.c.bone, "bones"))


class Tracks:
    def __init__(self, tx: BaseTransaction) -> None:
        self._tx = tx

    # -- writing ---------------------------------------------------------------------------------------------------

    def write_chunks(self, document_key: int, rows: list[TrackRow], from_commit: int, behind: int = 0) -> None:
        """Add track rows of `ClipEncoder`, shifted by a number of chunks."""
        if behind:
            rows = [(chunk + behind, *rest) for chunk, *rest in rows]
        self._tx.insert_tuples(track, _TRACK_ROW, [(document_key, from_commit, CURRENT, *row) for row in rows])

    def write_shapes(self, document_key: int, shapes: dict[Shape, int]) -> None:
        rows = [{"document": document_key, "shape": n, "bones": pack_shape(s)} for s, n in shapes.items()]
        self._tx.insert_rows(shape, rows)

    def write_shape_runs(self, document_key: int, rows: list[dict[str, Any]], from_commit: int) -> None:
        self._write(shape_run, document_key, rows, from_commit)

    def write_frame_runs(self, document_key: int, rows: list[dict[str, Any]], from_commit: int) -> None:
        self._write(frame_run, document_key, rows, from_commit)

    def write_timeline(self, document_key: int, pieces: Sequence[Piece], from_commit: int) -> None:
        self._write(timeline, document_key, [vars(piece) for piece in pieces], from_commit)

    def _write(self, table: Any, document_key: int, rows: list[dict[str, Any]], from_commit: int) -> None:
        self._tx.insert_rows(
            table,
            [row | {"document": document_key, "from_commit": from_commit, "to_commit": CURRENT} for row in rows],
        )

    def close(self, table: Any, document_key: int) -> None:
        """End all rows of the document in `timeline`, `frame_run` or `shape_run` with this commit."""
        self._end(table, and_(table.c.document == document_key, table.c.to_commit == CURRENT))

    def _end(self, table: Any, rows: Any) -> None:
        """Close current rows; rows written by this commit itself were never visible, and are deleted."""
        commit = self._tx.commit
        self._tx.run(delete(table).where(rows, table.c.from_commit == commit))
        self._tx.run(update(table).where(rows).values(closing(table, commit)))

    def shape_number(self, document_key: int, wanted: Shape) -> int:
        """The number of a shape in the document, a new one where it has none like it."""
        packed = pack_shape(wanted)
        query = select(shape.c.shape).where(shape.c.document == document_key, shape.c.bones == packed)
        number_of_equal = self._tx.fetch_value(query)
        if number_of_equal is not None:
            return int(number_of_equal)
        newest = select(func.coalesce(func.max(shape.c.shape), -1)).where(shape.c.document == document_key)
        number = int(self._tx.fetch_value(newest)) + 1
        self._tx.insert_rows(shape, [{"document": document_key, "shape": number, "bones": packed}])
        return number

    def rewrite_chunk(self, document_key: int, chunk: int, bone: int, channels: list[int], columns: Array) -> int:
        """Replace one track row from this commit on; returns the bytes written. Empty columns leave no row."""
        valid = and_(track.c.document == document_key, track.c.chunk == chunk, track.c.bone == bone)
        self._end(track, and_(valid, track.c.to_commit == CURRENT))
        rows = encode_chunk(chunk, columns.T, [(bone, channel) for channel in channels])
        self.write_chunks(document_key, rows, self._tx.commit)
        return sum(len(row[DATA_PLACE]) for row in rows)

    def close_run(self, table: Any, document_key: int, start: Any, position: int) -> dict[str, Any]:
        """End the run that holds a position (or slot) with this commit, and answer its columns by name."""
        holds = and_(table.c.document == document_key, table.c.to_commit == CURRENT, start <= position)
        (run,) = self._tx.fetch_all(select(table).where(holds, start + table.c.count > position))
        row = dict(run._mapping)
        holds = and_(table.c.document == document_key, start == row[start.name], table.c.to_commit == CURRENT)
        self._end(table, holds)
        return row

    def rewrite_frame_ids(self, document_key: int, parts: Sequence[NDArray[np.int64] | list[str]]) -> None:
        """Replace the ids of all frames from this commit on. Texts that are plain integers are kept as such."""
        runs = FrameIdRuns()
        for part in parts:
            plain = isinstance(part, np.ndarray) or all(is_plain_integer(text) for text in part)
            runs.add(np.array(part, dtype=np.int64) if plain else part)
        self.close(frame_run, document_key)
        self.write_frame_runs(document_key, runs.rows, self._tx.commit)

    def shapes(self, document_key: int) -> dict[int, Shape]:
        """Every shape that a frame of the document has had, by its number."""
        query = select(shape.c.shape, shape.c.bones).where(shape.c.document == document_key)
        return {number: unpack_shape(packed) for number, packed in self._tx.fetch_all(query)}

    def shapes_in_use(self, document_key: int) -> list[Shape]:
        """Every distinct shape that a current frame has."""
        query = (
            select(shape.c.bones)
            .join(shape_run, and_(shape_run.c.document == shape.c.document, shape_run.c.shape == shape.c.shape))
            .where(shape.c.document == document_key, self._tx.valid(shape_run))
            .distinct()
        )
        return [unpack_shape(packed) for (packed,) in self._tx.fetch_all(verify(query, shape))]

    def _shape_runs(self, document_key: int, start: int, end: int) -> Iterator[tuple[int, int, Shape]]:
        """(slot, count, shape) of the runs in slots start to end - 1, cut to them."""
        for slot, count, packed in self._rows(_SHAPE_RUNS, document_key, start, end - 1):
            first, last = max(slot, start), min(slot + count, end)
            yield first, last - first, unpack_shape(packed)

    def frame_bones(self, document_key: int, first: int, last: int) -> Iterator[tuple[int, int]]:
        """(frames, frame_bones of each) of frames first to last, in runs."""
        for piece in self.pieces(document_key, first, last):
            for _, count, bones in self._shape_runs(document_key, piece.slot, piece.slot + piece.count):
                yield count, len(bones)

    def shape_at(self, document_key: int, slot: int) -> Shape:
        """The shape of the frame in a slot."""
        return self._shapes(document_key, slot, slot + 1, None)[0][0]

    def chunk_length(self, document_key: int, chunk: int) -> int:
        """How many slots of a chunk hold frames."""
        query = select(func.max(track.c.count)).where(track.c.document == document_key, track.c.chunk == chunk)
        return int(self._tx.fetch_value(query) or CHUNK)

    def chunk(self, document_key: int, chunk: int, bone: int) -> tuple[list[int], Array] | None:
        """(channels, (k, n) columns) of one track row, None where the bone has none in that chunk."""
        query = select(track.c.channels, track.c.codec, track.c.data, track.c.data_checksum).where(
            track.c.document == document_key, track.c.chunk == chunk, track.c.bone == bone, self._tx.valid(track)
        )
        row = self._tx.fetch_one(query)
        if row is None:
            return None
        channels = channels_of(row.channels)
        if unsound([tuple(row)], codec=1) is not None:
            raise describe_track_damage(self._tx, document_key, chunk, bone)
        return channels, decompress(row.data, len(channels), row.codec).copy()

    # -- reading ---------------------------------------------------------------------------------------------------

    def pieces(self, document_key: int, first: int, last: int) -> list[Piece]:
        """The timeline from frame first to last, cut to it."""
        result = []
        for start, slot, count in self._rows(_PIECES, document_key, first, last):
            begin, end = max(start, first), min(start + count - 1, last)
            result.append(Piece(begin, slot + begin - start, end - begin + 1))
        return result

    def slot_of(self, document_key: int, position: int) -> int:
        """Return the slot of a frame. Raises NotFoundError."""
        pieces = self.pieces(document_key, position, position)
        if not pieces:
            raise NotFoundError(f"The document has no frame {position}.")
        return pieces[0].slot

    def blocks(
        self,
        document_key: int,
        first: int,
        last: int,
        *,
        columns: Sequence[tuple[int, int]] = (),
        bones: Sequence[int] | None = None,
        step: int = 1,
        bare: bool = False,
    ) -> Iterator[FrameBlock]:
        """Frames first to last (positions) in blocks of bounded size, without motion names.

        columns: (bone, channel) that every block has, in this order; further channels that occur follow.
        bones: read these only (shapes keep the others out too). step: every step-th frame, counted from `first`.
        bare: samples alone, without shapes and ids.
        """
        for piece in self.pieces(document_key, first, last):
            start = piece.slot
            while start < piece.slot + piece.count:
                # End at a multiple of the block size, so that no chunk is read twice.
                end = min((start // BLOCK_FRAMES + 1) * BLOCK_FRAMES, piece.slot + piece.count)
                position = piece.first + start - piece.slot
                skip = -(position - first) % step
                block = self._block(document_key, start, end, position, columns, bones, bare=bare)
                if step > 1:
                    block = _every(block, skip, step)
                if len(block):
                    yield block
                start = end

    def _block(
        self,
        document_key: int,
        start: int,
        end: int,
        position: int,
        columns: Sequence[tuple[int, int]],
        bones: Sequence[int] | None,
        *,
        bare: bool,
    ) -> FrameBlock:
        """The frames in slots start to end - 1, which are neighbours on the timeline."""
        first_chunk, last_chunk = start // CHUNK, (end - 1) // CHUNK
        tracks: dict[int, list[tuple[int, int, int, int, bytes]]] = {n: [] for n in range(first_chunk, last_chunk + 1)}
        if bones is None:
            rows = self._rows(_TRACKS, document_key, first_chunk, last_chunk)
        else:
            rows = self._rows(_TRACKS_OF_BONES, document_key, first_chunk, last_chunk, bones=list(bones))
        if (wrong := unsound(rows, codec=4)) is not None:
            raise describe_track_damage(self._tx, document_key, *wrong[:2])
        for row in sorted(rows, key=itemgetter(0, 1)):
            tracks[row[0]].append(row[1:6])
        stretches = []
        for chunk, held in tracks.items():
            begin, stop = max(start, chunk * CHUNK), min(end, (chunk + 1) * CHUNK)
            offsets = slice(begin - chunk * CHUNK, stop - chunk * CHUNK)
            stretches.append(Stretch(side_by_side(held), offsets, slice(begin - start, stop - start)))
        values, whole = gathered(stretches, end - start, columns)
        if bare:
            return FrameBlock(values, whole, (), [])
        shapes, shape_of = self._shapes(document_key, start, end, bones)
        ids = self.frame_ids(document_key, position, position + end - start - 1)
        return FrameBlock(values, whole, shapes, ids, shape_of)

    def _shapes(
        self, document_key: int, start: int, end: int, bones: Sequence[int] | None
    ) -> tuple[tuple[Shape, ...], NDArray[np.intp] | None]:
        numbers: dict[Shape, int] = {}
        runs: list[tuple[int, int]] = []
        wanted = None if bones is None else set(bones)
        for _, count, whole in self._shape_runs(document_key, start, end):
            kept = whole if wanted is None else tuple(pair for pair in whole if pair[0] in wanted)
            runs.append((numbers.setdefault(kept, len(numbers)), count))
        if sum(count for _, count in runs) != end - start:
            raise StoreError("The store has no shape for some frames.", remedy="Run `mcml db check`.")
        if len(numbers) == 1:
            return tuple(numbers), None
        indices = np.repeat([number for number, _ in runs], [count for _, count in runs])
        return tuple(numbers), indices.astype(np.intp)

    def frame_ids(self, document_key: int, first: int, last: int) -> NDArray[np.int64] | list[str]:
        """The ids of frames first to last: integers, or texts where one of them is not a plain integer."""
        parts: list[NDArray[np.int64] | list[str]] = []
        for start, count, first_id, step, texts in self._rows(_FRAME_RUNS, document_key, first, last):
            a, b = max(first, start) - start, min(last + 1, start + count) - start
            if texts is not None:
                parts.append(json.loads(texts)[a:b])
            else:
                parts.append(first_id + step * np.arange(a, b, dtype=np.int64))
        if all(isinstance(part, np.ndarray) for part in parts):
            return np.concatenate([*parts, np.empty(0, np.int64)])
        return [str(item) for part in parts for item in part]

    def _rows(self, query: Prepared, document_key: int, first: int, last: int, **given: Any) -> Sequence[Any]:
        given |= {"document": document_key, "at": self._tx.at, "first": first, "last": last}
        return self._tx.fetch_all(query, given)


def _every(block: FrameBlock, skip: int, step: int) -> FrameBlock:
    return FrameBlock(
        block.values[skip::step],
        block.columns,
        block.shapes,
        block.ids[skip::step],
        None if block.shape_of is None else block.shape_of[skip::step],
    )
