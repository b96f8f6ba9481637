"""Identifiers and times that the store hands out."""

from __future__ import annotations

import hashlib
import os
import time
import unicodedata
import uuid
from datetime import UTC, datetime, timedelta


def new_uuid() -> str:
    """A UUID of version 7 (RFC 9562, section 5.7): 48 bits of milliseconds, then random bits; sorts by creation."""
    milliseconds = time.time_ns() // 1_000_000
    random = int.from_bytes(os.urandom(10), "big")
    value = milliseconds << 80 | 0x7 << 76 | (random >> 62 & 0xFFF) << 64 | 0b10 << 62 | random & (1 << 62) - 1
    return str(uuid.UUID(int=value))


def now(later: timedelta = timedelta()) -> str:
    """Return the time as ISO 8601 in UTC, to the millisecond; or a later time."""
    return (datetime.now(UTC) + later).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def digest_of(secret: str) -> str:
    """Return the stored digest of a secret: random bytes need no salt."""
    return hashlib.sha256(secret.encode()).hexdigest()


def normalise_name(name: str) -> str:
    """A name as the store holds and finds it: in NFC, so that both ways to write 걸음 or é are one name."""
    return unicodedata.normalize("NFC", name)
