"""Workers that stay: a server's uploads of many clips are read by them, and become what the importer alone makes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import psutil
import pytest

from mcml.files.import_options import ImportOptions
from mcml_service.actions.importing import import_pool
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.actions.importing.import_pool import ImportPool
from mcml_service.actions.importing.read_apart import SentClip
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.lists.filtering import DocumentFilter
from tests.api.test_two_servers import until
from tests.builders import bvh, source
from tests.jobs import works

CLIPS = {f"clip{number:02}.bvh": bvh(3 + number % 5, seed=number) for number in range(12)}


@pytest.fixture(scope="module")
def pool() -> Iterator[ImportPool]:
    made = ImportPool()
    yield made
    made.close()


@pytest.fixture
def sqlite(tmp_path: Path) -> Iterator[Database]:
    database = Database(f"sqlite:///{tmp_path}/store.db")
    database.migrate()
    yield database
    database.close()


@pytest.fixture(autouse=True)
def as_a_server(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A process with threads, and workers for few clips."""
    monkeypatch.setenv("MCML_IMPORT_PROCESSES", "2")
    monkeypatch.setattr(import_pool, "WORTH_STARTING", 8)
    over = threading.Event()
    waiting = threading.Thread(target=over.wait)
    waiting.start()
    yield
    over.set()
    waiting.join()


def imported(database: Database, files: dict[str, bytes], pool: ImportPool | None) -> Any:
    sources = [source(name, content) for name, content in files.items()]
    return import_files(database, sources, ImportOptions(), Settings(), pool=pool)


def test_they_make_what_the_importer_makes(tmp_path: Path, pool: ImportPool) -> None:
    files = CLIPS | {"bad.bvh": b"HIERARCHY\nROOT"}
    seen = []
    for number, each in enumerate((pool, None)):
        database = Database(f"sqlite:///{tmp_path}/{number}.db")
        database.migrate()
        done = imported(database, files, each)
        assert database.check() == []
        with database.read() as tx:
            stored = tx.documents.page(DocumentFilter(), after=None, limit=100)
            receipts = [{**item.receipt, "twins": []} for item in done.documents]
            seen.append(([(one.name, one.frames) for one in stored], receipts, [str(one) for one in done.problems]))
        database.close()
    assert pool.is_running
    assert seen[0] == seen[1]


@pytest.mark.parametrize("most_bytes", [import_pool.MOST_BYTES, 1])
def test_short_clips_are_sent_some_at_a_time(
    sqlite: Database, pool: ImportPool, monkeypatch: pytest.MonkeyPatch, most_bytes: int
) -> None:
    sent: list[int] = []
    submit = pool.submit

    def counted(clips: list[SentClip], settings: Settings) -> Any:
        sent.append(len(clips))
        return submit(clips, settings)

    monkeypatch.setattr(pool, "submit", counted)
    monkeypatch.setattr(import_pool, "AHEAD", 1)
    monkeypatch.setattr(import_pool, "MOST_BYTES", most_bytes)
    done = imported(sqlite, CLIPS, pool)
    assert [f"{item.name}.bvh" for item in done.documents] == list(CLIPS)
    assert sum(sent) == len(CLIPS)
    assert (max(sent) > 1) == (most_bytes > 1)
    assert sqlite.check() == []


@pytest.mark.slow
def test_a_worker_that_dies_costs_no_clip(sqlite: Database, pool: ImportPool) -> None:
    imported(sqlite, CLIPS, pool)
    executor = pool._start(2)
    for process in list(executor._processes.values()):
        os.kill(process.pid, signal.SIGKILL)
    again = {name: content + b"\n" for name, content in CLIPS.items()}
    for _ in range(2):
        assert len(imported(sqlite, again, pool).documents) == len(CLIPS)
    assert sqlite.check() == []


@pytest.mark.slow
def test_a_worker_that_is_killed_while_it_sends_a_result_ends_the_wait(
    sqlite: Database, pool: ImportPool, tmp_path: Path
) -> None:
    imported(sqlite, CLIPS, pool)
    work = pool._start(2).submit(works.half_a_result, str(tmp_path / "begun"))
    until(lambda: (tmp_path / "begun").exists() and bool((tmp_path / "begun").read_text()))
    os.kill(int((tmp_path / "begun").read_text()), signal.SIGKILL)
    waiting = ThreadPoolExecutor(1)
    assert waiting.submit(pool.wait, work).result(60) is None
    waiting.shutdown()
    again = {name: content + b"\n\n" for name, content in CLIPS.items()}
    assert len(imported(sqlite, again, pool).documents) == len(CLIPS)


PROGRAM = """
import sys
from mcml_service.actions.importing.import_pool import ImportPool
from mcml_service.actions.importing.read_apart import SentClip
from mcml_service.settings import Settings
from mcml.files.import_options import ImportOptions
if __name__ == "__main__":
    pool = ImportPool()
    pool.submit([SentClip("bvh", {}, ImportOptions())], Settings()).result()
    print(*[process.pid for process in pool._start(2)._processes.values()], flush=True)
    sys.stdin.read()
"""


@pytest.mark.slow
def test_they_end_with_who_started_them(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    with subprocess.Popen(
        [sys.executable, program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
    ) as started:
        assert started.stdout is not None
        workers = [psutil.Process(int(pid)) for pid in started.stdout.readline().split()]
        assert workers
        started.kill()
        _, alive = psutil.wait_procs(workers, timeout=20)
    assert alive == []
