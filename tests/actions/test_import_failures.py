"""An import that fails leaves nothing, and one that goes on is not swept."""

from __future__ import annotations

import pytest
from sqlalchemy import func, select

from mcml.errors import McmlError, NotFoundError
from mcml.files.import_options import ImportOptions
from mcml_service.actions.importing import import_clip, keep_upload
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.settings import Settings
from mcml_service.storage.core import tables
from mcml_service.storage.database import Database
from tests.builders import ASF, amc, bvh, source, store


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(import_clip, "FLUSH_BYTES", 2000)
    monkeypatch.setattr(keep_upload, "EARLY_BYTES", 0)


def rows(database: Database) -> dict[str, int]:
    with database.read() as tx:
        counted = {
            table.name: tx.connection.execute(select(func.count()).select_from(table)).scalar_one()
            for table in (tables.document, tables.track, tables.upload, tables.upload_block, tables.shape)
        }
    return {name: count for name, count in counted.items() if count}


def test_a_bad_last_block_leaves_nothing(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []
    flush = import_clip.Importer._flush
    monkeypatch.setattr(import_clip.Importer, "_flush", lambda self, tx: (seen.append(1), flush(self, tx))[1])
    with pytest.raises(McmlError):
        store(database, {"long.bvh": bvh(12_000)[:-30] + b"x\n"})
    assert seen, "nothing was flushed early, so the test shows nothing"
    assert rows(database) == {}


def test_a_failure_at_the_end_leaves_nothing(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError("No space left on device")

    monkeypatch.setattr("mcml_service.storage.documents.documents.Documents.publish", full)
    with pytest.raises(OSError, match="No space"):
        store(database, {"long.bvh": bvh(3000)})
    assert rows(database) == {}


def test_sweeping_leaves_running_imports_alone(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    prepare = import_clip.Importer._prepare

    def swept_meanwhile(self: import_clip.Importer, upload: keep_upload.Upload) -> None:
        prepare(self, upload)
        assert rows(database)["track"]
        assert database.sweep() == 0

    monkeypatch.setattr(import_clip.Importer, "_prepare", swept_meanwhile)
    store(database, {"long.bvh": bvh(3000)})
    assert database.check() == []


def test_an_import_whose_lease_ended_says_so(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    prepare = import_clip.Importer._prepare

    def swept_meanwhile(self: import_clip.Importer, upload: keep_upload.Upload) -> None:
        prepare(self, upload)
        assert database.sweep(lease_before=float("inf")) == 1

    monkeypatch.setattr(import_clip.Importer, "_prepare", swept_meanwhile)
    with pytest.raises(NotFoundError, match="swept"):
        store(database, {"long.bvh": bvh(3000)})
    assert rows(database) == {}


@pytest.mark.parametrize(
    ("files", "what", "remedy"),
    [
        ({}, "sent with it: none", "Send the .asf in the same request"),
        ({"a.asf": ASF, "b.asf": ASF}, "sent with it: a.asf, b.asf", "Give the .asf the name of its motion"),
        ({"leg.asf": b"bones\n"}, "sent with it: leg.asf, which cannot be read", "Mend the .asf"),
    ],
)
def test_the_remedy_for_a_motion_without_its_skeleton_is_one(
    database: Database, files: dict[str, bytes], what: str, remedy: str
) -> None:
    motion = amc().replace(b"#!OML:ASF leg.asf\n", b"")
    sent = [source(*item) for item in (*files.items(), ("walk.amc", motion))]
    done = import_files(database, sent, ImportOptions(), Settings())
    (error,) = [error for name, error in done.problems if name == "walk.amc"]
    assert what in error.what
    assert error.remedy is not None
    assert remedy in error.remedy
