"""Many files in one call: their documents share transactions, and each is still whole or absent, in order."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcml.errors import ConflictError
from mcml.files.import_options import ImportOptions
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.importing.import_batch import BATCH_CLIPS, EARLY_CLIPS, ImportResult
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.documents.documents import Documents
from mcml_service.storage.lists.filtering import DocumentFilter
from mcml_service.storage.transaction import Transaction
from tests import fuzz
from tests.actions.test_kill import run
from tests.builders import ASF, bvh, read_by, source

FILES = {f"clip{number:02}.bvh": bvh(4, seed=number) for number in range(BATCH_CLIPS + 4)}


@pytest.fixture(params=[1, 2], autouse=True)
def processes(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    read_by(monkeypatch, request.param)


def together(database: Database, files: dict[str, bytes], on_duplicate: str = "new") -> ImportResult:
    sources = [source(name, content) for name, content in files.items()]
    return import_files(database, sources, ImportOptions(on_duplicate=on_duplicate), Settings())


def stored(tx: Transaction) -> dict[str, bytes]:
    found = tx.documents.page(DocumentFilter(), after=None, limit=1000)
    exports = {item.name: export_document(tx, item, ExportOptions("bvh", original=True)) for item in found}
    return {f"{name}.bvh": b"".join(export.content) for name, export in exports.items()}


def test_documents_come_in_the_order_of_their_files_around_a_bad_one(database: Database) -> None:
    names = list(FILES)
    result = together(database, FILES | {names[3]: b"HIERARCHY\nROOT", "leg.asf": ASF})
    kept = [name for name in names if name != names[3]]
    assert [item.name for item in result.documents] == [*(name[:-4] for name in kept), "leg"]
    assert [name for name, _ in result.problems] == [names[3]]
    assert database.check() == []


def test_few_commits_hold_many_documents(database: Database) -> None:
    together(database, FILES)
    with database.read() as tx:
        # Where few are to come, fewer are enough for a commit, down to one.
        assert tx.newest_commit() <= len(FILES) // EARLY_CLIPS + EARLY_CLIPS.bit_length()
        assert stored(tx) == FILES


@pytest.mark.parametrize("on_duplicate", ["new", "skip"])
def test_equal_files_of_one_call_know_each_other_and_are_kept_once(database: Database, on_duplicate: str) -> None:
    content = bvh(4)
    first, other, again = together(
        database, {"a.bvh": content, "b.bvh": bvh(4, seed=1), "c.bvh": content}, on_duplicate
    ).documents
    assert (again.skipped, again.uuid == first.uuid) == (on_duplicate == "skip", on_duplicate == "skip")
    assert (first.receipt["twins"], other.receipt["twins"]) == ([], [])
    assert again.receipt["twins"] == ([] if on_duplicate == "skip" else [first.uuid])
    with database.read() as tx:
        kept = {tx.uploads.find(item.sha256, item.size) for key in (1, 2, 3) for item in tx.uploads.of(key)}
        assert len(kept) == 2
    assert database.check() == []


def test_one_that_cannot_be_stored_takes_none_with_it(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    publish = Documents.publish

    def refused(self: Documents, *about: object, message: str, **rest: object) -> None:
        if message == "clip02.bvh":
            raise ConflictError("Another write came in between.")
        publish(self, *about, message=message, **rest)  # type: ignore[arg-type]

    monkeypatch.setattr(Documents, "publish", refused)
    result = together(database, FILES)
    assert [name for name, _ in result.problems] == ["clip02.bvh"]
    with database.read() as tx:
        assert stored(tx) == {name: content for name, content in FILES.items() if name != "clip02.bvh"}
    assert database.check() == []


def test_what_was_read_before_the_import_was_stopped_is_stored(database: Database) -> None:
    def stop(name: str, *_: object) -> None:
        if name == "clip02.bvh":
            raise KeyboardInterrupt

    sources = [source(name, content) for name, content in FILES.items()]
    with pytest.raises(KeyboardInterrupt):
        import_files(database, sources, ImportOptions(), Settings(), progress=stop)
    with database.read() as tx:
        assert sorted(stored(tx)) == ["clip00.bvh", "clip01.bvh"]


@pytest.mark.slow
@pytest.mark.parametrize("processes", [2], indirect=True)
@pytest.mark.parametrize("point", fuzz.share([20, 5, 60, 40], 2))
def test_killed_among_them_leaves_each_whole_or_absent(
    database: Database, database_url: str, tmp_path: Path, point: int
) -> None:
    folder = tmp_path / "clips"
    folder.mkdir()
    for name, content in FILES.items():
        (folder / name).write_bytes(content)
    assert run(database_url, folder, point).returncode == -9
    with database.read() as tx:
        assert stored(tx).items() <= FILES.items()
    assert database.check() == []
    assert [item.name for item in together(database, FILES, "skip").documents] == [name[:-4] for name in FILES]
