"""BaseX's server in one JVM, and a client of its protocol that reads whole answers."""

from __future__ import annotations

import hashlib
import os
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class BaseXClient:
    """A session. Strings end with a zero byte; an answer is followed by a line of information and a status byte."""

    def __init__(self, port: int) -> None:
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

    def query(self, expression: str) -> bytes:
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


@contextmanager
def serving(home: Path) -> Iterator[BaseXClient]:
    """A server that keeps its databases below `home`, without a time limit, text and attribute index on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    environment = os.environ | {"HOME": str(home), "JAVA_ARGS": f"-Xmx8g -Duser.home={home} -Dorg.basex.TIMEOUT=0"}
    command = [shutil.which("basexserver") or "basexserver", "-z", f"-p{port}"]
    log = (home / "log").open("wb")
    process = subprocess.Popen(command, env=environment, stdout=log, stderr=log)
    try:
        client = _connected(port, home / "log")
        for option in ("TEXTINDEX true", "ATTRINDEX true", "SERIALIZER indent=no"):
            client.execute(f"SET {option}")
        yield client
        client.close()
    finally:
        process.terminate()
        process.wait(30)
        log.close()


def _connected(port: int, log: Path) -> BaseXClient:
    for _ in range(150):
        try:
            return BaseXClient(port)
        except ConnectionRefusedError:
            time.sleep(0.2)
    raise RuntimeError(f"BaseX does not start: {log.read_text()[-2000:]}")
