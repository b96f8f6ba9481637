"""Columns beside the store: nothing of them changes an answer, whatever becomes of the file."""

from __future__ import annotations

import io
import os
import sqlite3
import stat
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import cache
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

import pytest
from typer.testing import CliRunner

from mcml.files.import_options import ImportOptions
from mcml.formats.format import SourceFile
from mcml_schemas.querying.queries import QueryRequest
from mcml_service.actions.editing.frame_ranges import delete_frames
from mcml_service.actions.editing.whole_document import delete_document, restore_document
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.actions.keeping.keep_store import backup
from mcml_service.actions.keeping.purge_documents import purge_documents
from mcml_service.cli import app
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.library import groups
from mcml_service.xpath.library.disk.part_file import path_of, why_not
from mcml_service.xpath.queries import Queries
from tests import fuzz
from tests.builders import bvh

QUESTIONS = (
    "count(//frame)",
    "count(//frame_bone)",
    "count(//bone)",
    "count(/mcml[contains(header/filename, '1')])",
    "count(//frame[@id='2'])",
    "max(//frame_bone[@name='LeftUpLeg']/@Rx)",
    "avg(//frame_bone[@name='Hips']/@Ty)",
    "sum(//frame_bone/@Ry)",
    "//frame[frame_bone[@name='Hips']/@Ty > 100000]",
    "//frame_bone[@name='LeftUpLeg'][@Rx > 5]",
    "//frame[frame_bone[@name='LeftUpLeg']/@Rx > frame_bone[@name='Hips']/@Rx]/@id",
    "count(//frame_bone[@Rx > 5])",
    "//frame[2]",
    "distinct-values(//motion_name)",
    "//header/filename",
)
COUNT = 40


