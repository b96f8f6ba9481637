"""Records of the parameter section of a C3D file: groups and parameters as bytes of Intel machines."""

from __future__ import annotations

import struct
from typing import Final

from mcml.formats.c3d.parameters import Parameter

LONGEST_TEXT: Final = 127
MOST_TEXTS: Final = 255
"""The sizes of a parameter are bytes: LABELS2 and further ones hold the rest."""

_MOST_BYTES: Final = 0xFFFF
"""The distance to the next record is a word."""


def group_record(number: int, name: str) -> bytes:
    """Return the record of a group. number: 1 to 127."""
    plain = name.encode("latin-1", errors="replace")[:LONGEST_TEXT]
    return struct.pack("<bb", len(plain), -number) + plain + struct.pack("<HB", 3, 0)


def record(group: int, name: str, kind: int, dimensions: tuple[int, ...], data: bytes) -> bytes:
    """Return the record of a parameter. kind: -1 characters, 1 bytes, 2 words, 4 floats. group: its number."""
    plain = name.encode("latin-1", errors="replace")[:LONGEST_TEXT]
    content = struct.pack("<bB", kind, len(dimensions)) + bytes(dimensions) + data + b"\0"
    return struct.pack("<bb", len(plain), group) + plain + struct.pack("<H", 2 + len(content)) + content


def word_record(group: int, name: str, number: int) -> bytes:
    """Return the record of one word without a sign."""
    return record(group, name, 2, (), struct.pack("<H", number))


def float_record(group: int, name: str, number: float) -> bytes:
    """Return the record of one float."""
    return record(group, name, 4, (), struct.pack("<f", number))


def text_record(group: int, name: str, texts: list[bytes], *, single: bool = False) -> bytes:
    """Return the record of texts, filled up with blanks to one length. single: one text without a second dimension."""
    longest = max(1, *map(len, texts)) if len(texts) > 1 else max(1, len(texts[0]))
    data = b"".join(text.ljust(longest) for text in texts)
    return record(group, name, -1, (longest,) if single else (longest, len(texts)), data)


def copy_record(group: int, name: str, parameter: Parameter) -> bytes:
    """Return the record of a parameter of another file, under its own spelling."""
    spelling = parameter.spelling.rpartition(":")[2] or name
    return record(group, spelling, parameter.kind, parameter.dimensions, parameter.to_intel())


def fits_record(parameter: Parameter) -> bool:
    """Whether a record can hold a parameter: the last one of a file may be longer than others."""
    return len(parameter.data) + len(parameter.dimensions) + 5 <= _MOST_BYTES
