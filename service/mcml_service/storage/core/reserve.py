"""Reserved disk space that is released when the disk is full, because deleting data also needs some space."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TypeVar

from mcml.errors import SpaceError

BYTES = 16 << 20
ENOUGH = 2
"""The reserve is made if this multiple of its size is free."""
TO_OPEN = 256 << 10
"""Disk space for opening a store: SQLite makes two files beside it."""
Result = TypeVar("Result")


class Reserve:
    """A file beside an SQLite store. path: of the store; None for other databases, which have none."""

    def __init__(self, path: Path | None) -> None:
        self._path = None if path is None else path.with_name(f"{path.name}.reserve")

    def _measure(self) -> int:
        """Return its size in bytes; 0 without a file."""
        with suppress(OSError):
            return self._path.stat().st_size if self._path is not None else 0
        return 0

    def keep(self) -> None:
        """Make the file if it is missing or incomplete and the disk has space."""
        path = self._path
        if path is None or self._measure() >= BYTES:
            return
        part = path.with_name(f"{path.name}.part")
        with suppress(OSError):
            if shutil.disk_usage(path.parent).free < ENOUGH * BYTES:
                return
            try:
                with os.fdopen(os.open(part, os.O_CREAT | os.O_WRONLY | os.O_TRUNC, 0o600), "wb") as file:
                    for _ in range(BYTES >> 20):
                        file.write(bytes(1 << 20))
                part.replace(path)
            finally:
                part.unlink(missing_ok=True)

    def spend(self, operation: Callable[[], Result], room: int = BYTES) -> Result:
        """Run an operation that frees disk space and return its result.

        If the disk is full, release this many bytes and run it again.
        """
        try:
            return operation()
        except SpaceError:
            held = self._measure()
            if self._path is None or not held:
                raise
            with suppress(OSError):
                if held > room:
                    os.truncate(self._path, held - room)
                else:
                    self._path.unlink()
            return operation()
