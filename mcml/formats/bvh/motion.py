"""The MOTION of a BVH file: numbers to blocks of frames."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from mcml.errors import FormatError, Notice
from mcml.formats.format import note
from mcml.formats.text.lines import line_and_column
from mcml.formats.text.numbers import NumberStream, bad_token, count_tokens, parse_numbers, token_bounds, what_is_wrong
from mcml.motion.clip import FrameBlock, Shape, full_shape
from mcml.motion.skeleton import CHANNELS, Array, Skeleton

SAMPLE_BYTES: Final = 1 << 16
SPREAD_FRAMES: Final = 32
BEGINNING_FRAMES: Final = 8
MISSING: Final = b"?"
"""Text of a missing sample. No program writes it; the repair `missing-samples` replaces `nan` by it."""

_MISSING_WORD: Final = re.compile(rb"(?<!\S)\?(?!\S)")
_COMMENT: Final = re.compile(rb"(?:^|(?<=[\r\n]))[ \t]*(?:#|//)[^\r\n]*")
FRAMES_WITHOUT_CHANNELS: Final = 1 << 14
"""Frames of a block where a skeleton never moves, so that nothing limits its size."""


@dataclass(frozen=True, slots=True)
class Sample:
    """The beginning of the motion. bounds: of the words of its text. values: (n, D) of its whole frames."""

    text: bytes
    bounds: NDArray[np.intp]
    values: Array


class Motion:
    """The frames of a file, read again each time.

    start: byte offset of the first number. text_start: of the first line, for counting lines.
    """

    def __init__(self, stream: BinaryIO, start: int, skeleton: Skeleton, frames: int, text_start: int) -> None:
        self._stream = stream
        self._start = start
        self._skeleton = skeleton
        self._columns = skeleton.columns()
        self._frames = frames
        self._text_start = text_start
        self._first: Array | None = None
        self.comments = False
        """Whether comment lines were seen among the frames."""

    def sample(self) -> Sample:
        """The beginning, from which the number style is guessed; empty where it is not all numbers."""
        self._stream.seek(self._start)
        text = self._stream.read(SAMPLE_BYTES)
        if len(text) == SAMPLE_BYTES:
            text = text[: max(text.rfind(b" "), text.rfind(b"\n"), text.rfind(b"\t"), text.rfind(b"\r")) + 1]
        width = len(self._columns)
        bounds = token_bounds(text)
        values = self._begins(text, len(bounds)) if width and self._frames else None
        if values is None:
            return Sample(b"", bounds[:0], np.empty((0, width)))
        frames = min(self._frames, len(values) // width)
        return Sample(text, bounds, values[: frames * width].reshape(frames, width))

    def spread(self, sample: Sample) -> Array:
        """Return (n, D) frames from the beginning, and spread over the motion if each frame has its own line."""
        width = len(self._columns)
        if not len(sample.values) or len(sample.values) >= self._frames:
            return sample.values
        reach = 4 * max(map(len, sample.text.splitlines()))
        end = self._stream.seek(0, 2)
        rows = [sample.values]
        for start in np.linspace(self._start + len(sample.text), end - reach, SPREAD_FRAMES).astype(np.int64).tolist():
            self._stream.seek(max(start, self._start))
            lines = self._stream.read(reach).splitlines()[1:-1]
            found = [parse_numbers(line) for line in lines[:1]]
            rows += [values[None] for values in found if values is not None and len(values) == width]
        # Few from the beginning: programs put poses there that are not those of the motion.
        first = sample.values[:: -(-len(sample.values) // BEGINNING_FRAMES)] if len(rows) > 1 else sample.values
        return np.concatenate([first, *rows[1:]])

    def _begins(self, text: bytes, count: int) -> Array | None:
        """Return the first `count` numbers of the motion's text, None if one of these words is not a number."""
        piece = NumberStream(self._stream, self._start).next()
        # Of a short clip that is all: `blocks` need not parse it again.
        self._first = None if piece is None else self._numbers(piece[0])
        if self._first is None or len(self._first) < count:
            return self._numbers(text)
        return self._first[:count]

    def _numbers(self, text: bytes) -> Array | None:
        """The numbers of a text without comment lines, NaN for missing samples; None where a word is neither."""
        values = parse_numbers(text)
        if values is not None or not (MISSING in text or b"#" in text or b"//" in text):
            return values
        plain = _COMMENT.sub(b"", text)
        if len(plain) < len(text):
            self.comments = True
        values = parse_numbers(_MISSING_WORD.sub(b"0", plain))
        if values is not None and MISSING in plain:
            words = np.array(plain.split())
            values = np.where(words == MISSING, np.nan, values)
        return values

    def blocks(self, notices: list[Notice]) -> Iterator[FrameBlock]:
        """All frames. Raises FormatError with the place of a bad number, and where the file ends too early."""
        width = len(self._columns)
        source = NumberStream(self._stream, self._start)
        done, rest = 0, np.empty(0)
        while done < self._frames and width:
            piece = source.next()
            if piece is None:
                raise self._too_short(done, len(rest))
            values = self._parsed(*piece, done * width + len(rest))
            values = np.concatenate([rest, values]) if len(rest) else values
            whole = min(len(values) // width, self._frames - done)
            rest = values[whole * width :].copy()
            if whole:
                ids = np.arange(done + 1, done + whole + 1, dtype=np.int64)
                yield _block(values[: whole * width].reshape(whole, width), self._columns, ids)
            done += whole
        while done < self._frames:
            count = min(FRAMES_WITHOUT_CHANNELS, self._frames - done)
            ids = np.arange(done + 1, done + count + 1, dtype=np.int64)
            yield _block(np.empty((count, 0)), self._columns, ids)
            done += count
        self._report_surplus(source, len(rest), notices)
        if self.comments:
            note(notices, "warning", "comment lines among the frames are not in the document; the kept file has them")

    def _parsed(self, text: bytes, offset: int, before: int) -> Array:
        values = self._numbers(text) if self._first is None or offset != self._start else self._first
        if values is not None:
            return values
        # Blanks of the same length keep the positions of errors.
        text = _COMMENT.sub(lambda found: b" " * len(found[0]), _MISSING_WORD.sub(b"0", text))
        bad = bad_token(text)
        if bad is None:
            raise FormatError("a number cannot be read", at=line_and_column(self._stream, offset, self._text_start))
        index, position, token = bad
        # Behind the last declared frame nothing is read, only counted.
        frame, column = divmod(before + index, len(self._columns))
        if frame >= self._frames:
            numbers_before = parse_numbers(text[:position])
            return np.empty(0) if numbers_before is None else numbers_before
        joint, channel = self._columns[column]
        kind = "position" if CHANNELS[channel][0] == "T" else "rotation"
        name = f"{self._skeleton.joints[joint].source_name} {CHANNELS[channel][1].upper()}{kind}"
        raise FormatError(
            f"frame {frame + 1}, value {column + 1} ({name}): {what_is_wrong(token)}",
            at=line_and_column(self._stream, offset + position, self._text_start),
            remedy="Write numbers with a decimal point, separated by blanks.",
        )

    def _too_short(self, done: int, values: int) -> FormatError:
        width = len(self._columns)
        self._stream.seek(0, 2)
        place = line_and_column(self._stream, self._stream.tell(), self._text_start)
        where = f"in frame {done + 1}, behind value {values} of {width}" if values else f"behind frame {done}"
        return FormatError(
            f"MOTION declares {self._frames} frames, data ends {where} of {self._frames}",
            at=place,
            remedy="The file was cut off: send it whole, or correct Frames.",
        )

    def _report_surplus(self, source: NumberStream, left_over: int, notices: list[Notice]) -> None:
        surplus = left_over
        while (piece := source.next()) is not None:
            surplus += count_tokens(piece[0])
        if not surplus:
            return
        width = len(self._columns)
        frames = f"{surplus // width} more" if width and surplus % width == 0 else f"{surplus} more values"
        notice = Notice("warning", f"MOTION declares {self._frames} frames, the file holds {frames}: left out")
        if notice not in notices:
            notices.append(notice)


def _block(values: Array, columns: tuple[tuple[int, int], ...], ids: NDArray[np.int64]) -> FrameBlock:
    """Frames (n, D) in which NaN is a missing sample."""
    gone = np.isnan(values)
    if not gone.any():
        return FrameBlock(values, columns, (full_shape(columns),), ids)
    patterns, shape_of = np.unique(gone, axis=0, return_inverse=True)
    shapes: list[Shape] = []
    for pattern in patterns:
        bits = dict.fromkeys((joint for joint, _ in columns), 0)
        for (joint, channel), missing in zip(columns, pattern.tolist(), strict=True):
            bits[joint] |= 0 if missing else 1 << channel
        shapes.append(tuple(bits.items()))
    return FrameBlock(values, columns, tuple(shapes), ids, shape_of.reshape(-1))
