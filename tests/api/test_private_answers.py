"""What depends on who asks: counts of the whole store, and answers that caches keep."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from fastapi.testclient import TestClient

from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.api.asked import API
from tests.builders import SECRET, bvh, one_kind, store

Asking = Callable[..., TestClient]


@pytest.fixture
def asking(database: Database) -> Asking:
    """A client of somebody from another machine, by how their token is made."""
    app = create_app(Settings(), database, lambda: SECRET)

    def of(name: str, **granted: object) -> TestClient:
        with database.write() as tx:
            secret = tx.tokens.add(name, **granted)  # type: ignore[arg-type]
        return TestClient(app, client=("10.0.0.7", 1), headers={"authorization": f"Bearer {secret}"})

    return of


@one_kind
def test_members_of_single_projects_get_no_counts_of_the_store(database: Database, asking: Asking) -> None:
    store(database, {"a.bvh": bvh(3)}, project="mine")
    store(database, {"b.bvh": bvh(3), "c.bvh": bvh(4)}, project="theirs")
    with database.write() as tx:
        mine = tx.projects.get("mine")
        ann, lee, kim = (tx.accounts.add(*who, "x") for who in (("ann", "owner"), ("lee", "member"), ("kim", "reader")))
        tx.members.put(mine, "lee", "owner")
    for refused in (
        asking("of lee", owner=lee),
        asking("of ann, limited", owner=ann, projects=[mine]),
        asking("nobody's, limited", projects=[mine]),
    ):
        answer = refused.get("/metrics")
        assert answer.status_code == 403
        assert "mcml_" not in answer.text
    for allowed in (asking("of kim", owner=kim), asking("scraper", scope="read"), asking("of ann", owner=ann)):
        assert 'mcml_documents{body="missing"} 3' in allowed.get("/metrics").text


PUBLIC = ("/healthz", "/readyz", "/favicon.svg")
ASKED = (
    "/",
    "/docs",
    "/openapi.json",
    "/mcml.dtd",
    "/login",
    "/metrics",
    "/nowhere",
    f"{API}/documents",
    f"{API}/documents/nowhere",
    f"{API}/xpath?q=//frame",
    f"{API}/account",
    f"{API}/shared/documents/x/mcml",
)


@pytest.mark.slow
@one_kind
@pytest.mark.parametrize("known", [True, False], ids=["by a reader", "by a stranger"])
def test_no_cache_gives_an_answer_to_another(database: Database, asking: Asking, known: bool) -> None:
    uuid = store(database, {"a.bvh": bvh(3)})[0]
    client = asking("reader", scope="read")
    if not known:
        del client.headers["authorization"]
    there = (f"{API}/documents/{uuid}", f"{API}/documents/{uuid}/mcml", f"{API}/documents/{uuid}/mcml?revision=1")
    frames = (f"{API}/documents/{uuid}/frames?revision=1&format=npy", f"{API}/documents/{uuid}/export?format=bvh")
    for path in (*ASKED, *there, *frames):
        answer = client.get(path)
        told = answer.headers["cache-control"].replace(" ", "").split(",")
        assert {"private", "no-store"} & set(told), path
        assert "public" not in told, path
        named = {name.strip().lower() for name in answer.headers["vary"].split(",")}
        assert {"cookie", "authorization"} <= named, path
    for path in PUBLIC:
        answer = client.get(path)
        assert "private" not in answer.headers.get("cache-control", ""), path
        assert "authorization" not in answer.headers.get("vary", "").lower(), path


@one_kind
def test_what_is_said_for_good_stays(database: Database, asking: Asking) -> None:
    uuid = store(database, {"a.bvh": bvh(600)})[0]
    answer = asking("reader", scope="read").get(f"{API}/documents/{uuid}/frames?revision=1&format=json&limit=1000")
    assert "Accept-Encoding" in answer.headers["vary"]
    lasting = asking("another", scope="read").get(f"{API}/documents/{uuid}/frames?revision=1&format=npy")
    assert lasting.headers["cache-control"] == "private, max-age=31536000, immutable"
