"""A store that goes away while the runner looks for jobs, and comes back."""

from __future__ import annotations

import threading
from concurrent.futures import Future
from contextlib import AbstractContextManager
from typing import Any

import pytest

from mcml.errors import StoreError, UnavailableError
from mcml_service.jobs.runner import Runner, keep_outcome
from mcml_service.jobs.worker import Refused
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.transaction import Transaction
from mcml_service.storage.work.jobs import StoredJob


@pytest.mark.parametrize("method", ["read", "write"])
@pytest.mark.parametrize("error", [UnavailableError, StoreError])
def test_jobs_go_on_when_the_store_is_back(
    database: Database, monkeypatch: pytest.MonkeyPatch, method: str, error: type[StoreError]
) -> None:
    """However often it was looked for in vain: each look takes a place, and gives it back."""
    settings = Settings(job_workers=2)
    with database.write() as tx:
        uuid = tx.jobs.add(tx.projects.get_or_add("lab"), "reach", "a model", "kim", [], {})
    looks, taken, ended = [0], [], threading.Event()
    asked = getattr(database, method)

    def seldom(*words: Any) -> AbstractContextManager[Transaction]:
        looks[0] += 1
        if looks[0] <= 3 * settings.jobs_at_a_time:
            raise error("The store cannot be reached now.")
        found: AbstractContextManager[Transaction] = asked(*words)
        return found

    def drive(_runner: Runner, job: StoredJob) -> None:
        taken.append(job.uuid)
        ended.set()

    monkeypatch.setattr("mcml_service.jobs.runner.LOOK_SECONDS", 0.001)
    monkeypatch.setattr(Runner, "_drive", drive)
    monkeypatch.setattr(database, method, seldom)
    runner = Runner(database, settings)
    runner.start()
    assert ended.wait(20)
    runner.stop()
    assert taken == [uuid]


class Workers:
    """They end the one job when its lease was renewed so many times."""

    crew = None

    def __init__(self) -> None:
        self._future: Future[Refused] = Future()
        self._renewed = 0

    def submit(self, *_: Any) -> Future[Refused]:
        return self._future

    def renewed(self) -> None:
        self._renewed += 1
        if self._renewed == 4:
            self._future.set_result(Refused({"detail": "what the analysis itself said"}))

    def shutdown(self) -> None:
        """Nothing runs."""


def test_a_job_outlives_an_outage(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    """Twice while a worker does it, and once when it is begun, after which it is begun anew."""
    monkeypatch.setattr("mcml_service.storage.work.jobs.LEASE_SECONDS", 0.2)
    for name, value in (("LOOK_SECONDS", 0.001), ("STOP_SECONDS", 0.001), ("LEASE_SECONDS", 0.004)):
        monkeypatch.setattr(f"mcml_service.jobs.runner.{name}", value)
    with database.write() as tx:
        uuid = tx.jobs.add(tx.projects.get_or_add("lab"), "reach", "a model", "kim", [], {})
    workers, begins, renewals, ended = Workers(), [0], [0], threading.Event()
    begin, renew, end = Runner._begin, Runner._renew, Runner._end

    def seldom_begin(runner: Runner, job: StoredJob) -> None:
        begins[0] += 1
        if begins[0] == 1:
            raise UnavailableError("The store cannot be reached now.")
        begin(runner, job)

    def seldom_renew(runner: Runner, job: StoredJob) -> bool:
        workers.renewed()
        renewals[0] += 1
        if renewals[0] < 3:
            raise UnavailableError("The store cannot be reached now.")
        return renew(runner, job)

    def ending(runner: Runner, *words: Any) -> None:
        end(runner, *words)
        ended.set()

    def kept(*words: Any) -> None:
        keep_outcome(*words)
        ended.set()

    monkeypatch.setattr(Runner, "_begin", seldom_begin)
    monkeypatch.setattr(Runner, "_renew", seldom_renew)
    monkeypatch.setattr(Runner, "_end", ending)
    monkeypatch.setattr("mcml_service.jobs.runner.keep_outcome", kept)
    runner = Runner(database, Settings(job_workers=1))
    monkeypatch.setattr(runner, "_workers", workers)
    runner.start()
    assert ended.wait(20)
    runner.stop()
    with database.read() as tx:
        job = tx.jobs.get(uuid)
    assert job.problem == {"detail": "what the analysis itself said"}
    assert job.attempt == 2
