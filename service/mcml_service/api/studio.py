"""The studio's files, and the pages at its addresses. If it is not built, `/` reports it."""

from __future__ import annotations

import json
import mimetypes
from contextlib import suppress
from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, Header, Request
from fastapi.responses import Response

from mcml.errors import NotFoundError
from mcml_service.api.page import page
from mcml_service.api.policy import page_policy
from mcml_service.resources import studio_path

router = APIRouter(include_in_schema=False)

STATIC = studio_path() / "static"
"""The served files: index.html and the files that it loads."""
PAGES = studio_path() / "pages.json"
"""The pages of the studio: a row each, for the server and for src/pages.ts."""

OTHERS = ("/api/", "/assets/", "/docs/")
"""Below these nothing is a page of the studio."""
POLICY = {
    **page_policy(
        ["'self'"],
        ["'self'"],
        "img-src 'self' data: blob:; media-src 'self' blob:; connect-src 'self'; worker-src 'self'",
    ),
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-embedder-policy": "require-corp",
}
FOR_GOOD = "public, max-age=31536000, immutable"
"""Names of built files hold a sum of their content."""
ENCODINGS = (("br", ".br"), ("gzip", ".gz"))

NOT_BUILT = """<h1>MCML Repository</h1>
<p>The server runs. The studio, its face in the browser, is not built here: <code>make run</code> builds it,
<code>python service/web/build.py</code> too.</p>
<p><a href="/docs/guide">Documentation</a> · <a href="/docs">API reference</a> ·
<a href="/mcml.dtd">mcml.dtd</a> · <a href="/api/v1/documents">documents</a></p>
<pre>curl -F file=@walk.bvh -F label=walk {base}/api/v1/documents
mcml import walk.bvh --label walk --server {base}</pre>"""


def studio_page(request: Request, accept_encoding: Annotated[str, Header()] = "") -> Response:
    """Any address of the studio: its own routes find the page."""
    if not (STATIC / "index.html").is_file():
        return page("MCML Repository", NOT_BUILT.format(base=str(request.base_url).rstrip("/")))
    return _file("index.html", accept_encoding, {**POLICY, "cache-control": "no-cache"})


def unknown_page(request: Request) -> Response | None:
    """Return the studio's page for an unknown address; None if the request is not for a page, and for paths of the
    API and of files.
    """
    wants_page = request.method in ("GET", "HEAD") and "text/html" in request.headers.get("accept", "")
    if not wants_page or request.url.path.startswith(OTHERS):
        return None
    shown = studio_page(request, request.headers.get("accept-encoding", ""))
    shown.status_code = 404
    return shown


def page_addresses(pages: Path) -> list[str]:
    """Patterns of the routes of the pages in pages.json; "/" is the first page."""
    addresses = ["/"]
    for row in json.loads(pages.read_text(encoding="utf-8")):
        if row["about"] != "one":
            addresses.append(row["path"])
        if row["about"] != "nothing":
            addresses.append(f"{row['path']}/{{id}}")
    return addresses


for address in page_addresses(PAGES):
    router.get(address)(studio_page)


@router.get("/shared")
def show_shared_page(accept_encoding: Annotated[str, Header()] = "") -> Response:
    """Show the page of a share link; the part of the link after # stays in the browser."""
    return _file(
        "shared.html", accept_encoding, {**POLICY, "cache-control": "no-cache", "referrer-policy": "no-referrer"}
    )


@router.get("/assets/{name}")
def send_built_file(name: str, accept_encoding: Annotated[str, Header()] = "") -> Response:
    """A script, style or worker of the studio."""
    # A page with an embedder policy starts only workers with the same policy.
    headers = {"cache-control": FOR_GOOD, "cross-origin-embedder-policy": "require-corp"}
    return _file(f"assets/{name}", accept_encoding, headers)


@router.get("/favicon.svg")
def icon() -> Response:
    return _file("favicon.svg", "", {"cache-control": "max-age=86400"})


def _file(name: str, accepted: str, headers: dict[str, str]) -> Response:
    """Return a built file, compressed if the client accepts it.

    Raises NotFoundError for any other name. It is read before its length is sent: `make web` may replace it at any
    time.
    """
    if ".." in name or "\\" in name:
        raise NotFoundError(f"There is no file {name!r}.")
    kind = mimetypes.guess_type(name)[0] or "application/octet-stream"
    for encoding, ending in (*ENCODINGS, ("", "")):
        if encoding in accepted:
            with suppress(FileNotFoundError, IsADirectoryError):
                content = (STATIC / (name + ending)).read_bytes()
                packed = {"content-encoding": encoding} if encoding else {}
                return Response(content, media_type=kind, headers={**headers, **packed, "vary": "accept-encoding"})
    raise NotFoundError(f"There is no file {name!r}.")
