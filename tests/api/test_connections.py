"""Clients that are slow, silent or too many, on real sockets of a real server."""

from __future__ import annotations

import os
import resource
import shutil
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

import httpx
import pytest
import uvicorn

from mcml_service.api.connections import BACKLOG, connections_of
from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.limits import Limits
from mcml_service.xpath.query_pool import PooledQueries as Queries
from tests.actions.test_import_failures import rows
from tests.api.test_admission import until
from tests.builders import SECRET, bvh, one_kind, store

API = "/api/v1"
OWNER = {"authorization": f"Bearer {SECRET}"}
HALF = b"GET /api/v1/documents HTTP/1.1\r\nHost: 127.0.0."


@contextmanager
def serving(database: Database, **settings: Any) -> Iterator[tuple[int, uvicorn.Server]]:
    """The port of a server, and the server, which must end by itself."""
    chosen = Settings(**settings)
    listener = socket.create_server(("127.0.0.1", 0), backlog=BACKLOG)
    app = create_app(chosen, database, lambda: SECRET)
    config = uvicorn.Config(app, log_config=None, http=connections_of(chosen), backlog=BACKLOG, proxy_headers=False)  # type: ignore[arg-type]  # as `serve` does
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]})
    thread.start()
    try:
        until(lambda: server.started)
        yield listener.getsockname()[1], server
    finally:
        server.should_exit = True
        thread.join()
        listener.close()


def opened(port: int, sent: bytes = b"") -> socket.socket:
    client = socket.create_connection(("127.0.0.1", port), timeout=30)
    client.sendall(sent)
    return client


def to_the_end(client: socket.socket) -> bytes:
    """All that comes until the server closes."""
    found = b""
    # Where the server has not read all that was sent, its end is a reset.
    with suppress(ConnectionResetError):
        while some := client.recv(1 << 16):
            found += some
    return found


def answers(port: int) -> bool:
    url = f"http://127.0.0.1:{port}{API}/documents"
    return httpx.get(url, headers=OWNER, timeout=30).status_code == 200


@one_kind
def test_half_open_connections_make_room(database: Database) -> None:
    with serving(database, connections=20, header_seconds=600) as (port, server), ExitStack() as stack:
        halves = [stack.enter_context(opened(port, HALF[: number % 40])) for number in range(60)]
        assert answers(port)
        # The first 40 had rested longest.
        assert [to_the_end(one) for one in halves[:40]] == [b""] * 40
        assert len(server.server_state.connections) <= 20
        # The last goes on where it stopped.
        halves[-1].sendall(
            HALF[59 % 40 :] + f"1\r\nAuthorization: Bearer {SECRET}\r\nConnection: close\r\n\r\n".encode()
        )
        assert to_the_end(halves[-1]).startswith(b"HTTP/1.1 200")


@one_kind
def test_connections_at_work_are_not_closed(database: Database) -> None:
    with serving(database, connections=1) as (port, _):
        url = f"http://127.0.0.1:{port}{API}"
        with httpx.stream("GET", f"{url}/events", headers=OWNER) as events:
            lines = events.iter_lines()
            assert next(lines).startswith("id: ")
            with opened(port) as refused:
                said = to_the_end(refused)
            assert said.startswith(b"HTTP/1.1 503 Service Unavailable")
            assert b"retry-after: " in said
            assert b"application/problem+json" in said
            store(database, {"a.bvh": bvh(3)})
            assert any(line == "event: document" for line in lines)
        until(lambda: answers_once_free(port))


def answers_once_free(port: int) -> bool:
    try:
        return answers(port)
    except (httpx.HTTPError, OSError):
        return False


