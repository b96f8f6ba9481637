"""Jobs: long work as rows, so that a server that was killed finds what it had begun."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Row, Select, and_, func, or_, select, update

from mcml.errors import ConflictError, NotFoundError
from mcml_service.storage.core.identifiers import new_uuid, normalise_name, now
from mcml_service.storage.core.tables import project
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.views import is_seen
from mcml_service.storage.projects.activity import Activity
from mcml_service.storage.projects.quotas import Quotas
from mcml_service.storage.work.tables import job, result

LEASE_SECONDS = 12.0
"""How long a runner may be silent before another one takes its jobs."""

MOST_ATTEMPTS = 3
"""So often a job is begun whose worker dies before the job has begun. Deaths of servers do not count."""

ENDED = ("done", "failed", "cancelled")

_LISTED = (
    select(job, project.c.name.label("project_name"), result.c.uuid.label("result_uuid"))
    .join(project, project.c.id == job.c.project)
    .outerjoin(result, result.c.id == job.c.result)
)


@dataclass(frozen=True)
class StoredJob:
    """A job. inputs: [{"document", "revision"}]. share: of the work that is done, 0 to 1. problem: why it failed."""

    key: int
    uuid: str
    project: str
    project_key: int
    analysis: str
    name: str
    owner: str
    state: str
    inputs: list[dict[str, Any]]
    parameters: dict[str, Any]
    stage: str
    share: float
    attempt: int
    cancel: bool
    created: str
    started: str | None
    ended: str | None
    problem: dict[str, Any] | None
    result: str | None


class Jobs:
    def __init__(self, tx: BaseTransaction, activity: Activity, quotas: Quotas) -> None:
        self._tx = tx
        self._activity = activity
        self._quotas = quotas

    def add(
        self,
        project_key: int,
        analysis: str,
        name: str,
        owner: str,
        inputs: list[dict[str, Any]],
        parameters: dict[str, Any],
        runner: str | None = None,
    ) -> str:
        """Add a job; return its uuid. runner: starts the job at once; else it waits for one. Raises AccessError."""
        self._quotas.require(project_key)
        uuid = new_uuid()
        self._tx.insert_row(
            job,
            uuid=uuid,
            project=project_key,
            analysis=analysis,
            name=normalise_name(name),
            owner=owner,
            state="running" if runner else "waiting",
            inputs=json.dumps(inputs),
            parameters=json.dumps(parameters),
            stage="waiting",
            share=0.0,
            attempt=1 if runner else 0,
            runner=runner,
            lease=time.time() + LEASE_SECONDS if runner else None,
            cancel=False,
            created=now(),
            started=now() if runner else None,
        )
        self._activity.note("job", "add", project_key=project_key, subject=normalise_name(name))
        return uuid

    def get(self, uuid: str) -> StoredJob:
        """NotFoundError."""
        row = self._tx.fetch_one(self._select_seen().where(job.c.uuid == uuid))
        if row is None:
            raise NotFoundError(f"There is no job {uuid}.", remedy="List the jobs to see their ids.")
        return _to_job(row)

    def page(self, *, project_name: str | None, state: str | None, before: int | None, limit: int) -> list[StoredJob]:
        """The newest first. before: the key of the last job of the page before."""
        query = self._select_seen().order_by(job.c.id.desc()).limit(limit)
        if project_name is not None:
            query = query.where(project.c.name == normalise_name(project_name))
        if state is not None:
            query = query.where(job.c.state == state)
        if before is not None:
            query = query.where(job.c.id < before)
        return [_to_job(row) for row in self._tx.fetch_all(query)]

    def active_or_ended_since(self, time: str) -> list[StoredJob]:
        """Return waiting and running jobs, and those that ended at a time or later; the oldest first."""
        going = job.c.state.not_in(ENDED)
        query = self._select_seen().where(going | (job.c.ended >= time)).order_by(job.c.id)
        return [_to_job(row) for row in self._tx.fetch_all(query)]

    def _select_seen(self) -> Select[Any]:
        return _LISTED.where(is_seen(self._tx.view, job.c.project))

    def any_claimable(self, of_project: int = 0) -> bool:
        """Whether `claim` would find a job; a cheap read."""
        return self._tx.fetch_one(_claimable(of_project).limit(1)) is not None

    def claim(self, runner: str, most: int, of_project: int = 0) -> list[StoredJob]:
        """Claim up to `most` jobs that wait, or whose lease has expired; the oldest first.

        of_project: limit of running jobs in one project, 0 for none; with a limit, claim one at a time.
        """
        if of_project:
            # The second of two runners sees the job that the first has taken.
            self._tx.order()
        query = _claimable(of_project).order_by(job.c.id).limit(most).with_for_update(skip_locked=True)
        keys = self._tx.fetch_column(query)
        taken: list[StoredJob] = []
        for key in keys:
            self._tx.run(
                update(job)
                .where(job.c.id == key)
                .values(
                    state="running",
                    runner=runner,
                    lease=time.time() + LEASE_SECONDS,
                    attempt=job.c.attempt + 1,
                    started=func.coalesce(job.c.started, now()),
                )
            )
            taken += map(_to_job, self._tx.fetch_all(_LISTED.where(job.c.id == key)))
        return taken

    def renew(self, uuid: str, runner: str) -> None:
        """Renew the lease. ConflictError where another runner has the job by now."""
        self._change(uuid, runner, lease=time.time() + LEASE_SECONDS)

    def tell(self, uuid: str, runner: str, stage: str, share: float) -> None:
        """Record the progress of a job. Raises ConflictError if another runner has taken it."""
        self._change(uuid, runner, stage=stage, share=share)

    def is_wanted(self, uuid: str, runner: str) -> bool:
        """Tell whether the job should continue: it belongs to this runner, and nobody has cancelled it."""
        mine = select(job.c.cancel).where(job.c.uuid == uuid, job.c.state == "running", job.c.runner == runner)
        return self._tx.fetch_one(mine.where(~job.c.cancel)) is not None

    def _change(self, uuid: str, runner: str, **values: Any) -> None:
        mine = update(job).where(job.c.uuid == uuid, job.c.state == "running", job.c.runner == runner)
        if not self._tx.run(mine.values(**values)):
            raise ConflictError(f"Job {uuid} is no longer this runner's.", remedy="Wait for the other one.")

    def end(
        self,
        uuid: str,
        runner: str,
        state: str,
        *,
        result_key: int | None = None,
        problem: dict[str, Any] | None = None,
    ) -> None:
        """Close a job as done, failed or cancelled. ConflictError where another runner has it by now."""
        done: dict[str, Any] = {"share": 1.0, "stage": "done"} if state == "done" else {}
        self._change(
            uuid,
            runner,
            state=state,
            ended=now(),
            lease=None,
            result=result_key,
            problem=None if problem is None else json.dumps(problem),
            **done,
        )
        whose = select(job.c.project, job.c.name, job.c.owner).where(job.c.uuid == uuid)
        ((project_key, name, owner),) = self._tx.fetch_all(whose)
        self._activity.note("job", state, project_key=project_key, subject=name, author=owner)

    def cancel(self, uuid: str) -> StoredJob:
        """Cancel a job: a waiting one ends at once, a running one when its runner notices. Raises AccessError."""
        current = self.get(uuid)
        self._quotas.require(current.project_key)
        waiting = update(job).where(job.c.uuid == uuid, job.c.state == "waiting")
        if self._tx.run(waiting.values(state="cancelled", ended=now(), cancel=True)):
            self._activity.note("job", "cancelled", project_key=current.project_key, subject=current.name)
        self._tx.run(update(job).where(job.c.uuid == uuid, job.c.state == "running").values(cancel=True))
        return current if current.state in ENDED else self.get(uuid)

    def give_back(self, uuid: str, runner: str) -> None:
        """Let a job wait again that its runner could not have done."""
        mine = update(job).where(job.c.uuid == uuid, job.c.state == "running", job.c.runner == runner)
        self._tx.run(mine.values(state="waiting", runner=None, lease=None))

    def release(self, runner: str) -> None:
        """Give back what a runner that stops in order has not finished; the attempt does not count."""
        self._tx.run(
            update(job)
            .where(job.c.runner == runner, job.c.state == "running")
            .values(state="waiting", runner=None, lease=None, attempt=job.c.attempt - 1)
        )


def _claimable(of_project: int) -> Select[tuple[int]]:
    """Keys of jobs that wait where no more of their project run, or whose runner has been silent for too long."""
    silent = and_(job.c.state == "running", job.c.lease < time.time())
    waits = job.c.state == "waiting"
    if of_project:
        other = job.alias()
        running = select(func.count()).where(other.c.project == job.c.project, other.c.state == "running")
        waits &= running.scalar_subquery() < of_project
    return select(job.c.id).where(or_(waits, silent))


def _to_job(row: Row[Any]) -> StoredJob:
    return StoredJob(
        key=row.id,
        uuid=row.uuid,
        project=row.project_name,
        project_key=row.project,
        analysis=row.analysis,
        name=row.name,
        owner=row.owner,
        state=row.state,
        inputs=json.loads(row.inputs),
        parameters=json.loads(row.parameters),
        stage=row.stage,
        share=row.share,
        attempt=row.attempt,
        cancel=row.cancel,
        created=row.created,
        started=row.started,
        ended=row.ended,
        problem=None if row.problem is None else json.loads(row.problem),
        result=row.result_uuid,
    )
