"""Tables whose cells are separated by commas or semicolons, read as if by tabs."""

from __future__ import annotations

import io
from typing import BinaryIO, cast

_FIRST_LINE = 1 << 12


class _Translated(io.RawIOBase):
    """A stream in which some bytes are read as others; no byte moves, so that places stay true."""

    def __init__(self, stream: BinaryIO, table: bytes) -> None:
        self._stream = stream
        self._table = table

    def read(self, size: int = -1, /) -> bytes:
        return self._stream.read(size).translate(self._table)

    def seek(self, offset: int, whence: int = io.SEEK_SET, /) -> int:
        return self._stream.seek(offset, whence)

    def tell(self) -> int:
        return self._stream.tell()


def tabbed(stream: BinaryIO) -> BinaryIO:
    """The stream, or one that reads its separators as tabs: semicolons (its commas are decimal then), else commas.

    The first line decides: with a tab, nothing is converted.
    """
    stream.seek(0)
    line = stream.read(_FIRST_LINE).lstrip().split(b"\n")[0].split(b"\r")[0]
    stream.seek(0)
    if b"\t" in line or not (b"," in line or b";" in line):
        return stream
    pairs = {";": "\t", ",": "."} if b";" in line else {",": "\t"}
    table = bytes(ord(pairs.get(chr(code), chr(code))) for code in range(256))
    return cast(BinaryIO, _Translated(stream, table))
