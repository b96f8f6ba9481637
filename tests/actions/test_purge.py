"""Documents removed for good: nothing of them stays, nothing of others goes, and a kill in between spoils nothing."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import BaseModel
from typer.testing import CliRunner

from mcml.errors import ConflictError, NotFoundError
from mcml_schemas.querying.queries import QueryRequest
from mcml_service.actions.analysing.use_result import Results
from mcml_service.actions.editing.whole_document import add_labels, delete_document
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.keeping.keep_room import prune_history
from mcml_service.actions.keeping.keep_store import backup, restore
from mcml_service.actions.keeping.purge_documents import finish_purges, purge_documents, purgeable
from mcml_service.analysis.catalogue import ANALYSES
from mcml_service.analysis.interface import Answer
from mcml_service.cli import app
from mcml_service.settings import Settings
from mcml_service.storage.core.schema import metadata
from mcml_service.storage.core.tables import document
from mcml_service.storage.database import Database
from mcml_service.xpath.queries import Queries
from tests.builders import MCML, bvh, store

NAME = "somebody-private"


def content(database: Database, uuid: str) -> bytes:
    with database.read() as tx:
        return b"".join(export_document(tx, tx.documents.get(uuid), ExportOptions("mcml")).content)


def texts(database: Database) -> str:
    """Every text and number of the store."""
    with database.read() as tx:
        return repr([tuple(row) for table in metadata.sorted_tables for row in tx.connection.execute(table.select())])


def rows_of(database: Database, key: int) -> int:
    with database.read() as tx:
        found = 0
        for table in metadata.sorted_tables:
            column = table.c.id if table is document else table.c.get("document")
            if column is not None:
                found += len(tx.connection.execute(table.select().where(column == key)).all())
        return found


def key_of(database: Database, uuid: str) -> int:
    with database.read() as tx:
        return tx.documents.get(uuid, deleted=True).key


def result(database: Database, name: str, inputs: list[str], clip: int | None = None) -> str:
    with database.write() as tx:
        project = tx.projects.get("default")
        listed = [{"document": uuid, "revision": 1} for uuid in inputs]
        key, uuid = tx.results.add(project, "reach", name, "kim", listed, {}, {})
        tx.results.add_part(key, "points", "points", {"a": 1}, {"all": np.arange(9.0)}, clip)
        return uuid


@pytest.mark.slow
def test_nothing_stays_and_nothing_else_goes(database: Database, tmp_path: Path) -> None:
    twin = store(database, {"twin.bvh": bvh(700)})[0]
    gone = store(database, {f"{NAME}.bvh": bvh(700)})[0]
    alone = store(database, {f"{NAME}-2.mcml": MCML})[0]
    other = store(database, {"other.bvh": bvh(20, seed=4, names=("Hips", "Chest"))})[0]
    with database.write() as tx:
        add_labels(tx, tx.documents.get(gone), [(NAME, 1, 300)])
    with database.write() as tx:
        delete_document(tx, tx.documents.get(other))
    result(database, NAME, [gone])
    shared = result(database, "shared", [twin, gone], key_of(database, gone))
    before, kept = content(database, twin), original(database, twin)
    keys = [key_of(database, uuid) for uuid in (gone, alone)]

    found = {one.uuid: one for one in purgeable(database, [gone, alone])}
    assert found[gone].own_results == 1
    assert found[gone].results == ((shared, "shared"),)
    assert found[gone].bytes > 0
    assert purge_documents(database, [gone, alone]) == 2

    assert [rows_of(database, key) for key in keys] == [0, 0]
    assert NAME not in texts(database)
    assert database.check(past=True) == []
    assert (content(database, twin), original(database, twin)) == (before, kept)
    with database.read() as tx:
        assert tx.documents.find(other, deleted=True) is not None
        assert [part.document for part in tx.results.parts(tx.results.get(shared).key)] == [None]
        with pytest.raises(NotFoundError):
            tx.documents.get(gone, deleted=True)
    backup(database, tmp_path / "copy.db")
    assert NAME.encode() not in (tmp_path / "copy.db").read_bytes()
    if database.name == "sqlite":
        path = Path(database.url.removeprefix("sqlite:///"))
        held = b"".join(part.read_bytes() for part in path.parent.glob(f"{path.name}*"))
        assert NAME.encode() not in held


def original(database: Database, uuid: str) -> bytes:
    with database.read() as tx:
        return b"".join(tx.uploads.read(tx.documents.get(uuid).key, "bvh") or ())


def test_a_purge_that_is_killed_goes_on(database: Database) -> None:
    uuid = store(database, {"a.bvh": bvh(256 * 40)})[0]
    other = store(database, {"b.bvh": bvh(30, seed=2)})[0]
    key = key_of(database, uuid)
    with database.write() as tx:
        tx.purging.begin(tx.documents.get(uuid))
    with database.write() as tx:
        assert tx.purging.remove_tracks(key)
    # Nobody sees it, and what is left of it is no fault.
    assert database.check(past=True) == []
    with database.read() as tx:
        assert tx.documents.find(uuid, deleted=True) is None
    assert content(database, other)
    assert finish_purges(database) == 1
    assert rows_of(database, key) == 0
    assert finish_purges(database) == 0


def test_deleted_ones_by_their_age(database: Database) -> None:
    ids = [store(database, {f"{name}.bvh": bvh(3)})[0] for name in "ab"]
    with database.write() as tx:
        delete_document(tx, tx.documents.get(ids[0]))
    assert [one.uuid for one in purgeable(database, [], 0)] == [ids[0]]
    assert purgeable(database, [], 1) == []
    with pytest.raises(NotFoundError, match="There is no document"):
        purgeable(database, [ids[0][:8]])


def test_the_command_shows_before_it_does(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'store.db'}"
    database = Database(url)
    database.migrate()
    uuid = store(database, {"a[red].bvh": bvh(3)})[0]
    runner = CliRunner()
    shown = runner.invoke(app, ["purge", uuid, "--database", url])
    assert shown.exit_code == 0
    assert "a[red]" in shown.output
    assert "--yes does it" in shown.output
    assert content(database, uuid)
    done = runner.invoke(app, ["purge", uuid, "--yes", "--json", "--database", url])
    assert json.loads(done.output)["purged"] == 1
    with pytest.raises(NotFoundError):
        content(database, uuid)
    database.close()


ASKED = (
    "count(//frame)", "sum(//@Rx)", "//bone/name", "//frame_bone[@Rx > 3]/@Rx", "//source", "//frame[2]",
    f"sum(//frame[motion_name='{NAME}']/frame_bone/@Rx)",
)  # fmt: skip


def answers(engine: Queries) -> list[tuple[object, object]]:
    found = [engine.answer(QueryRequest(q=text, limit=1000)) for text in ASKED]
    return [(answer.value, answer.items) for answer in found]


def read_anew(database: Database) -> list[tuple[object, object]]:
    """The same by a server that has just been started."""
    engine = Queries(database, Settings())
    try:
        return answers(engine)
    finally:
        engine.close()


def test_a_server_that_runs_keeps_nothing_of_it(database: Database) -> None:
    """What it holds in memory is of documents that exist, also where later ones come in the place of those."""
    running, elsewhere = Queries(database, Settings()), Database(database.url)
    store(database, {"other.bvh": bvh(30)})
    for seed in range(1, 4):
        gone = store(database, {f"{NAME}.bvh": bvh(300, seed=seed, names=("Hips", f"joint-{seed}"))})[0]
        with database.write() as tx:
            add_labels(tx, tx.documents.get(gone), [(NAME, 1, 300)])
        assert answers(running) == read_anew(database)
        purge_documents(elsewhere, [gone])
        assert answers(running) == read_anew(database)
    running.close()
    elsewhere.close()


@pytest.mark.parametrize("how", ["purge", "prune"])
def test_pages_of_what_is_gone_are_refused(database: Database, how: str) -> None:
    """The next one would leave out as many items as went, and say nothing."""
    engine = Queries(database, Settings())
    ids = [store(database, {f"{name}.bvh": bvh(30)})[0] for name in "ab"]
    request = QueryRequest(q="//frame/@id", limit=20)
    pages = [engine.answer(request).next_cursor]
    with database.write() as tx:
        add_labels(tx, tx.documents.get(ids[0]), [("walk", 1, 5)])
    pages.append(engine.answer(request).next_cursor)
    shown = engine.stream(request.model_copy(update={"limit": None})).shown(lambda forest, nodes: len(nodes))  # type: ignore[union-attr]
    if how == "purge":
        purge_documents(database, ids[1:])
    else:
        assert prune_history(database, 0, do=True).documents == 1
    for cursor in pages:
        with pytest.raises(NotFoundError, match="purged or pruned"):
            engine.answer(request.model_copy(update={"cursor": cursor}))
    with pytest.raises(NotFoundError, match="purged or pruned"):
        next(shown)
    if how == "purge":
        # What is asked from now on has all its pages, of earlier revisions too.
        request = request.model_copy(update={"document": ids[:1], "revision": 1})
    cursor = engine.answer(request).next_cursor
    assert len(engine.answer(request.model_copy(update={"cursor": cursor})).items or []) == (
        10 if how == "purge" else 20
    )
    engine.close()


def test_a_store_that_held_documents_is_not_filled_again(database: Database, tmp_path: Path) -> None:
    """What servers keep under the keys of those would be taken for what the backup holds."""
    uuid = store(database, {"a.bvh": bvh(3)})[0]
    backup(database, tmp_path / "copy.db")
    purge_documents(database, [uuid])
    with pytest.raises(ConflictError, match="The store is not empty"):
        restore(database, tmp_path / "copy.db")


class Nothing(BaseModel):
    """No parameters."""


def test_a_model_of_it_is_used_no_more(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    said = SimpleNamespace(parameters=Nothing, run=lambda _, wish: Answer(wish))
    analysis = SimpleNamespace(prepare=lambda _: True, operations={"say": said})
    monkeypatch.setitem(ANALYSES, "reach", analysis)
    uuid = store(database, {"a.bvh": bvh(3)})[0]
    made, running = result(database, "model", [uuid]), Results(database, Settings())
    assert running.use(made, "say", {}, author="kim").answer.value == Nothing()
    elsewhere = Database(database.url)
    purge_documents(elsewhere, [uuid])
    elsewhere.close()
    with pytest.raises(NotFoundError):
        running.use(made, "say", {}, author="kim")


def test_no_key_is_given_again(database: Database) -> None:
    keys = []
    for seed in range(3):
        uuid = store(database, {"a.bvh": bvh(3, seed=seed, names=("Hips", f"joint-{seed}"))})[0]
        with database.read() as tx:
            stored = tx.documents.get(uuid)
            keys.append((stored.key, stored.skeleton))
        purge_documents(database, [uuid])
    assert len({key for key, _ in keys}) == len({skeleton for _, skeleton in keys}) == 3
