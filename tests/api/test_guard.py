"""Who may ask what from where."""

from __future__ import annotations

from fastapi.testclient import TestClient

from service.app import create_app
from service.settings import Settings
from service.storage.database import Database


def test_loopback_answers_only_to_loopback_names(client: TestClient) -> None:
    assert client.get("/api/v1/documents").status_code == 200
    for host in ("localhost:8000", "[::1]:8000", "127.0.0.2"):
        assert client.get("/api/v1/documents", headers={"host": host}).status_code == 200, host
    for host in ("rebinding.example", "127.0.0.1.evil.example", ""):
        assert client.get("/api/v1/documents", headers={"host": host}).status_code == 403, host


def test_foreign_pages_may_not_write(client: TestClient) -> None:
    files = [("file", ("a.bvh", b"HIERARCHY"))]
    foreign = client.post("/api/v1/documents", files=files, headers={"origin": "http://evil.example"})
    assert foreign.status_code == 403
    own = client.post("/api/v1/documents", files=files, headers={"origin": "http://127.0.0.1:8000"})
    assert own.status_code == 422


def test_other_addresses_need_a_token(database: Database) -> None:
    with database.write() as tx:
        secret = tx.tokens.add("render farm")
        old = tx.tokens.add("old", expires="2001-01-01T00:00:00.000Z")
    with TestClient(create_app(Settings(host="0.0.0.0"), database), base_url="http://studio.example") as open_client:
        assert open_client.get("/healthz").status_code == 200
        refused = open_client.get("/api/v1/documents")
        assert refused.status_code == 401
        assert refused.headers["www-authenticate"] == "Bearer"
        for wrong in ("mcml_nope", old, ""):
            assert open_client.get("/api/v1/documents", headers={"authorization": f"Bearer {wrong}"}).status_code == 401
        good = {"authorization": f"Bearer {secret}"}
        assert open_client.get("/api/v1/documents", headers=good).status_code == 200
        from tests.builders import bvh

        made = open_client.post("/api/v1/documents", files=[("file", ("a.bvh", bvh(2)))], headers=good).json()
        history = open_client.get(f"/api/v1/documents/{made['documents'][0]['id']}/revisions", headers=good).json()
        assert history["items"][0]["author"] == "render farm"
    with database.read() as tx:
        assert secret not in str(tx.connection.exec_driver_sql("SELECT * FROM token").all())


def test_large_requests_are_refused_before_they_are_read(database: Database) -> None:
    with TestClient(create_app(Settings(max_upload_bytes=1000), database), base_url="http://127.0.0.1") as client:
        answer = client.post("/api/v1/documents", files=[("file", ("a.bvh", b"x" * 2000))])
    assert answer.status_code == 413