@pytest.fixture(autouse=True)
def small_groups(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(groups, "DOCUMENTS", 12)
    monkeypatch.setattr(groups, "MOST_DOCUMENTS", 30)
    monkeypatch.setattr(groups, "LASTING", 1)


@pytest.fixture
def library(tmp_path: Path) -> Iterator[Database]:
    database = copy_store(tmp_path / "store.db")
    yield database
    database.close()


def copy_store(path: Path) -> Database:
    """A filled store: filled once, for it takes longer than most of what is asked of it."""
    path.write_bytes(_filled_once())
    return Database(f"sqlite:///{path}")


@cache
def _filled_once() -> bytes:
    with TemporaryDirectory() as folder:
        path = Path(folder, "store.db")
        filled(path).close()
        return path.read_bytes()


def filled(path: Path, first: int = 0) -> Database:
    database = Database(f"sqlite:///{path}")
    database.migrate()
    files = []
    for number in range(first, first + COUNT):
        names = ("Hips", "LeftUpLeg", "LeftLeg")[: 2 + number % 2]
        files.append(SourceFile(f"{number}.bvh", io.BytesIO(bvh(1 + number % 7, seed=number, names=names))))
    assert not import_files(database, files, ImportOptions(unit="cm"), Settings()).problems
    return database


@contextmanager
def asking(database: Database, folder: str = "") -> Iterator[Queries]:
    """An engine as a fresh process has it, all that it made written at the end."""
    engine = Queries(database, Settings(cache_dir=folder))
    try:
        yield engine
        if engine.caches.sidecar is not None:
            engine.caches.sidecar.flush()
    finally:
        engine.close()


def answers(engine: Queries) -> list[object]:
    found = [engine.answer(QueryRequest(q=text, limit=1000)) for text in QUESTIONS]
    return [answer.model_dump(exclude={"explain"}) for answer in found]


def expected(database: Database) -> list[object]:
    with asking(database, "none") as engine:
        assert engine.caches.sidecar is None
        return answers(engine)


def kept(database: Database) -> Path:
    """The file, written."""
    with asking(database) as engine:
        assert answers(engine) == expected(database)
    found = path_of(database, "")
    assert found is not None
    return found


def rows(path: Path) -> list[tuple[bytes, str]]:
    with closing(sqlite3.connect(path)) as connection:
        return connection.execute("SELECT held, name FROM part ORDER BY held, name").fetchall()


def no_reading(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    """From now on columns cannot be read from the store."""
    for name in ("headers", "zones", "shapes", "frame_runs", "spans", "documents"):
        monkeypatch.setattr(f"mcml_service.storage.documents.columns.Columns.{name}", None)


def test_a_fresh_process_reads_no_columns_of_the_store(library: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    wanted, _ = expected(library), kept(library)
    no_reading(library, monkeypatch)
    with asking(library) as engine:
        assert answers(engine) == wanted


def test_the_file_lies_beside_the_store_for_its_owner_alone(library: Database, tmp_path: Path) -> None:
    path = kept(library)
    assert path == tmp_path / "store.db-cache"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_a_folder_that_is_named_has_one_file_a_store(library: Database, tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    other = filled(tmp_path / "other" / "store.db")
    folder = tmp_path / "kept" / "here"
    for database in (library, other):
        with asking(database, str(folder)) as engine:
            assert answers(engine) == expected(database)
    assert len(list(folder.glob("store.db-*.db-cache"))) == 2
    assert not (tmp_path / "store.db-cache").exists()
    other.close()


@pytest.mark.parametrize("seed", fuzz.share(range(4), 2))
def test_edits_between_processes_change_nothing_but_the_answers(library: Database, seed: int) -> None:
    random = Random(seed)
    deleted: list[str] = []
    for _ in range(5):
        kept(library)
        with library.write() as tx:
            there = [listed.uuid for listed in tx.columns.documents()]
            if deleted and random.random() < 0.3:
                restore_document(tx, tx.documents.get(deleted.pop(), deleted=True))
            elif random.random() < 0.5:
                deleted.append(random.choice(there))
                delete_document(tx, tx.documents.get(deleted[-1]))
            else:
                stored = tx.documents.get(random.choice(there))
                if stored.frames > 1:
                    delete_frames(tx, stored, 1, 1, renumber=False)
                    tx.documents.add_revision(stored, "frames")
    kept(library)


def test_parts_that_were_changed_are_made_again(library: Database) -> None:
    path, wanted = kept(library), expected(library)
    random = Random(1)
    for held, name in rows(path):
        with closing(sqlite3.connect(path)) as connection:
            (data,) = connection.execute("SELECT data FROM part WHERE held = ? AND name = ?", (held, name)).fetchone()
            place = random.randrange(len(data))
            wrong = data[:place] + bytes([data[place] ^ (1 << random.randrange(8))]) + data[place + 1 :]
            wrong = random.choice([wrong, data[:place], data + b"\0", str(place), b""])
            connection.execute("UPDATE part SET data = ? WHERE held = ? AND name = ?", (wrong, held, name))
            connection.commit()
    with asking(library) as engine:
        assert answers(engine) == wanted
    assert kept(library) == path


def test_a_part_under_the_name_of_another_is_not_believed(library: Database) -> None:
    path, wanted = kept(library), expected(library)
    with closing(sqlite3.connect(path)) as connection:
        held = [row[0] for row in connection.execute("SELECT DISTINCT held FROM part WHERE held != x'' ORDER BY 1")]
        for one, other in ((held[0], b"?"), (held[1], held[0]), (b"?", held[1])):
            connection.execute("UPDATE part SET held = ? WHERE held = ?", (other, one))
        connection.commit()
    with asking(library) as engine:
        assert answers(engine) == wanted


@pytest.mark.parametrize("seed", fuzz.share(range(12), 3))
def test_a_broken_file_is_thrown_away(library: Database, seed: int) -> None:
    path, wanted = kept(library), expected(library)
    random = Random(seed)
    data = bytearray(path.read_bytes())
    if seed < 3:
        data = data[: (0, 50, len(data) // 2)[seed]]
    elif seed == 3:
        data = bytearray(b"no database" * 1000)
    else:
        for _ in range(200):
            data[random.randrange(len(data) if seed % 2 else 40_000)] ^= 1 << random.randrange(8)
    path.write_bytes(data)
    with asking(library) as engine:
        assert answers(engine) == wanted
    assert expected(library) == wanted


def test_a_file_of_another_format_is_made_anew(library: Database) -> None:
    path = kept(library)
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA user_version = 999")
        connection.execute("DROP TABLE part")
    before = rows(kept(library))
    assert before


def test_without_a_folder_to_write_memory_serves(library: Database, tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with asking(library, str(tmp_path / "file" / "folder")) as engine:
        assert answers(engine) == expected(library)
        assert engine.caches.sidecar is not None
        engine.caches.sidecar.flush()
        assert engine.caches.sidecar.trouble
    place = path_of(library, str(tmp_path / "file" / "folder"))
    assert place is not None
    assert why_not(place)


def test_the_doctor_says_where_nothing_can_be_kept(
    library: Database, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "400")
    (tmp_path / "file").write_bytes(b"")
    cases = (("", "store.db-cache", 0), ("none", "memory only", 0), (str(tmp_path / "file" / "x"), "LACK", 1))
    for folder, said, code in cases:
        monkeypatch.setenv("MCML_CACHE_DIR", folder)
        done = CliRunner().invoke(app, ["doctor", "--database", library.url])
        assert said in done.output
        assert done.exit_code == code


def test_two_engines_at_once(library: Database) -> None:
    wanted = expected(library)
    with asking(library) as one, asking(library) as other:
        for engine in (one, other, one):
            assert answers(engine) == wanted


@pytest.mark.slow
def test_a_killed_writer_leaves_nothing_wrong(library: Database, tmp_path: Path) -> None:
    wanted = expected(library)
    program = (
        "import os, sys\n"
        "from mcml_service.xpath.library import groups\n"
        "from mcml_service.xpath.library.disk import writer\n"
        "from tests.xpath import test_sidecar as t\n"
        "groups.DOCUMENTS, groups.MOST_DOCUMENTS, groups.LASTING = 12, 30, 1\n"
        "make_room = writer.Writer._make_room\n"
        "writer.Writer._make_room = lambda self, connection: os._exit(9)\n"
        "database = t.Database(sys.argv[1])\n"
        "with t.asking(database) as engine: t.answers(engine)\n"
    )
    done = subprocess.run([sys.executable, "-c", program, library.url], cwd=Path(__file__).parents[2], check=False)
    assert done.returncode == 9
    assert (tmp_path / "store.db-cache").exists()
    assert rows(tmp_path / "store.db-cache") == []
    with asking(library) as engine:
        assert answers(engine) == wanted


def test_the_limit_is_kept_and_what_was_used_stays(library: Database) -> None:
    path = kept(library)
    with closing(sqlite3.connect(path)) as connection:
        (total,) = connection.execute("SELECT SUM(size) FROM part").fetchone()
        connection.execute("UPDATE part SET used = 0 WHERE name != 'shapes'")
        connection.commit()
    with asking(library) as engine:
        assert engine.caches.sidecar is not None
        engine.caches.sidecar._writer._limit = total // 2
        with library.write() as tx:
            delete_document(tx, tx.documents.get(tx.columns.documents()[0].uuid))
        answers(engine)
    with closing(sqlite3.connect(path)) as connection:
        assert connection.execute("SELECT SUM(size) FROM part").fetchone()[0] <= total // 2


def test_another_store_of_the_same_name_is_not_confused(tmp_path: Path) -> None:
    path = tmp_path / "store.db"
    for first in (0, 100):
        database = filled(path, first)
        kept(database)
        database.close()
        for each in tmp_path.glob("store.db*"):
            if not each.name.startswith("store.db-cache"):
                each.unlink()


@pytest.mark.slow
def test_a_copy_that_went_another_way_is_not_confused(library: Database, tmp_path: Path) -> None:
    """Both have the same documents at the same revisions."""
    copy = tmp_path / "copy.db"
    backup(library, copy)
    for at in (1, 2):
        with library.write() as tx:
            stored = next(tx.documents.get(one.uuid) for one in tx.columns.documents() if one.frames > 3)
            delete_frames(tx, stored, at, 2, renumber=False)
            tx.documents.add_revision(stored, "frames")
        kept(library)
        library.close()
        for ending in ("", "-wal", "-shm"):
            (tmp_path / f"store.db{ending}").unlink(missing_ok=True)
        os.rename(copy, tmp_path / "store.db")
        copy.unlink(missing_ok=True)
        library = Database(library.url)
        backup(library, copy)
    kept(library)
    library.close()


def test_nothing_of_a_purged_document_stays(library: Database) -> None:
    path = kept(library)
    before = set(rows(path))
    with library.read() as tx:
        gone = tx.columns.documents()[3].uuid
    with asking(library) as running:
        answers(running)
        purge_documents(library, [gone])
        wanted = expected(library)
        assert answers(running) == wanted
    assert not before & set(rows(path))
    assert gone.encode() not in path.read_bytes()
    with asking(library) as engine:
        assert answers(engine) == wanted
