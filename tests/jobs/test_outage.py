"""A store that goes away while the runner looks for jobs, and comes back."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import AbstractContextManager
from types import SimpleNamespace
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


class Work:
    """A worker's task, and the cluster that has it done: it ends when the store was told of it so many times."""

    def __init__(self) -> None:
        self.tells = 0
        self._done: Callable[[Any], None] | None = None

    def add_done_callback(self, done: Callable[[Any], None]) -> None:
        self._done = done

    def told(self) -> None:
        self.tells += 1
        if self.tells == 4 and self._done is not None:
            self._done(self)

    def client(self) -> Any:
        return SimpleNamespace(submit=lambda *_, **__: self, get_events=lambda _: [])

    def result(self) -> Refused:
        return Refused({"detail": "what the analysis itself said"})

    def release(self) -> None:
        """Nobody holds it."""


def test_a_job_outlives_an_outage(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    """Twice while a worker does it, and once when it is begun, after which it is begun anew."""
    monkeypatch.setattr("mcml_service.storage.work.jobs.LEASE_SECONDS", 0.2)
    for name, value in (("LOOK_SECONDS", 0.001), ("NEWS_SECONDS", 0.001), ("LEASE_SECONDS", 0.004)):
        monkeypatch.setattr(f"mcml_service.jobs.runner.{name}", value)
    with database.write() as tx:
        uuid = tx.jobs.add(tx.projects.get_or_add("lab"), "reach", "a model", "kim", [], {})
    work, calls, ended = Work(), [0], threading.Event()
    tell, end = Runner._tell, Runner._end

    def seldom(runner: Runner, *words: Any) -> bool:
        calls[0] += 1
        if calls[0] > 2:
            work.told()
        if calls[0] in (1, 3, 4):
            raise UnavailableError("The store cannot be reached now.")
        return tell(runner, *words)

    def ending(runner: Runner, *words: Any) -> None:
        end(runner, *words)
        ended.set()

    def kept(*words: Any) -> None:
        keep_outcome(*words)
        ended.set()

    monkeypatch.setattr(Runner, "_tell", seldom)
    monkeypatch.setattr(Runner, "_end", ending)
    monkeypatch.setattr("mcml_service.jobs.runner.keep_outcome", kept)
    runner = Runner(database, Settings(job_workers=1))
    monkeypatch.setattr(runner, "_cluster", SimpleNamespace(client=work.client, close=lambda: None))
    runner.start()
    assert ended.wait(20)
    runner.stop()
    with database.read() as tx:
        job = tx.jobs.get(uuid)
    assert job.problem == {"detail": "what the analysis itself said"}
    assert job.attempt == 2
