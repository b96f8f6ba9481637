"""The rows of a TRC file as blocks of frames."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from service.errors import FormatError, LimitError, Notice, Place
from service.formats.format import Limits, note
from service.formats.lines import blocks_of, line_and_column, shown
from service.formats.numbers import is_number, parse_numbers, what_is_wrong
from service.motion.clip import FrameBlock, Shape, full_shape
from service.motion.skeleton import Array, Skeleton

BLOCK_BYTES: Final = 1 << 20
LONGEST_ROW: Final = 1 << 22
_ROW = re.compile(rb"[^\r\n]+")
_WHOLE = re.compile(rb"[+-]?[0-9]{1,18}")


@dataclass(frozen=True)
class TimeColumn:
    """How the second cell of a row is written: with so many decimals, from the time of the first frame on."""

    decimals: int
    first: float


class Rows:
    """Frames of a file from a byte offset on, read anew each time.

    text_start: byte offset of the first line. declared: NumFrames. rate: frames a second, to compare the times with.
    time: None where there is no first row.
    """

    def __init__(
        self,
        stream: BinaryIO,
        start: int,
        skeleton: Skeleton,
        text_start: int,
        declared: int | None,
        rate: float | None,
        limits: Limits,
    ) -> None:
        self._stream = stream
        self._start = start
        self._text_start = text_start
        self._limits = limits
        self._columns = skeleton.columns()
        self._joints = len(skeleton)
        self._width = 2 + len(self._columns)
        self._declared = declared
        self._rate = rate
        self._names = [joint.source_name for joint in skeleton.joints]
        self.time = self._time_column()

    def _time_column(self) -> TimeColumn | None:
        self._stream.seek(self._start)
        rows = _ROW.findall(self._stream.read(1 << 14))
        times = [cells[1].strip() for row in rows[:50] if len(cells := self._cells(row)) > 1]
        known = [time.decode("latin-1") for time in times if is_number(time.decode("latin-1"))]
        if not known:
            return None
        decimals = max(len(text.partition(".")[2].lower().partition("e")[0]) for text in known)
        first = float(known[0])
        if self._rate is not None:
            # 0.083 at 120 Hz is ten frames, rounded: so are the times that follow.
            whole = round(first * self._rate) / self._rate
            first = whole if abs(whole - first) <= 0.5001 * 10.0**-decimals else first
        return TimeColumn(decimals, first)

    def blocks(self, notices: list[Notice]) -> Iterator[FrameBlock]:
        """All frames. FormatError with line, frame and marker for a bad cell."""
        done = 0
        for text, offset in self._pieces():
            read = self._read_quickly(text)
            ids, times, values = self._read_slowly(text, offset, done) if read is None else read
            if not len(values):
                continue
            self._compare_times(times, done, notices)
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
                    at=line_and_column(self._stream, offset, self._text_start),
                    remedy="Check the file.",
                )
        if rest.strip():
            yield rest, offset

    def _read_quickly(self, text: bytes) -> tuple[NDArray[np.int64], Array, Array] | None:
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
        # A number such as 1.0 is no id; what numbers cannot tell apart is read slowly.
        if not all(_WHOLE.fullmatch(row[: row.index(b"\t")]) for row in rows):
            return None
        return table[:, 0].astype(np.int64), table[:, 1], np.ascontiguousarray(table[:, 2:])

    def _read_slowly(self, text: bytes, offset: int, done: int) -> tuple[NDArray[np.int64], Array, Array]:
        ids: list[int] = []
        times: list[float] = []
        rows: list[list[float]] = []
        for match in _ROW.finditer(text):
            cells = [cell.strip() for cell in self._cells(match.group())]
            if not any(cells):
                continue
            at = line_and_column(self._stream, offset + match.start(), self._text_start)
            if not _WHOLE.fullmatch(cells[0]):
                raise FormatError(
                    f"{shown(cells[0].decode('latin-1'))} is no frame number", at=at, remedy="Begin rows with Frame#."
                )
            number = int(cells[0])
            while len(cells) > self._width and not cells[-1]:
                cells.pop()
            # Rows may lack the tabs of what is missing at their end, but the last line of a file may have been cut off.
            whole = match.end() < len(text) or (done + len(rows) + 1 == self._declared and (len(cells) - 2) % 3 == 0)
            if not 2 <= len(cells) <= self._width or (len(cells) < self._width and not whole):
                raise FormatError(
                    f"frame {number} has {max(0, len(cells) - 2)} coordinates, the head says {self._width - 2}",
                    at=at,
                    remedy="Leave a cell empty where a sample is missing.",
                )
            numbers = [self._number(cell, place, number, at) for place, cell in enumerate(cells[1:])]
            ids.append(number)
            times.append(numbers[0])
            rows.append(numbers[1:] + [np.nan] * (self._width - 1 - len(numbers)))
        values = np.array(rows, dtype=np.float64).reshape(len(rows), len(self._columns))
        return np.array(ids, dtype=np.int64), np.array(times), values

    def _number(self, cell: bytes, place: int, frame: int, at: Place) -> float:
        if not cell or cell.lower() == b"nan":
            return float("nan")
        text = cell.decode("latin-1")
        if is_number(text):
            return float(text)
        what = "time" if not place else f"{self._names[(place - 1) // 3]} {'XYZ'[(place - 1) % 3]}"
        raise FormatError(f"frame {frame}, {what}: {what_is_wrong(text)}", at=at)

    @staticmethod
    def _cells(row: bytes) -> list[bytes]:
        return row.split(b"\t") if b"\t" in row else row.split()

    def _compare_times(self, times: Array, done: int, notices: list[Notice]) -> None:
        """The document holds no times, only a rate: say so where the column tells something else."""
        if self._rate is None or self.time is None:
            return
        expected = self.time.first + np.arange(done, done + len(times)) / self._rate
        allowed = 0.5001 * 10.0**-self.time.decimals + 1e-9 * np.abs(expected)
        if (np.abs(times - expected) > allowed).any() or np.isnan(times).any():
            note(notices, "warning", "the times do not follow from DataRate, which is all that the document holds")

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
