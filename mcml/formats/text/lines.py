"""Lines and tokens of text files that know their place, and the encoding of a file.

Positions in the file are byte offsets; lines end with LF, CRLF or CR alone. Nothing here holds a whole file.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import BinaryIO, NamedTuple

from mcml.errors import FormatError, LimitError, Notice, Place
from mcml.formats.text.plausible_text import EASTERN, plausible_codecs, title_of

BLOCK = 1 << 18
LONGEST_LINE = 1 << 20
"""Bytes of a line in the head of a file; in no format does a sensible one come near."""

BLANKS = " \t\v\f\r\n"
"""White space of the text formats; the wider one of Unicode may be part of a name."""

_LOOKED_AT = 64
_UTF8_BOM = codecs.BOM_UTF8
_BLANK_FREE = re.compile(r"\S+", re.ASCII)
LINE_END = re.compile(rb"\r\n|\n|\r")


def blocks_of(stream: BinaryIO, start: int = 0, size: int = BLOCK) -> Iterator[bytes]:
    """The bytes of a stream from an offset on. Other readers of the stream may seek in between."""
    position = start
    while True:
        stream.seek(position)
        block = stream.read(size)
        if not block:
            return
        position += len(block)
        yield block


@dataclass(frozen=True, slots=True)
class Encoding:
    """codec: Python's name, "utf-8-sig" for UTF-8 with a byte order mark. start: offset of the text."""

    codec: str
    start: int
    notices: tuple[Notice, ...] = ()


def utf16_codec(head: bytes) -> str | None:
    """The codec of text in UTF-16, with its byte order mark or without; None for anything else. head: the first bytes.

    Without the mark every second byte of text in ASCII is zero, and none of the others.
    """
    if head.startswith((codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE)):
        return None
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    even, odd = head[0:_LOOKED_AT:2], head[1:_LOOKED_AT:2]
    for codec, letters, zeros in (("utf-16-le", even, odd), ("utf-16-be", odd, even)):
        if len(zeros) > 1 and not any(zeros) and 0 not in letters:
            return codec
    return None


def detect_encoding(stream: BinaryIO, given: str | None, stop: Callable[[bytes], bool] | None = None) -> Encoding:
    """UTF-8, else the given encoding, else the one whose letters are most plausible, else Latin-1.

    stop: called with each block; true ends the search, for files whose rest contains only numbers. Raises FormatError
    for an unknown codec, UTF-16, and text that the given encoding cannot read.
    """
    stream.seek(0)
    head = stream.read(_LOOKED_AT)
    if utf16_codec(head) is not None:
        raise FormatError("the file is UTF-16 text", at=Place(line=1), remedy="Save it as UTF-8.")
    if given is not None:
        _check_codec(given)
    start = len(_UTF8_BOM) if head.startswith(_UTF8_BOM) else 0

    def chunks() -> Iterator[bytes]:
        for block in blocks_of(stream, start):
            yield block
            if stop is not None and stop(block):
                return

    if _decodes(chunks(), "utf-8"):
        if start:
            notice = Notice("repair", "the file begins with a byte order mark (UTF-8)")
            return Encoding("utf-8-sig", start, (notice,))
        return Encoding("utf-8", 0)
    if given is not None:
        if not _decodes(chunks(), given):
            raise FormatError(
                f"the text is not {given}", at=Place(line=1), remedy="Name its encoding, such as latin-1 or cp949."
            )
        return Encoding(codecs.lookup(given).name, start)
    codec = next((codec for codec in _plausible(chunks()) if _decodes(chunks(), codec)), "latin-1")
    tried = ", ".join(title_of(name) for name in (*EASTERN, "latin-1"))
    what = (
        f"the text is not UTF-8; of {tried} it is most plausible as {title_of(codec)}. Name the encoding if it is not"
    )
    return Encoding(codec, start, (Notice("guess", what),))


