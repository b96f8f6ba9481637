"""What is asked often finds its rows by an index, in a store without statistics too: SQLite's plans say so."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from mcml_service.storage.database import Database
from mcml_service.storage.lists.filtering import DocumentFilter
from mcml_service.storage.lists.list_rows import read_list_rows
from mcml_service.storage.transaction import Transaction
from tests.builders import bvh, store

ASKED: dict[str, tuple[Callable[[Transaction], object], str]] = {
    "files that were stored before": (lambda tx: tx.uploads.twins({"bvh": "0" * 64}, 1), "ix_upload_sha256"),
    "what changed since": (lambda tx: tx.columns.changed_since(1), "ix_revision_commit"),
    "the first page of a list": (
        lambda tx: tx.documents.page(DocumentFilter(), after=None, limit=10),
        "ix_document_there",
    ),
    "how many documents there are": (lambda tx: tx.documents.count(DocumentFilter()), "ix_document_there"),
    "revisions since": (lambda tx: tx.revisions.since(1, 100), "ix_revision_commit"),
}


FOUND: dict[str, Callable[[Transaction], object]] = {
    "the feed of changes": lambda tx: tx.revisions.since(0, 1),
    "what is told of a page": lambda tx: tx.documents.get_many([1]),
    "pictures of a page": lambda tx: tx.thumbnails.of(tx.documents.get_many([1])),
    "labels of a page": lambda tx: tx.spans.of_many([1]),
    "facts of a page": lambda tx: tx.heads.read_texts([1], ("calibration_unit", "global_axis_of_gravity")),
    "what lists need of a document that changed": lambda tx: [
        list(rows) for rows in vars(read_list_rows(tx, [1])).values()
    ],
    "documents of a collection": lambda tx: tx.documents.keys_of({tx.documents.get_many([1])[0].uuid}),
}
"""What is asked of few documents."""


def plans_of(folder: Path, ask: Callable[[Transaction], object]) -> list[list[str]]:
    """The plan of each statement."""
    database = Database(f"sqlite:///{folder}/store.db")
    database.migrate()
    store(database, {"one.bvh": bvh(3)}, labels=())
    said: list[str] = []
    with database.read() as tx:
        driver: Any = tx.connection.connection.driver_connection
        driver.set_trace_callback(said.append)
        ask(tx)
        driver.set_trace_callback(None)
        plans = [[row[3] for row in driver.execute(f"EXPLAIN QUERY PLAN {text}")] for text in said]
    database.close()
    return plans


@pytest.mark.parametrize("what", ASKED)
def test_rows_are_found_by_their_index(tmp_path: Path, what: str) -> None:
    ask, index = ASKED[what]
    plans = plans_of(tmp_path, ask)
    assert any(index in plan[0] for plan in plans), plans
    assert not any("B-TREE FOR ORDER BY" in step for step in plans[0]), plans


@pytest.mark.parametrize("what", FOUND)
def test_of_few_documents_no_table_is_read_whole(tmp_path: Path, what: str) -> None:
    plans = plans_of(tmp_path, FOUND[what])
    steps = [step for plan in plans for step in plan]
    assert steps
    assert not [step for step in steps if step.startswith("SCAN") and "json_each" not in step], plans
