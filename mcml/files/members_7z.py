"""The members of a 7z archive, unpacked by a program of its own (`mcml.processes.unpack_7z`)."""

from __future__ import annotations

import json
import unicodedata
from contextlib import ExitStack
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any, BinaryIO

from mcml.errors import FormatError, LimitError, McmlError, Place, SpaceError, UnsupportedError
from mcml.formats.format import SourceFile
from mcml.processes.programs import run_reader
from mcml.processes.unpack_7z import MEMORY, SECONDS

INSTALL = "pip install 'mcml-repository[7z]'"


@dataclass
class Member:
    """A file in the archive, to be read once. left: bytes that are not read yet."""

    name: str
    start: int
    left: int
    stream: BinaryIO

    def read(self, most: int) -> bytes:
        """Return the next bytes, up to so many."""
        self.stream.seek(self.start)
        block = self.stream.read(min(most, self.left))
        self.start += len(block)
        self.left -= len(block)
        return block


def read_members(file: SourceFile, stack: ExitStack, *, members: int, size: int, ratio: float) -> list[Member]:
    """Return the files in a 7z archive, without folders and links. stack: closes them.

    members, size, ratio: how many files, how many bytes unpacked, and how many times the bytes of the archive are
    allowed. Raises UnsupportedError without py7zr, FormatError for a damaged or encrypted archive, LimitError.
    """
    if find_spec("py7zr") is None:
        raise UnsupportedError(
            "7z archives need the package py7zr.",
            at=Place(file=file.name),
            remedy=f"Install it: {INSTALL}. Or send a zip.",
        )
    asked = json.dumps({"members": members, "size": size, "ratio": ratio})
    try:
        answer = run_reader("mcml.processes.unpack_7z", asked, stream=file.stream, seconds=SECONDS, memory=MEMORY)
    except McmlError as error:
        raise error.in_file(file.name) from None
    stack.callback(answer.close)
    head: dict[str, Any] = json.loads(answer.readline())
    if "error" in head:
        _refuse(head, file)
    start = answer.tell()
    found = []
    for name, length, is_file in head["members"]:
        if is_file:
            found.append(Member(unicodedata.normalize("NFC", name.replace("\\", "/")), start, length, answer))
        start += length
    if start != answer.seek(0, 2):
        raise FormatError("The 7z archive is damaged.", at=Place(file=file.name), remedy="Pack the files again.")
    return found


def _refuse(head: dict[str, Any], file: SourceFile) -> None:
    if head["kind"] == "space":
        raise SpaceError
    kind = LimitError if head["kind"] == "limit" else FormatError
    raise kind(head["error"], at=Place(file=file.name), remedy=head["remedy"])
