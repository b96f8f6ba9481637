"""The progress of jobs, live. By hand: a stream of events waits between them, so it is async, as no operation is."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from typing import Annotated, Any

from fastapi import APIRouter, Path, Request
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool

from schemas.examples import JOB
from schemas.jobs import Job
from service.actions.analysing.describe_job import job_answer
from service.storage.database import Database
from service.storage.jobs import ENDED

router = APIRouter(tags=["jobs"])

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


@router.get("/jobs/{id}/events", operation_id="follow_job", response_class=StreamingResponse, responses=_EVENTS)
async def follow_job(
    id: Annotated[str, Path(description="Id of the job", examples=[JOB])], http: Request
) -> StreamingResponse:
    """The progress of a job as server-sent events, until it has ended."""
    database: Database = http.app.state.repository.database
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
