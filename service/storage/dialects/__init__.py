"""What differs between databases, and only that: one module each, listed here."""

from __future__ import annotations

from service.storage.dialects.base import Dialect
from service.storage.dialects.postgresql import PostgreSQL
from service.storage.dialects.sqlite import SQLite

DIALECTS: dict[str, type[Dialect]] = {"sqlite": SQLite, "postgresql": PostgreSQL}

__all__ = ["DIALECTS", "Dialect"]
