"""A database that goes away and comes back: requests are told to come again, and then are answered."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from contextlib import suppress

import pytest
from sqlalchemy import make_url

from mcml.errors import UnavailableError
from mcml_service.storage.database import Database
from tests import postgres
from tests.builders import bvh, served, upload


class Line:
    """A line to a server, which can be cut and mended: what a client of it sees of a restart."""

    def __init__(self, port: int) -> None:
        self._target = port
        self._listening: socket.socket | None = None
        self._open: list[socket.socket] = []
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]

    def mend(self) -> None:
        listening = socket.create_server(("127.0.0.1", self.port))
        self._listening = listening
        threading.Thread(target=self._accept, args=(listening,), daemon=True).start()

    def cut(self) -> None:
        held = [*self._open, *([self._listening] if self._listening else [])]
        self._open.clear()
        for one in held:
            with suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()

    def _accept(self, listening: socket.socket) -> None:
        while True:
            try:
                client, _ = listening.accept()
            except OSError:
                return
            server = socket.create_connection(("127.0.0.1", self._target))
            self._open += [client, server]
            for source, target in ((client, server), (server, client)):
                threading.Thread(target=_carry, args=(source, target), daemon=True).start()


def _carry(source: socket.socket, target: socket.socket) -> None:
    with suppress(OSError):
        while data := source.recv(65536):
            target.sendall(data)
        target.shutdown(socket.SHUT_RDWR)


@pytest.fixture
def line(postgres_template: str) -> Iterator[tuple[Line, Database]]:
    with postgres.new_database(postgres_template, "template_store") as url:
        address = make_url(url)
        assert address.port is not None
        cable = Line(address.port)
        cable.mend()
        database = Database(address.set(port=cable.port).render_as_string(hide_password=False))
        yield cable, database
        database.close()
        cable.cut()


def test_requests_are_told_to_come_again(line: tuple[Line, Database]) -> None:
    cable, database = line
    with served(database) as client:
        upload(client, {"a.bvh": bvh(3)})
        for _ in range(2):
            cable.cut()
            for method, path in (("GET", "/documents"), ("GET", "/xpath?q=count(//frame)"), ("DELETE", "/documents/x")):
                answer = client.request(method, f"/api/v1{path}", headers={"if-match": "*"})
                assert answer.status_code == 503
                assert answer.json()["type"] == "/docs/problems#unavailable-error"
                assert int(answer.headers["retry-after"]) > 0
            cable.mend()
            assert client.get("/api/v1/documents").json()["total"] == 1
            assert client.get("/api/v1/xpath", params={"q": "count(//frame)"}).json()["value"] == 3


def test_transactions_that_lose_the_line_are_told(line: tuple[Line, Database]) -> None:
    cable, database = line
    with pytest.raises(UnavailableError):
        _add_projects(cable, database)
    cable.mend()
    with database.read() as tx:
        assert tx.projects.find("lab") is None


def _add_projects(cable: Line, database: Database) -> None:
    with database.write() as tx:
        tx.projects.get_or_add("lab")
        cable.cut()
        tx.projects.get_or_add("gait")
