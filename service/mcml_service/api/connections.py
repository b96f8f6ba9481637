"""Limits of time and number for connections: clients that send or read almost nothing do not block others.

uvicorn itself closes only connections that are idle between two requests.
"""

from __future__ import annotations

import asyncio
import functools
from collections.abc import Callable
from contextlib import suppress
from http import HTTPStatus
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from mcml_service.api.problems import RETRY_SECONDS, plain
from mcml_service.settings import Settings

LEAST_BYTES = 16_384
"""Bytes of a body that must arrive within `stall_seconds`: about 500 bytes a second."""

BACKLOG = 128
"""Connections that are accepted in one go, before any is counted."""


class Connection(H11Protocol):
    """A connection with limits. most: number of connections. header, stall: seconds, from the settings."""

    def __init__(self, *given: Any, most: int, header: float, stall: float, **named: Any) -> None:
        super().__init__(*given, **named)
        self._most, self._header, self._stall = most, header, stall
        self._awaited: Any = None
        """IDLE: the headers of a request, SEND_BODY: its body, None: nothing, from the client."""
        self._timers: dict[str, asyncio.TimerHandle] = {}
        self._received = 0
        self._rests_since = 0.0

    @property
    def rests(self) -> bool:
        """Whether no request is worked on."""
        return self.cycle is None or self.cycle.response_complete

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)  # type: ignore[arg-type]  # as uvicorn has it
        self._rests_since = self.loop.time()
        if len(self.connections) > self._most and not self._make_room():
            self._refuse(503, "The server has as many connections as it may.", {"retry-after": RETRY_SECONDS})
        else:
            self._await()

    def connection_lost(self, exc: Exception | None) -> None:
        for timer in self._timers.values():
            timer.cancel()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        self._received += len(data)
        super().data_received(data)

    def handle_events(self) -> None:
        super().handle_events()
        self._await()

    def on_response_complete(self) -> None:
        self._rests_since = self.loop.time()
        super().on_response_complete()
        if self.transport.get_write_buffer_size():
            self._set("taking", self._stall, self._check_taking)

    def pause_writing(self) -> None:
        super().pause_writing()
        self._set("taking", self._stall, self._check_taking)

    def send_400_response(self, msg: str) -> None:
        self._refuse(400, msg)

    def shutdown(self) -> None:
        # Streams of events never end by themselves.
        if "stopping" in self.app_state:
            self.app_state["stopping"].set()
        super().shutdown()

    def _await(self) -> None:
        """Set the timeout for the next data from the client."""
        state = self.conn.their_state
        # A connection that is kept after an answer has uvicorn's time.
        kept = state is h11.IDLE and self.timeout_keep_alive_task is not None
        awaited = state if state in (h11.IDLE, h11.SEND_BODY) and not kept else None
        if awaited is self._awaited:
            return
        self._awaited = awaited
        if awaited is h11.IDLE:
            self._set("sending", self._header, self._end_headers)
        elif awaited is h11.SEND_BODY:
            self._received = 0
            self._set("sending", self._stall, self._check_body)
        elif "sending" in self._timers:
            self._timers.pop("sending").cancel()

    def _set(self, name: str, seconds: float, then: Callable[[], None]) -> None:
        if name in self._timers:
            self._timers[name].cancel()
        self._timers[name] = self.loop.call_later(seconds, then)

    def _end_headers(self) -> None:
        if self.conn.trailing_data[0]:
            self._refuse(408, f"The request did not come within {self._header:g} s.")
        else:
            # Browsers open connections in advance.
            self.transport.close()

    def _check_body(self) -> None:
        if self.flow.read_paused or self._received >= LEAST_BYTES:
            self._received = 0
            self._set("sending", self._stall, self._check_body)
        else:
            self._refuse(408, f"The body brought less than {LEAST_BYTES} bytes in {self._stall:g} s.")

    def _check_taking(self) -> None:
        if self.flow.write_paused or self.transport.is_closing():
            self.transport.abort()

    def _make_room(self) -> bool:
        """Close the other connection that rests longest, if any does."""
        resting = [
            connection
            for connection in self.connections
            if isinstance(connection, Connection) and connection.rests and connection is not self
        ]
        if not resting:
            return False
        longest = min(resting, key=lambda connection: connection._rests_since)
        self.connections.discard(longest)
        longest.transport.abort()
        return True

    def _refuse(self, status: int, detail: str, headers: dict[str, str] | None = None) -> None:
        """Answer a problem at once, and close."""
        problem = plain(status, detail, headers=headers)
        sent = [*problem.raw_headers, (b"connection", b"close")]
        events = (
            h11.Response(status_code=status, headers=sent, reason=HTTPStatus(status).phrase.encode()),
            h11.Data(data=bytes(problem.body)),
            h11.EndOfMessage(),
        )
        with suppress(h11.LocalProtocolError):  # an answer is on its way already
            self.transport.write(b"".join(self.conn.send(event) or b"" for event in events))
        if self.cycle is not None:
            self.cycle.disconnected = True
            self.cycle.message_event.set()
        self.transport.close()


def connections_of(settings: Settings) -> Callable[..., asyncio.Protocol]:
    """Return the factory with which uvicorn makes connections."""
    return functools.partial(
        Connection, most=_most(settings.connections), header=settings.header_seconds, stall=settings.stall_seconds
    )


def _most(wanted: int) -> int:
    """Limit connections to half of the open files that the system allows; the store and uploads need the rest."""
    try:
        import resource
    except ImportError:  # Windows
        return wanted
    may = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    return wanted if may == resource.RLIM_INFINITY else max(1, min(wanted, (may - BACKLOG) // 2))
