"""Sends webhooks in the format of https://www.standardwebhooks.com: one thread in each server.

A message belongs to the server that claimed it as long as its lease lasts, so several servers send each once. If the
server is killed meanwhile, the message is sent again with the same id.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
import ipaddress
import logging
import socket
import ssl
import threading
import time
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import httpcore

from mcml.errors import McmlError
from mcml_service.storage.database import Database
from mcml_service.storage.projects.activity import SERVER
from mcml_service.storage.team.webhooks import Claimed

log = logging.getLogger("mcml.webhooks")

LOOK_SECONDS = 1.0
"""Interval of checks for messages to send."""

TOGETHER = 4
"""Messages that are sent at a time."""

SEND_SECONDS = 20.0
"""Longest time for one, from looking its host up to its answer's head."""

MAPPED = ipaddress.ip_network("64:ff9b::/96")
"""IPv6 addresses that represent IPv4 addresses (RFC 6052)."""


def is_public(address: str) -> bool:
    """Whether an address is one of the internet, and no host of a network of one's own."""
    ip = ipaddress.ip_address(address.partition("%")[0])
    if isinstance(ip, ipaddress.IPv6Address):
        inner = ip.ipv4_mapped or ip.sixtofour
        if ip in MAPPED:
            inner = ipaddress.IPv4Address(ip.packed[-4:])
        if inner is not None:
            return is_public(str(inner))
        if ip.teredo is not None:
            return False
    return ip.is_global and not ip.is_multicast


def addresses_of(host: str, port: int, *, private: bool) -> list[str]:
    """Return the addresses of a host.

    Raises OSError if there are none, or if one is private and private ones are refused.
    """
    addresses = [str(entry[4][0]) for entry in socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)]
    if not private and not all(map(is_public, addresses)):
        raise OSError("the host is in a private network")
    return addresses


def signature(secret: str, message: str, timestamp: int, payload: bytes) -> str:
    key = base64.b64decode(secret.removeprefix("whsec_"))
    signed = b"%s.%d.%s" % (message.encode(), timestamp, payload)
    return "v1," + base64.b64encode(hmac.digest(key, signed, hashlib.sha256)).decode()


class Sender:
    """Started and stopped with the server. private: whether hosts in private networks are allowed."""

    def __init__(self, database: Database, *, private: bool) -> None:
        self._database = database.for_call(database.view, SERVER)
        self._private = private
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="mcml-webhooks", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        """End after the messages that are under way."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(timeout=SEND_SECONDS)

    def send_due(self) -> None:
        """Send all that is to be sent now."""
        while not self._stopping.is_set():
            with self._database.read() as tx:
                if not tx.webhooks.any_due():
                    return
            with self._database.write(SERVER) as tx:
                tx.webhooks.queue()
                claimed = tx.webhooks.claim(TOGETHER)
            if not claimed:
                return
            with ThreadPoolExecutor(len(claimed), "mcml-webhook") as pool:
                list(pool.map(self._deliver, claimed))

    def _run(self) -> None:
        while not self._stopping.wait(LOOK_SECONDS):
            try:
                self.send_due()
            except McmlError as error:
                log.warning("cannot send webhooks now: %s", error)
            except Exception:
                log.exception("cannot send webhooks now")

    def _deliver(self, claimed: Claimed) -> None:
        status, problem, patience = self._send(claimed)
        with self._database.write(SERVER) as tx:
            tx.webhooks.note_outcome(claimed, status, problem, patience)

    def _send(self, claimed: Claimed) -> tuple[int | None, str | None, float]:
        """Send a message; return (status, reason of a failure, seconds that the answer asks to wait)."""
        timestamp, payload = int(time.time()), claimed.payload.encode()
        headers: dict[bytes | str, bytes | str] = {
            "content-type": "application/json",
            "user-agent": "mcml-repository",
            "webhook-id": claimed.message,
            "webhook-timestamp": str(timestamp),
            "webhook-signature": signature(claimed.secret, claimed.message, timestamp, payload),
        }
        network = _Network(time.monotonic() + SEND_SECONDS, private=self._private)
        try:
            with (
                httpcore.ConnectionPool(ssl_context=ssl.create_default_context(), network_backend=network) as pool,
                pool.stream("POST", claimed.url, headers=headers, content=payload) as answer,
            ):
                status, waits = answer.status, dict(answer.headers).get(b"retry-after", b"")
        except (httpcore.NetworkError, httpcore.TimeoutException, httpcore.ProtocolError, OSError) as error:
            return None, f"{type(error).__name__}: {error}", 0.0
        problem = None if 200 <= status < 300 else f"answered {status}"
        return status, problem, float(waits) if waits.isdigit() else 0.0


class _Network(httpcore.NetworkBackend):
    """Connects only to the checked addresses, also if the name gets others meanwhile."""

    def __init__(self, until: float, *, private: bool) -> None:
        self._until = until
        self._private = private
        self._plain = httpcore.SyncBackend()

    def connect_tcp(
        self,
        host: str,
        port: int,
        timeout: float | None = None,
        local_address: str | None = None,
        socket_options: Iterable[Any] | None = None,
    ) -> httpcore.NetworkStream:
        address = addresses_of(host, port, private=self._private)[0]
        stream = self._plain.connect_tcp(address, port, _measure_time_left(self._until), local_address, socket_options)
        return _Stream(stream, self._until)


class _Stream(httpcore.NetworkStream):
    """A connection with a total time limit, also for slow bytes."""

    def __init__(self, stream: httpcore.NetworkStream, until: float) -> None:
        self._stream = stream
        self._until = until

    def read(self, max_bytes: int, timeout: float | None = None) -> bytes:
        return self._stream.read(max_bytes, _measure_time_left(self._until))

    def write(self, buffer: bytes, timeout: float | None = None) -> None:
        self._stream.write(buffer, _measure_time_left(self._until))

    def close(self) -> None:
        self._stream.close()

    def start_tls(
        self, ssl_context: ssl.SSLContext, server_hostname: str | None = None, timeout: float | None = None
    ) -> httpcore.NetworkStream:
        return _Stream(
            self._stream.start_tls(ssl_context, server_hostname, _measure_time_left(self._until)), self._until
        )

    def get_extra_info(self, info: str) -> Any:
        return self._stream.get_extra_info(info)


def _measure_time_left(until: float) -> float:
    """Return the remaining seconds; raise httpcore.ReadTimeout if there are none."""
    left = until - time.monotonic()
    if left <= 0:
        raise httpcore.ReadTimeout("it took too long")
    return left
