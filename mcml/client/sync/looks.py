"""The files of a folder and their checksums, except those that somebody is writing."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

from mcml.client.folders import EXTENSIONS
from mcml.files.companions import COMPANION_ENDINGS

SETTLE_SECONDS = 1.0
"""A file that was written this recently is looked at twice."""
_BLOCK = 1 << 20
_ENDINGS = {*EXTENSIONS, *COMPANION_ENDINGS}

Stamp: TypeAlias = tuple[int, int, int]
"""Size, time of change in nanoseconds, number of the file."""


@dataclass
class Look:
    """The files of a folder.

    sums: SHA-256 by path in the folder, with slashes. busy: files that change. faults: reasons by unreadable file.
    """

    sums: dict[str, str] = field(default_factory=dict)
    busy: set[str] = field(default_factory=set)
    faults: dict[str, str] = field(default_factory=dict)


class Looker:
    """Looks at a folder, again and again: a file is read once for each change. Hidden files are left out."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._known: dict[str, tuple[Stamp, str]] = {}

    def look(self, told: Callable[[int, int, str], None]) -> Look:
        """The folder now. told: receives files done, of how many, and the name of the next."""
        result = Look()
        stamps = dict(_walk(self._folder))
        fresh = []
        for done, (path, stamp) in enumerate(stamps.items()):
            known = self._known.get(path)
            if known is not None and known[0] == stamp:
                result.sums[path] = known[1]
                continue
            told(done, len(stamps), path)
            try:
                digest = _digest_of(self._folder / path)
            except OSError as error:
                result.faults[path] = error.strerror or str(error)
                continue
            fresh.append(path)
            result.sums[path] = digest
        if any(time.time_ns() - stamps[path][1] < SETTLE_SECONDS * 1e9 for path in fresh):
            time.sleep(SETTLE_SECONDS)
        for path in fresh:
            if self.is_still(path, stamps[path]):
                self._known[path] = (stamps[path], result.sums[path])
            else:
                result.busy.add(path)
                del result.sums[path]
        self._known = {path: known for path, known in self._known.items() if path in stamps}
        return result

    def is_still(self, path: str, stamp: Stamp | None = None) -> bool:
        """Tell whether a file has this stamp, or the one of the last look."""
        known = self._known.get(path)
        expected = stamp or (known and known[0])
        try:
            return _stamp_of(self._folder / path) == expected
        except OSError:
            return False

    def know(self, path: str, digest: str) -> None:
        """Remember the sum of a file that was just written."""
        self._known[path] = (_stamp_of(self._folder / path), digest)


def _walk(folder: Path) -> list[tuple[str, Stamp]]:
    """Files of known formats, and the buffers of glTF files, in order."""
    files = []
    for root, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for name in sorted(names):
            path = Path(root, name)
            if name.startswith(".") or path.suffix.lower() not in _ENDINGS or not path.is_file():
                continue
            try:
                files.append((path.relative_to(folder).as_posix(), _stamp_of(path)))
            except FileNotFoundError:
                continue
    return files


def _stamp_of(path: Path) -> Stamp:
    facts = path.stat()
    return facts.st_size, facts.st_mtime_ns, facts.st_ino


def _digest_of(path: Path) -> str:
    hashed = hashlib.sha256()
    with path.open("rb") as stream:
        while block := stream.read(_BLOCK):
            hashed.update(block)
    return hashed.hexdigest()