@one_kind
def test_headers_that_do_not_come(database: Database) -> None:
    with serving(database, header_seconds=0.1) as (port, _):
        with opened(port, HALF) as half, opened(port) as silent:
            said = to_the_end(half)
            assert said.startswith(b"HTTP/1.1 408 Request Timeout")
            assert b"application/problem+json" in said
            # Browsers open connections that they do not need.
            assert to_the_end(silent) == b""
        with opened(port, f"GET /healthz HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode()) as kept:
            assert kept.recv(9) == b"HTTP/1.1 "
            kept.sendall(HALF)
            assert b"HTTP/1.1 408 " in to_the_end(kept)
        assert answers(port)


@one_kind
def test_a_body_that_hardly_comes(database: Database) -> None:
    head = (
        f"POST {API}/documents HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer {SECRET}\r\n"
        "Content-Length: 90000\r\nContent-Type: multipart/form-data; boundary=end\r\n\r\n"
    )
    with serving(database, stall_seconds=0.2) as (port, _):
        with opened(port, head.encode() + b"--end\r\n") as slow:
            stop = threading.Event()

            def drip() -> None:
                while not stop.wait(0.01):
                    try:
                        slow.sendall(b"x")
                    except OSError:
                        return

            dripping = threading.Thread(target=drip)
            dripping.start()
            try:
                said = slow.recv(1 << 16)
            finally:
                stop.set()
                dripping.join()
            assert said.startswith(b"HTTP/1.1 408 Request Timeout")
        assert rows(database) == {}
        assert answers(port)


@pytest.mark.slow
@one_kind
def test_an_answer_that_is_not_taken(database: Database) -> None:
    (uuid,) = store(database, {"long.bvh": bvh(20_000)})
    asked = f"GET {API}/documents/{uuid}/mcml HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer {SECRET}\r\n\r\n"
    with serving(database, stall_seconds=0.2) as (port, server):
        with socket.socket() as client:
            client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            client.connect(("127.0.0.1", port))
            client.sendall(asked.encode())
            assert client.recv(12) == b"HTTP/1.1 200"
            until(lambda: not server.server_state.connections)
        # Nothing of it is held any more.
        until(lambda: not server.server_state.tasks)
        assert answers(port)


@one_kind
def test_what_is_no_request_is_a_problem(database: Database, caplog: pytest.LogCaptureFixture) -> None:
    with serving(database) as (port, _):
        with opened(port, b"NOT HTTP AT ALL\r\n\r\n") as client:
            said = to_the_end(client)
        assert said.startswith(b"HTTP/1.1 400 Bad Request")
        assert b"application/problem+json" in said
        for method in (b"POST", b"HEAD"):
            # The body makes no sense while the request is worked on; an answer to HEAD could not say so.
            head = b" / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n"
            with opened(port, method + head + b"ZZ\r\n") as client:
                assert to_the_end(client)[:12] == (b"HTTP/1.1 400" if method == b"POST" else b"")
        assert answers(port)
    assert {record.name for record in caplog.records} <= {"uvicorn.error"}, "asyncio tells of errors that nobody caught"


@one_kind
def test_a_server_that_stops_ends_streams_of_events(database: Database) -> None:
    with (
        serving(database) as (port, server),
        httpx.stream("GET", f"http://127.0.0.1:{port}{API}/events", headers=OWNER, timeout=60) as events,
    ):
        lines = events.iter_lines()
        assert next(lines).startswith("id: ")
        server.should_exit = True
        assert [line for line in lines if line.startswith("event: ")] == ["event: ready"]


@pytest.fixture
def ended(monkeypatch: pytest.MonkeyPatch) -> Iterator[threading.Event]:
    """Queries last until they are cancelled; told when one was."""
    told, over = threading.Event(), threading.Event()

    def lasting(queries: Queries, request: Any, limits: Limits) -> Any:
        until(lambda: limits.over or over.is_set())
        told.set()
        limits.check()

    monkeypatch.setattr(Queries, "answer", lasting)
    yield told
    over.set()


def asks_xpath(port: int) -> socket.socket:
    headers = f"Host: 127.0.0.1\r\nAuthorization: Bearer {SECRET}\r\n\r\n"
    return opened(port, f"GET {API}/xpath?q=reverse(1) HTTP/1.1\r\n{headers}".encode())


@one_kind
def test_queries_end_when_their_clients_leave(database: Database, ended: threading.Event) -> None:
    with serving(database, heavy_places=1, query_seconds=600) as (port, server):
        turns = server.config.app.state.admission._reads._queue  # type: ignore[union-attr]  # what nobody else asks
        works = asks_xpath(port)
        until(lambda: turns.held == 1)
        waits = asks_xpath(port)
        until(lambda: turns.waiting.total() == 1)
        waits.close()
        until(lambda: turns.waiting.total() == 0)
        assert not ended.is_set()
        works.close()
        assert ended.wait(60)
        until(lambda: turns.held == 0)
        assert answers(port)


@one_kind
def test_a_server_that_stops_tells_those_who_wait(database: Database, ended: threading.Event) -> None:
    with ExitStack() as stack:
        port, server = stack.enter_context(serving(database, heavy_places=1, query_seconds=600))
        turns = server.config.app.state.admission._reads._queue  # type: ignore[union-attr]  # what nobody else asks
        works = stack.enter_context(asks_xpath(port))
        until(lambda: turns.held == 1)
        with asks_xpath(port) as waits:
            until(lambda: turns.waiting.total() == 1)
            server.should_exit = True
            answer = to_the_end(waits)
        assert answer.startswith(b"HTTP/1.1 503")
        assert b"The server stops." in answer
        works.close()


@pytest.mark.fuzz  # Long: in `make test` a server in this process has as many (above).
@pytest.mark.skipif(sys.platform != "linux", reason="limits of files are set as Linux does")
@pytest.mark.parametrize(("files", "sockets"), [(256, 350), (4096, 900)])
def test_half_open_sockets_leave_mcml_serve_answering(
    files: int, sockets: int, tmp_path: Path, sqlite_template: Path
) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft < sockets + 200:
        # Our own ends are files too.
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 4096), hard))
    shutil.copy(sqlite_template, tmp_path / "store.db")
    environment = {name: value for name, value in os.environ.items() if not name.startswith("MCML_")}
    environment |= {
        "PYTHONPATH": os.getcwd(),
        "XDG_DATA_HOME": str(tmp_path),
        "MCML_DATABASE": f"sqlite:///{tmp_path / 'store.db'}",
        "MCML_LOG_FORMAT": "json",
    }
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with (tmp_path / "log").open("wb") as log:
        server = subprocess.Popen(
            [sys.executable, "-m", "mcml_service.cli", "serve", "--port", str(port)],
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=log,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (files, files)),  # no threads yet
        )
    try:
        until(lambda: server.poll() is not None or answers_once_free(port))
        with ExitStack() as stack:
            for _ in range(sockets):
                stack.enter_context(opened(port, HALF))
            assert answers(port)
            server.send_signal(signal.SIGTERM)
            assert server.wait(60) in (0, -signal.SIGTERM)
    finally:
        server.kill()
        server.wait()
    assert (tmp_path / "log").read_bytes().count(b"\n") <= 5
