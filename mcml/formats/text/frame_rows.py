"""Frame-major motion text: a line that opens a frame, then a line for each bone, its name and its values.

AMC and HTR2 are written so. Regular frames (the bones and the order of the first one) are read all at once; any other
frame, line by line.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import BinaryIO, Final

import numpy as np

from mcml.errors import FormatError, LimitError, Notice, Place
from mcml.formats.format import note
from mcml.formats.text.lines import blocks_of, line_and_column, shown
from mcml.formats.text.numbers import is_number, parse_numbers, what_is_wrong
from mcml.motion.clip import FrameBlock, Shape
from mcml.motion.skeleton import Array

BLOCK_BYTES: Final = 1 << 20
LARGEST_FRAME: Final = 1 << 24
_PLAIN_ID = re.compile(rb"(?:0|-?[1-9][0-9]{0,17})")
_ZERO = re.compile(rb"[+-]?0+(?:\.0*)?(?:[eE][+-]?[0-9]+)?")
_LINE = re.compile(rb"[^\r\n]+")


@dataclass(frozen=True)
class RowLayout:
    """The form of the rows of a file.

    opening: a pattern of the line that opens a frame, group 1 its id. opening_words: number of words in that line.
    joints, channels: of a row, by the bone's name in the file's encoding. fold_case: ignore the case of names.
    names_bones, remedy: for messages: the place that defines bones, and the remedy if it does not match. three_values:
    remedy for a bone with three values if fewer are expected; "" if there is none.
    """

    opening: re.Pattern[bytes]
    opening_words: int
    joints: dict[bytes, int]
    channels: dict[bytes, tuple[int, ...]]
    fold_case: bool
    names_bones: str
    remedy: str
    codec: str
    three_values: str = ""

    def find(self, name: bytes) -> bytes | None:
        """The name as the layout spells it, None for an unknown bone."""
        if name in self.joints or not self.fold_case:
            return name if name in self.joints else None
        return self._folded.get(name.lower())

    @cached_property
    def _folded(self) -> dict[bytes, bytes]:
        return {name.lower(): name for name in self.joints}

    def show(self, text: bytes) -> str:
        return shown(text[:100].decode(self.codec, errors="replace"))


def note_comments(rows: FrameRows, notices: list[Notice]) -> None:
    """Report the number of comments among the frames, which remain only in the uploaded file."""
    if rows.comments:
        what = f"{rows.comments} comments among the frames are not in the document; the kept file has them"
        note(notices, "warning", what)
    if rows.zero_rows:
        note(notices, "note", "zeros of bones without degrees of freedom are not in the document")


class FrameRows:
    """Frames of a file from a byte offset on, read again each time.

    text_start: byte offset of the first line, for counting lines. stop: a pattern of the line that ends the motion.
    """

    def __init__(
        self,
        stream: BinaryIO,
        start: int,
        layout: RowLayout,
        text_start: int,
        stop: re.Pattern[bytes] | None = None,
    ) -> None:
        self._stream = stream
        self._start = start
        self._layout = layout
        self._text_start = text_start
        self._stop = stop
        self._opening = re.compile(
            rb"(?:^|(?<=[\r\n]))" + layout.opening.pattern + rb"(?=[\r\n])", layout.opening.flags
        )
        self._spelled: dict[bytes, bytes] = {}
        self.stopped = False
        """Whether the line that ends the motion was seen."""
        self.zero_rows = False
        """Whether zeros of bones without channels were seen."""
        self.comments = 0
        """Lines with a comment that were seen; MCML has no place for comments inside the motion."""

    def blocks(self) -> Iterator[FrameBlock]:
        """All frames. FormatError with line and frame for a bad row."""
        regular: _Regular | None = None
        self.comments, self.zero_rows = 0, False
        for text, offset in self._pieces():
            if b"#" in text:
                self.comments += sum(b"#" in line for line in _LINE.findall(text))
            if regular is None:
                second = self._opening.search(text, 1)
                regular = self._read_slowly(text[: second.start()] if second else text, offset)[1]
            block = None if regular is None or b"#" in text else regular.read(text)
            if block is None:
                block, regular = self._read_slowly(text, offset)
            if block is not None:
                yield block

    def _pieces(self) -> Iterator[tuple[bytes, int]]:
        """(text, byte offset) of whole frames."""
        rest, offset = b"", self._start
        self.stopped = False
        for block in blocks_of(self._stream, self._start, BLOCK_BYTES):
            # Where nothing was found before, nothing needs to be looked for again.
            floor = max(0, rest.rfind(b"\n"), rest.rfind(b"\r"))
            rest += block
            # A bracket is found a hundred times faster than a line that begins with one.
            match = self._stop.search(rest) if self._stop is not None and b"[" in rest else None
            if match is not None:
                rest, self.stopped = rest[: match.start()], True
                break
            # A short block is the last one: its rest needs no cut.
            whole = len(block) < BLOCK_BYTES or not (b"\n" in block or b"\r" in block)
            cut = 0 if whole else self._last_opening(rest, floor)
            if cut:
                yield rest[:cut], offset
                rest, offset = rest[cut:], offset + cut
            elif len(rest) > LARGEST_FRAME:
                raise LimitError(
                    f"no frame begins within {LARGEST_FRAME >> 20} MiB",
                    at=self._place(offset),
                    remedy="Check the file.",
                )
        if rest.strip():
            yield rest, offset

    def _last_opening(self, text: bytes, floor: int) -> int:
        """Return the start of the last, possibly incomplete frame; 0 if none begins after `floor`."""
        reach = 1 << 14
        while True:
            start = max(floor, len(text) - reach)
            # The line in which the search begins is cut, so it must not count.
            openings = [match.start() for match in self._opening.finditer(text, start) if match.start() > start]
            if openings:
                return openings[-1]
            if start == floor:
                return 0
            reach *= 4

    def _place(self, offset: int) -> Place:
        return line_and_column(self._stream, offset, self._text_start)

    def _read_slowly(self, text: bytes, offset: int) -> tuple[FrameBlock | None, _Regular | None]:
        """The frames of a text line by line, and how the last of them is laid out."""
        frames: list[tuple[bytes, dict[bytes, list[float]]]] = []
        current: dict[bytes, list[float]] | None = None
        for match in _LINE.finditer(text):
            line = match.group().partition(b"#")[0].strip()
            if not line:
                continue
            opening = self._layout.opening.fullmatch(line)
            if opening:
                current = {}
                frames.append((opening[1], current))
                continue
            if current is None:
                what = f"before the first frame: found {self._layout.show(line)}"
                raise FormatError(what, at=self._place(offset + match.start()))
            self._add_row(line, frames[-1][0], current, offset + match.start())
        if not frames:
            return None, None
        return _block(self._layout, frames), _Regular.of(self._layout, frames[-1][1], self._spelled)

    def _add_row(self, line: bytes, frame: bytes, rows: dict[bytes, list[float]], offset: int) -> None:
        words = line.split()
        name = self._layout.find(words[0])
        if name is None:
            what = f"is not in the {self._layout.names_bones}"
            raise self._wrong_row(frame, words[0], f": bone * {what}", offset, self._layout.remedy)
        if name in rows:
            raise self._wrong_row(frame, words[0], ": bone * occurs twice", offset)
        expected = len(self._layout.channels[name])
        if not expected and len(words) > 1 and all(_ZERO.fullmatch(word) for word in words[1:]):
            # Some programs write zeros for bones that do not move.
            self.zero_rows = True
            del words[1:]
        if len(words) - 1 != expected:
            lists = "dof lists" if self._layout.fold_case else "rows have"
            what = f": bone * has {len(words) - 1} values, {self._layout.names_bones} {lists} {expected}"
            three = len(words) == 4 and self._layout.three_values
            raise self._wrong_row(frame, words[0], what, offset, three or self._layout.remedy)
        values = []
        for index, word in enumerate(words[1:], start=1):
            text = word.decode("latin-1")
            if not is_number(text):
                raise self._wrong_row(frame, words[0], f", bone *, value {index}: {what_is_wrong(text)}", offset)
            values.append(float(text))
        rows[name] = values
        self._spelled[name] = words[0]

    def _wrong_row(self, frame: bytes, bone: bytes, what: str, offset: int, remedy: str | None = None) -> FormatError:
        """The error for a row. what: with a `*` for the bone."""
        words = f"frame {frame.decode('latin-1')}{what.replace('*', self._layout.show(bone), 1)}"
        return FormatError(words, at=self._place(offset), remedy=remedy)


@dataclass(frozen=True)
class _Regular:
    """Frames that all list the same bones in the same order, as every program but an editor writes them."""

    opening_words: int
    opening: re.Pattern[bytes]
    names: tuple[bytes, ...]
    places: tuple[int, ...]
    width: int
    columns: tuple[tuple[int, int], ...]
    shape: Shape

    @classmethod
    def of(cls, layout: RowLayout, rows: dict[bytes, list[float]], spelled: dict[bytes, bytes]) -> _Regular:
        places, place = [], layout.opening_words
        for values in rows.values():
            places.append(place)
            place += 1 + len(values)
        columns, shape = _columns_and_shape(layout, tuple(rows))
        names = tuple(spelled[name] for name in rows)
        return cls(layout.opening_words, layout.opening, names, tuple(places), place, columns, shape)

    def read(self, text: bytes) -> FrameBlock | None:
        """The frames of a text, None where one of them is different."""
        words = text.split()
        count, left_over = divmod(len(words), self.width)
        if left_over or not count:
            return None
        for name, place in zip(self.names, self.places, strict=True):
            if words[place :: self.width].count(name) != count:
                return None
        ids = [b" ".join(words[at : at + self.opening_words]) for at in range(0, len(words), self.width)]
        found = [self.opening.fullmatch(text) for text in ids]
        if not all(found):
            return None
        # Names and openings go, last first, so that the places of the others stay true; then only numbers are left.
        for place in sorted({*self.places, *range(self.opening_words)}, reverse=True):
            words[place :: self.width] = [b""] * count
        values = parse_numbers(b" ".join(words))
        if values is None or len(values) != count * len(self.columns):
            return None
        return FrameBlock(
            values.reshape(count, len(self.columns)),
            self.columns,
            (self.shape,),
            _ids([match[1] for match in found if match]),
        )


def _columns_and_shape(layout: RowLayout, names: tuple[bytes, ...]) -> tuple[tuple[tuple[int, int], ...], Shape]:
    columns = tuple((layout.joints[name], channel) for name in names for channel in layout.channels[name])
    shape = tuple((layout.joints[name], sum(1 << channel for channel in layout.channels[name])) for name in names)
    return columns, shape


def _ids(texts: list[bytes]) -> np.ndarray[tuple[int], np.dtype[np.int64]] | list[str]:
    """Frame ids: whole numbers where all are plain ones, else the texts."""
    if all(_PLAIN_ID.fullmatch(text) for text in texts):
        return np.array([int(text) for text in texts], dtype=np.int64)
    return [text.decode("latin-1") for text in texts]


def _block(layout: RowLayout, frames: list[tuple[bytes, dict[bytes, list[float]]]]) -> FrameBlock:
    """Frames that may differ in their bones and the order of these."""
    union = dict.fromkeys(name for _, rows in frames for name in rows)
    columns = _columns_and_shape(layout, tuple(union))[0]
    start: dict[bytes, int] = {}
    width = 0
    for name in union:
        start[name] = width
        width += len(layout.channels[name])
    values: Array = np.full((len(frames), len(columns)), np.nan)
    shapes: dict[Shape, int] = {}
    shape_of = np.zeros(len(frames), dtype=np.intp)
    for index, (_, rows) in enumerate(frames):
        for name, row in rows.items():
            values[index, start[name] : start[name] + len(row)] = row
        shape = _columns_and_shape(layout, tuple(rows))[1]
        shape_of[index] = shapes.setdefault(shape, len(shapes))
    return FrameBlock(
        values,
        columns,
        tuple(shapes),
        _ids([text for text, _ in frames]),
        None if len(shapes) == 1 else shape_of,
    )
