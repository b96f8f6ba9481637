"""What is asked often finds its rows by an index, in a store without statistics too: SQLite's plans say so."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from service.storage.database import Database, Transaction
from service.storage.filtering import DocumentFilter
from tests.builders import bvh, store

ASKED: dict[str, tuple[Callable[[Transaction], object], str]] = {
    "files that were stored before": (lambda tx: tx.uploads.twins({"bvh": "0" * 64}, 1), "ix_upload_sha256"),
    "what changed since": (lambda tx: tx.columns.changed_since(1), "ix_revision_commit"),
    "the first page of a list": (
        lambda tx: tx.documents.page(DocumentFilter(), after=None, limit=10),
        "ix_document_there",
    ),
    "how many documents there are": (lambda tx: tx.documents.count(DocumentFilter()), "ix_document_there"),
    "revisions since": (lambda tx: tx.documents.revisions_since(1, 100), "ix_revision_commit"),
}


@pytest.mark.parametrize("what", ASKED)
def test_rows_are_found_by_their_index(tmp_path: Path, what: str) -> None:
    database = Database(f"sqlite:///{tmp_path}/store.db")
    database.migrate()
    store(database, {"one.bvh": bvh(3)}, labels=())
    ask, index = ASKED[what]
    said: list[str] = []
    with database.read() as tx:
        driver: Any = tx.connection.connection.driver_connection
        driver.set_trace_callback(said.append)
        ask(tx)
        driver.set_trace_callback(None)
        plans = [[row[3] for row in driver.execute(f"EXPLAIN QUERY PLAN {text}")] for text in said]
    database.close()
    assert any(index in plan[0] for plan in plans), plans
    assert not any("B-TREE FOR ORDER BY" in step for step in plans[0]), plans
