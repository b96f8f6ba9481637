"""The middleware that every request passes first: bounds, no writes from foreign pages, authentication."""

from __future__ import annotations

import asyncio
import logging
import re
import sys
import time
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException

from mcml.errors import McmlError, SpaceError
from mcml_service.api.authentication import SHARED, Authentication, foreign_name, is_own_page
from mcml_service.api.forwarded import as_the_client_sent_it
from mcml_service.api.login_pages import LOGIN_PATH, LoginPages
from mcml_service.api.logs import begin_request, requests
from mcml_service.api.policy import DEFAULTS, ONLY_TLS
from mcml_service.api.problems import answer, plain
from mcml_service.api.traffic import FOLLOWING, Traffic
from mcml_service.settings import Settings

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]

START_AGAIN = "Make room on the disk of the store, then start the server again."
LOGIN_WORDS = "This repository opens with an account or a token."
SAFE_METHODS = {"GET", "HEAD", "OPTIONS"}
COUNTED_METHODS = SAFE_METHODS | {"POST", "PUT", "PATCH", "DELETE"}
OPEN_PATHS = {"/healthz", "/readyz"}
OPEN_FILES = ("/assets/", "/favicon.svg", "/shared")
"""Public files: the program of the studio, and the page for visitors with a share link."""
ASKERS = ("Cookie", "Authorization")
"""Headers of requests by which answers differ."""
ENTRIES = {LOGIN_PATH, "/api/v1/session", SHARED, f"{LOGIN_PATH}/openid", f"{LOGIN_PATH}/openid/back"}
"""Paths for requesting a session."""


class Guard:
    """ASGI middleware. Names requests, counts answers, and requests under way."""

    def __init__(
        self,
        app: Any,
        settings: Settings,
        authentication: Authentication,
        counts: dict[tuple[str, int], int],
        traffic: Traffic,
    ) -> None:
        self.app = app
        self.authentication = authentication
        self.proxies = settings.proxies
        self.max_bytes = settings.max_upload_bytes
        self.counts = counts
        self.traffic = traffic
        self.friends = settings.friends
        self.provider = settings.openid

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, _in_words(send))
            return
        began = time.perf_counter()
        scope = as_the_client_sent_it(scope, self.proxies)
        headers = Headers(scope=scope)
        request = begin_request(headers.get("x-request-id"))
        refusal = self._refusal(scope, headers)
        if headers.get("range"):
            # Ranges refer to uncompressed bytes.
            plain_only = [(name, value) for name, value in scope["headers"] if name != b"accept-encoding"]
            scope = {**scope, "headers": plain_only}
        path = scope["path"]
        if refusal is None and path.startswith(f"{SHARED}/"):
            refusal = await run_in_threadpool(self._entry, scope, headers, self.authentication.link_refusal)
            path = path.replace("/shared", "", 1)
            scope = {**scope, "path": path, "raw_path": path.encode()}
        elif refusal is None and path not in ENTRIES and depends_on_asker(path):
            if self.authentication.stand_open(scope, headers):
                refusal = foreign_name(headers)
            else:
                # Off the event loop: a store whose connections are all in use must not stop the streams that hold them.
                refusal = await run_in_threadpool(self._entry, scope, headers, self.authentication.refusal)
        method = scope["method"]
        if method == "HEAD":
            scope = {**scope, "method": "GET"}

        status = 0

        async def send_answer(message: MutableMapping[str, Any]) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                _tag_compressed(message)
                _protect(message, request, scope["scheme"])
                if depends_on_asker(path):
                    _keep_private(message)
            elif method == "HEAD":
                message = {**message, "body": b""}
            await send(message)

        is_work = not scope["path"].endswith(FOLLOWING)
        if is_work:
            self.traffic.begins()
        try:
            await (refusal or self.app)(scope, self._bound(receive), send_answer)
        except asyncio.CancelledError:
            if status or not scope["app"].state.stopping.is_set():
                raise
            words = "Retry the request. Before you repeat a change, check whether it was made."
            await plain(503, "The server stopped before this was done.", words)(scope, receive, send_answer)
        except Exception:
            status = status or 500
            raise
        finally:
            if is_work:
                self.traffic.ends()
            self._note(scope, method, status, (time.perf_counter() - began) * 1000)

    def _note(self, scope: Scope, method: str, status: int, milliseconds: float) -> None:
        """Count an answer and tell the log of it. status: 0 where the client left before there was any."""
        if status:
            key = (method if method in COUNTED_METHODS else "other", status)
            self.counts[key] = self.counts.get(key, 0) + 1
        if requests.isEnabledFor(logging.INFO):
            client = scope.get("client")
            facts = {
                "method": method,
                "path": scope["path"],
                "status": status,
                "milliseconds": round(milliseconds, 1),
                "author": getattr(scope.get("mcml.entry"), "author", None),
                "client": client and client[0],
            }
            line = (method, scope["path"], status, milliseconds)
            requests.info("%s %s %d in %.1f ms", *line, extra={"facts": facts})

    def _entry(self, scope: Scope, headers: Headers, refuse: Callable[[Scope, Headers], Any]) -> Any:
        try:
            refusal = refuse(scope, headers)
            if refusal is not None and refusal.status_code == 401 and _is_page(scope, headers):
                pages = LoginPages(headers.get("accept-language", ""), self.provider)
                return pages.login(LOGIN_WORDS, status=401, then=scope["path"])
            return refusal
        except McmlError as error:
            return answer(error)

    def _bound(self, receive: Receive) -> Receive:
        """Bodies without a length count as well."""
        taken = 0

        async def receive_bounded() -> MutableMapping[str, Any]:
            nonlocal taken
            message = await receive()
            taken += len(message.get("body", b""))
            if taken > self.max_bytes:
                raise HTTPException(413, f"The request has more than {self.max_bytes} bytes, which is the limit.")
            return message

        return receive_bounded

    def _refusal(self, scope: Scope, headers: Headers) -> Any:
        if scope["path"] in OPEN_PATHS:
            return None
        if b"%00" in scope.get("query_string", b"") or "\0" in scope["path"]:
            return plain(400, "An address cannot hold the character U+0000.", "Leave %00 out.")
        origin = headers.get("origin")
        own = origin is None or is_own_page(scope, headers) or origin in self.friends
        if not own and scope["method"] not in SAFE_METHODS:
            return plain(
                403, f"Pages of {origin} may not write here.", "Send the request from this server's own pages."
            )
        length = headers.get("content-length", "0")
        if length.isdigit() and (len(length) > 18 or int(length) > self.max_bytes):
            return plain(413, f"The request has {length} bytes, the limit is {self.max_bytes}.", "Send it in parts.")
        return None


