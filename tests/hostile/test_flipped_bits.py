"""Bits that flip in a store: what is answered is what was written, or it is told that it is not."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Connection, Table, and_, select, update
from sqlalchemy.exc import SQLAlchemyError

from mcml.errors import McmlError
from mcml_schemas.querying.queries import QueryRequest
from mcml_service.actions.editing.single_element import Change
from mcml_service.actions.editing.whole_document import add_labels, change_document, delete_document
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.settings import Settings
from mcml_service.storage.core.schema import metadata
from mcml_service.storage.database import Database
from mcml_service.storage.lists.filtering import DocumentFilter
from mcml_service.storage.transaction import Transaction
from mcml_service.storage.upkeep.checks import faults
from mcml_service.xpath.queries import Queries
from tests import postgres
from tests.builders import ASF, HTR, MCML, amc, bvh, c3d_file, store
from tests.edits import change_element

EXPRESSIONS = (
    "//frame[motion_name='walk']/@id", "//bone/name", "//header/*", "//frame_bone[@Rx > 2]/@Rx", "sum(//@Ry)",
    "max(//@Rz)", "count(//frame)", "//property", "//frame[3]",
)  # fmt: skip


def fill(database: Database) -> None:
    """Documents of several formats: labelled, edited, renamed, deleted; and a result."""
    files: list[dict[str, bytes]] = [
        {"a.bvh": bvh(300)}, {"b.mcml": MCML},
        {"c.asf": ASF, "c.amc": amc(20)}, {"d.htr": HTR}, {"e.c3d": c3d_file(40)},
        {"f.bvh": bvh(20, seed=3)},
    ]  # fmt: skip
    ids = [store(database, one, properties=(("age", "23", "year"),))[0] for one in files]
    for uuid in ids[:4]:
        with database.write() as tx:
            stored = tx.documents.get(uuid)
            add_labels(tx, stored, [("walk", 1, stored.frames), ("bar-1", 1, 1)])
    with database.write() as tx:
        change_element(tx, tx.documents.get(ids[0]), "/mcml/motion/frame[270]/frame_bone[2]", Change({"Rx": "33.5"}))
    with database.write() as tx:
        change_document(tx, tx.documents.get(ids[1]), name="renamed", project="lab")
    with database.write() as tx:
        delete_document(tx, tx.documents.get(ids[5]))
        project = tx.projects.get("lab")
        key, _ = tx.results.add(project, "reach", "model", "kim", [{"document": ids[0], "revision": 1}], {"a": 1}, {})
        tx.results.add_part(key, "points", "points", {"axes": ["a", "b"]}, {"all": np.arange(900.0).reshape(3, -1)})
        tx.mappings.put("lab", "usual", (("a", "b"),), "kim")


def answers(tx: Transaction, engine: Queries | None = None) -> Iterator[tuple[str, Any]]:
    """What users ask of the store, bit by bit."""
    for deleted in (False, True):
        for stored in tx.documents.page(DocumentFilter(deleted=deleted), after=None, limit=100):
            yield f"document {stored.key}", replace(stored, key=0)
            yield f"receipt {stored.key}", tx.documents.receipt(stored.key)
            yield f"labels {stored.key}", [replace(span, key=0) for span in tx.spans.of(stored.key)]
            yield f"history {stored.key}", tx.revisions.of(stored.key)
            for name in ("mcml", "csv", stored.format):
                for original in (True, False):
                    content = export_document(tx, stored, ExportOptions(name, original=original)).content
                    yield f"{name} {stored.key} {original}", b"".join(content)
    for found in tx.results.page(project_name=None, analysis=None, parent=None, before=None, limit=9):
        parts = tx.results.parts(found.key)
        yield (
            "result",
            (replace(found, key=0), parts, [tx.results.array(found.key, part, "all").mean() for part in parts]),
        )
    yield "mappings", [replace(mapping, key=0) for mapping in tx.mappings.page(None, None, 9)]
    for text in EXPRESSIONS if engine is not None else ():
        assert engine is not None
        answer = engine.answer(QueryRequest(q=text, limit=1000))
        yield text, (answer.value, answer.items)


def judged(asked: Iterator[tuple[str, Any]], wanted: dict[str, Any]) -> str:
    """ "same", "told" or "silent"."""
    try:
        found = dict(asked)
    except McmlError:
        return "told"
    return "same" if found == wanted else "silent"


# -- SQLite: a bit of the file -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """A store as one file, and its answers."""
    path = tmp_path_factory.mktemp("sound") / "store.db"
    database = Database(f"sqlite:///{path}")
    database.migrate()
    fill(database)
    assert database.check(past=True) == []
    wanted = all_answers(database)
    with database.dialect.engine.connect() as connection:
        connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)")
    database.close()
    return path, wanted


def all_answers(database: Database) -> dict[str, Any]:
    engine = Queries(database, Settings())
    try:
        with database.read() as tx:
            return dict(answers(tx, engine))
    finally:
        engine.close()


def flip(path: Path, place: int) -> None:
    with path.open("r+b") as file:
        file.seek(place // 8)
        byte = file.read(1)[0]
        file.seek(place // 8)
        file.write(bytes([byte ^ (1 << place % 8)]))


def flipped(path: Path, wanted: dict[str, Any], seed: int, folder: Path) -> str:
    """What becomes of a copy with one bit flipped: "checked" where the check says so, else as `judged`."""
    copy = folder / "flipped.db"
    shutil.copy(path, copy)
    # Most bytes of a small store are empty space, and mean nothing.
    used = np.flatnonzero(np.fromfile(copy, np.uint8)).tolist()
    random = Random(seed)
    flip(copy, 8 * random.choice(used) + random.randrange(8))
    database = Database(f"sqlite:///{copy}")
    engine = Queries(database, Settings())
    try:
        database.require_schema()
        if database.check(past=True):
            return "checked"
        with database.read() as tx:
            return judged(answers(tx, engine), wanted)
    except McmlError:
        return "told"
    finally:
        engine.close()
        database.close()


def flips(sound: tuple[Path, dict[str, Any]], seeds: range, folder: Path) -> Counter[str]:
    found = {seed: flipped(*sound, seed, folder) for seed in seeds}
    assert [seed for seed, verdict in found.items() if verdict == "silent"] == []
    return Counter(found.values())


@pytest.mark.slow
def test_no_flipped_bit_is_silent(sound: tuple[Path, dict[str, Any]], tmp_path: Path) -> None:
    found = flips(sound, range(20), tmp_path)
    # Most flips matter: the check of the store tells them, or an error when they are read.
    assert found["checked"] + found["told"] > 10


@pytest.mark.fuzz(seeds=10)
def test_no_flipped_bit_is_silent_many_times(sound: tuple[Path, dict[str, Any]], seed: int, tmp_path: Path) -> None:
    print(flips(sound, range(seed, seed + 100), tmp_path))


# -- PostgreSQL: a bit of a value --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def team(postgres_template: str) -> Iterator[tuple[Database, dict[str, Any]]]:
    with postgres.new_database(postgres_template, "template_store") as url:
        database = Database(url)
        fill(database)
        with database.read() as tx:
            wanted = dict(answers(tx))
        yield database, wanted
        database.close()


def change_value(connection: Connection, random: Random) -> tuple[str, str] | None:
    """Flips a bit of one value of one row; (table, column), None where there is nothing to flip, or it may not be."""
    table: Table = random.choice([table for table in metadata.sorted_tables if table.name != "job"])
    rows = connection.execute(select(table)).mappings().all()
    if not rows:
        return None
    row = random.choice(rows)
    column = random.choice(list(table.columns))
    value = row[column.name]
    if value is None or value in ("", b""):
        return None
    match value:
        case bool():
            new: Any = not value
        case int():
            new = value ^ (1 << random.randrange(15))
        case float():
            bits = np.float64(value).view(np.int64) ^ np.int64(1 << random.randrange(52))
            new = float(bits.view(np.float64))
        case bytes():
            place = random.randrange(len(value))
            new = value[:place] + bytes([value[place] ^ (1 << random.randrange(8))]) + value[place + 1 :]
        case str():
            place = random.randrange(len(value))
            new = value[:place] + chr(ord(value[place]) ^ (1 << random.randrange(4))) + value[place + 1 :]
    key = and_(*(one == row[one.name] for one in table.primary_key))
    with connection.begin_nested() as nested:
        try:
            connection.execute(update(table).where(key).values({column.name: new}))
        except SQLAlchemyError:
            nested.rollback()
            return None
    return table.name, column.name


def changed(team: tuple[Database, dict[str, Any]], seed: int) -> tuple[str, tuple[str, str] | None]:
    database, wanted = team
    with database.dialect.engine.connect() as connection:
        transaction = connection.begin()
        try:
            where = change_value(connection, Random(seed))
            if where is None:
                return "none", None
            tx = Transaction(connection, database.dialect)
            return ("checked" if faults(tx, past=True) else judged(answers(tx), wanted)), where
        finally:
            transaction.rollback()


def changes(team: tuple[Database, dict[str, Any]], seeds: range) -> Counter[str]:
    found = {seed: changed(team, seed) for seed in seeds}
    assert {seed: where for seed, (verdict, where) in found.items() if verdict == "silent"} == {}
    return Counter(verdict for verdict, _ in found.values())


@pytest.mark.slow
def test_no_changed_value_is_silent(team: tuple[Database, dict[str, Any]]) -> None:
    assert changes(team, range(60))["checked"] > 20


@pytest.mark.fuzz(seeds=10)
def test_no_changed_value_is_silent_many_times(team: tuple[Database, dict[str, Any]], seed: int) -> None:
    print(changes(team, range(seed, seed + 150)))