def _plausible(chunks: Iterator[bytes]) -> list[str]:
    """Codecs for which the first lines that are not ASCII are plausible, the best first."""
    found, size = [], 0
    for chunk in chunks:
        if not chunk.isascii():
            # A line that continues in the next chunk may end within a character.
            found.append(chunk[: chunk.rfind(b"\n")] if len(chunk) == BLOCK else chunk)
            size += len(chunk)
        if size >= 2 * BLOCK:
            break
    return plausible_codecs(b"\n".join(found), "latin-1")


def _check_codec(given: str) -> None:
    letters = bytes(range(128))
    try:
        fits = letters.decode(given) == letters.decode("ascii")
    except (LookupError, UnicodeError, TypeError, ValueError, AttributeError):
        fits = False
    if not fits:
        raise FormatError(
            f"{given!r} is no encoding of text that contains ASCII", remedy="Use a name such as utf-8, cp949, latin-1."
        )


def _decodes(chunks: Iterator[bytes], codec: str) -> bool:
    """Whether the bytes are text in that codec."""
    decoder = codecs.getincrementaldecoder(codec)()
    pending = False
    try:
        for chunk in chunks:
            if not pending and chunk.isascii():
                continue
            pending = True
            decoder.decode(chunk)
        decoder.decode(b"", final=True)
    except UnicodeError:
        return False
    return True


def shown(text: str) -> str:
    """A word of a file as messages show it: quoted, and not endless."""
    return repr(text if len(text) <= 60 else text[:57] + "…")


def encoded(text: str, codec: str, notices: list[Notice]) -> bytes:
    """Text in the encoding of its source; as UTF-8 with a notice where that cannot hold it."""
    try:
        return text.encode(codec)
    except (UnicodeError, LookupError):
        notices.append(Notice("warning", f"the text does not fit {codec}; written as UTF-8"))
        return text.encode("utf-8", errors="replace")


class Line(NamedTuple):
    """One line without its end. number: from 1. start, end: byte offsets, end behind the line's end characters."""

    text: str
    number: int
    start: int
    end: int

    def words(self) -> list[str]:
        return _BLANK_FREE.findall(self.text)

    def at(self, column: int | None = None) -> Place:
        return Place(line=self.number, column=column)


class Lines:
    """The lines of a stream, decoded, one ahead."""

    def __init__(self, stream: BinaryIO, encoding: Encoding, start: int | None = None, number: int = 1) -> None:
        codec = "utf-8" if encoding.codec == "utf-8-sig" else encoding.codec
        self._lines = _lines(stream, encoding.start if start is None else start, number, codec)
        self._ahead: Line | None = None
        self.number = number
        """Number of the line last read."""

    def peek(self) -> Line | None:
        """The next line, None at the end of the file."""
        if self._ahead is None:
            self._ahead = next(self._lines, None)
        return self._ahead

    def next(self) -> Line | None:
        line, self._ahead = self._ahead or next(self._lines, None), None
        if line is not None:
            self.number = line.number
        return line

    def __iter__(self) -> Iterator[Line]:
        while (line := self.next()) is not None:
            yield line

    @property
    def here(self) -> Place:
        """The line last read."""
        return Place(line=self.number)


def _lines(stream: BinaryIO, start: int, number: int, codec: str) -> Iterator[Line]:
    """Raises FormatError for NUL, LimitError for an endless line."""
    rest, offset = b"", start
    for block in blocks_of(stream, start, 1 << 16):
        if b"\0" in block:
            line = number + len(LINE_END.findall(block[: block.index(b"\0")]))
            raise FormatError("the file holds NUL bytes", at=Place(line=line), remedy="Send the text file itself.")
        rest += block
        position = 0
        for match in LINE_END.finditer(rest):
            last, end = match.span()
            if end == len(rest) and match.group() == b"\r":
                # A CR at the end of a block may be the half of a CRLF.
                break
            yield Line(rest[position:last].decode(codec, "replace"), number, offset + position, offset + end)
            position = end
            number += 1
        rest, offset = rest[position:], offset + position
        if len(rest) > LONGEST_LINE:
            raise LimitError(
                f"a line is longer than {LONGEST_LINE} bytes", at=Place(line=number), remedy="Break it into lines."
            )
    if rest:
        yield Line(rest.removesuffix(b"\r").decode(codec, "replace"), number, offset, offset + len(rest))


