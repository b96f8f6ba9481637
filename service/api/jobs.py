"""Jobs: how far long work is, live or on request, and ending it."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path, Query, Request
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool

from schemas.examples import JOB
from schemas.jobs import Job, JobPage
from service.actions.analysing.describe_job import job_answer
from service.api.dependencies import (
    AuthorDep,
    DatabaseDep,
    PageDep,
    ProjectQuery,
    decode_cursor,
    encode_cursor,
)
from service.storage.database import Database
from service.storage.jobs import ENDED

router = APIRouter(tags=["jobs"])

JobId = Annotated[str, Path(description="Id of the job", examples=[JOB])]

NEWS_SECONDS = 0.3
"""How often a stream of events looks for news."""

SILENCE_SECONDS = 15.0
"""After so long without news a stream says that it is still there, or proxies would close it."""

_EVENTS: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "Events `progress`, each with the job as JSON, and at last `end`",
        "content": {"text/event-stream": {"schema": {"type": "string"}}},
    }
}


@router.get("/jobs", operation_id="list_jobs", response_model_exclude_none=True)
def list_jobs(
    database: DatabaseDep,
    page: PageDep,
    project: ProjectQuery = None,
    state: Annotated[Literal["waiting", "running", "done", "failed", "cancelled"] | None, Query()] = None,
) -> JobPage:
    """Jobs, the newest first."""
    before = None if page.cursor is None else int(decode_cursor(page.cursor, int)[0])
    with database.read() as tx:
        found = tx.jobs.page(project_name=project, state=state, before=before, limit=page.limit + 1)
    shown = found[: page.limit]
    more = encode_cursor(shown[-1].key) if len(found) > page.limit else None
    return JobPage(items=[job_answer(job) for job in shown], next_cursor=more)


@router.get("/jobs/{id}", operation_id="get_job", response_model_exclude_none=True)
def get_job(id: JobId, database: DatabaseDep) -> Job:
    """How far a job is, and what came of it."""
    with database.read() as tx:
        return job_answer(tx.jobs.get(id))


@router.delete("/jobs/{id}", status_code=202, operation_id="cancel_job", response_model_exclude_none=True)
def cancel_job(id: JobId, http: Request, database: DatabaseDep, author: AuthorDep) -> Job:
    """End a job. One that waits ends at once; one that runs soon, its worker is killed if it takes too long."""
    with database.write(author) as tx:
        job = tx.jobs.cancel(id)
    http.app.state.runner.wake()
    return job_answer(job)


@router.get("/jobs/{id}/events", operation_id="follow_job", response_class=StreamingResponse, responses=_EVENTS)
async def follow_job(id: JobId, http: Request, database: DatabaseDep) -> StreamingResponse:
    """The progress of a job as server-sent events, until it has ended."""
    first = await run_in_threadpool(_read, database, id)

    async def events() -> AsyncIterator[str]:
        job, silent = first, 0.0
        yield _event(job)
        while job.state not in ENDED:
            await asyncio.sleep(NEWS_SECONDS)
            if await http.is_disconnected():
                return
            known, job = job, await run_in_threadpool(_read, database, id)
            silent = 0.0 if job != known else silent + NEWS_SECONDS
            if job != known:
                yield _event(job)
            elif silent >= SILENCE_SECONDS:
                silent = 0.0
                yield ": still there\n\n"

    return StreamingResponse(events(), media_type="text/event-stream", headers={"cache-control": "no-store"})


def _read(database: Database, uuid: str) -> Job:
    with database.read() as tx:
        return job_answer(tx.jobs.get(uuid))


def _event(job: Job) -> str:
    kind = "end" if job.state in ENDED else "progress"
    return f"event: {kind}\ndata: {job.model_dump_json(exclude_none=True)}\n\n"
