"""The application: the only place where everything is put together."""

from __future__ import annotations

import asyncio
import logging
import os
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from functools import cache
from threading import Thread
from typing import Any

from fastapi import APIRouter, Depends, FastAPI
from fastapi.middleware.cors import CORSMiddleware
from fastapi.middleware.gzip import GZipMiddleware
from starlette.middleware.gzip import DEFAULT_EXCLUDED_CONTENT_TYPES
from starlette.routing import BaseRoute

from mcml.resources import program_version
from mcml_service.actions.exporting.write_tables import TYPES
from mcml_service.actions.importing.import_pool import ImportPool
from mcml_service.actions.keeping.keep_room import forget_activity
from mcml_service.actions.keeping.purge_documents import finish_purges
from mcml_service.api import description, events, guide, health, openid, page, problems, sessions, studio
from mcml_service.api.admission import Admission
from mcml_service.api.authentication import Authentication
from mcml_service.api.file_names import read_names_in_forms
from mcml_service.api.middleware import Guard
from mcml_service.api.parameters import require_known_parameters
from mcml_service.api.routes import PREFIX, add_routes
from mcml_service.api.traffic import Traffic
from mcml_service.clips.deriver import Deriver, Stage
from mcml_service.jobs.runner import Runner
from mcml_service.jobs.webhooks import Sender
from mcml_service.local_secret import keep_secret, read_secret
from mcml_service.operations import all_operations
from mcml_service.operations.call import Repository
from mcml_service.settings import Settings, data_folder, unknown_variables
from mcml_service.storage.database import Database

log = logging.getLogger("mcml")

EXPOSED = [
    *("ETag", "Link", "Location", "Retry-After", "Content-Disposition", "X-Total-Count", "X-Request-ID"),
    *("X-MCML-Columns", "X-MCML-Shape", "X-MCML-Origin", "X-MCML-Step"),
    *("X-MCML-First-Line", "X-MCML-Lines", "X-MCML-Total-Lines"),
]
"""Headers that pages of other origins may read."""

AS_THEY_ARE = (*DEFAULT_EXCLUDED_CONTENT_TYPES, TYPES["block"])
"""Media types that are not compressed. Numbers of a motion hardly compress, and playback waits for them."""

DESCRIPTION = """
Every motion-capture clip in one open XML language, stored element by element, searched with XPath.

Frame numbers are XPath positions: from 1, both ends included. Errors are problem details (RFC 9457). Writes to one
document need `If-Match` with the revision that was read.
"""


def create_app(
    settings: Settings,
    database: Database | None = None,
    secret: Callable[[], str | None] = lambda: None,
    *,
    ready: bool = False,
) -> FastAPI:
    """Create the service on a store with the current schema.

    database: of a program that uses the service in its own process; default from the settings. secret: returns the
    local secret; requests from this machine with it have the rights of an owner of the store. ready: start the
    processes that evaluate queries before the first query.
    """
    read_names_in_forms()
    store = database or Database(settings.database_url, settings.database_read_url)
    traffic = Traffic()
    repository = Repository(store, settings)
    repository.evaluated = "apart"

    def build(stage: Stage, go_on: Callable[[], bool]) -> None:
        # Imported here: a server starts without mathematics.
        from mcml_service.xpath.column_builder import build_columns

        build_columns(store, settings, stage, go_on)

    deriver = Deriver(store, traffic.is_busy, build)
    sender = Sender(store, private=settings.webhook_private)

    @asynccontextmanager
    async def lifespan(_app: FastAPI) -> AsyncIterator[dict[str, Any]]:
        store.require_schema()
        store.reserve.spend(store.sweep)
        store.reserve.keep()
        finish_purges(store, cache_dir=settings.cache_dir)
        store.reserve.spend(lambda: forget_activity(store, settings.activity_days))
        app.state.runner.start()
        if settings.derive:
            deriver.start()
        sender.start()
        if ready:
            # A server starts without mathematics, which takes a second.
            Thread(target=repository.begin, daemon=True).start()
        app.state.stopping = asyncio.Event()
        yield {"stopping": app.state.stopping}
        deriver.stop()
        sender.stop()
        app.state.runner.stop()
        app.state.repository.close()
        if database is None:
            store.close()

    app = FastAPI(
        title="MCML Repository",
        version=program_version(),
        description=DESCRIPTION,
        docs_url=None,
        redoc_url=None,
        # A name that ends with a slash is no other address; and no answer leads to a host that a request names.
        redirect_slashes=False,
        lifespan=lifespan,
        separate_input_output_schemas=False,
        routes=_routes(),
    )
    app.state.repository = repository
    app.state.runner = Runner(store, settings)
    repository.wake = app.state.runner.wake
    repository.import_pool = ImportPool()
    repository.register.patience = 0
    app.state.admission = Admission(settings)
    app.state.requests = {}
    # Streams of events, and requests that wait, look at it; connections set it.
    app.state.stopping = asyncio.Event()
    problems.install(app, studio.unknown_page)
    description.install(app)
    app.add_middleware(GZipMiddleware, minimum_size=2048, compresslevel=1, exclude_content_types=AS_THEY_ARE)
    app.state.authentication = authentication = Authentication(settings, store, secret)
    app.add_middleware(
        Guard, settings=settings, authentication=authentication, counts=app.state.requests, traffic=traffic
    )
    if settings.friends:
        # Outermost: a browser sends a preflight request first, without a token.
        app.add_middleware(
            CORSMiddleware,
            allow_origins=settings.friends,
            allow_methods=["*"],
            allow_headers=["*"],
            expose_headers=EXPOSED,
            max_age=600,
        )
    return app


@cache
def _routes() -> list[BaseRoute]:
    """Return all routes.

    They contain no state of an application, and FastAPI takes a fifth of a second to make them.
    """
    router = APIRouter(prefix=PREFIX, dependencies=[Depends(require_known_parameters)])
    add_routes(router, all_operations())
    for part in (events.router, sessions.router):
        router.include_router(part)
    pages = APIRouter()
    # Requests for pages and health checks may have unknown parameters.
    for part in (health.router, page.router, studio.router, sessions.pages, openid.router):
        pages.include_router(part)
    return [*router.routes, *pages.routes, *guide.ROUTES]


def app_from_environment() -> FastAPI:
    """The service of the environment; `uvicorn --factory mcml_service.app:app_from_environment` serves it."""
    for fault in unknown_variables(os.environ):
        log.warning("%s", fault)
    folder = data_folder()
    keep_secret(folder)
    return create_app(Settings(), secret=lambda: read_secret(folder), ready=True)
