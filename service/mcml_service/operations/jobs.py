"""Jobs: how far long work is, and ending it."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from mcml_schemas.examples import JOB
from mcml_schemas.jobs import Job, JobPage
from mcml_service.actions.analysing.describe_job import job_answer
from mcml_service.operations.arguments import InProject, Page
from mcml_service.operations.call import Call

JobId = Annotated[str, Field(description="Id of the job", examples=[JOB])]


def list_jobs(
    call: Call,
    page: Page,
    project: InProject = None,
    state: Annotated[
        Literal["waiting", "running", "done", "failed", "cancelled"] | None, Field(description="Only in this state")
    ] = None,
) -> JobPage:
    before = page.after(int)
    with call.database.read() as tx:
        jobs = tx.jobs.page(
            project_name=project, state=state, before=None if before is None else before[0], limit=page.most(call) + 1
        )
    shown, more = page.cut(call, jobs, lambda job: (job.key,))
    return JobPage(items=[job_answer(job) for job in shown], next_cursor=more)


def get_job(call: Call, id: JobId) -> Job:
    with call.database.read() as tx:
        return job_answer(tx.jobs.get(id))


def cancel_job(call: Call, id: JobId) -> Job:
    """One that waits ends at once; one that runs soon, its worker is killed if it takes too long."""
    with call.database.write(call.author) as tx:
        job = tx.jobs.cancel(id)
    call.repository.wake()
    return job_answer(job)
