"""A program that unpacks a 7z archive: a line of JSON, then the bytes of its members, one after the other.

The line has `members`, each [name, bytes, whether it is a file], or `error`, `remedy` and `kind`. A dictionary of
LZMA may take 4 GiB, and one call of the decompressor 128 MB, so it runs in a process of limited memory.

Source: 7z format description (7zFormat.txt of the LZMA SDK); py7zr reads it.
"""

from __future__ import annotations

import json
import sys
from typing import Any, BinaryIO

from mcml.errors import is_full
from mcml.processes.scene_answer import UnreadableError

SECONDS = 120.0
MEMORY = 1 << 30
"""Bytes of the process that unpacks."""
AGAIN = "Pack the files again, or send them as a zip."


def main() -> None:
    """Read the standard input; the argument has `members`, `size` and `ratio`, the limits."""
    if sys.platform != "win32":
        from mcml.processes.bounds import bound_growth, end_after

        end_after(SECONDS)
        bound_growth(MEMORY)
    target = sys.stdout.buffer
    try:
        _unpack(json.loads(sys.argv[1]), sys.stdin.buffer, target)
    except UnreadableError as error:
        target.seek(0)
        target.truncate()
        target.write(json.dumps(error.facts).encode() + b"\n")
    target.flush()


def _unpack(limits: dict[str, Any], source: BinaryIO, target: BinaryIO) -> None:
    from py7zr.exceptions import PasswordRequired, UnsupportedCompressionMethodError

    try:
        _write_members(limits, source, target)
    except PasswordRequired:
        raise UnreadableError("The 7z archive is encrypted.", "Pack the files again without a password.") from None
    except UnsupportedCompressionMethodError:
        what = "The 7z archive is compressed by a method that is not read."
        raise UnreadableError(what, "Pack the files again with LZMA2, or as a zip.") from None
    except (MemoryError, UnreadableError):
        raise
    except Exception as error:
        if isinstance(error, OSError) and is_full(error):
            raise UnreadableError("", kind="space") from error
        raise UnreadableError("The 7z archive is damaged.", AGAIN) from error


def _write_members(limits: dict[str, Any], source: BinaryIO, target: BinaryIO) -> None:
    import py7zr
    from py7zr.exceptions import PasswordRequired

    compressed = source.seek(0, 2)
    source.seek(0)
    with py7zr.SevenZipFile(source, max_extract_size=limits["size"]) as archive:
        if archive.needs_password():
            raise PasswordRequired
        # Folders and sockets have no bytes; links have those of their targets' names.
        entries = [entry for entry in archive.files if not entry.is_directory and not entry.is_socket]
        members = [(entry.filename, entry.uncompressed, not entry.is_symlink) for entry in entries]
        size = sum(length for _, length, _ in members)
        if size > min(limits["size"], (1 << 20) + limits["ratio"] * compressed):
            what = "The 7z archive unpacks to more than the limits allow."
            raise UnreadableError(what, "Send the files themselves.", "limit")
        if len(members) > limits["members"]:
            what = f"The archive holds {len(members)} files, the limit is {limits['members']}."
            raise UnreadableError(what, "Send it in parts.", "limit")
        target.write(json.dumps({"members": members}).encode() + b"\n")
        archive.extract(factory=_make_factory(target))


def _make_factory(target: BinaryIO) -> Any:
    """Make the object that gives py7zr a file for each member, in the order of the archive: always the target."""
    from py7zr.io import Py7zIO, WriterFactory

    class Append(Py7zIO):
        def write(self, s: bytes | bytearray) -> int:
            return target.write(s)

        def read(self, size: int | None = None) -> bytes:
            return b""

        def seek(self, offset: int, whence: int = 0) -> int:
            return 0

        def flush(self) -> None:
            """Nothing waits here."""

        def size(self) -> int:
            return 0

    class Factory(WriterFactory):
        def create(self, filename: str) -> Py7zIO:
            return Append()

    return Factory()
