"""BaseX's server in one JVM, and clients that read whole answers: over HTTP where its HTTP server is installed.

Debian's package has no `basexhttp`; BaseX's own archive has. Else questions go over BaseX's protocol on a socket.
"""

from __future__ import annotations

import base64
import hashlib
import http.client
import os
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urlencode


class BaseXClient:
    """A session. Strings end with a zero byte; an answer is followed by a line of information and a status byte."""

    asked = "over its own protocol"

    def __init__(self, port: int) -> None:
        self._opened = ""
        self._socket = socket.create_connection(("127.0.0.1", port))
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._rest = b""
        realm, nonce = self._string().decode().split(":")
        secret = hashlib.md5(f"admin:{realm}:admin".encode()).hexdigest()
        self._socket.sendall(f"admin\0{hashlib.md5((secret + nonce).encode()).hexdigest()}\0".encode())
        if self._byte():
            raise RuntimeError("BaseX refuses its default account.")

    def execute(self, command: str) -> bytes:
        """The whole answer to a database command. UTF-8 holds neither 0 nor 255, so nothing has to be unescaped."""
        self._socket.sendall(command.encode() + b"\0")
        answer = self._string()
        information = self._string()
        if self._byte():
            raise RuntimeError(f"BaseX: {information.decode()} at {command[:200]}")
        return answer

    def query(self, database: str, expression: str) -> bytes:
        """The answer, with a database as context."""
        if database != self._opened:
            self.execute(f"OPEN {database}")
            self._opened = database
        return self.execute(f"XQUERY {expression}")

    def close(self) -> None:
        self._socket.close()

    def _string(self) -> bytes:
        parts = []
        while (end := self._rest.find(b"\0")) < 0:
            parts.append(self._rest)
            self._receive()
        parts.append(self._rest[:end])
        self._rest = self._rest[end + 1 :]
        return b"".join(parts)

    def _byte(self) -> int:
        if not self._rest:
            self._receive()
        first, self._rest = self._rest[0], self._rest[1:]
        return first

    def _receive(self) -> None:
        self._rest = self._socket.recv(1 << 20)
        if not self._rest:
            raise RuntimeError("BaseX closed the connection.")


class BaseXHttpClient(BaseXClient):
    """A session whose questions go to the REST service, which opens the database for each, over one kept connection."""

    asked = "over HTTP"

    def __init__(self, port: int, http_port: int) -> None:
        super().__init__(port)
        self._http = http.client.HTTPConnection("127.0.0.1", http_port, timeout=600)
        self._account = {"Authorization": f"Basic {base64.b64encode(b'admin:admin').decode()}"}

    def query(self, database: str, expression: str) -> bytes:
        # The session must not hold the database open.
        if self._opened != database:
            self.execute("CLOSE")
            self._opened = database
        asked = f"/rest/{database}?{urlencode({'query': expression, 'indent': 'no'})}"
        try:
            status, content = self._get(asked)
        except (http.client.RemoteDisconnected, ConnectionError):
            # The server closes connections at rest, here while another engine was asked: never a timed one.
            self._http.close()
            status, content = self._get(asked)
        if status != 200:
            raise RuntimeError(f"BaseX: {content[:500].decode()} at {expression[:200]}")
        return content

    def _get(self, address: str) -> tuple[int, bytes]:
        self._http.request("GET", address, headers=self._account)
        answer = self._http.getresponse()
        return answer.status, answer.read()


@contextmanager
def serving(home: Path) -> Iterator[BaseXClient]:
    """A server that keeps its databases below `home`, without a time limit, text and attribute index on."""
    port, http_port, stop_port = _free_port(), _free_port(), _free_port()
    options = f"-Xmx8g -Duser.home={home} -Dorg.basex.path={home} -Dorg.basex.TIMEOUT=0"
    environment = os.environ | {"HOME": str(home), "JAVA_ARGS": options, "BASEX_JVM": options}
    command = shutil.which("basexhttp")
    arguments = [f"-p{port}", "-z"]
    if command is not None:
        arguments += [f"-h{http_port}", f"-s{stop_port}"]
    log = (home / "log").open("wb")
    process = subprocess.Popen(
        [command or shutil.which("basexserver") or "basexserver", *arguments],
        env=environment,
        cwd=home,
        stdout=log,
        stderr=log,
    )
    try:
        client = _connected(port, None if command is None else http_port, home / "log")
        for option in ("TEXTINDEX true", "ATTRINDEX true", "SERIALIZER indent=no"):
            client.execute(f"SET {option}")
        yield client
        client.close()
    finally:
        process.terminate()
        process.wait(30)
        log.close()


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def _connected(port: int, http_port: int | None, log: Path) -> BaseXClient:
    for _ in range(150):
        try:
            if http_port is None:
                return BaseXClient(port)
            socket.create_connection(("127.0.0.1", http_port)).close()
            return BaseXHttpClient(port, http_port)
        except ConnectionRefusedError:
            time.sleep(0.2)
    raise RuntimeError(f"BaseX does not start: {log.read_text()[-2000:]}")
