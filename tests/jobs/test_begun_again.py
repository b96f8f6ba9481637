"""Jobs whose process, scheduler or server ends: they are begun again, and given up where it is their own fault."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from distributed import KilledWorker
from distributed.client import FutureCancelledError
from sqlalchemy import update

from mcml_service.jobs.runner import Runner
from mcml_service.jobs.worker import Refused
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.work.jobs import StoredJob
from mcml_service.storage.work.tables import job as jobs
from tests.builders import one_kind

SAID = {"detail": "what the analysis itself said"}
Ending = Callable[[], Any]


def killed() -> Any:
    raise KilledWorker("a task", SimpleNamespace(address="tls://127.0.0.1:1"), 1)


def lost() -> Any:
    raise FutureCancelledError("a task", "scheduler-connection-lost")


def unstarted() -> Any:
    raise RuntimeError("Nanny failed to start worker process")


def answered() -> Any:
    return Refused(SAID)


class Future:
    def __init__(self, ending: Ending) -> None:
        self.result = ending

    def add_done_callback(self, done: Callable[[Any], None]) -> None:
        done(self)

    def release(self) -> None:
        """Nobody holds it."""


class Workers:
    """A cluster whose tasks end as listed. begun: whether each says something before it ends."""

    def __init__(self, *endings: Ending, begun: bool = False) -> None:
        self.endings, self.begun = list(endings), begun
        self.events: list[Any] = []
        self.keys: list[str] = []

    def client(self) -> Any:
        if self.endings[0] is unstarted:
            self.endings.pop(0)()
        return SimpleNamespace(submit=self.submit, get_events=lambda _: tuple(self.events))

    def submit(self, *_: Any, key: str, **__: Any) -> Future:
        self.keys.append(key)
        if self.begun:
            self.events.append((0, {"stage": "loading", "share": 0.1}))
        return Future(self.endings.pop(0))

    def close(self) -> None:
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
    monkeypatch.setattr(runner, "_cluster", workers)
    runner.start()
    assert done.wait(30)
    runner.stop()
    with database.read() as tx:
        return tx.jobs.get(uuid)


@pytest.mark.parametrize("ending", [killed, lost, unstarted])
def test_a_process_that_ends_while_it_starts_fails_no_job(
    database: Database, monkeypatch: pytest.MonkeyPatch, ending: Ending
) -> None:
    workers = Workers(ending, ending, answered)
    found = ended(database, added(database), workers, monkeypatch)
    assert found.problem == SAID
    assert len(set(workers.keys)) == len(workers.keys)


@one_kind
@pytest.mark.parametrize("ending", [killed, lost, unstarted])
def test_it_is_given_up_after_three_times(database: Database, monkeypatch: pytest.MonkeyPatch, ending: Ending) -> None:
    workers = Workers(ending, ending, ending, answered)
    found = ended(database, added(database), workers, monkeypatch)
    assert found.problem is not None
    assert "3 times in vain" in found.problem["detail"]
    assert found.problem["remedy"]
    assert workers.endings == [answered]


@one_kind
def test_a_job_that_kills_its_worker_is_given_up_at_once(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    workers = Workers(killed, answered, begun=True)
    found = ended(database, added(database), workers, monkeypatch)
    assert found.problem is not None
    assert "MCML_JOB_MEMORY_MIB" in found.problem["remedy"]
    assert workers.endings == [answered]


def test_deaths_of_servers_do_not_count(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    uuid = added(database)
    for number in range(6):
        with database.write() as tx:
            assert [one.uuid for one in tx.jobs.claim(f"server {number}", 1)] == [uuid]
            # It was killed, and its lease ends.
            tx.connection.execute(update(jobs).values(lease=0.0))
    found = ended(database, uuid, Workers(killed, lost, answered), monkeypatch)
    assert found.problem == SAID
