"""Heavy requests wait in turn, some are sent away, and nothing light stands behind them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

import pytest
from fastapi.testclient import TestClient

from mcml_schemas.querying.queries import QueryAnswer, QueryRequest
from mcml_service.api import admission
from mcml_service.operations import OPERATIONS
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath import limits
from mcml_service.xpath.limits import Limits
from mcml_service.xpath.query_pool import PooledQueries as Queries
from tests.builders import bvh, one_kind, served, upload

API = "/api/v1"
MANY = 45
"""More than the threads that a server has for what is light."""
HEAVY = "count(for $bone in //bone return $bone)"
QUICK = "count(//bone)"


@pytest.fixture
def gate(monkeypatch: pytest.MonkeyPatch) -> Iterator[threading.Event]:
    """Heavy queries end once it is open."""
    gate, answer = threading.Event(), Queries.answer

    def late(queries: Queries, request: QueryRequest, limits: Limits | None = None) -> QueryAnswer:
        assert HEAVY not in request.q or gate.wait(60)
        return answer(queries, request, limits)

    monkeypatch.setattr(Queries, "answer", late)
    yield gate
    gate.set()


@contextmanager
def asked(client: TestClient, count: int, **more: Any) -> Iterator[list[Future[Any]]]:
    """So many queries at once; those that wait are counted when the block begins."""
    with ThreadPoolExecutor(count) as pool:
        yield [
            pool.submit(client.get, f"{API}/xpath", params={"q": f"{HEAVY} + {number}"}, **more)
            for number in range(count)
        ]


def until(holds: Callable[[], bool]) -> None:
    """Waits for it; the time limit of the test ends what never holds."""
    while not holds():
        threading.Event().wait(0.02)


def waiting(client: TestClient) -> int:
    queue = client.app.state.admission._reads  # type: ignore[attr-defined]  # what nobody else asks
    return int(queue._queue.waiting.total())


@one_kind
def test_what_is_light_is_not_behind_what_is_heavy(database: Database, gate: threading.Event) -> None:
    with served(database, Settings(heavy_places=2, heavy_waiting=200)) as client:
        upload(client, {"a.bvh": bvh(3)})
        with asked(client, MANY) as queries:
            until(lambda: waiting(client) == MANY - 1)
            assert client.get(f"{API}/documents").json()["total"] == 1
            # What writes has a queue of its own.
            upload(client, {"b.bvh": bvh(4)})
            assert client.get(f"{API}/facets").status_code == 200
            gate.set()
            assert [query.result().status_code for query in queries] == [200] * MANY


@one_kind
def test_what_is_quick_is_not_behind_what_is_heavy(database: Database, gate: threading.Event) -> None:
    """Not even behind queries of the same client: pages, lists and facets."""
    with served(database, Settings(heavy_places=2)) as client:
        upload(client, {"a.bvh": bvh(3)})
        with asked(client, 3) as queries:
            until(lambda: waiting(client) == 2)
            bones = client.get(f"{API}/xpath", params={"q": QUICK}).json()["value"]
            assert client.post(f"{API}/xpath", json={"q": QUICK}).json()["value"] == bones > 0
            assert client.get(f"{API}/documents", params={"xpath": "//bone"}).json()["total"] == 1
            assert client.get(f"{API}/facets", params={"xpath": "//bone"}).status_code == 200
            # An error is one at once.
            assert client.get(f"{API}/xpath", params={"q": QUICK, "document": "none"}).status_code == 404
            assert waiting(client) == 2
            gate.set()
            assert [query.result().status_code for query in queries] == [200] * 3


@one_kind
def test_what_is_not_quick_after_all_waits_for_its_turn(
    database: Database, gate: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "QUICK_SECONDS", -10.0)
    with served(database, Settings(heavy_places=2)) as client, ThreadPoolExecutor(1) as pool:
        upload(client, {"a.bvh": bvh(3)})
        with asked(client, 1) as queries:
            until(lambda: client.app.state.admission._reads._queue.held == 1)  # type: ignore[attr-defined]  # as above
            quick = pool.submit(client.get, f"{API}/xpath", params={"q": QUICK})
            until(lambda: waiting(client) == 1)
            gate.set()
            assert quick.result().json()["value"] > 0
            assert queries[0].result().status_code == 200


def test_what_ends_with_its_client_has_a_lane() -> None:
    """Who waits elsewhere does not look whether the client is there."""
    assert [name for name, one in OPERATIONS.items() if one.cancel_on_disconnect and one.queued is not True] == []


@one_kind
def test_those_who_ask_too_much_are_sent_away_first(database: Database, gate: threading.Event) -> None:
    with database.write() as tx:
        others = [{"authorization": f"Bearer {tx.tokens.add(name)}"} for name in ("kim", "lee", "park")]
    settings = Settings(heavy_places=1, heavy_waiting=2)
    question: dict[str, Any] = {"params": {"q": HEAVY}}
    with served(database, settings) as client, ThreadPoolExecutor(3) as pool:
        runs = pool.submit(client.get, f"{API}/xpath", **question)
        until(lambda: client.app.state.admission._reads._queue.held == 1)  # type: ignore[attr-defined]  # as above
        waits = [pool.submit(client.get, f"{API}/xpath", **question)]
        until(lambda: waiting(client) == 1)
        share = client.get(f"{API}/xpath", **question)
        assert (share.status_code, share.json()["type"]) == (429, "/docs/problems#share-error")
        waits.append(pool.submit(client.get, f"{API}/xpath", headers=others[0], **question))
        until(lambda: waiting(client) == 2)
        full = client.get(f"{API}/xpath", headers=others[1], **question)
        assert (full.status_code, full.json()["type"]) == (503, "/docs/problems#busy-error")
        assert int(share.headers["retry-after"]) == int(full.headers["retry-after"]) > 0
        gate.set()
        assert [one.result().status_code for one in (runs, *waits)] == [200, 200, 200]
        assert client.get(f"{API}/xpath", headers=others[2], **question).status_code == 200


@one_kind
def test_nobody_waits_for_ever(database: Database, gate: threading.Event) -> None:
    with served(database, Settings(heavy_places=1, heavy_wait_seconds=0.01)) as client, asked(client, 1) as queries:
        until(lambda: client.app.state.admission._reads._queue.held == 1)  # type: ignore[attr-defined]  # as above
        late = client.get(f"{API}/xpath", params={"q": HEAVY})
        assert (late.status_code, late.json()["detail"]) == (503, "No place was free within 0.01 s.")
        # With an expression a list is as heavy as a query.
        assert client.get(f"{API}/documents", params={"xpath": HEAVY}).status_code == 503
        assert client.get(f"{API}/documents").status_code == 200
        assert waiting(client) == 0
        gate.set()
        assert queries[0].result().status_code == 200


@one_kind
def test_the_time_of_a_query_begins_with_its_turn(
    database: Database, gate: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[str] = []
    limits = Queries.limits

    def noted(queries: Queries, client: str = "", author: str = "") -> Any:
        begun.append(client)
        return limits(queries, client, author)

    monkeypatch.setattr(Queries, "limits", noted)
    with served(database, Settings(heavy_places=1)) as client, asked(client, 3) as queries:
        until(lambda: waiting(client) == 2 and len(begun) == 1)
        gate.set()
        assert [query.result().status_code for query in queries] == [200, 200, 200]
        assert len(begun) == 3


@one_kind
def test_memory_is_given_back_where_it_is_never_quiet(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    given = threading.Event()
    monkeypatch.setattr(admission, "QUIET_SECONDS", 3600.0)
    monkeypatch.setattr(admission, "BUSY_SECONDS", 0.01)
    monkeypatch.setattr(admission, "give_memory_back", given.set)
    with served(database) as client:
        assert client.get(f"{API}/xpath", params={"q": HEAVY}).status_code == 200
        assert given.wait(30)


@one_kind
def test_memory_is_given_back_when_it_is_quiet(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    given, quiet = threading.Event(), admission.give_memory_back

    def back() -> None:
        quiet()
        given.set()

    monkeypatch.setattr(admission, "QUIET_SECONDS", 0.01)
    monkeypatch.setattr(admission, "give_memory_back", back)
    with served(database) as client:
        assert client.get(f"{API}/documents").status_code == 200
        assert client.get(f"{API}/xpath", params={"q": HEAVY}).status_code == 200
        assert given.wait(30)
