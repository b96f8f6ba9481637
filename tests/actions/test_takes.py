"""Files that hold several motions: one document each, of one skeleton and one kept file."""

from __future__ import annotations

from pathlib import Path

import pytest
from sqlalchemy import func, select
from sqlalchemy.sql import FromClause

from mcml.errors import ConversionError, FormatError, NotFoundError
from mcml.files.motion import convert, read
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.keeping.check_uploads import compare_all
from mcml_service.settings import Settings
from mcml_service.storage.core.tables import skeleton, upload
from mcml_service.storage.database import Database
from tests.builders import MCML, one_kind, read_by, store
from tests.formats.readers.fbx_text import fbx_text
from tests.formats.readers.posing import npz

DATA = fbx_text(("Walk", "Run"))


def count_rows(database: Database, table: FromClause) -> int:
    with database.read() as tx:
        return int(tx.fetch_value(select(func.count()).select_from(table)) or 0)


def export(database: Database, uuid: str, form: str) -> tuple[str, bytes]:
    with database.read() as tx:
        found = export_document(tx, tx.documents.get(uuid), ExportOptions(form))
        return found.file_name, b"".join(found.content)


def test_each_take_is_a_document_of_one_skeleton_and_one_file(database: Database) -> None:
    uuids = store(database, {"a.fbx": DATA})
    with database.read() as tx:
        assert [tx.documents.get(uuid).name for uuid in uuids] == ["a#Walk", "a#Run"]
    assert count_rows(database, skeleton) == 1
    assert count_rows(database, upload) == 1
    assert [export(database, uuid, "original") for uuid in uuids] == [("a.fbx", DATA)] * 2
    assert export(database, uuids[0], "bvh") != export(database, uuids[1], "bvh")
    # The same files again, under another name: each take is its own twin.
    assert store(database, {"b.fbx": DATA}, on_duplicate="skip") == uuids


@one_kind
def test_a_take_is_chosen_by_its_name(database: Database) -> None:
    uuids = store(database, {"a.fbx": DATA}, take="Run", name="sprint")
    with database.read() as tx:
        assert [tx.documents.get(uuid).name for uuid in uuids] == ["sprint"]
    with pytest.raises(NotFoundError, match="no take 'Jump'"):
        store(database, {"a.fbx": DATA}, take="Jump")


@one_kind
def test_kept_files_are_compared_with_their_take_and_rate(database: Database) -> None:
    store(database, {"a.fbx": DATA})
    store(database, {"b.fbx": fbx_text()}, rate=47.3)
    with database.read() as tx:
        compared = list(compare_all(tx, Settings()))
    assert len(compared) == 3
    assert not any(each.faults or each.unread for each in compared)


@one_kind
def test_workers_read_takes_as_the_importer_does(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    read_by(monkeypatch, 2)
    files = {f"{number}.fbx": fbx_text(("Walk", "Run"), frames=5 + number) for number in range(5)}
    uuids = store(database, files)
    assert len(uuids) == 10
    with database.read() as tx:
        assert [tx.documents.get(uuid).frames for uuid in uuids] == [5, 5, 6, 6, 7, 7, 8, 8, 9, 9]
        assert tx.documents.get(uuids[3]).name == "1#Run"


@one_kind
def test_a_document_without_an_upload_has_no_original(database: Database) -> None:
    uuid = store(database, {"a.mcml": MCML})[0]
    with pytest.raises(ConversionError, match="No uploaded file"):
        export(database, uuid, "original")


def test_the_library_asks_which_of_several(tmp_path: Path) -> None:
    path = tmp_path / "a.fbx"
    path.write_bytes(DATA)
    with pytest.raises(FormatError, match="hold 2 motions") as error:
        read(path)
    assert error.value.remedy == "Say which, with `take`: Walk, Run."
    run = read(path, take="Run")
    assert (len(run), run.frame_time) == (11, pytest.approx(1 / 30))
    assert len(read(path, take="Run", rate=60)) == 21
    assert convert(path, tmp_path / "run.bvh", take="Run")[0].read_bytes().startswith(b"HIERARCHY")


def test_properties_of_a_file_stand_beside_those_of_the_user(database: Database) -> None:
    import numpy as np

    data = npz(poses=np.zeros((3, 72)), trans=np.zeros((3, 3)), fps=30, gender="male")
    uuid = store(database, {"a.npz": data}, properties=(("age", "23", "year"),))[0]
    text = export(database, uuid, "mcml")[1]
    assert b"gender" in text
    assert b"age" in text
