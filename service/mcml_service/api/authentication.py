"""Authentication of requests, by the store's accounts and tokens and by the origin of a request, not by its claims.

A proxy on the same machine looks like a local client: nginx's bare `proxy_pass` sends `Host: 127.0.0.1:8000` and no
header that would reveal it. So a store of several people never allows anonymous access, on any listening address.
"""

from __future__ import annotations

import hmac
from collections.abc import Callable, Mapping, MutableMapping
from contextlib import suppress
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import urlsplit

from starlette.datastructures import Headers

from mcml.errors import McmlError, StoreError
from mcml_service.api.problems import plain
from mcml_service.local_secret import PREFIX
from mcml_service.settings import Settings, is_loopback
from mcml_service.storage.database import Database

FORWARDING = frozenset(
    {
        "forwarded",
        "via",
        "x-real-ip",
        "x-client-ip",
        "x-cluster-client-ip",
        "x-envoy-external-address",
        "true-client-ip",
        "cf-connecting-ip",
        "fastly-client-ip",
    }
)
"""Headers that proxies add, besides X-Forwarded-…."""

COOKIE = "mcml_session"
"""That carries a browser's session."""
TLS_COOKIE = f"__Host-{COOKIE}"
"""The same over https: browsers take one of this name from the server itself alone, not from pages without TLS or from
its neighbours under the same domain."""

SHARE_COOKIE = "mcml_share"
"""Cookie with the session of a visitor with a share link; sent only below SHARED."""

SHARED = "/api/v1/shared"
"""Prefix of the API paths for visitors with a share link only."""

LOGIN = (
    "Send `Authorization: Bearer mcml_…`; `mcml token add NAME` on the server's machine makes one. Browsers: /login."
)

PASSED_ON = "This server requires a token for requests from other machines."


def why_closed(settings: Settings, database: Database) -> str | None:
    """Return the reason why a server needs a token from everybody, from its settings and the kind of its store.

    None: it does not.
    """
    if settings.login == "always":
        return "This server needs a token (MCML_LOGIN=always)."
    if not database.dialect.personal:
        return "This server needs a token: its store is one for several people."
    if not settings.knows_host:
        return "This server requires a token: MCML_HOST does not say that it listens on this machine only."
    if not is_loopback(settings.host):
        return "This server needs a token: it is open to other machines."
    return None


class Authentication:
    """Decides which requests a server answers.

    secret: the secret that commands on this machine send, read again each time; None if there is none.
    """

    def __init__(self, settings: Settings, database: Database, secret: Callable[[], str | None]) -> None:
        self._database = database
        self._secret = secret
        self._closed = why_closed(settings, database)

    def stand_open(self, scope: Mapping[str, Any], headers: Headers) -> bool:
        """Whether who comes from here needs no token. Answers at once."""
        try:
            return self._closed is None and _is_direct(scope, headers) and not self._database.has_token()
        except StoreError:
            return False

    def refusal(self, scope: MutableMapping[str, Any], headers: Headers) -> Any:
        """Return the answer to a request without a required token, or None.

        May wait for the store. Stores the identity of the request in `scope["mcml.entry"]` (`storage.accounts.Entry`).
        """
        direct = _is_direct(scope, headers)
        kind, _, given = headers.get("authorization", "").partition(" ")
        visit = _cookie(headers, cookie_name(scope["scheme"])) if not kind else None
        given = given.strip() if kind.lower() == "bearer" else ""
        if direct and given.startswith(PREFIX):
            secret = self._secret()
            if secret is not None and hmac.compare_digest(given.encode(), secret.encode()):
                return None
        with self._database.look() as tx:
            entry, is_noted = tx.tokens.came(given) if given else (None, False)
            if visit is not None and entry is None:
                entry = tx.sessions.entry(visit)
        if visit is not None and entry is not None and _is_foreign(scope, headers):
            return plain(403, "A session writes from pages of this server alone.", "Send the same Origin, or a token.")
        if entry is None:
            otherwise = "This server needs a token, since its store has one." if direct else PASSED_ON
            return plain(401, self._closed or otherwise, LOGIN, {"www-authenticate": "Bearer"})
        if given and not is_noted:
            self._note_use(given)
        scope["mcml.entry"] = entry
        return None

    def link_refusal(self, scope: MutableMapping[str, Any], headers: Headers) -> Any:
        """As `refusal`, for paths below SHARED."""
        visit = _cookie(headers, share_cookie_name(scope["scheme"]))
        with self._database.read() as tx:
            entry = None if visit is None else tx.sessions.share_entry(visit)
        if entry is None:
            return plain(401, "This link has expired or was revoked.", "Open it again, or ask for another one.")
        scope["mcml.entry"] = entry
        return None

    def _note_use(self, secret: str) -> None:
        # If it cannot be recorded, access is not refused.
        with suppress(McmlError), self._database.write("authentication") as tx:
            tx.tokens.note_use(secret)


def _is_direct(scope: Mapping[str, Any], headers: Headers) -> bool:
    """Tell whether a request comes from this machine, without a header of a proxy."""
    client = scope.get("client")
    passed_on = any(name in FORWARDING or name.startswith("x-forwarded") for name in headers)
    return client is not None and is_loopback(client[0]) and not passed_on


def cookie_name(scheme: str) -> str:
    """Of the cookie that carries a browser's session."""
    return TLS_COOKIE if scheme == "https" else COOKIE


def share_cookie_name(scheme: str) -> str:
    """Return the name of the cookie with the session of a share link. Its path excludes a name with `__Host-`."""
    return f"__Secure-{SHARE_COOKIE}" if scheme == "https" else SHARE_COOKIE


def _cookie(headers: Headers, name: str) -> str | None:
    """Return the value of a cookie."""
    try:
        cookies: SimpleCookie = SimpleCookie(headers.get("cookie", ""))
    except CookieError:
        return None
    return cookies[name].value if name in cookies else None


def _is_foreign(scope: Mapping[str, Any], headers: Headers) -> bool:
    """Tell whether a write lacks proof that it comes from this server's own pages."""
    return scope["method"] not in ("GET", "HEAD", "OPTIONS") and not is_own_page(scope, headers)


def is_own_page(scope: Mapping[str, Any], headers: Headers) -> bool:
    """Tell whether a page of this server sends a request, by its Origin.

    A page without TLS is rejected if the server is reached over https. The opposite is accepted: an untrusted proxy
    cannot report that it was reached over https.
    """
    scheme, _, host = headers.get("origin", "").partition("://")
    return host == headers.get("host") and (scheme == "https" or scope["scheme"] != "https")


def foreign_name(headers: Headers) -> Any:
    """The refusal of a name that is not of this machine: one that resolves to it would let any page read the
    repository (DNS rebinding)."""
    host = host_of(f"//{headers.get('host', '')}")
    if is_loopback(host):
        return None
    return plain(403, f"{host!r} is not a name of this machine.", "Use http://127.0.0.1 or http://localhost.")


def host_of(address: str) -> str:
    """Return the host's name in lower case, "" if it is missing or invalid."""
    try:
        return urlsplit(address).hostname or ""
    except ValueError:
        return ""
