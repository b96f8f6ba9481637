"""How much of files is read before it is refused."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class FileLimits:
    """Limits of a read; the defaults suit trusted files.

    size: bytes of all files together, unpacked. archive_files: in one archive. archive_ratio: of the unpacked size to
    the size of the archive. frames, values, joints: of one motion.
    """

    size: int = 2 << 30
    archive_files: int = 2000
    archive_ratio: float = 200.0
    frames: int = 50_000_000
    values: int = 4_000_000_000
    joints: int = 10_000
