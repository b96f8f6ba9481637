"""Room that is given back: history forgotten, pages freed, a reserve for full disks."""

from __future__ import annotations

import sqlite3
import stat
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mcml.errors import ConflictError, NotFoundError, SpaceError
from mcml_service.actions.editing.single_element import Change
from mcml_service.actions.editing.whole_document import restore_revision, undo_revision
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.keeping.check_uploads import compare_all
from mcml_service.actions.keeping.keep_room import compact_store, prune_history
from mcml_service.actions.keeping.keep_store import backup
from mcml_service.actions.keeping.purge_documents import purge_documents
from mcml_service.cli import app
from mcml_service.settings import Settings
from mcml_service.storage.core.reserve import Reserve
from mcml_service.storage.database import Database
from tests.builders import bvh, store
from tests.edits import change_element


def content(database: Database, uuid: str, revision: int | None = None) -> bytes:
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        then = tx if revision is None else tx.at_commit(tx.documents.commit_of(stored.key, revision))
        return b"".join(export_document(then, then.documents.get(uuid), ExportOptions("mcml", original=False)).content)


def edited(database: Database, uuid: str, times: int) -> None:
    for number in range(times):
        with database.write() as tx:
            place = f"/mcml/motion/frame[{number + 1}]/frame_bone[2]"
            change_element(tx, tx.documents.get(uuid), place, Change({"Rx": str(number)}))


def test_history_is_forgotten_and_what_is_there_stays(database: Database) -> None:
    uuid = store(database, {"a.bvh": bvh(300)})[0]
    other = store(database, {"b.bvh": bvh(3, seed=2)})[0]
    edited(database, uuid, 4)
    now, untouched = content(database, uuid), content(database, other)
    shown = prune_history(database, 0, do=False)
    assert (shown.documents, shown.revisions) == (1, 4)
    assert content(database, uuid, 1) != now
    assert prune_history(database, 0, do=True) == shown
    assert prune_history(database, 0, do=True).documents == 0
    assert database.check(past=True) == []
    assert (content(database, uuid), content(database, other)) == (now, untouched)
    with pytest.raises(NotFoundError, match="Revision 2 was pruned: those from 5 on are kept"):
        content(database, uuid, 2)
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        assert [revision.number for revision in tx.revisions.of(stored.key)] == [5]
        assert tx.uploads.of(stored.key) == []
        unread = {found.name.split()[0]: found.unread for found in compare_all(tx, Settings())}
    assert "pruned" in (unread["a"] or "")
    assert unread["b"] is None
    with pytest.raises(ConflictError, match="Nothing before"), database.write() as tx:
        undo_revision(tx, tx.documents.get(uuid), 5)
    edited(database, uuid, 1)
    with database.write() as tx:
        restore_revision(tx, tx.documents.get(uuid), 5)
    assert content(database, uuid) == now
    assert database.check(past=True) == []


def test_history_of_late_is_kept(database: Database) -> None:
    uuid = store(database, {"a.bvh": bvh(30)})[0]
    edited(database, uuid, 2)
    assert prune_history(database, 1, do=True).documents == 0
    assert content(database, uuid, 1)


def test_room_is_given_back_in_steps(database: Database) -> None:
    ids = [store(database, {f"{n}.bvh": bvh(4000, seed=n)})[0] for n in range(3)]
    before = content(database, ids[0])
    size = database.size()["total"]
    purge_documents(database, ids[1:])
    left: list[int] = []
    freed = compact_store(database, left.append)
    assert left
    if database.name == "sqlite":
        assert freed > size / 3
        assert len(left) <= freed // (1000 * 8192) + 1
        assert not database.dialect.compaction().stops_writers
        assert database.dialect.compaction().bytes == 0
    assert content(database, ids[0]) == before
    assert database.check(past=True) == []


def test_a_store_of_before_says_what_it_needs(tmp_path: Path) -> None:
    path = tmp_path / "store.db"
    with sqlite3.connect(path) as old:
        old.execute("PRAGMA journal_mode=WAL")
        old.execute("CREATE TABLE first (a)")
        old.execute("DROP TABLE first")
    old.close()
    url = f"sqlite:///{path}"
    database = Database(url)
    database.migrate()
    store(database, {"a.bvh": bvh(300)})
    runner = CliRunner()
    refused = runner.invoke(app, ["db", "compact", "--database", url])
    assert refused.exit_code == 1
    assert "writers wait" in str(refused.exception)
    assert runner.invoke(app, ["db", "compact", "--yes", "--database", url]).exit_code == 0
    assert not database.dialect.compaction().stops_writers
    assert database.check() == []
    database.close()


def test_commands_show_what_a_prune_would_free(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'store.db'}"
    database = Database(url)
    database.migrate()
    uuid = store(database, {"a.bvh": bvh(300)})[0]
    edited(database, uuid, 2)
    shown = CliRunner().invoke(app, ["db", "prune", "--older-than", "0", "--database", url])
    assert "would forget 2 revisions of 1 documents" in shown.output
    assert content(database, uuid, 1)
    database.close()


def test_files_are_their_owners_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    monkeypatch.delenv("MCML_DATABASE", raising=False)
    assert CliRunner().invoke(app, ["ls"]).exit_code == 0
    folder = tmp_path / "mcml"
    made = Database(f"sqlite:///{folder / 'mcml.db'}")
    uuid = store(made, {"a.bvh": bvh(3)})[0]
    backup(made, tmp_path / "copy.db")
    made.reserve.keep()
    modes = {path.name: stat.S_IMODE(path.stat().st_mode) for path in (folder, tmp_path / "copy.db", *folder.iterdir())}
    assert modes.pop("mcml") == 0o700
    assert set(modes.values()) == {0o600}
    assert {"mcml.db", "mcml.db-wal", "mcml.db.reserve", "copy.db"} <= set(modes)
    made.close()
    (folder / "mcml.db").chmod(0o644)
    again = Database(f"sqlite:///{folder / 'mcml.db'}")
    assert content(again, uuid)
    assert stat.S_IMODE((folder / "mcml.db").stat().st_mode) == 0o600
    again.close()


def test_a_full_disk_spends_the_reserve(tmp_path: Path) -> None:
    reserve = Reserve(tmp_path / "store.db")
    spare = tmp_path / "store.db.reserve"
    asked: list[bool] = []

    def delete() -> str:
        asked.append(spare.exists())
        if spare.exists():
            raise SpaceError
        return "done"

    reserve.keep()
    assert spare.stat().st_size == 16 << 20
    assert reserve.spend(delete) == "done"
    assert asked == [True, False]
    with pytest.raises(SpaceError):
        reserve.spend(lambda: (_ for _ in ()).throw(SpaceError()))
    reserve.keep()
    assert spare.exists()


def test_other_connections_keep_their_locks(tmp_path: Path) -> None:
    """To open and close a store's file beside SQLite lets go of its locks, and another process believes it alone."""
    path = tmp_path / "store.db"
    database = Database(f"sqlite:///{path}")
    database.migrate()
    with database.write() as tx:
        tx.projects.get_or_add("lab")
        other = Database(f"sqlite:///{path}")
        with other.read() as seen:
            assert seen.projects.find("lab") is None
        said = subprocess.run(
            [
                sys.executable,
                "-c",
                f"import sqlite3; sqlite3.connect({str(path)!r}, timeout=0).execute('BEGIN IMMEDIATE')",
            ],
            capture_output=True,
            text=True,
            check=False,
        )
        assert "locked" in said.stderr
        other.close()
    assert (tmp_path / "store.db-wal").exists()
    database.close()
