"""Two server processes on one store behave as one, and so do two workers of one."""

from __future__ import annotations

import itertools
import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from datetime import timedelta
from pathlib import Path
from typing import Any

import httpx
import pytest
from fastapi.testclient import TestClient
from sqlalchemy import Engine, TextClause, create_engine, make_url, text
from sqlalchemy.exc import OperationalError

from mcml_service.actions.reading.read_news import News
from mcml_service.operations.call import Call
from mcml_service.storage.core.dialects.postgresql import COMMIT_LOCK
from mcml_service.storage.core.identifiers import now
from mcml_service.storage.database import Database
from tests import postgres
from tests.builders import bvh

API = "/api/v1"


def environment(url: str, folder: Path, **more: str) -> dict[str, str]:
    kept = {name: value for name, value in os.environ.items() if not name.startswith("MCML_")}
    ours = {"PYTHONPATH": os.getcwd(), "XDG_DATA_HOME": str(folder), "MCML_DATABASE": url, "MCML_CACHE_DIR": "none"}
    return {**kept, **ours, "MCML_JOB_WORKERS": "1", "MCML_LOGIN": "always", **more}


@contextmanager
def serving(url: str, folder: Path, servers: int, *words: str) -> Iterator[list[str]]:
    """Addresses of servers of a store."""
    ports = [postgres.free_port() for _ in range(servers)]
    command = [sys.executable, "-m", "mcml_service.cli", "serve", *words]
    with (folder / "log").open("wb") as log:
        started = [
            subprocess.Popen([*command, "--port", str(port)], env=environment(url, folder), stdout=log, stderr=log)
            for port in ports
        ]
    try:
        addresses = [f"http://127.0.0.1:{port}" for port in ports]
        until(lambda: all(map(is_ready, addresses)) or any(server.poll() is not None for server in started))
        assert all(server.poll() is None for server in started), (folder / "log").read_text()
        yield addresses
    finally:
        for server in started:
            server.send_signal(signal.SIGTERM)
        for server in started:
            server.wait(30)


def is_ready(address: str) -> bool:
    try:
        # To read certificates, of which this needs none, would take time from the server that starts.
        return httpx.get(f"{address}/readyz", timeout=5, verify=False).status_code == 200
    except httpx.HTTPError:
        return False


def until(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + 60
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.05)


@pytest.fixture
def token(database: Database) -> str:
    with database.write() as tx:
        return tx.tokens.add("kim", None)


@pytest.fixture
def clients(database_url: str, token: str, tmp_path: Path) -> Iterator[list[httpx.Client]]:
    with serving(database_url, tmp_path, 2) as addresses:
        yield [client(address, token) for address in addresses]


def client(address: str, token: str, **headers: str) -> httpx.Client:
    return httpx.Client(base_url=f"{address}{API}", headers={"authorization": f"Bearer {token}", **headers}, timeout=60)


def upload(at: httpx.Client, name: str, frames: int = 3, **headers: str) -> httpx.Response:
    return at.post("/documents", files={"file": (f"{name}.bvh", bvh(frames))}, data={"project": "lab"}, headers=headers)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [pytest.param("sqlite", marks=pytest.mark.fuzz), "postgresql"], indirect=True)
def test_two_are_one(clients: list[httpx.Client], database: Database) -> None:
    first, second = clients
    seen_at_once(clients)
    events_of_one_come_from_the_other(first, second)
    one_key_makes_one(clients)
    doors_are_the_same(first, second, database)
    links_open_once(clients, database)


def seen_at_once(clients: list[httpx.Client]) -> None:
    rng = random.Random(7)
    made = upload(clients[0], "a").json()["documents"][0]["id"]
    count = 1
    for step in range(20):
        writer, reader = rng.sample(clients, 2)
        if step % 4 == 0:
            assert upload(writer, f"more {step}").status_code == 201
            count += 1
        changed = writer.patch(f"/documents/{made}", json={"name": f"a {step}"}, headers={"if-match": "*"})
        assert changed.status_code == 200
        assert reader.get(f"/documents/{made}").json()["name"] == f"a {step}"
        assert reader.get("/documents").json()["total"] == count
        assert reader.get("/xpath", params={"q": "count(//frame)"}).json()["value"] == 3 * count
        names = {item["name"] for item in reader.get("/documents", params={"limit": 100}).json()["items"]}
        assert f"a {step}" in names


def events_of_one_come_from_the_other(first: httpx.Client, second: httpx.Client) -> None:
    with second.stream("GET", "/events", params={"kind": "document"}) as events:
        lines = events.iter_lines()
        assert "event: ready" in itertools.islice(lines, 2)
        made = upload(first, "told").json()["documents"][0]["id"]
        assert any(made in line for line in lines)


def one_key_makes_one(clients: list[httpx.Client]) -> None:
    before = clients[0].get("/documents").json()["total"]
    with ThreadPoolExecutor(8) as pool:
        sent = [pool.submit(upload, clients[i % 2], "once", **{"idempotency-key": "once"}) for i in range(8)]
        answers = [answer.result() for answer in sent]
    assert {answer.status_code for answer in answers} <= {201, 409}
    assert len({answer.text for answer in answers if answer.status_code == 201}) == 1
    assert clients[1].get("/documents").json()["total"] == before + 1


