"""Bodies that a server derives while it has nothing else to do."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Sequence
from random import Random

import pytest
from sqlalchemy import text

from mcml.errors import UnavailableError
from mcml_schemas.frames import FrameEdits
from mcml_service.actions.editing.frame_ranges import edit_frames
from mcml_service.actions.editing.whole_document import add_labels, change_document, delete_document
from mcml_service.api import traffic
from mcml_service.clips import derive, deriver
from mcml_service.clips.bodies import MADE, read_bodies
from mcml_service.clips.derive import derive_missing
from mcml_service.clips.deriver import Deriver
from mcml_service.clips.read_clip import Skeletons
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.documents.columns import Listed
from tests.builders import bvh, one_kind, served, store

NAMES = ("Hips", "LeftUpLeg", "LeftLeg", "LeftFoot")
CUT = {"edits": [{"do": "delete", "first": 1, "last": 5}]}
LONG = 30.0
"""Seconds that nothing here takes."""


def some(database: Database, count: int = 5) -> list[str]:
    return store(database, {f"{n}.bvh": bvh(20 + n, seed=n, names=NAMES) for n in range(count)})


def missing(database: Database) -> int:
    with database.read() as tx:
        return len(tx.bodies.without(MADE))


def until(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + LONG
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.fixture(autouse=True)
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deriver, "LOOK_SECONDS", 0.01)
    monkeypatch.setattr(deriver, "QUIET_SECONDS", 0.01)
    monkeypatch.setattr(traffic, "QUIET_SECONDS", 0.01)


def test_a_server_derives_what_comes_in(database: Database) -> None:
    some(database, 2)
    with served(database, Settings(derive=True)) as client:
        whole = '{body="kept"} 3\nmcml_documents{body="missing"} 0\n'
        form = [("file", ("late.bvh", bvh(9, seed=9, names=NAMES)))]
        stored = client.post("/api/v1/documents", files=form).json()["documents"][0]
        late, link = stored["id"], stored["calibration"]
        until(lambda: missing(database) == 0)
        assert whole in client.get("/metrics").text
        place = f"/api/v1/documents/{late}"
        assert client.get(link).json()["kept"]
        assert client.get(place).json()["links"]["calibration"] == link
        assert client.post(f"{place}/frames", json=CUT, headers={"if-match": "*"}).status_code == 200
        until(lambda: missing(database) == 0)
        assert client.get(f"{place}/calibration").json()["kept"]
    assert not [thread for thread in threading.enumerate() if thread.name == "mcml-derive"]
    assert database.check() == []


@one_kind
def test_a_server_may_be_told_not_to(database: Database) -> None:
    with served(database, Settings(derive=False)):
        assert not [thread for thread in threading.enumerate() if thread.name == "mcml-derive"]


@one_kind
def test_it_waits_for_others_and_ends_at_once(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deriver, "PATIENCE_SECONDS", LONG)
    some(database)
    asked = threading.Event()
    one = Deriver(database, lambda: asked.set() or True)  # type: ignore[func-returns-value]
    one.start()
    assert asked.wait(LONG)
    one.stop()
    assert not one._thread.is_alive()
    assert missing(database) == 5
    monkeypatch.setattr(deriver, "PATIENCE_SECONDS", 0.02)
    Deriver(database, lambda: True).derive()
    assert missing(database) == 0, "but not for ever"


def test_one_that_cannot_be_derived_stops_no_other(
    database: Database, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    uuids = some(database)
    with database.write("a") as tx:
        bad = tx.documents.get(uuids[1])
        tx.connection.execute(text(f"UPDATE track SET data_checksum = data_checksum + 1 WHERE document = {bad.key}"))
    asked: list[list[str]] = []
    whole = derive.derive_bodies

    def noted(tx: object, documents: Sequence[Listed], skeletons: Skeletons) -> object:
        asked.append([listed.uuid for listed in documents])
        return whole(tx, documents, skeletons)  # type: ignore[arg-type]

    monkeypatch.setattr(derive, "derive_bodies", noted)
    one = Deriver(database, lambda: False)
    with caplog.at_level(logging.WARNING, "mcml.derive"):
        one.derive()
        assert missing(database) == 1
        asked.clear()
        with database.write("a") as tx:
            add_labels(tx, tx.documents.get(uuids[0]), [("walk", 1, 2)])
        one.derive()
    assert asked == [], "it is not tried again"
    assert [uuids[1] in record.getMessage() for record in caplog.records] == [True]
    failed: list[str] = []
    assert derive_missing(database, lambda *_: None, lambda listed, _: failed.append(listed.uuid)) == 0
    assert failed == [uuids[1]]
    with database.write("a") as tx:
        change_document(tx, tx.documents.get(uuids[1]), name="again")
    one.derive()
    assert uuids[1] in asked[-1], "another revision may be sound"


@one_kind
def test_a_store_that_is_away_fails_no_document(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    some(database)
    monkeypatch.setattr(deriver, "LATER_SECONDS", 0.01)
    whole, away = Database.write, [True, True]

    def write(self: Database, author: str = "local") -> object:
        if author == derive.AUTHOR and away:
            away.pop()
            raise UnavailableError("away")
        return whole(self, author)

    monkeypatch.setattr(Database, "write", write)
    one = Deriver(database, lambda: False)
    one.start()
    until(lambda: missing(database) == 0)
    one.stop()
    assert away == []


def test_several_servers_do_no_harm(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deriver, "TOGETHER", 2)
    uuids = some(database, 9)
    others = [Deriver(database, lambda: False) for _ in range(3)]
    for one in others:
        one.start()
    with database.write("a") as tx:
        delete_document(tx, tx.documents.get(uuids[4]))
    until(lambda: missing(database) == 0)
    for one in others:
        one.stop()
    assert database.check() == []
    with database.read() as tx:
        kept = tx.connection.execute(text("SELECT document, block FROM body")).all()
        assert len(kept) == len(set(kept)) >= 8


def test_what_is_edited_meanwhile_has_the_body_of_its_revision(database: Database) -> None:
    (uuid,) = some(database, 1)

    def cut(done: int, of: int) -> None:
        if done < of:
            with database.write("a") as tx:
                edit_frames(tx, tx.documents.get(uuid), FrameEdits.model_validate(CUT))

    with database.read() as tx:
        before = read_bodies(tx, tx.columns.documents())
    derive_missing(database, cut)
    with database.read() as tx:
        at_first = tx.at_commit(tx.documents.commit_of(tx.documents.get(uuid).key, 1))
        past, now = (read_bodies(one, one.columns.documents()) for one in (at_first, tx))
    for key, body in before.items():
        assert (past[key].frames, now[key].frames) == (body.frames, body.frames - 5)
        assert past[key].blocks == body.blocks


def test_what_is_missing_is_known_without_reading_bodies(database: Database) -> None:
    random = Random(5)
    uuids = some(database, 6)
    for _ in range(12):
        with database.write("a") as tx:
            stored = tx.documents.get(random.choice(uuids))
            if random.random() < 0.5:
                add_labels(tx, stored, [("walk", 1, 2)])
            else:
                change_document(tx, stored, description=str(random.random()))
        if random.random() < 0.3:
            derive_missing(database, lambda *_: None)
        with database.read() as tx:
            documents = tx.columns.documents()
            assert sorted(tx.bodies.without(MADE)) == sorted(tx.bodies.missing(documents, MADE))
            assert sorted(tx.bodies.without(MADE + 1)) == sorted(listed.key for listed in documents)


@one_kind
def test_a_server_builds_the_columns_of_first_queries(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    """At its start, and after many documents changed; one document more is no reason."""
    built: list[tuple[str, int]] = []

    def build(stage: str, go_on: Callable[[], bool]) -> None:
        assert go_on()
        built.append((stage, missing(database)))

    one = Deriver(database, lambda: False, build)
    monkeypatch.setattr(deriver, "MANY", 3)
    one.derive()
    one.derive()
    assert built == [("columns", 0), ("bodies", 0)]
    some(database, 2)
    one.derive()
    assert len(built) == 2
    some(database, 3)
    one.derive()
    assert built[2:] == [("columns", 3), ("bodies", 0)], "bodies are derived in between"


def _all(database: Database) -> list[Listed]:
    with database.read() as tx:
        return tx.columns.documents()
