"""The first entry of a zip: some formats are zips, and are no archives of files."""

from __future__ import annotations

import struct
from dataclasses import dataclass

_LOCAL_HEADER = b"PK\x03\x04"


@dataclass(frozen=True)
class Entry:
    """The first file of a zip. stored: whether it is not compressed."""

    name: str
    stored: bool


def first_entry(first_bytes: bytes) -> Entry | None:
    """The first entry of a zip by its local header (APPNOTE 6.3, section 4.3.7); None for anything else."""
    header = header_of_first_entry(first_bytes)
    if not header:
        return None
    method = struct.unpack_from("<H", header, 8)[0]
    return Entry(header[30:].decode("utf-8", "replace"), method == 0)


def header_of_first_entry(first_bytes: bytes) -> bytes:
    """The local header of the first entry of a zip, up to the end of its name; empty for anything else."""
    if len(first_bytes) < 30 or not first_bytes.startswith(_LOCAL_HEADER):
        return b""
    return first_bytes[: 30 + struct.unpack_from("<H", first_bytes, 26)[0]]
