"""Messages on a pipe between a program and who started it: a length in 8 bytes, big-endian, and so many bytes."""

from __future__ import annotations

import struct
from typing import IO


def read_message(source: IO[bytes]) -> bytes | None:
    """The next message, None at the end of the input."""
    head = source.read(8)
    return source.read(struct.unpack(">Q", head)[0]) if len(head) == 8 else None


def write_message(target: IO[bytes], message: bytes) -> None:
    """Send a message at once."""
    target.write(struct.pack(">Q", len(message)) + message)
    target.flush()
