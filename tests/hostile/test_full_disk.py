"""A full disk is said in words, with its own status, and nothing of the request stays."""

from __future__ import annotations

import errno
import io
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import event, text

from mcml_service.actions.importing import import_clip, keep_upload
from mcml_service.storage.database import Database
from tests.actions.test_import_failures import rows
from tests.builders import bvh, upload

API = "/api/v1"
Full = Callable[[int], AbstractContextManager[None]]


@pytest.fixture
def full(database: Database) -> Full:
    """While the context lasts, the store has room for so many more pages (SQLite), or for no more rows (PostgreSQL)."""
    return lambda pages: (_no_pages if database.name == "sqlite" else _no_rows)(database, pages)


@contextmanager
def _no_pages(database: Database, room: int) -> Iterator[None]:
    engine = database.dialect.engine
    with database.read() as tx:
        pages = tx.connection.execute(text("PRAGMA page_count")).scalar_one() + room

    def limit(connection, _record) -> None:  # type: ignore[no-untyped-def]
        connection.execute(f"PRAGMA max_page_count={pages}")

    event.listen(engine, "connect", limit)
    engine.dispose()
    try:
        yield
    finally:
        event.remove(engine, "connect", limit)
        engine.dispose()


@contextmanager
def _no_rows(database: Database, _room: int) -> Iterator[None]:
    refuse = """CREATE FUNCTION refuse() RETURNS trigger LANGUAGE plpgsql AS
        $$ BEGIN RAISE EXCEPTION 'could not extend file: No space left on device' USING ERRCODE = '53100'; END $$"""
    with database.dialect.writing() as connection:
        connection.execute(text(refuse))
        for table in ("track", "header"):
            connection.execute(text(f"CREATE TRIGGER full_disk BEFORE INSERT ON {table} EXECUTE FUNCTION refuse()"))
    try:
        yield
    finally:
        with database.dialect.writing() as connection:
            connection.execute(text("DROP FUNCTION refuse CASCADE"))


def assert_full(answer) -> None:  # type: ignore[no-untyped-def]
    assert answer.status_code == 507, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["type"] == "/docs/problems#space-error"
    assert "room" in answer.json()["remedy"]


@pytest.mark.slow
@pytest.mark.parametrize("flushed", ["at once", "in parts"])
@pytest.mark.parametrize("room", [0, 3, 10])
def test_an_upload_to_a_full_store_leaves_nothing(
    client: TestClient, database: Database, full: Full, monkeypatch: pytest.MonkeyPatch, room: int, flushed: str
) -> None:
    if flushed == "in parts":
        monkeypatch.setattr(import_clip, "FLUSH_BYTES", 2000)
        monkeypatch.setattr(keep_upload, "EARLY_BYTES", 0)
    long = {"long.bvh": bvh(6000)}
    with full(room):
        assert_full(client.post(f"{API}/documents", files=[("file", ("long.bvh", long["long.bvh"]))]))
    assert rows(database) == {}
    assert database.check() == []
    upload(client, long)
    assert client.get(f"{API}/documents").json()["total"] == 1


def test_an_edit_of_a_full_store_changes_nothing(client: TestClient, full: Full) -> None:
    uuid = upload(client, {"walk.bvh": bvh(4)})["documents"][0]["id"]  # type: ignore[index]
    address = f"{API}/documents/{uuid}"
    before = client.get(address).json()
    with full(0):
        long = "a walk " * 14_000
        assert_full(client.patch(address, json={"description": long, "name": "b"}, headers={"if-match": "*"}))
        assert client.get(address).json() == before


@pytest.mark.parametrize("name", ["long.bvh", "long.zip"])
def test_an_upload_that_does_not_fit_beside_the_store(
    client: TestClient, database: Database, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("long.bvh", bvh(6000))
    content = packed.getvalue() if name == "long.zip" else bvh(6000)
    allowed = len(content) if name == "long.zip" else 0
    written = 0
    write = tempfile.SpooledTemporaryFile.write

    def refuse(self, data):  # type: ignore[no-untyped-def]
        nonlocal written
        written += len(data)
        if written > allowed:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(self, data)

    with monkeypatch.context() as patched:
        patched.setattr(tempfile.SpooledTemporaryFile, "write", refuse)
        answer = client.post(f"{API}/documents", files=[("file", (name, content))])
    assert_full(answer)
    assert rows(database) == {}
