"""Runs waiting jobs: one runner in each server process.

A job belongs to a runner as long as its lease is renewed. A killed server renews nothing: after `LEASE_SECONDS` another
server, or the same after a restart, starts its jobs again from the beginning.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import Counter
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from typing import Any

from mcml.errors import ConflictError, McmlError, UnavailableError
from mcml_schemas.problem import Problem
from mcml_service.actions.analysing.save_results import save_results
from mcml_service.analysis.interface import Progress
from mcml_service.jobs.engines import make_workers
from mcml_service.jobs.telling import CancelledError, Teller
from mcml_service.jobs.worker import Outcome, Refused, Task, perform, work_on
from mcml_service.jobs.workers import InterruptionError
from mcml_service.settings import Settings
from mcml_service.storage.core.identifiers import new_uuid
from mcml_service.storage.database import Database
from mcml_service.storage.projects.activity import SERVER
from mcml_service.storage.work.jobs import LEASE_SECONDS, MOST_ATTEMPTS, StoredJob

log = logging.getLogger("mcml.jobs")

LOOK_SECONDS = 1.0
"""Interval of checks for jobs without a notification."""

STOP_SECONDS = 0.3
"""How often the owner of a job looks whether the server stops."""

STARTING = "starting a worker"
"""The stage of a job until its worker reports another one."""

KILL_SECONDS = 10.0
"""Time that a cancelled job has to stop before its worker is killed."""


class Runner:
    """Started and stopped with the server."""

    def __init__(self, database: Database, settings: Settings) -> None:
        self._database = database.for_call(database.view, SERVER)
        self._settings = settings
        self._workers = make_workers(database, settings)
        self._name = new_uuid()
        self._deaths: Counter[str] = Counter()
        self._wake = threading.Event()
        self._stopping = threading.Event()
        self._free = threading.Semaphore(settings.jobs_at_a_time)
        self._drivers = ThreadPoolExecutor(settings.jobs_at_a_time, "mcml-job")
        self._thread = threading.Thread(target=self._look, name="mcml-jobs", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def wake(self) -> None:
        """A job was added: look at once."""
        self._wake.set()

    def stop(self) -> None:
        """Stop in order: unfinished jobs wait for the next server."""
        self._stopping.set()
        self._wake.set()
        self._thread.join(timeout=10)
        self._drivers.shutdown(wait=True)
        with suppress(McmlError), self._database.write("jobs") as tx:
            tx.jobs.release(self._name)
        self._workers.shutdown()

    def _look(self) -> None:
        while not self._stopping.is_set():
            try:
                self._take()
            except McmlError as error:
                log.warning("cannot look for jobs: %s", error)
            # Once it was spent, or where there was no room when the server started.
            self._database.reserve.keep()
            self._wake.wait(LOOK_SECONDS)
            self._wake.clear()

    def _take(self) -> None:
        while not self._stopping.is_set() and self._free.acquire(blocking=False):
            job = None
            try:
                job = self._claim()
            finally:
                # A store that is away for a while must not use the places up.
                if job is None:
                    self._free.release()
            if job is None:
                return
            self._drivers.submit(self._drive, job)

    def _claim(self) -> StoredJob | None:
        with self._database.read() as tx:
            waits = tx.jobs.any_claimable(self._settings.jobs_of_project)
        if not waits:
            return None
        with self._database.write("jobs") as tx:
            return next(iter(tx.jobs.claim(self._name, 1, self._settings.jobs_of_project)), None)

    def _drive(self, job: StoredJob) -> None:
        try:
            if job.cancel:
                self._end(job, "cancelled")
            else:
                self._run(job)
        except (ConflictError, UnavailableError) as error:
            # An unreachable store does not fail a job: it starts again after its lease has ended.
            log.warning("job %s: %s", job.uuid, error)
        except InterruptionError as error:
            self._begin_again(job, error)
        except McmlError as error:
            log.warning("job %s failed: %s", job.uuid, error)
            self._fail(job, error.what, error.remedy)
        except Exception as error:
            log.exception("job %s failed", job.uuid)
            self._fail(job, f"The analysis failed unexpectedly: {type(error).__name__}.", "The server's log has more.")
        finally:
            self._free.release()
            self._wake.set()

    def _run(self, job: StoredJob) -> None:
        """Have the job done; once more if it kills its worker, then no more."""
        for is_last in (False, True):
            self._begin(job)
            future = self._submit(job)
            try:
                if not self._watch(job, future):
                    if not self._stopping.is_set():
                        self._end(job, "cancelled")
                    return
                keep_outcome(self._database, self._settings, job, self._name, self._outcome(future))
            except BrokenExecutor as error:
                self._judge_death(job, error, is_last=is_last)
            else:
                return
            finally:
                # Also a job that is another runner's by now, or whose store is away.
                if not future.done():
                    self._workers.kill(future)

    def _submit(self, job: StoredJob) -> Future[Outcome]:
        """InterruptionError where no worker can be started, or no scheduler answers."""
        replica = self._database.replica
        urls = self._database.url, None if replica is None else replica.url
        task = Task(urls, job.uuid, self._name, job.analysis, job.inputs, job.parameters)
        try:
            return self._workers.submit(work_on, task, self._workers.crew)
        except (OSError, RuntimeError) as error:
            raise InterruptionError(
                f"No worker could be started: {str(error) or type(error).__name__}.",
                remedy="Look at the server's log and its free memory, then start the job again.",
            ) from error

    def _watch(self, job: StoredJob, future: Future[Outcome]) -> bool:
        """Renew the lease until the work has ended; return False if it was lost."""
        renewed, cancelled_at = time.monotonic(), None
        while not wait([future], STOP_SECONDS).done:
            if self._stopping.is_set():
                return False
            if time.monotonic() - renewed >= LEASE_SECONDS / 4:
                renewed = time.monotonic()
                with suppress(UnavailableError):
                    if not self._renew(job) and cancelled_at is None:
                        cancelled_at = time.monotonic()
            if cancelled_at is not None and time.monotonic() - cancelled_at > KILL_SECONDS:
                return False
        return True

    def _outcome(self, future: Future[Outcome]) -> Outcome | None:
        """Return the output of the worker; None if the job was cancelled. Raises BrokenExecutor if it died."""
        try:
            return future.result()
        except CancelledError:
            return None
        except MemoryError as error:
            most = self._settings.job_memory_mib
            raise McmlError(f"The job needs more than {most} MiB of memory.", remedy=self._remedy) from error

    def _judge_death(self, job: StoredJob, error: BrokenExecutor, *, is_last: bool) -> None:
        """Raise what a job ends with whose worker died. Return if it may be tried once more."""
        with self._database.read() as tx:
            has_begun = tx.jobs.get(job.uuid).stage != STARTING
        if has_begun and not is_last:
            log.warning("job %s: its worker died, and it is tried once more", job.uuid)
            return
        reason = "The worker died twice on this job; it may have taken too much memory."
        raise (McmlError if has_begun else InterruptionError)(reason, remedy=self._remedy) from error

    @property
    def _remedy(self) -> str:
        return f"Choose fewer clips, or raise MCML_JOB_MEMORY_MIB ({self._settings.job_memory_mib})."

    def _begin_again(self, job: StoredJob, error: McmlError) -> None:
        """Let a job wait again, a few times.

        Crashes of servers do not count: jobs do not cause them either, and nothing is left to count them.
        """
        self._deaths[job.uuid] += 1
        log.warning("job %s: %s", job.uuid, error)
        if self._deaths[job.uuid] < MOST_ATTEMPTS:
            with suppress(McmlError), self._database.write("jobs") as tx:
                tx.jobs.give_back(job.uuid, self._name)
            return
        del self._deaths[job.uuid]
        self._fail(job, f"The job was begun {MOST_ATTEMPTS} times in vain. {error.what}", error.remedy)

    def _begin(self, job: StoredJob) -> None:
        with self._database.write("jobs") as tx:
            tx.jobs.tell(job.uuid, self._name, STARTING, 0.0)

    def _renew(self, job: StoredJob) -> bool:
        """Keep the job for this runner. Return whether it is still wanted."""
        with self._database.write("jobs") as tx:
            tx.jobs.renew(job.uuid, self._name)
            return tx.jobs.is_wanted(job.uuid, self._name)

    def _end(self, job: StoredJob, state: str, problem: dict[str, Any] | None = None) -> None:
        with self._database.write("jobs") as tx:
            tx.jobs.end(job.uuid, self._name, state, problem=problem)

    def _fail(self, job: StoredJob, what: str, remedy: str | None = None) -> None:
        with suppress(McmlError):
            self._end(job, "failed", _problem(what, remedy))


def keep_outcome(database: Database, settings: Settings, job: StoredJob, runner: str, outcome: Outcome | None) -> None:
    """End a job with its outcome: parts, a problem, or None if it was cancelled."""
    if outcome is not None and not isinstance(outcome, Refused):
        save_results(database, settings, job, runner, outcome)
        return
    with database.write("jobs") as tx:
        if outcome is None:
            tx.jobs.end(job.uuid, runner, "cancelled")
        else:
            tx.jobs.end(job.uuid, runner, "failed", problem=outcome.problem)


def run_here(database: Database, settings: Settings, job: StoredJob, runner: str, progress: Progress) -> None:
    """Do a job in this process, as commands on a local store do. progress: shown to the user."""
    with Teller(database, job.uuid, runner, renews=True) as tell:

        def watch(stage: str, share: float) -> None:
            tell(stage, share)
            progress(stage, share)

        try:
            outcome = perform(database, job.analysis, job.inputs, job.parameters, watch)
            keep_outcome(database, settings, job, runner, outcome)
        except (KeyboardInterrupt, CancelledError):
            keep_outcome(database, settings, job, runner, None)
        except Exception:
            with suppress(McmlError):
                keep_outcome(database, settings, job, runner, Refused(_problem("The analysis failed unexpectedly.")))
            raise


def _problem(what: str, remedy: str | None = None) -> dict[str, Any]:
    problem = Problem(type="about:blank", title="Job failed", status=500, detail=what, remedy=remedy)
    return problem.model_dump(exclude_none=True)
