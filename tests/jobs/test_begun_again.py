"""Jobs whose process, scheduler or server ends: they are begun again, and given up where it is their own fault."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Future
from typing import Any

import pytest
from sqlalchemy import update

from mcml_service.jobs.runner import Runner
from mcml_service.jobs.worker import Refused, Task
from mcml_service.jobs.workers import InterruptionError
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.work.jobs import StoredJob
from mcml_service.storage.work.tables import job as jobs
from tests.builders import one_kind

SAID = {"detail": "what the analysis itself said"}
Ending = Callable[[], Any]


def killed() -> Any:
    raise BrokenExecutor("a process died")


def lost() -> Any:
    raise InterruptionError("The scheduler of the workers ended.", remedy="Start the job again.")


def unstarted() -> Any:
    raise OSError("Resource temporarily unavailable")


def answered() -> Any:
    return Refused(SAID)


class Workers:
    """Workers whose jobs end as listed. begun: each tells of itself before it ends."""

    crew = None

    def __init__(self, database: Database, *endings: Ending, begun: bool = False) -> None:
        self.endings, self.begun = list(endings), begun
        self._database = database

    def submit(self, _work: Any, task: Task, _crew: None) -> Future[Any]:
        ending = self.endings.pop(0)
        if ending is unstarted:
            ending()
        if self.begun:
            with self._database.write() as tx:
                tx.jobs.tell(task.uuid, task.runner, "loading", 0.1)
        future: Future[Any] = Future()
        try:
            future.set_result(ending())
        except Exception as error:
            future.set_exception(error)
        return future

    def shutdown(self) -> None:
        """Nothing runs."""


def added(database: Database) -> str:
    with database.write() as tx:
        return tx.jobs.add(tx.projects.get_or_add("lab"), "reach", "a model", "kim", [], {})


def ended(database: Database, uuid: str, workers: Workers, monkeypatch: pytest.MonkeyPatch) -> StoredJob:
    """The job when a runner has ended it."""
    done = threading.Event()
    drive = Runner._drive

    def driven(runner: Runner, job: StoredJob) -> None:
        drive(runner, job)
        with database.read() as tx:
            if tx.jobs.get(uuid).state == "failed":
                done.set()

    monkeypatch.setattr(Runner, "_drive", driven)
    monkeypatch.setattr("mcml_service.jobs.runner.LOOK_SECONDS", 0.001)
    runner = Runner(database, Settings(job_workers=1))
    monkeypatch.setattr(runner, "_workers", workers)
    runner.start()
    assert done.wait(30)
    runner.stop()
    with database.read() as tx:
        return tx.jobs.get(uuid)


@pytest.mark.parametrize("ending", [killed, lost, unstarted])
def test_a_process_that_ends_while_it_starts_fails_no_job(
    database: Database, monkeypatch: pytest.MonkeyPatch, ending: Ending
) -> None:
    workers = Workers(database, ending, ending, answered)
    found = ended(database, added(database), workers, monkeypatch)
    assert found.problem == SAID


@one_kind
@pytest.mark.parametrize("ending", [killed, lost, unstarted])
def test_it_is_given_up_after_three_times(database: Database, monkeypatch: pytest.MonkeyPatch, ending: Ending) -> None:
    workers = Workers(database, ending, ending, ending, answered)
    found = ended(database, added(database), workers, monkeypatch)
    assert found.problem is not None
    assert "3 times in vain" in found.problem["detail"]
    assert found.problem["remedy"]
    assert workers.endings == [answered]


@one_kind
def test_a_job_that_kills_two_workers_is_given_up(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    workers = Workers(database, killed, killed, answered, begun=True)
    found = ended(database, added(database), workers, monkeypatch)
    assert found.problem is not None
    assert "died twice" in found.problem["detail"]
    assert "MCML_JOB_MEMORY_MIB" in found.problem["remedy"]
    assert workers.endings == [answered]


@one_kind
def test_a_job_that_kills_one_worker_is_tried_once_more(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    found = ended(database, added(database), Workers(database, killed, answered, begun=True), monkeypatch)
    assert (found.problem, found.attempt) == (SAID, 1)


def test_deaths_of_servers_do_not_count(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    uuid = added(database)
    for number in range(6):
        with database.write() as tx:
            assert [one.uuid for one in tx.jobs.claim(f"server {number}", 1)] == [uuid]
            # It was killed, and its lease ends.
            tx.connection.execute(update(jobs).values(lease=0.0))
    found = ended(database, uuid, Workers(database, killed, lost, answered), monkeypatch)
    assert found.problem == SAID