def _in_words(send: Send) -> Send:
    """Report an expected failure of the start as its message, not as a traceback."""

    async def tell(message: MutableMapping[str, Any]) -> None:
        error = sys.exc_info()[1]
        if message["type"] == "lifespan.startup.failed" and isinstance(error, McmlError):
            remedy = START_AGAIN if isinstance(error, SpaceError) else error.remedy
            message = {**message, "message": f"{error.what} {remedy or ''}".strip()}
        await send(message)

    return tell


def _is_page(scope: Scope, headers: Headers) -> bool:
    """Whether a person looks at this with a browser."""
    return scope["method"] == "GET" and "text/html" in headers.get("accept", "")


def _protect(message: MutableMapping[str, Any], request: str, scheme: str) -> None:
    headers = MutableHeaders(raw=message["headers"])
    headers["x-request-id"] = request
    for name, value in (*DEFAULTS, ONLY_TLS) if scheme == "https" else DEFAULTS:
        headers.setdefault(name, value)


def depends_on_asker(path: str) -> bool:
    """Tell whether answers at a path depend on the user: all except public ones."""
    return path not in OPEN_PATHS and not path.startswith(OPEN_FILES)


def _keep_private(message: MutableMapping[str, Any]) -> None:
    """Keep caches from giving an answer to another user (RFC 9111, 3.5 and 4.1)."""
    headers = MutableHeaders(raw=message["headers"])
    told = headers.get("cache-control", "")
    if "private" not in told and "no-store" not in told:
        headers["cache-control"] = f"private, {told}" if told else "private"
    for name in ASKERS:
        headers.add_vary_header(name)


def _tag_compressed(message: MutableMapping[str, Any]) -> None:
    """A strong tag names one sequence of bytes: the compressed answer has its own (RFC 9110, 8.8.1)."""
    headers = MutableHeaders(raw=message["headers"])
    tag = headers.get("etag")
    if tag and headers.get("content-encoding") == "gzip" and not tag.startswith("W/") and not tag.endswith('-gzip"'):
        headers["etag"] = re.sub(r'"$', '-gzip"', tag)
