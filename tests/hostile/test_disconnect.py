"""A client that goes away in the middle of an upload, on a real socket to a real server, leaves nothing."""

from __future__ import annotations

import itertools
import socket
import threading
from collections.abc import Iterator
from queue import Queue
from typing import Any

import httpx
import pytest
import uvicorn

from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.actions.test_import_failures import rows
from tests.builders import SECRET, bvh

pytestmark = pytest.mark.above_store

BOUNDARY = "end-of-part"
CONTENT = bvh(20_000)


class Watched:
    """The service, saying of each request when it is over, and how it was answered."""

    def __init__(self, app: Any) -> None:
        self.app = app
        self.started: Queue[str] = Queue()
        self.ended: Queue[int | None] = Queue()

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        status: int | None = None

        async def noted(message: Any) -> None:
            nonlocal status
            status = message.get("status", status)
            await send(message)

        self.started.put(scope["path"])
        try:
            await self.app(scope, receive, noted)
        finally:
            self.ended.put(status)


@pytest.fixture
def served(database: Database) -> Iterator[tuple[Watched, int]]:
    """The watched service, and the port it listens on."""
    watched = Watched(create_app(Settings(), database, lambda: SECRET))
    listener = socket.create_server(("127.0.0.1", 0))
    server = uvicorn.Server(uvicorn.Config(watched, log_level="error"))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]})
    thread.start()
    try:
        yield watched, listener.getsockname()[1]
    finally:
        server.should_exit = True
        thread.join()
        listener.close()


def request(announced: int | None) -> bytes:
    """An upload; announced: the length it says its body has, None for a body in chunks."""
    length = "Transfer-Encoding: chunked" if announced is None else f"Content-Length: {announced}"
    return (
        f"POST /api/v1/documents HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer {SECRET}\r\n{length}\r\n"
        f"Content-Type: multipart/form-data; boundary={BOUNDARY}\r\n\r\n"
    ).encode()


BODY = (
    f'--{BOUNDARY}\r\nContent-Disposition: form-data; name="file"; filename="long.bvh"\r\n\r\n'.encode()
    + CONTENT
    + f"\r\n--{BOUNDARY}--\r\n".encode()
)


WAYS = list(itertools.product((0, len(BODY) // 2, len(BODY) - 3), (False, True), (False, True)))
"""(bytes of the body that are sent, whether in chunks, whether the connection is reset instead of closed)."""


@pytest.mark.slow
def test_a_client_that_goes_away_leaves_nothing(served: tuple[Watched, int], database: Database) -> None:
    watched, port = served
    for sent, chunked, abruptly in WAYS:
        client = socket.create_connection(("127.0.0.1", port))
        if abruptly:
            # Closing sends a reset instead of an orderly end.
            client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
        client.sendall(request(None if chunked else len(BODY)))
        assert watched.started.get(timeout=30) == "/api/v1/documents"
        part = BODY[:sent]
        client.sendall(f"{len(part):x}\r\n".encode() + part if chunked and part else part)
        client.close()
        assert watched.ended.get(timeout=30) != 201, (sent, chunked, abruptly)
        assert rows(database) == {}, (sent, chunked, abruptly)

    owner = {"authorization": f"Bearer {SECRET}"}
    with httpx.Client(base_url=f"http://127.0.0.1:{port}/api/v1", headers=owner) as other:
        assert other.post("/documents", files={"file": ("long.bvh", CONTENT)}).status_code == 201
        assert other.get("/documents").json()["total"] == 1
    assert database.check() == []
