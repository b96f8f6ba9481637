"""Bounds of requests, and pages of others."""

from __future__ import annotations

from fastapi.testclient import TestClient

from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import one_kind, served

pytestmark = one_kind


def test_foreign_pages_may_not_write(client: TestClient) -> None:
    files = [("file", ("a.bvh", b"HIERARCHY"))]
    foreign = client.post("/api/v1/documents", files=files, headers={"origin": "http://evil.example"})
    assert foreign.status_code == 403
    own = client.post("/api/v1/documents", files=files, headers={"origin": "http://127.0.0.1:8000"})
    assert own.status_code == 422


def test_large_requests_are_refused_before_they_are_read(database: Database) -> None:
    with served(database, Settings(max_upload_bytes=1000)) as client:
        answer = client.post("/api/v1/documents", files=[("file", ("a.bvh", b"x" * 2000))])
    assert answer.status_code == 413