class Token(NamedTuple):
    """A word of a line. column: from 1, in characters."""

    text: str
    line: Line
    column: int

    @property
    def at(self) -> Place:
        return Place(line=self.line.number, column=self.column)


_WORD = re.compile(r"[{}]|[^\s{}]+", re.ASCII)


class Tokens:
    """Words of a file regardless of lines; braces are separate tokens even if they touch a word.

    comments: beginnings of lines that are skipped.
    """

    def __init__(self, lines: Lines, comments: tuple[str, ...] = ()) -> None:
        self._lines = lines
        self._comments = comments
        self.passed_over = 0
        self._line: Line | None = None
        self._position = 0
        self._end = 0
        self._ahead: Token | None = None

    def peek(self) -> Token | None:
        """The next word, None at the end of the file."""
        if self._ahead is None:
            self._ahead = self._find()
        return self._ahead

    def _find(self) -> Token | None:
        line, position = self._line, self._position
        while True:
            match = None if line is None else _WORD.search(line.text, position)
            if match is not None and line is not None:
                return Token(match.group(), line, match.start() + 1)
            line, position = self._lines.next(), 0
            if line is None:
                return None
            if self._comments and line.text.lstrip(BLANKS).startswith(self._comments):
                self.passed_over += 1
                line = None
                continue
            # The last character that is no blank, looked for once a line: a file may be one long line.
            self._line, self._position, self._end = line, 0, len(line.text.rstrip(BLANKS))

    def next(self) -> Token | None:
        token, self._ahead = self._ahead or self._find(), None
        if token is not None:
            self._position = token.column - 1 + len(token.text)
        return token

    def rest_words(self, most: int) -> list[str]:
        """The words that the current line still holds, up to one more than `most`; `skip_line` takes them all."""
        if self._line is None:
            return []
        return [match.group() for match in islice(_WORD.finditer(self._line.text, self._position), most + 1)]

    def skip_line(self) -> None:
        """Continue after the current line's last word."""
        if self._line is not None:
            self._position = self._end
            self._ahead = None

    def rest_of_line(self) -> Token | None:
        """Return the rest of the line, trimmed, up to a brace that opens a body; None if it is empty."""
        if self._line is None:
            return None
        self._ahead = None
        text = self._line.text
        last = self._end - 1
        end = text.find("{", self._position)
        while end >= 0 and not (end == last or end == self._position or text[end - 1] in BLANKS):
            end = text.find("{", end + 1)
        rest = text[self._position : end if end >= 0 else len(text)]
        start = self._position + len(rest) - len(rest.lstrip(BLANKS))
        self._position += len(rest)
        name = rest.strip(BLANKS)
        return Token(name, self._line, start + 1) if name else None

    def has_words_in_line(self) -> bool:
        """Whether the current line still holds words."""
        return bool(self.rest_words(0))

    def next_line_is_a_word(self) -> bool:
        """Whether the line after the current one holds a single word."""
        following = self._lines.peek()
        return following is not None and len(list(islice(_WORD.finditer(following.text), 2))) == 1

    def offset(self) -> int:
        """Byte offset behind the last word read, in a line that is ASCII up to there."""
        return 0 if self._line is None else self._line.start + self._position

    @property
    def here(self) -> Place:
        """The last word read, or the end of the file."""
        return Place(line=self._lines.number)


def line_and_column(stream: BinaryIO, offset: int, start: int = 0) -> Place:
    """The place of a byte offset, by counting line ends from the beginning (only needed for a message)."""
    line, last_start, position, after_cr = 1, start, start, False
    for block in blocks_of(stream, start, 1 << 20):
        block = block[: offset - position]
        for match in re.finditer(rb"\r\n|\n|\r", block):
            if not (after_cr and match.start() == 0 and match.group() == b"\n"):
                line += 1
            last_start = position + match.end()
        after_cr = block.endswith(b"\r")
        position += len(block)
        if position >= offset:
            break
    return Place(line=line, column=offset - last_start + 1)
