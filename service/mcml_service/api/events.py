"""Live events: the progress of a job, and all changes in the store.

Written by hand: a stream waits between events, so it is async, unlike operations.
"""

from __future__ import annotations

import asyncio
import re
import time
from collections.abc import AsyncIterator
from typing import Annotated, Any, Literal, get_args

from fastapi import APIRouter, Header, Path, Query, Request
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool

from mcml.errors import AccessError, QueryError
from mcml_schemas.examples import DOCUMENT, JOB, PROJECT
from mcml_schemas.jobs import Job
from mcml_service.actions.analysing.describe_job import job_answer
from mcml_service.actions.reading.read_news import LABELLING, News
from mcml_service.api.authentication import Authentication
from mcml_service.api.routes import call_of
from mcml_service.storage.core.identifiers import now
from mcml_service.storage.database import Database
from mcml_service.storage.work.jobs import ENDED

router = APIRouter(tags=["jobs"])

NEWS_SECONDS = 0.3
"""How often a stream of events looks for news."""

SILENCE_SECONDS = 15.0
"""Time without events after which a stream sends a comment, because proxies would close it."""

STREAM_SECONDS = 300.0
"""Length of a stream; its client then reconnects with the last event id."""

RIGHTS_SECONDS = 3.0
"""Interval of checking that the rights of a stream's client have not changed."""

_EVENTS: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "Events `progress`, each with the job as JSON, and at last `end`",
        "content": {"text/event-stream": {"schema": {"type": "string"}}},
    }
}


@router.get("/jobs/{id}/events", operation_id="follow_job", response_class=StreamingResponse, responses=_EVENTS)
async def follow_job(
    id: Annotated[str, Path(description="Id of the job", examples=[JOB])], http: Request
) -> StreamingResponse:
    """The progress of a job as server-sent events, until it has ended."""
    database, stay = _follow(http), Stay(http)
    first = await run_in_threadpool(_read, database, id)

    async def events() -> AsyncIterator[str]:
        job, silent = first, 0.0
        yield _event(job)
        while job.state not in ENDED:
            if not await stay.goes_on():
                return
            known, job = job, await run_in_threadpool(_read, database, id)
            silent = 0.0 if job != known else silent + NEWS_SECONDS
            if job != known:
                yield _event(job)
            elif silent >= SILENCE_SECONDS:
                silent = 0.0
                yield ": still there\n\n"

    return StreamingResponse(events(), media_type="text/event-stream", headers={"cache-control": "no-store"})


EventKind = Literal["job", "document", "label", "comment", "proposal"]
_MARK = re.compile(r"(\d{1,18})@([0-9T:.Z-]{1,32})(?:@(\d{1,18}))?")
_NEWS: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "Events as JSON: `document`, `label` (revisions), `job` (a job), `comment`, `proposal` (what "
        "was done)",
        "content": {"text/event-stream": {"schema": {"type": "string"}}},
    }
}


@router.get("/events", operation_id="follow_events", response_class=StreamingResponse, responses=_NEWS)
async def follow_events(
    http: Request,
    kind: Annotated[
        list[EventKind] | None, Query(description="Only these kinds; may be repeated", examples=[["job"]])
    ] = None,
    project: Annotated[str | None, Query(description="Only of this project", examples=[PROJECT])] = None,
    document: Annotated[str | None, Query(description="Only of this document", examples=[DOCUMENT])] = None,
    since: Annotated[
        str | None,
        Query(description="Id of the last event that is known", examples=["412@2026-01-31T14:02:11.120Z@4711"]),
    ] = None,
    seconds: Annotated[
        float | None,
        Query(ge=0, le=86_400, description="End after so long; at most five minutes", examples=[60]),
    ] = None,
    last_event_id: Annotated[
        str | None,
        Header(
            description="As `since`; browsers send it by themselves", examples=["412@2026-01-31T14:02:11.120Z@4711"]
        ),
    ] = None,
) -> StreamingResponse:
    """Stream events of the store as server-sent events, from now on or since an event.

    `document` and `label` have a new revision, `job` the progress of a job, `comment` and `proposal` a change of one.
    `ready` comes first. `reset` means that too many events were missed and lists must be read again. A stream ends
    after five minutes, and soon after the rights of its client change: reconnect with the id of the last event, as
    browsers do automatically.
    """
    database, stay = _follow(http), Stay(http)
    mark = last_event_id or since
    news = await run_in_threadpool(_begin, database, mark)
    wanted = frozenset(kind or get_args(EventKind))

    async def events() -> AsyncIterator[str]:
        until = None if seconds is None else time.monotonic() + seconds
        silent = 0.0
        yield _write_event("ready", "{}", news)
        while True:
            found = await run_in_threadpool(_look, database, news, wanted, project, document)
            for text in found:
                yield text
            silent = 0.0 if found else silent + NEWS_SECONDS
            if until is not None and time.monotonic() >= until:
                return
            if silent >= SILENCE_SECONDS:
                silent = 0.0
                yield ": still there\n\n"
            if not await stay.goes_on():
                return

    return StreamingResponse(events(), media_type="text/event-stream", headers={"cache-control": "no-store"})


