"""The differences between databases: one module each, listed here."""

from __future__ import annotations

from importlib import import_module

from mcml_service.storage.core.dialects.base import Dialect

DIALECTS = {"sqlite": "sqlite:SQLite", "postgresql": "postgresql:PostgreSQL"}
"""Module and class by SQLAlchemy's name; imported when it is used, for a driver takes as long as a short command."""


def find_dialect(name: str) -> type[Dialect]:
    """Return the dialect with a name. Raises KeyError for an unknown name."""
    module, _, kind = DIALECTS[name].partition(":")
    dialect: type[Dialect] = getattr(import_module(f"mcml_service.storage.core.dialects.{module}"), kind)
    return dialect


__all__ = ["DIALECTS", "Dialect", "find_dialect"]
