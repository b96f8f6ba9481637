"""How much of files is read before it is refused."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class FileLimits:
    """Bounds of what is read at a time; the defaults suit files that one trusts.

    size: bytes of all files together, unpacked. archive_files: in one archive. archive_ratio: of the size of what an
    archive holds to its own. frames, values, joints: of one motion.
    """

    size: int = 2 << 30
    archive_files: int = 2000
    archive_ratio: float = 200.0
    frames: int = 50_000_000
    values: int = 4_000_000_000
    joints: int = 10_000
