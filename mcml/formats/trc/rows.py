"""The rows of a TRC file as blocks of frames."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from mcml.errors import FormatError, LimitError, Notice, Place
from mcml.formats.format import Limits, note
from mcml.formats.text.lines import blocks_of, line_and_column, shown
from mcml.formats.text.numbers import is_number, parse_numbers, what_is_wrong
from mcml.formats.trc.times import Times
from mcml.motion.clip import FrameBlock, Shape, full_shape
from mcml.motion.skeleton import Array, Skeleton

BLOCK_BYTES: Final = 1 << 20
LONGEST_ROW: Final = 1 << 22
_ROW = re.compile(rb"[^\r\n]+")
_SECOND = re.compile(rb"\n *[^\t\r\n ][^\t\r\n]*\t([^\t\r\n]*)")
_WHOLE = re.compile(rb"[+-]?[0-9]{1,18}")


@dataclass(frozen=True)
class Columns:
    """Which columns of the rows are markers. width: cells of a row, number and time with them. kept: cells of the
    coordinates of the markers, in their order."""

    width: int
    kept: NDArray[np.intp]


class Rows:
    """Frames of a file from a byte offset on, read again each time.

    text_start: byte offset of the first line. declared: NumFrames.
    """

    def __init__(
        self,
        stream: BinaryIO,
        start: int,
        skeleton: Skeleton,
        columns: Columns,
        text_start: int,
        declared: int | None,
        limits: Limits,
    ) -> None:
        self._stream = stream
        self._start = start
        self._text_start = text_start
        self._limits = limits
        self._columns = skeleton.columns()
        self._joints = len(skeleton)
        self._width = columns.width
        self._kept = columns.kept
        self._declared = declared
        self._names = {
            int(cell): f"{skeleton.joints[place // 3].source_name} {'XYZ'[place % 3]}"
            for place, cell in enumerate(columns.kept)
        }

    def times(self) -> Times:
        """The second column of all rows."""
        parts: list[Array] = []
        written = kept = 0
        for text, _ in self._pieces():
            cells = self._second_cells(text)
            values = parse_numbers(b" ".join(cells)) if all(cells) else None
            if values is None or len(values) != len(cells):
                known = [cell.decode("latin-1") for cell in cells]
                values = np.array([float(cell) if is_number(cell) else np.nan for cell in known])
            parts.append(values)
            fractions = [cell.partition(b".")[2] for cell in cells]
            if any(b"e" in cell or b"E" in cell for cell in fractions):
                fractions = [re.split(rb"[eE]", cell)[0] for cell in fractions]
            written = max(written, max(map(len, fractions), default=0))
            kept = max(kept, max((len(fraction.rstrip(b"0")) for fraction in fractions), default=0))
        return Times(np.concatenate(parts) if parts else np.zeros(0), written, kept)

    def _second_cells(self, text: bytes) -> list[bytes]:
        if b"\t" in text and b"\n" in text:
            return [cell.strip() for cell in _SECOND.findall(b"\n" + text)]
        rows = (self._cells(row, 2) for row in _ROW.findall(text))
        return [row[1].strip() for row in rows if len(row) > 1 and row[0].strip()]

    def blocks(self, notices: list[Notice]) -> Iterator[FrameBlock]:
        """All frames. FormatError with line, frame and marker for a bad cell."""
        done = 0
        for text, offset in self._pieces():
            read = self._read_quickly(text)
            ids, values = self._read_slowly(text, offset, done) if read is None else read
            if not len(values):
                continue
            done += len(values)
            self._limits.check_size(done, len(self._columns))
            shapes, shape_of = self._shapes(values)
            yield FrameBlock(values, self._columns, shapes, ids, shape_of)
        if self._declared is not None and done != self._declared:
            note(notices, "warning", f"NumFrames says {self._declared}, the file has {done} rows: these count")

    def _pieces(self) -> Iterator[tuple[bytes, int]]:
        """(text, byte offset) of whole rows."""
        rest, offset = b"", self._start
        for block in blocks_of(self._stream, self._start, BLOCK_BYTES):
            rest += block
            cut = max(rest.rfind(b"\n"), rest.rfind(b"\r")) + 1
            if cut:
                yield rest[:cut], offset
                rest, offset = rest[cut:], offset + cut
            elif len(rest) > LONGEST_ROW:
                raise LimitError(
                    f"a row is longer than {LONGEST_ROW >> 20} MiB",
                    at=self._place(offset),
                    remedy="Check the file.",
                )
        if rest.strip():
            yield rest, offset

    def _read_quickly(self, text: bytes) -> tuple[NDArray[np.int64], Array] | None:
        """Rows in which every cell is a number, all at once; None where one is different."""
        if b"\t\t" in text or b" " in text or b"\t" not in text:
            return None
        rows = _ROW.findall(text)
        tabs = self._width - 1
        trailing = all(row.endswith(b"\t") for row in rows)
        if any(row.count(b"\t") != tabs + trailing for row in rows):
            return None
        values = parse_numbers(text)
        if values is None or len(values) != len(rows) * self._width:
            return None
        table = values.reshape(len(rows), self._width)
        # A number such as 1.0 is not an id; ids beyond the precision of numbers are read slowly.
        if not all(_WHOLE.fullmatch(row[: row.index(b"\t")]) for row in rows):
            return None
        return table[:, 0].astype(np.int64), np.ascontiguousarray(table[:, self._kept])

    def _read_slowly(self, text: bytes, offset: int, done: int) -> tuple[NDArray[np.int64], Array]:
        ids: list[int] = []
        rows: list[list[float]] = []
        for match in _ROW.finditer(text):
            cells = [cell.strip() for cell in self._cells(match.group())]
            if not any(cells):
                continue
            start = offset + match.start()
            if not _WHOLE.fullmatch(cells[0]):
                raise FormatError(
                    f"{shown(cells[0].decode('latin-1'))} is no frame number",
                    at=self._place(start),
                    remedy="Begin rows with Frame#.",
                )
            number = int(cells[0])
            while len(cells) > self._width and not cells[-1]:
                cells.pop()
            # Rows may lack the tabs of missing samples at their end, but the last line of a file may also be
            # incomplete.
            whole = match.end() < len(text) or (done + len(rows) + 1 == self._declared and (len(cells) - 2) % 3 == 0)
            if not 2 <= len(cells) <= self._width or (len(cells) < self._width and not whole):
                raise FormatError(
                    f"frame {number} has {max(0, len(cells) - 2)} coordinates, the head says {self._width - 2}",
                    at=self._place(start),
                    remedy="Leave a cell empty where a sample is missing.",
                )
            cells += [b""] * (self._width - len(cells))
            self._number(cells[1], 1, number, start)
            ids.append(number)
            rows.append([self._number(cells[place], place, number, start) for place in self._kept.tolist()])
        values = np.array(rows, dtype=np.float64).reshape(len(rows), len(self._columns))
        return np.array(ids, dtype=np.int64), values

    def _number(self, cell: bytes, place: int, frame: int, start: int) -> float:
        if not cell or cell.lower() == b"nan":
            return float("nan")
        text = cell.decode("latin-1")
        if is_number(text):
            return float(text)
        what = f"frame {frame}, {self._names.get(place, 'time')}: {what_is_wrong(text)}"
        raise FormatError(what, at=self._place(start))

    def _place(self, offset: int) -> Place:
        """Line and column of a byte offset, found by reading the file up to there: for messages alone."""
        return line_and_column(self._stream, offset, self._text_start)

    @staticmethod
    def _cells(row: bytes, most: int = -1) -> list[bytes]:
        return row.split(b"\t", most) if b"\t" in row else row.split(None, most)

    def _shapes(self, values: Array) -> tuple[tuple[Shape, ...], NDArray[np.intp] | None]:
        missing = np.isnan(values)
        if not missing.any():
            return (full_shape(self._columns),), None
        patterns, shape_of = np.unique(missing, axis=0, return_inverse=True)
        shapes = tuple(
            tuple(
                (joint, sum(1 << axis for axis in range(3) if not gone[3 * joint + axis]))
                for joint in range(self._joints)
            )
            for gone in patterns
        )
        return shapes, shape_of.reshape(-1)
