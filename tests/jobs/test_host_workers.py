"""Jobs in processes of this host: bounded, apart from each other, and gone with their server."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import httpx
import psutil
import pytest
from fastapi.testclient import TestClient

from mcml.errors import StoreError
from mcml_service.jobs import dask_workers
from mcml_service.jobs.host_workers import HostWorkers
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests import fuzz, postgres
from tests.api.test_two_servers import environment, is_ready, until
from tests.builders import one_kind, served
from tests.jobs import works
from tests.jobs.test_jobs import API, fill, instead, start, wait

pytestmark = one_kind


@contextmanager
def server(database: Database, **settings: Any) -> Iterator[TestClient]:
    fill(database)
    with served(database, Settings(**{"job_workers": 1, **settings})) as client:
        yield client


def value_of(client: TestClient, job: dict[str, Any]) -> Any:
    """What a job of `works` found."""
    done = wait(client, job)
    assert done["state"] == "done", done
    return client.get(f"{API}/results/{done['result']}/numbers").json()["data"]


@pytest.mark.slow
def test_a_process_that_is_killed_while_it_sends_a_result_ends_its_work(database: Database, tmp_path: Path) -> None:
    """A result of many megabytes takes seconds to send, and a job may be cancelled meanwhile."""
    with HostWorkers(2, 1 << 30) as workers:
        work = workers.submit(works.half_a_result, str(tmp_path / "begun"))
        until((tmp_path / "begun").exists)
        workers.kill(work)
        assert isinstance(work.exception(60), BrokenExecutor)
        assert workers.submit(os.getpid).result(60) != os.getpid()


@pytest.mark.fuzz  # Long: in `make test` one of two dies.
def test_two_jobs_run_at_once(database: Database, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    instead(monkeypatch, partial(works.meeting, str(tmp_path)))
    with server(database, job_workers=2) as client:
        jobs = [start(client) for _ in range(2)]
        assert [value_of(client, job)["value"] for job in jobs] == [2, 2]


@pytest.mark.slow
def test_a_job_that_needs_too_much_memory_fails_in_words(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    with server(database, job_memory_mib=256) as client:
        instead(monkeypatch, partial(works.greedy, 4096))
        failed = wait(client, start(client))
        assert failed["state"] == "failed"
        assert failed["problem"]["detail"] == "The job needs more than 256 MiB of memory."
        assert "MCML_JOB_MEMORY_MIB" in failed["problem"]["remedy"]
        instead(monkeypatch, partial(works.greedy, 128))
        assert value_of(client, start(client)) == {"value": 128}


@pytest.mark.slow
def test_a_job_ends_alone_when_its_process_dies(
    database: Database, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The other one goes on."""
    with server(database, job_workers=2) as client:
        instead(monkeypatch, works.endless)
        goes_on = start(client)
        wait(client, goes_on, lambda found: found["stage"] == "for ever")
        instead(monkeypatch, partial(works.dying, 99, str(tmp_path / "marks")))
        failed = wait(client, start(client))
        assert (failed["state"], "died twice" in failed["problem"]["detail"]) == ("failed", True)
        assert (tmp_path / "marks").read_text() == "xx"
        found = client.get(f"{API}/jobs/{goes_on['id']}").json()
        assert (found["state"], found["stage"]) == ("running", "for ever")


@pytest.mark.slow
def test_workers_have_no_web_and_one_thread(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    """Mathematics in several threads would take the cores of others, and sum in another order."""
    instead(monkeypatch, works.surroundings)
    with server(database) as client:
        found = value_of(client, start(client))
    assert not {"fastapi", "starlette", "uvicorn", "typer", "dask", "distributed"} & set(found["modules"])
    assert "numpy" in found["modules"]
    assert found["native_threads"] == 0


@contextmanager
def program(url: str, folder: Path, *words: str, **more: str) -> Iterator[tuple[subprocess.Popen[bytes], str]]:
    """`mcml serve` in a process of its own, and its address. words: what Python does before."""
    port = postgres.free_port()
    text = "\n".join([*words, f"sys.argv = ['mcml', 'serve', '--port', '{port}']", "main()"])
    command = [sys.executable, "-c", f"import sys\nfrom mcml_service.cli import main\n{text}"]
    with (folder / "log").open("wb") as log:
        started = subprocess.Popen(command, env=environment(url, folder, **more), stdout=log, stderr=log)
    try:
        yield started, f"http://127.0.0.1:{port}"
    finally:
        started.kill()
        started.wait(30)


@contextmanager
def asked(database: Database, address: str, process: subprocess.Popen[bytes]) -> Iterator[httpx.Client]:
    """A server that answers, asked by a user of its store."""
    until(lambda: is_ready(address) or process.poll() is not None)
    assert process.poll() is None
    with database.write() as tx:
        token = tx.tokens.add("kim", None)
    with httpx.Client(base_url=address, headers={"authorization": f"Bearer {token}"}, timeout=60) as client:
        yield client


@pytest.mark.slow
@pytest.mark.parametrize("does_spread", fuzz.share([True, False], 2))
def test_no_process_is_left_when_a_server_is_killed(
    database: Database, database_url: str, tmp_path: Path, does_spread: bool
) -> None:
    fill(database)
    place = tmp_path / "pieces"
    place.mkdir()
    work = f"partial(works.spread_as_job, works.endless_piece, {str(place)!r})" if does_spread else "works.endless"
    words = [
        "from functools import partial",
        "from tests.jobs import works",
        "import mcml_service.jobs.runner as runner",
        "import mcml_service.jobs.host_workers as host",
        "host.ALONE_SECONDS = 0.0",
        f"runner.work_on = {work}",
    ]
    with program(database_url, tmp_path, *words, MCML_JOB_WORKERS="2") as (process, address):
        with asked(database, address, process) as client:
            job = start(client)
            if does_spread:
                until(lambda: len(os.listdir(place)) == 2)
            else:
                wait(client, job, lambda found: found["stage"] == "for ever")
        family = psutil.Process(process.pid).children(recursive=True)
        assert len(family) >= (4 if does_spread else 2)
        process.send_signal(signal.SIGKILL)
        process.wait(30)
        until(lambda: not any(one.is_running() and one.status() != psutil.STATUS_ZOMBIE for one in family))


HIDE = "import sys\nsys.modules['dask'] = sys.modules['distributed'] = None\n"
"""Hides the extra `cluster` from a process, and from those that it starts."""


@pytest.mark.slow
def test_jobs_run_without_dask(
    database: Database, database_url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "sitecustomize.py").write_text(HIDE)
    fill(database)
    hidden = os.pathsep.join([str(tmp_path), os.getcwd()])
    with (
        program(database_url, tmp_path, PYTHONPATH=hidden) as (process, address),
        asked(database, address, process) as client,
    ):
        assert wait(client, start(client))["state"] == "done"
    monkeypatch.setattr(dask_workers, "find_spec", {"distributed": None}.get)
    with pytest.raises(StoreError) as error:
        dask_workers.DaskWorkers(database, Settings(dask_scheduler="tcp://host:8786"))
    assert "pip install 'mcml-repository[cluster]'" in (error.value.remedy or "")
