"""`mcml doctor` lists documents that would be read otherwise today, each with what mends it."""

from __future__ import annotations

from pathlib import Path

import pytest
from sqlalchemy import text
from typer.testing import CliRunner

from mcml_service.actions.keeping.find_differing import Differing, look_for_differing
from mcml_service.cli import app, differing
from mcml_service.storage.database import Database
from tests.builders import bvh, c3d_file, one_kind, store
from tests.c3d_writer import c3d_bytes
from tests.formats.test_bvh_translation import LYING, row
from tests.formats.test_bvh_translation import bvh as posed
from tests.formats.test_c3d_quantities import LABELS, POINTS, TYPED
from tests.odd_documents import ODD


def found_in(database: Database, project: str | None = None) -> list[Differing]:
    return [item for one in look_for_differing(database, project, lambda: True) for item in one.found]


def doctor(database: Database, *words: str) -> str:
    return CliRunner().invoke(app, ["doctor", "--database", database.url, *words]).output.replace("\n     ", " ")


def added(database: Database, name: str) -> str:
    """A document of which a program before added the positions to the OFFSET."""
    rows = [row("0 15 0", turned=LYING)] * 300
    return store(database, {f"{name}.bvh": posed("0 90 0", rows)}, translation="relative", project=name)[0]


def measured(database: Database, monkeypatch: pytest.MonkeyPatch) -> str:
    """A document of which a program before took angles and the like as markers."""
    with monkeypatch.context() as patch:
        patch.setattr("mcml.formats.c3d.format.quantities_of", lambda said, labels: {})
        return store(database, {"lab.c3d": c3d_bytes(POINTS, labels=LABELS, parameters=TYPED)}, project="lab")[0]


def renamed(database: Database) -> str:
    """A document whose project calls a joint otherwise since."""
    uuid = store(database, {"tail.bvh": bvh(400, names=("Hips", "Tail"))}, project="zoo")[0]
    with database.write() as tx:
        tx.aliases.put("zoo", (("Tail", "tail_base"),), "kim")
    return uuid


def test_each_kind_is_found_with_what_mends_it(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    sound = {"a.bvh": bvh(300), "b.bvh": posed("0 90 0", [row("5 89 -161")] * 9), "n.bvh": bvh(0)}
    sound["c.c3d"] = c3d_file(up="+Z")
    store(database, sound)
    assert found_in(database) == []
    lying, lab, tail = added(database, "lying"), measured(database, monkeypatch), renamed(database)
    by_id = {one.id: one for one in found_in(database)}
    assert set(by_id) == {lying, lab, tail}
    assert "Hips absolute" in by_id[lying].what
    assert f"mcml export {lying} --format bvh" in by_id[lying].remedy
    assert "LKneeAngles" in by_id[lab].what
    assert "LKneePower" in by_id[lab].what
    assert "Tail -> tail_base" in by_id[tail].what
    assert by_id[tail].remedy == f"mcml names apply {tail}"
    told = doctor(database)
    assert all(one.what in told and one.remedy in told for one in by_id.values())
    assert "of 7 documents 3 would differ today" in told
    alone = doctor(database, "--project", "lab")
    assert "of 1 documents 1 would differ today" in alone
    assert lying not in alone
    # What mends it, does.
    assert CliRunner().invoke(app, ["names", "apply", tail, "--database", database.url]).exit_code == 0
    assert {one.id for one in found_in(database)} == {lying, lab}


@one_kind
def test_up_that_was_guessed_otherwise(database: Database, shared: Path) -> None:
    uuid = store(database, {"walk.trc": (shared / "trc/std_walking2_markers.trc").read_bytes()})[0]
    (found,) = found_in(database)
    assert (found.what, found.remedy) == ("up was X, and is guessed as Z", f"mcml calibrate {uuid} --up Z")
    done = CliRunner().invoke(app, [*found.remedy.split()[1:], "--database", database.url])
    assert done.exit_code == 0, done.output
    assert found_in(database) == []


@one_kind
def test_files_of_laboratories(database: Database, shared: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = {name: (shared / "lab" / name).read_bytes() for name in ("s4_am_gait04.c3d", "hc030a05.c3d")}
    with monkeypatch.context() as patch:
        patch.setattr("mcml.formats.c3d.format.quantities_of", lambda said, labels: {})
        before = store(database, files)
    told = {one.id for one in found_in(database) if "stored as markers" in one.what}
    assert told == set(before)
    store(database, files, project="again")
    assert [one for one in found_in(database, "again") if "stored as markers" in one.what] == []


@one_kind
def test_a_large_library_is_told_in_part(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    for number in range(4):
        added(database, f"lying {number}")
    monkeypatch.setattr(differing, "MOST_SHOWN", 2)
    told = doctor(database)
    assert told.count("positions would be read as") == 2
    assert "and 2 more" in told
    monkeypatch.setattr(differing, "SECONDS", 0.0)
    told = doctor(database)
    assert "of 0 documents 0 would differ today" in told
    assert "4 were not looked at" in told
    assert "--project NAME" in told


@one_kind
def test_a_damaged_document_hides_no_other(database: Database) -> None:
    first, second = added(database, "a"), added(database, "b")
    with database.write() as tx:
        key = tx.documents.get(first).key
        tx.connection.execute(text(f"UPDATE track SET count = count + 1 WHERE document = {key}"))
    looked = list(look_for_differing(database, None, lambda: True))
    assert [one.found[0].id for one in looked if one.found] == [second]
    assert [one.unread.partition(":")[0] for one in looked if one.unread] == [first]
    assert f"not looked at: {first}" in doctor(database)


@pytest.mark.slow
@one_kind
def test_odd_documents_stop_nothing(database: Database) -> None:
    for name, files in ODD.items():
        store(database, files, project=name)
    uuid = added(database, "lying")
    looked = list(look_for_differing(database, None, lambda: True))
    assert len(looked) == len(ODD) + 1
    assert [one.unread for one in looked if one.unread] == []
    assert uuid in {item.id for one in looked for item in one.found}
