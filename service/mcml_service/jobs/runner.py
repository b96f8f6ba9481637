"""Takes jobs that wait and has them done: one runner a server process.

A job belongs to a runner as long as its lease is renewed. A server that was killed renews nothing: after
`LEASE_SECONDS` another one, or the same started anew, takes its jobs up again from the beginning.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import Any

from mcml.errors import ConflictError, McmlError, UnavailableError
from mcml_schemas.problem import Problem
from mcml_service.actions.analysing.save_results import save_results
from mcml_service.analysis.interface import Progress
from mcml_service.jobs.cluster import Cluster
from mcml_service.jobs.worker import CancelledError, Outcome, Refused, on_dask, perform
from mcml_service.settings import Settings
from mcml_service.storage.core.identifiers import new_uuid
from mcml_service.storage.database import Database
from mcml_service.storage.projects.activity import SERVER
from mcml_service.storage.work.jobs import LEASE_SECONDS, MOST_ATTEMPTS, StoredJob

log = logging.getLogger("mcml.jobs")

LOOK_SECONDS = 1.0
"""How often a runner looks for jobs that nobody told it of."""

NEWS_SECONDS = 0.3
"""How often the owner of a job asks its worker how far it is."""

KILL_SECONDS = 10.0
"""How long a cancelled job may go on before its worker is killed."""


class InterruptionError(McmlError):
    """What ran a job ended before the job had begun, through no fault of the job."""


class Runner:
    """Started and stopped with the server."""

    def __init__(self, database: Database, settings: Settings) -> None:
        self._database = database.for_call(database.view, SERVER)
        self._settings = settings
        self._cluster = Cluster(database, settings)
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
        """End in order: what is not done waits for the next server."""
        self._stopping.set()
        self._wake.set()
        self._thread.join(timeout=10)
        self._drivers.shutdown(wait=True)
        with suppress(McmlError), self._database.write("jobs") as tx:
            tx.jobs.release(self._name)
        self._cluster.close()

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
                job = self._claimed()
            finally:
                # A store that is away for a while must not use the places up.
                if job is None:
                    self._free.release()
            if job is None:
                return
            self._drivers.submit(self._drive, job)

    def _claimed(self) -> StoredJob | None:
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
            # A store that is away fails no job: it is begun anew when its lease is over.
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
        self._tell(job, "starting a worker", 0.0)
        client = self._client()
        # Another server that was cut off may still have the job done under a name that is no longer ours.
        key, known = f"{job.uuid}-{job.attempt}-{new_uuid()}", len(client.get_events(job.uuid))
        replica = self._database.replica
        urls = self._database.url, None if replica is None else replica.url
        future = client.submit(on_dask, urls, job.uuid, job.analysis, job.inputs, job.parameters, key=key, pure=False)
        ended = threading.Event()
        future.add_done_callback(lambda _: ended.set())
        try:
            if not self._watch(job, client, future, ended):
                if not self._stopping.is_set():
                    self._end(job, "cancelled")
                return
            begun = len(client.get_events(job.uuid)) > known
            keep_outcome(self._database, self._settings, job, self._name, self._outcome(future, begun=begun))
        finally:
            future.release()

    def _watch(self, job: StoredJob, client: Any, future: Any, ended: threading.Event) -> bool:
        """Pass news on until the work has ended; False where it was given up."""
        last, told, cancelled_at = ("starting a worker", 0.0), time.monotonic(), None
        while not ended.wait(NEWS_SECONDS):
            if self._stopping.is_set():
                self._cluster.kill(future)
                return False
            events = client.get_events(job.uuid)
            news = (events[-1][1]["stage"], events[-1][1]["share"]) if events else last
            if news == last and time.monotonic() - told < LEASE_SECONDS / 4:
                continue
            last, told = news, time.monotonic()
            with suppress(UnavailableError):
                if not self._tell(job, *news) and cancelled_at is None:
                    cancelled_at = time.monotonic()
            if cancelled_at is not None and time.monotonic() - cancelled_at > KILL_SECONDS:
                self._cluster.kill(future)
                return False
        return True

    def _client(self) -> Any:
        """InterruptionError where no worker can be started, or no scheduler answers."""
        try:
            return self._cluster.client()
        except (OSError, RuntimeError) as error:
            raise InterruptionError(
                f"No worker could be started: {str(error) or type(error).__name__}.",
                remedy="Look at the server's log and its free memory, then start the job again.",
            ) from error

    def _outcome(self, future: Any, *, begun: bool) -> Outcome | None:
        """What the worker gave; None where it heard that the job was cancelled. begun: whether the job told of itself.
        InterruptionError where nobody can give what it found."""
        from distributed import KilledWorker
        from distributed.client import FutureCancelledError

        try:
            outcome: Outcome = future.result()
        except CancelledError:
            return None
        except FutureCancelledError as error:
            raise InterruptionError("The scheduler of the workers ended.", remedy="Start the job again.") from error
        except KilledWorker as error:
            what = "The worker died twice on this job; it may have taken too much memory."
            remedy = f"Choose fewer clips, or raise MCML_JOB_MEMORY_MIB ({self._settings.job_memory_mib})."
            raise (McmlError if begun else InterruptionError)(what, remedy=remedy) from error
        return outcome

    def _begin_again(self, job: StoredJob, error: McmlError) -> None:
        """Let a job wait again, a few times. Deaths of servers do not count: those are no fault of a job either, and
        leave nobody to count them."""
        self._deaths[job.uuid] += 1
        log.warning("job %s: %s", job.uuid, error)
        if self._deaths[job.uuid] < MOST_ATTEMPTS:
            with suppress(McmlError), self._database.write("jobs") as tx:
                tx.jobs.give_back(job.uuid, self._name)
            return
        del self._deaths[job.uuid]
        self._fail(job, f"The job was begun {MOST_ATTEMPTS} times in vain. {error.what}", error.remedy)

    def _tell(self, job: StoredJob, stage: str, share: float) -> bool:
        with self._database.write("jobs") as tx:
            return tx.jobs.tell(job.uuid, self._name, stage, share)

    def _end(self, job: StoredJob, state: str, problem: dict[str, Any] | None = None) -> None:
        with self._database.write("jobs") as tx:
            tx.jobs.end(job.uuid, self._name, state, problem=problem)

    def _fail(self, job: StoredJob, what: str, remedy: str | None = None) -> None:
        with suppress(McmlError):
            self._end(job, "failed", _problem(what, remedy))


def keep_outcome(database: Database, settings: Settings, job: StoredJob, runner: str, outcome: Outcome | None) -> None:
    """End a job with what came of it: parts, a problem, or None where it was cancelled."""
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
    stop, cancelled = threading.Event(), threading.Event()

    def renew() -> None:
        while not stop.wait(LEASE_SECONDS / 8):
            with suppress(McmlError), database.write("jobs") as tx:
                if not tx.jobs.tell(job.uuid, runner):
                    cancelled.set()

    def watched(stage: str, share: float) -> None:
        if cancelled.is_set():
            raise CancelledError
        progress(stage, share)

    keeper = threading.Thread(target=renew, daemon=True)
    keeper.start()
    try:
        outcome = perform(database, job.analysis, job.inputs, job.parameters, watched)
        keep_outcome(database, settings, job, runner, outcome)
    except (KeyboardInterrupt, CancelledError):
        keep_outcome(database, settings, job, runner, None)
    except Exception:
        with suppress(McmlError):
            keep_outcome(database, settings, job, runner, Refused(_problem("The analysis failed unexpectedly.")))
        raise
    finally:
        stop.set()
        keeper.join()


def _problem(what: str, remedy: str | None = None) -> dict[str, Any]:
    problem = Problem(type="about:blank", title="Job failed", status=500, detail=what, remedy=remedy)
    return problem.model_dump(exclude_none=True)