def _follow(http: Request) -> Database:
    """Return the store as the user may see it. Raises AccessError for visitors with a share link."""
    call = call_of(http)
    if call.share is not None:
        raise AccessError("A link to documents follows no events.", remedy="Reload the state that it shows.")
    return call.database


class Stay:
    """The lifetime of a stream: as long as its client is connected, for a limited time, and with the same rights as
    at its start.
    """

    def __init__(self, http: Request) -> None:
        self._http = http
        self._entry = http.scope.get("mcml.entry")
        began = time.monotonic()
        self._until, self._next = began + STREAM_SECONDS, began + RIGHTS_SECONDS

    async def goes_on(self) -> bool:
        """Waits until it is time to look for news."""
        await asyncio.sleep(NEWS_SECONDS)
        at = time.monotonic()
        if self._http.app.state.stopping.is_set() or await self._http.is_disconnected() or at >= self._until:
            return False
        if at < self._next:
            return True
        self._next = at + RIGHTS_SECONDS
        return await self._is_let_in()

    async def _is_let_in(self) -> bool:
        """Whether the same request would be let in now, as the same person with the same rights."""
        authentication: Authentication = self._http.app.state.authentication
        scope = {name: value for name, value in self._http.scope.items() if name != "mcml.entry"}
        headers = self._http.headers
        if (
            not authentication.stand_open(scope, headers)
            and await run_in_threadpool(authentication.refusal, scope, headers) is not None
        ):
            return False
        return scope.get("mcml.entry") == self._entry


def _begin(database: Database, mark: str | None) -> News:
    """Return the position of an event id; without one, the current position."""
    with database.read() as tx:
        if mark is None:
            news = News(tx.newest_commit(), now(), tx.activity.newest())
            news.find_changed_jobs(tx)
            return news
        match = _MARK.fullmatch(mark)
        if match is None:
            raise QueryError("Unknown event id.", remedy="Begin without one.")
        newest = tx.activity.newest()
        return News(min(int(match[1]), tx.newest_commit()), match[2], min(int(match[3] or newest), newest))


def _look(
    database: Database, news: News, wanted: frozenset[str], project: str | None, document: str | None
) -> list[str]:
    texts = []
    with database.read() as tx:
        for event in news.revisions(tx):
            kind = "label" if event.operation in LABELLING else "document"
            here = project in (None, event.project) and document in (None, event.document)
            if kind in wanted and here:
                texts.append(_write_event(kind, event.model_dump_json(), news))
        for told in news.discussions(tx):
            if told.kind in wanted and project in (None, told.project) and document in (None, told.document):
                texts.append(_write_event(told.kind, told.model_dump_json(), news))
        if news.missed:
            texts.append(_write_event("reset", "{}", news))
        if "job" in wanted and document is None:
            for job in news.find_changed_jobs(tx):
                if project in (None, job.project):
                    texts.append(_write_event("job", job_answer(job).model_dump_json(exclude_none=True), news))
    return texts


def _write_event(kind: str, data: str, news: News) -> str:
    return f"id: {news.commit}@{news.time}@{news.event}\nevent: {kind}\ndata: {data}\n\n"


def _read(database: Database, uuid: str) -> Job:
    with database.read() as tx:
        return job_answer(tx.jobs.get(uuid))


def _event(job: Job) -> str:
    kind = "end" if job.state in ENDED else "progress"
    return f"event: {kind}\ndata: {job.model_dump_json(exclude_none=True)}\n\n"
