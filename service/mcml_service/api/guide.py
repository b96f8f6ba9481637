"""The documentation as pages below `/docs/guide`, built with the studio (`service/web/build.py`)."""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path

from fastapi import Request
from fastapi.responses import RedirectResponse
from starlette.responses import Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

from mcml.errors import NotFoundError
from mcml_service.api.policy import page_policy
from mcml_service.resources import studio_path

GUIDE_PATH = "/docs/guide"
GUIDE = studio_path() / "static" / "guide"

_INLINE = re.compile(r"<script>(.*?)</script>", re.DOTALL)
_SOURCES = "img-src 'self' data:; connect-src 'self'; worker-src 'self'; font-src 'self'"


class Guide(StaticFiles):
    """The files of the guide. Pages may run the scripts that they were built with, and no other."""

    def __init__(self) -> None:
        super().__init__(directory=GUIDE, check_dir=False)

    async def get_response(self, path: str, scope: Scope) -> Response:
        if not (GUIDE / "index.html").is_file():
            raise NotFoundError("The guide is not built here.", remedy="`make docs` builds it; its texts are in docs/.")
        response = await super().get_response(path, scope)
        file, found = self.lookup_path(path)
        if found is not None and file.endswith(".html"):
            scripts = _inline_scripts(file, found.st_mtime_ns)
            response.headers.update(page_policy(["'self'"], ["'self'", *scripts], _SOURCES))
        response.headers["cache-control"] = "no-cache"
        return response


@lru_cache(maxsize=256)
def _inline_scripts(file: str, _changed: int) -> tuple[str, ...]:
    return tuple(_INLINE.findall(Path(file).read_text(encoding="utf-8")))


async def _first_page(request: Request) -> RedirectResponse:
    """The first page, at the address that its links are relative to."""
    return RedirectResponse(f"{request.scope.get('root_path', '')}{GUIDE_PATH}/index.html", 307)


ROUTES = [*(Route(path, _first_page) for path in (GUIDE_PATH, f"{GUIDE_PATH}/")), Mount(GUIDE_PATH, Guide())]
