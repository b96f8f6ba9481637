"""Who may ask: loopback names without login, any other address with a token; no writes from foreign pages."""

from __future__ import annotations

import ipaddress
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any
from urllib.parse import urlsplit

from starlette.datastructures import Headers

from service.api.problems import plain
from service.settings import Settings
from service.storage.database import Database

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]

SAFE_METHODS = {"GET", "HEAD", "OPTIONS"}
OPEN_PATHS = {"/healthz", "/readyz"}


def is_loopback(host: str) -> bool:
    """Whether a host name or address (without port) means this machine."""
    name = host.strip("[]").rstrip(".").lower()
    if name == "localhost" or name.endswith(".localhost"):
        return True
    try:
        return ipaddress.ip_address(name).is_loopback
    except ValueError:
        return False


class Guard:
    """ASGI middleware. Notes the author of a request in `scope["mcml.author"]` and counts answers."""

    def __init__(self, app: Any, settings: Settings, database: Database, counts: dict[tuple[str, int], int]) -> None:
        self.app = app
        self.local = is_loopback(settings.host)
        self.database = database
        self.max_bytes = settings.max_upload_bytes
        self.counts = counts

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        refusal = self._refusal(scope, headers)

        async def counted(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                key = (scope["method"], message["status"])
                self.counts[key] = self.counts.get(key, 0) + 1
            await send(message)

        if refusal is not None:
            await refusal(scope, receive, counted)
            return
        await self.app(scope, receive, counted)

    def _refusal(self, scope: Scope, headers: Headers) -> Any:
        if scope["path"] in OPEN_PATHS:
            return None
        host = urlsplit(f"//{headers.get('host', '')}").hostname or ""
        origin = headers.get("origin")
        if origin and scope["method"] not in SAFE_METHODS and urlsplit(origin).netloc != headers.get("host"):
            return plain(
                403, f"Pages of {origin} may not write here.", "Send the request from this server's own pages."
            )
        length = headers.get("content-length", "0")
        if length.isdigit() and int(length) > self.max_bytes:
            return plain(413, f"The request has {length} bytes, the limit is {self.max_bytes}.", "Send it in parts.")
        if self.local:
            if not is_loopback(host):
                # A foreign name that resolves to this machine would let any page read the repository (DNS rebinding).
                return plain(
                    403, f"{host!r} is not a name of this machine.", "Use http://127.0.0.1 or http://localhost."
                )
            return None
        return self._token_refusal(scope, headers)

    def _token_refusal(self, scope: Scope, headers: Headers) -> Any:
        kind, _, secret = headers.get("authorization", "").partition(" ")
        owner = None
        if kind.lower() == "bearer" and secret:
            with self.database.read() as tx:
                owner = tx.tokens.owner(secret.strip())
        if owner is None:
            answer = plain(401, "This server needs a token.", "Send `Authorization: Bearer mcml_…`; see `mcml token`.")
            answer.headers["www-authenticate"] = "Bearer"
            return answer
        scope["mcml.author"] = owner
        return None
