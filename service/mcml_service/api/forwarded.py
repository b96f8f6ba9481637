"""Information about clients from trusted proxies (MCML_TRUSTED_PROXIES)."""

from __future__ import annotations

import ipaddress
from collections.abc import MutableMapping, Sequence
from typing import Any

from starlette.datastructures import Headers

Network = ipaddress.IPv4Network | ipaddress.IPv6Network


def as_the_client_sent_it(scope: MutableMapping[str, Any], trusted: Sequence[Network]) -> MutableMapping[str, Any]:
    """Return the request with the client, scheme and host from a trusted proxy's X-Forwarded-For, -Proto and -Host.

    Each proxy adds to the right, so the client is the first address from the right that is not a trusted proxy:
    addresses to the left may be forged. Headers from other senders are ignored.
    """
    client = scope.get("client")
    if not trusted or client is None or not _is_of(client[0], trusted):
        return scope
    headers = Headers(scope=scope)
    scope = dict(scope)
    passed = [part.strip() for part in ",".join(headers.getlist("x-forwarded-for")).split(",") if part.strip()]
    for address in reversed(passed):
        scope["client"] = (address, 0)
        if not _is_of(address, trusted):
            break
    scheme, host = (headers.get(f"x-forwarded-{name}", "").rpartition(",")[2].strip() for name in ("proto", "host"))
    if scheme in ("http", "https"):
        scope["scheme"] = scheme
    if host:
        others = [(name, value) for name, value in scope["headers"] if name != b"host"]
        scope["headers"] = [*others, (b"host", host.encode("latin-1"))]
    return scope


def _is_of(address: str, networks: Sequence[Network]) -> bool:
    try:
        ip = ipaddress.ip_address(address)
    except ValueError:
        return False
    return any(ip in network for network in networks)