def doors_are_the_same(first: httpx.Client, second: httpx.Client, database: Database) -> None:
    with database.write() as tx:
        secret = tx.tokens.add("lee", None)
    bearer = {"authorization": f"Bearer {secret}"}
    opened = first.post("/session", json={"token": secret})
    assert opened.status_code == 201
    cookie = {"cookie": f"mcml_session={opened.cookies['mcml_session']}"}
    visitor = httpx.Client(base_url=second.base_url, timeout=60)
    assert visitor.get("/documents", headers=bearer).status_code == 200
    assert visitor.get("/documents", headers=cookie).status_code == 200
    assert first.delete("/tokens/lee").status_code == 204
    assert visitor.get("/documents", headers=bearer).status_code == 401
    assert visitor.get("/documents", headers=cookie).status_code == 401


def links_open_once(clients: list[httpx.Client], database: Database) -> None:
    for _ in range(5):
        with database.write() as tx:
            link = tx.sessions.link("local")
        both = threading.Barrier(4)

        def follow(at: httpx.Client, link: str = link, both: threading.Barrier = both) -> int:
            both.wait(30)
            return at.post("/session", json={"link": link}).status_code

        with ThreadPoolExecutor(4) as pool:
            answers = list(pool.map(follow, [*clients, *clients]))
        assert sorted(answers) == [201, 403, 403, 403]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["postgresql"], indirect=True)
def test_workers_of_one_server_are_one(database: Database, database_url: str, token: str, tmp_path: Path) -> None:
    with serving(database_url, tmp_path, 1, "--workers", "2") as (address,):
        # Each request comes by a connection of its own, to either.
        seen_at_once([client(address, token, connection="close") for _ in range(2)])


@pytest.mark.slow
def test_an_upgrade_by_two_at_once_is_one(kind: str, request: Any, tmp_path: Path) -> None:
    def upgraded(url: str) -> None:
        command = [sys.executable, "-m", "mcml_service.cli", "db", "upgrade"]
        piped: Any = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "env": environment(url, tmp_path)}
        both = [subprocess.Popen(command, **piped) for _ in range(2)]
        said = [one.communicate(timeout=120)[0] for one in both]
        assert [one.returncode for one in both] == [0, 0], said
        store = Database(url)
        store.require_schema()
        assert store.check() == []
        store.close()

    if kind == "sqlite":
        upgraded(f"sqlite:///{tmp_path / 'new.db'}")
    else:
        with postgres.new_database(request.getfixturevalue("postgres_server")) as url:
            upgraded(url)


def test_a_job_that_ended_by_a_slow_clock_is_told(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    with database.write() as tx:
        uuid = tx.jobs.add(tx.projects.get_or_add("lab"), "reach", "a model", "kim", [], {}, runner="other")
    with database.read() as tx:
        news = News(tx.newest_commit(), now(), 0)
        assert [job.uuid for job in news.find_changed_jobs(tx)] == [uuid]
    monkeypatch.setattr("mcml_service.storage.work.jobs.now", lambda: now(-timedelta(seconds=5)))
    with database.write() as tx:
        tx.jobs.end(uuid, "other", "done")
    with database.read() as tx:
        assert [job.state for job in news.find_changed_jobs(tx)] == ["done"]
        assert news.find_changed_jobs(tx) == []


@pytest.mark.parametrize("kind", ["postgresql"], indirect=True)
def test_a_write_that_was_in_anothers_way_is_done_again(
    client: TestClient, database: Database, database_url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The other has the lock that it waits for, and wants what it has. The database ends one of them: the one that
    waited a second first, which on a busy machine is now and then the other."""
    uuid = client.post(f"{API}/documents", files={"file": ("a.bvh", bvh(3))}).json()["documents"][0]["id"]
    other, clashes = create_engine(database_url), []
    again = Call.begin_again
    monkeypatch.setattr(Call, "begin_again", lambda call: clashes.append(1) or again(call))
    waits = text("SELECT count(*) FROM pg_stat_activity WHERE wait_event_type = 'Lock' AND datname = :name")
    for name in "bcdefghijk":
        asked = {"json": {"name": name}, "headers": {"if-match": "*"}}
        with ThreadPoolExecutor(1) as pool, other.connect() as connection:
            connection.execute(text("SELECT pg_advisory_xact_lock(:key)"), {"key": COMMIT_LOCK})
            changed = pool.submit(client.patch, f"{API}/documents/{uuid}", **asked)
            until(lambda: count_of(other, waits, make_url(database_url).database) > 0)
            with suppress(OperationalError):
                connection.execute(text("SELECT id FROM document FOR UPDATE"))
            connection.rollback()
            assert changed.result(60).status_code == 200
        if clashes:
            break
    assert clashes
    other.dispose()
    assert client.get(f"{API}/documents/{uuid}").json()["name"] == name


def count_of(engine: Engine, statement: TextClause, name: str | None) -> int:
    with engine.connect() as connection:
        return int(connection.execute(statement, {"name": name}).scalar_one())
