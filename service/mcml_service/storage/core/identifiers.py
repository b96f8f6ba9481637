"""Identifiers and times that the store hands out."""

from __future__ import annotations

import hashlib
import os
import threading
import time
import unicodedata
import uuid
from datetime import UTC, datetime, timedelta
from typing import Final

_TICKS: Final = 4096
"""Parts of a millisecond that are told apart."""

_lock = threading.Lock()
_last = 0


def new_uuid() -> str:
    """A UUID of version 7 (RFC 9562, section 5.7): 48 bits of milliseconds, 12 of their parts, then random bits.

    It sorts by creation. Two of one process have different times (section 6.2, method 3): the documents of one import
    are made within a millisecond.
    """
    global _last
    with _lock:
        _last = ticks = max(_last + 1, time.time_ns() * _TICKS // 1_000_000)
    milliseconds, part = divmod(ticks, _TICKS)
    random = int.from_bytes(os.urandom(8), "big") & (1 << 62) - 1
    return str(uuid.UUID(int=milliseconds << 80 | 0x7 << 76 | part << 64 | 0b10 << 62 | random))


def now(later: timedelta = timedelta()) -> str:
    """Return the time as ISO 8601 in UTC, to the millisecond; or a later time."""
    return (datetime.now(UTC) + later).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def digest_of(secret: str) -> str:
    """Return the stored digest of a secret: random bytes need no salt."""
    return hashlib.sha256(secret.encode()).hexdigest()


def normalise_name(name: str) -> str:
    """A name as the store holds and finds it: in NFC, so that both ways to write 걸음 or é are one name."""
    return unicodedata.normalize("NFC", name)
