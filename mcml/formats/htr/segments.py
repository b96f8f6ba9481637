"""The motion of an HTR file of version 1: all frames of one segment, then all of the next.

A first pass finds where each segment begins; frames are then read by advancing a cursor in every segment, so that a
block of frames needs only a piece of each.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import BinaryIO, Final

import numpy as np

from mcml.errors import FormatError, LimitError, Notice, Place
from mcml.formats.format import Limits
from mcml.formats.text.lines import LONGEST_LINE, Encoding, blocks_of, line_and_column
from mcml.formats.text.numbers import bad_token, parse_numbers, what_is_wrong
from mcml.motion.skeleton import Array, Skeleton

COLUMNS: Final = 8
"""Values of a row: frame, Tx, Ty, Tz, Rx, Ry, Rz, SF."""

BLOCK_VALUES: Final = 1 << 19
READ_BYTES: Final = 1 << 22
"""Text held of all segments together."""

_HEADING = re.compile(rb"\[([^\]\r\n]*)\][^\r\n]*")
_COMMENT = re.compile(rb"#[^\r\n]*")
_LINE = re.compile(rb"[^\r\n]+")
_PLAIN_ID = re.compile(rb"(?:0|-?[1-9][0-9]{0,15})")
_NINES = b"999999"
_HUGE = re.compile(rb"[+-]?9{6,}[0-9]*(?:\.[0-9]*)?(?=\s)")


@dataclass
class Index:
    """The index of segments. spans: (start, end) byte offsets by segment name. missing: lexeme of missing values."""

    spans: dict[str, tuple[int, int]] = field(default_factory=dict)
    repeated: int = 0
    has_end: bool = False
    missing: str = ""
    comments: list[str] = field(default_factory=list)


def index_segments(stream: BinaryIO, start: int, encoding: Encoding, limits: Limits) -> Index:
    """One pass over the motion. LimitError for endless lines and more segments than a skeleton may have."""
    codec = "utf-8" if encoding.codec == "utf-8-sig" else encoding.codec
    index = Index()
    rest, offset, name, begin = b"", start, None, start
    for block in blocks_of(stream, start, 1 << 20):
        text = rest + block
        last = max(text.rfind(b"\n"), text.rfind(b"\r")) + 1
        if not last and len(text) > LONGEST_LINE + (1 << 20):
            raise LimitError(f"a line is longer than {LONGEST_LINE} bytes", at=line_and_column(stream, offset))
        if len(block) < 1 << 20:
            last = len(text)
        index.missing = index.missing or missing_lexeme(text)
        if b"#" in text[:last]:
            found = (match.decode(codec, errors="replace").rstrip() for match in _COMMENT.findall(text, 0, last))
            index.comments += [text for text in dict.fromkeys(found) if text not in index.comments][
                : 100 - len(index.comments)
            ]
        for heading in _headings(text, last):
            if name is not None:
                _close(index, name, begin, offset + heading.start())
            name, begin = heading[1].decode(codec, errors="replace").strip(), offset + heading.end()
            if name.lower() == "endoffile":
                index.has_end = True
                return index
            if len(index.spans) > limits.joints:
                raise LimitError(f"the file has more than {limits.joints} segments")
        rest, offset = text[last:], offset + last
    if name is not None:
        _close(index, name, begin, offset)
    return index


def missing_lexeme(text: bytes) -> str:
    """Return the first word of nines that marks a missing sample, "" without one; `0.999999` does not count."""
    place = text.find(_NINES)
    while place >= 0:
        before = text[max(0, place - 32) : place]
        found = _HUGE.match(text, place - len(before) + len(before.rstrip(b"+-.0123456789eE")))
        if found is not None:
            return found.group().decode()
        place = text.find(_NINES, place + len(_NINES))
    return ""


def _headings(text: bytes, end: int) -> Iterator[re.Match[bytes]]:
    """The lines that begin with a bracket; found by the bracket, as a pattern tries every line start in vain."""
    place = text.find(b"[", 0, end)
    while place >= 0:
        before = text[max(0, place - 256) : place].rstrip(b" \t")
        begins = before.endswith((b"\n", b"\r")) or (not before and place <= 256)
        heading = _HEADING.match(text, place, end) if begins else None
        if heading is not None:
            yield heading
        place = text.find(b"[", heading.end() if heading is not None else place + 1, end)


def _close(index: Index, name: str, begin: int, end: int) -> None:
    if name in index.spans:
        index.repeated += 1
    else:
        index.spans[name] = (begin, end)


class _Cursor:
    """The rows of one segment, in order."""

    def __init__(self, segments: Segments, name: str, start: int, end: int, keep_ids: bool) -> None:
        self.name = name
        self.span = (start, end)
        self._segments = segments
        self._position = start
        self._end = end
        self._waiting = np.empty(0)
        self._keep_ids = keep_ids
        self.ids: list[bytes] = []
        self.told = False
        """Whether other frame numbers were already reported."""

    def rows(self, count: int) -> Array:
        """Return the next rows, (count or fewer at the end, 8). Raises FormatError for text that is not a number."""
        while len(self._waiting) < count * COLUMNS and self._position < self._end:
            text = self._next_text()
            values = parse_numbers(text)
            if values is None or len(values) % COLUMNS:
                raise self._segments.blame(self)
            if self._keep_ids:
                self.ids += text.split()[::COLUMNS]
            self._waiting = np.concatenate([self._waiting, values]) if len(self._waiting) else values
        taken, self._waiting = self._waiting[: count * COLUMNS], self._waiting[count * COLUMNS :].copy()
        return taken.reshape(-1, COLUMNS)

    def _next_text(self) -> bytes:
        size = self._segments.read_bytes
        while True:
            self._segments.stream.seek(self._position)
            text = self._segments.stream.read(min(size, self._end - self._position))
            at_end = self._position + len(text) >= self._end or not text
            cut = len(text) if at_end else max(text.rfind(b"\n"), text.rfind(b"\r")) + 1
            if cut:
                break
            size *= 4
        self._position = self._end if at_end else self._position + cut
        return _COMMENT.sub(b"", text[:cut]) if b"#" in text else text[:cut]


class Segments:
    """The frames of a file with indexed segments, read again each time."""

    def __init__(self, stream: BinaryIO, skeleton: Skeleton, index: Index, frames: int, text_start: int) -> None:
        self.stream = stream
        self._skeleton = skeleton
        self._index = index
        self._frames = frames
        self._text_start = text_start
        self.read_bytes = max(2048, READ_BYTES // max(1, len(skeleton)))

    def blocks(self, notices: list[Notice]) -> Iterator[tuple[Array, list[bytes]]]:
        """((n, 7 J) values in declared order, n frame ids). FormatError where segments differ in their rows."""
        cursors: list[_Cursor] = []
        for index in self._skeleton.in_declared_order():
            name = self._skeleton.joints[index].source_name
            start, end = self._index.spans[name]
            cursors.append(_Cursor(self, name, start, end, keep_ids=not cursors))
        step = max(1, BLOCK_VALUES // (COLUMNS * max(1, len(cursors))))
        done = 0
        while done < self._frames and cursors:
            count = min(step, self._frames - done)
            values = np.empty((count, len(cursors), COLUMNS - 1))
            frame_ids = np.empty(0)
            for place, cursor in enumerate(cursors):
                rows = cursor.rows(count)
                if len(rows) < count:
                    raise self._wrong_count(cursor, done + len(rows))
                if not place:
                    frame_ids = rows[:, 0].copy()
                elif not cursor.told and not np.array_equal(rows[:, 0], frame_ids):
                    self._report_other_ids(cursor, cursors[0], notices)
                values[:, place] = rows[:, 1:]
            ids, cursors[0].ids = cursors[0].ids[:count], cursors[0].ids[count:]
            yield values.reshape(count, -1), ids
            done += count
        for cursor in cursors:
            more = cursor.rows(1 << 12)
            if len(more):
                raise self._wrong_count(cursor, done + len(more))

    def _wrong_count(self, cursor: _Cursor, found: int) -> FormatError:
        return FormatError(
            f"segment {cursor.name!r} has {found} rows, NumFrames says {self._frames}",
            at=self._place(cursor.span[1]),
            remedy="The file was cut off; send it whole.",
        )

    def _report_other_ids(self, cursor: _Cursor, first: _Cursor, notices: list[Notice]) -> None:
        # The whole segment is looked at, so once.
        cursor.told = True
        fault = self._first_fault(cursor)
        if fault is not None:
            raise fault
        notice = Notice("warning", f"segment {cursor.name!r} numbers its frames otherwise than {first.name!r}")
        if notice not in notices:
            notices.append(notice)

    def blame(self, cursor: _Cursor) -> FormatError:
        """Return the error for a segment."""
        fault = self._first_fault(cursor)
        return fault or FormatError(f"segment {cursor.name!r} cannot be read", at=self._place(cursor.span[0]))

    def _first_fault(self, cursor: _Cursor) -> FormatError | None:
        """The first bad row of a segment, None where every row has its fields."""
        start, end = cursor.span
        rest, offset, row = b"", start, 0
        for block in blocks_of(self.stream, start):
            text = rest + block[: max(0, end - offset - len(rest))]
            at_end = offset + len(text) >= end or not block
            last = len(text) if at_end else max(text.rfind(b"\n"), text.rfind(b"\r")) + 1
            for match in _LINE.finditer(text, 0, last):
                line = match.group().partition(b"#")[0]
                words = line.split()
                if not words:
                    continue
                row += 1
                where = f"segment {cursor.name!r}, row {row}"
                bad = bad_token(line)
                if bad is not None:
                    place = self._place(offset + match.start() + bad[1])
                    return FormatError(f"{where}: {what_is_wrong(bad[2])}", at=place)
                if len(words) != COLUMNS:
                    place = self._place(offset + match.start())
                    expected = "expected 8 (frame Tx Ty Tz Rx Ry Rz SF)"
                    return FormatError(f"{where} has {len(words)} fields, {expected}", at=place)
            rest, offset = text[last:], offset + last
            if at_end:
                break
        return None

    def _place(self, offset: int) -> Place:
        return line_and_column(self.stream, offset, self._text_start)


def plain_ids(texts: list[bytes]) -> np.ndarray[tuple[int], np.dtype[np.int64]] | list[str]:
    """Frame ids: whole numbers where all are plain ones, else the texts."""
    if all(_PLAIN_ID.fullmatch(text) for text in texts):
        return np.array([int(text) for text in texts], dtype=np.int64)
    return [text.decode("latin-1") for text in texts]
