"""Jobs of two server processes on one store: what one began the other tells, ends, and takes up."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

import httpx
import psutil
import pytest

from mcml_service.storage.database import Database
from tests import postgres
from tests.api.test_two_servers import API, environment, is_ready, until
from tests.jobs.test_jobs import fill, start, wait


class Server:
    """A process of its own, with the workers that it starts for jobs."""

    def __init__(self, url: str, folder: Path, token: str) -> None:
        port = postgres.free_port()
        command = [sys.executable, "-m", "mcml_service.cli", "serve", "--port", str(port)]
        with (folder / "log").open("ab") as log:
            self.process = subprocess.Popen(command, env=environment(url, folder), stdout=log, stderr=log)
        self.address = f"http://127.0.0.1:{port}"
        self.ask = httpx.Client(base_url=self.address, headers={"authorization": f"Bearer {token}"}, timeout=60)

    def family(self) -> list[psutil.Process]:
        found: list[psutil.Process] = psutil.Process(self.process.pid).children(recursive=True)
        return found

    def halt_workers(self) -> None:
        """Whatever is given to them now takes for ever."""
        for process in self.family():
            process.suspend()

    def kill(self) -> None:
        """With all that it started, as a machine that fails does."""
        with suppress(psutil.NoSuchProcess):
            everybody = [*self.family(), psutil.Process(self.process.pid)]
            for process in everybody:
                process.kill()
        self.process.wait(30)


@contextmanager
def server(url: str, folder: Path, token: str) -> Iterator[Server]:
    started = Server(url, folder, token)
    try:
        until(lambda: is_ready(started.address) or started.process.poll() is not None)
        assert started.process.poll() is None, (folder / "log").read_text()
        yield started
    finally:
        started.kill()


@contextmanager
def followed(at: Server, job: dict[str, Any]) -> Iterator[Callable[[], list[str]]]:
    """Gives the kinds of events of a job, as a server tells them, once it has ended."""
    kinds: list[str] = []
    with at.ask.stream("GET", f"{API}/jobs/{job['id']}/events", timeout=120) as stream:

        def listen() -> None:
            with suppress(httpx.HTTPError):
                kinds.extend(line for line in stream.iter_lines() if line.startswith("event: "))

        listener = threading.Thread(target=listen)
        listener.start()

        def ended() -> list[str]:
            listener.join(60)
            return kinds

        yield ended


def state_of(at: Server, job: dict[str, Any]) -> tuple[str, int]:
    found = at.ask.get(f"{API}/jobs/{job['id']}").json()
    return found["state"], found["attempt"]


on_postgresql = pytest.mark.parametrize("kind", ["postgresql"], indirect=True)


@pytest.fixture
def token(database: Database) -> str:
    fill(database)
    with database.write() as tx:
        return tx.tokens.add("kim", None)


@pytest.mark.slow
@on_postgresql
def test_what_one_server_began_the_other_tells_and_takes_up(
    database: Database, database_url: str, token: str, tmp_path: Path
) -> None:
    with ExitStack() as stack:
        first = stack.enter_context(server(database_url, tmp_path, token))
        warm = wait(first.ask, start(first.ask))
        assert warm["state"] == "done", warm

        first.halt_workers()
        job = start(first.ask)
        until(lambda: state_of(first, job) == ("running", 1))
        second = stack.enter_context(server(database_url, tmp_path, token))
        assert state_of(second, job) == ("running", 1)
        assert second.ask.get(f"{API}/results/{warm['result']}").json()["inputs"] == warm["inputs"]
        with followed(second, job) as told:
            first.kill()
            done = wait(second.ask, job)
            assert (done["state"], done["attempt"]) == ("done", 2)
            assert told()[-1] == "event: end"
        assert second.ask.get(f"{API}/results/{done['result']}").json()["inputs"] == warm["inputs"]
    assert database.check() == []


@pytest.mark.fuzz
@on_postgresql
def test_what_one_server_began_the_other_ends(
    database: Database, database_url: str, token: str, tmp_path: Path
) -> None:
    with ExitStack() as stack:
        second = stack.enter_context(server(database_url, tmp_path, token))
        assert wait(second.ask, start(second.ask))["state"] == "done"
        second.halt_workers()
        job = start(second.ask)
        until(lambda: state_of(second, job) == ("running", 1))
        third = stack.enter_context(server(database_url, tmp_path, token))
        with followed(third, job) as told:
            assert third.ask.delete(f"{API}/jobs/{job['id']}").status_code == 202
            assert wait(third.ask, job)["state"] == "cancelled"
            assert told()[-1] == "event: end"
        assert state_of(second, job) == ("cancelled", 1)
        # The worker that took the place of the one that hung.
        assert wait(second.ask, start(third.ask))["state"] == "done"
    assert database.check() == []
