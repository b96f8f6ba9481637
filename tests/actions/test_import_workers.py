"""Clips that other processes read: the same as read by the importer, whatever happens to these processes."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import pytest

from mcml.files.clip_files import Clip
from mcml.files.import_options import ImportOptions
from mcml.formats.format import SourceFile
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.importing import import_pool
from mcml_service.actions.importing import read_apart as read_apart_module
from mcml_service.actions.importing.import_batch import ImportResult
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.actions.importing.import_pool import ImportPool, reading_ahead
from mcml_service.actions.importing.read_apart import ReadApart, SentClip
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.actions.test_kill import IMPORTER
from tests.builders import ASF, HTR, MCML, TRC, amc, bvh, c3d_file, read_by, source

CLIPS = {f"clip{number:02}.bvh": bvh(4, seed=number) for number in range(40)}
MIXED = {name: CLIPS[name] for name in list(CLIPS)[:6]} | {
    "cut.bvh": bvh(30)[:-40],
    "twin.bvh": CLIPS["clip02.bvh"],
    "hand.mcml": MCML,
    "broken.mcml": MCML.replace(b"</skeleton>", b""),
    "two.htr": HTR,
    "points.c3d": c3d_file(),
    "hand.trc": TRC,
    "leg.asf": ASF,
    "leg_1.amc": amc(4),
    "leg_2.amc": amc(300),
    "long.bvh": bvh(700),
    "empty.bvh": b"",
}


@pytest.fixture(autouse=True)
def nobody_is_left() -> Iterator[None]:
    # The worker of all tests, where a test needed it before.
    before = set(multiprocessing.active_children())
    yield
    assert set(multiprocessing.active_children()) <= before


def opened(template: Path, path: Path) -> Iterator[Database]:
    shutil.copy(template, path)
    store = Database(f"sqlite:///{path}")
    yield store
    store.close()


@pytest.fixture
def sqlite(sqlite_template: Path, tmp_path: Path) -> Iterator[Database]:
    yield from opened(sqlite_template, tmp_path / "store.db")


@pytest.fixture
def other(sqlite_template: Path, tmp_path: Path) -> Iterator[Database]:
    yield from opened(sqlite_template, tmp_path / "other.db")


def imported(database: Database, files: dict[str, bytes], **options: object) -> ImportResult:
    sources = [source(name, content) for name, content in files.items()]
    return import_files(database, sources, ImportOptions(**options), Settings())  # type: ignore[arg-type]


def told(database: Database, result: ImportResult) -> list[object]:
    """All that an import said and stored, without what is new each time."""
    said: list[object] = []
    places = {item.uuid: item.name for item in result.documents}
    with database.read() as tx:
        for item in result.documents:
            export = export_document(tx, tx.documents.get(item.uuid), ExportOptions("mcml")).content
            facts = item.receipt | {"twins": [places.get(uuid) for uuid in item.receipt["twins"]]}
            said.append((item.name, facts, item.skipped, b"".join(export)))
    return said + [(name, type(error), str(error), error.remedy, error.details) for name, error in result.problems]


@pytest.mark.parametrize("options", [{}, {"on_duplicate": "skip", "frame_time": "0.02", "unit": "cm"}])
def test_workers_make_what_the_importer_makes(
    sqlite: Database, other: Database, monkeypatch: pytest.MonkeyPatch, options: dict[str, object]
) -> None:
    alone = imported(sqlite, MIXED, **options)
    assert len(alone.problems) == 3
    read_by(monkeypatch, 3)
    calls = counted(monkeypatch)
    assert told(other, imported(other, MIXED, **options)) == told(sqlite, alone)
    assert calls == [3]
    assert other.check() == []


def counted(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The number of workers of each time that some are started."""
    calls: list[int] = []
    started = ImportPool._start

    def counting(self: ImportPool, processes: int) -> Any:
        if not self.is_running:
            calls.append(processes)
        return started(self, processes)

    monkeypatch.setattr(ImportPool, "_start", counting)
    return calls


def die(sent: SentClip) -> None:
    if any(part.name == "clip05.bvh" for part in sent.parts.values()):
        os.kill(os.getpid(), signal.SIGKILL)


