"""What the database refuses, in words of ours, whichever way a row goes into it."""

from __future__ import annotations

from typing import Any

import pytest

from mcml.errors import ConflictError
from mcml_service.storage.core import tables
from mcml_service.storage.database import Database

ROW: dict[str, Any] = {"number": 7, "time": "2026-01-01T00:00:00Z", "author": "kim"}


def test_equal_keys_are_a_conflict(database: Database) -> None:
    with database.write() as tx:
        tx.insert_rows(tables.commit, [ROW])
    with pytest.raises(ConflictError), database.write() as tx:
        tx.insert_rows(tables.commit, [ROW])


def test_equal_names_are_a_conflict(database: Database) -> None:
    with database.write() as tx:
        tx.insert_row(tables.project, name="dance", created="2026-01-01T00:00:00Z")
    with pytest.raises(ConflictError), database.write() as tx:
        tx.insert_row(tables.project, name="dance", created="2026-01-01T00:00:00Z")