def run_out_of_memory(sent: SentClip) -> None:
    if any(part.name > "clip03.bvh" for part in sent.parts.values()):
        raise MemoryError


@pytest.mark.parametrize("accident", [die, run_out_of_memory])
def test_what_a_worker_cannot_do_the_importer_does(
    sqlite: Database, monkeypatch: pytest.MonkeyPatch, accident: Callable[[SentClip], None]
) -> None:
    read_by(monkeypatch, 2)
    read = import_pool.read_apart
    importer = os.getpid()

    def struck(sent: SentClip, settings: Settings) -> ReadApart | None:
        assert os.getpid() != importer
        try:
            accident(sent)
        except MemoryError:
            return None
        return read(sent, settings)

    monkeypatch.setattr(import_pool, "read_apart", struck)
    result = imported(sqlite, CLIPS)
    assert [item.name for item in result.documents] == [name[:-4] for name in CLIPS]
    assert sqlite.check() == []


def test_an_unexpected_error_is_the_importers(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(read_apart_module, "encode_clip", fail)
    clip = Clip("bvh", {"bvh": source("a.bvh", CLIPS["clip00.bvh"])})
    assert read_apart_module.read_apart(SentClip.of(clip, ImportOptions()), Settings()) is None


def test_files_on_disk_are_read_by_several_at_once(
    sqlite: Database, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    # Who inherits an open file shares its position: two that read one skeleton must not move it for each other.
    read_by(monkeypatch, 3)
    files = {"leg.asf": ASF} | {f"leg_{number}.amc": amc(4 + number) for number in range(24)}
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    streams = [SourceFile(name, (tmp_path / name).open("rb")) for name in files]
    result = import_files(sqlite, streams, ImportOptions(), Settings())
    for file in streams:
        file.stream.close()
    assert result.problems == []
    assert [item.receipt["frames"] for item in result.documents] == [4 + number for number in range(24)]


def test_workers_stay_near_the_importer(monkeypatch: pytest.MonkeyPatch) -> None:
    read_by(monkeypatch, 2)
    monkeypatch.setattr(import_pool, "AHEAD", 3)
    sent: list[SentClip] = []

    def note(self: ImportPool, clips: list[SentClip], settings: Settings) -> Future[list[None]]:
        sent.extend(clips)
        done: Future[list[None]] = Future()
        done.set_result([None] * len(clips))
        return done

    monkeypatch.setattr(ImportPool, "submit", note)
    clips = {number: Clip("bvh", {"bvh": source("a.bvh", b"")}) for number in range(40)}
    with reading_ahead(clips, ImportOptions(), Settings()) as reading:
        for number in range(20):
            reading.take(number)
            assert len(sent) <= number + 1 + 2 * 3 + import_pool.TOGETHER


def test_no_worker_for_what_is_stored_or_beside_threads(sqlite: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = counted(monkeypatch)
    over = threading.Event()
    waiting = threading.Thread(target=over.wait)
    waiting.start()
    assert len(imported(sqlite, CLIPS).documents) == len(CLIPS)
    over.set()
    waiting.join()
    read_by(monkeypatch, 2)
    assert all(item.skipped for item in imported(sqlite, CLIPS, on_duplicate="skip").documents)
    assert calls == []


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="workers are forked on Linux only")
def test_workers_end_with_an_importer_that_is_killed(tmp_path: Path) -> None:
    Database(url := f"sqlite:///{tmp_path / 'store.db'}").migrate()
    folder = tmp_path / "clips"
    folder.mkdir()
    for name, content in CLIPS.items():
        (folder / name).write_bytes(content)
    program = IMPORTER.format(root=str(Path(__file__).resolve().parents[2]))
    environment = os.environ | {"MCML_IMPORT_PROCESSES": "3"}
    words = [sys.executable, "-c", program, url, str(folder), "20"]
    importer = subprocess.Popen(words, env=environment, stdout=subprocess.PIPE)
    # Its output ends when nobody has it any more.
    assert importer.communicate(timeout=10)[0] == b""
    assert importer.returncode == -signal.SIGKILL
