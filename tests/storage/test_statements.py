"""The one way to execute SQL: each kind of statement, on both databases."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import pytest
from sqlalchemy import bindparam, insert, select, text, update

from mcml.errors import DamageError
from mcml_service.storage.core.seals import verify
from mcml_service.storage.core.sql_expressions import OneOf
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import project
from mcml_service.storage.database import Database
from mcml_service.storage.work.tables import saved

NAMES = Prepared(select(project.c.id, project.c.name).where(OneOf(project.c.id, "keys")).order_by(project.c.id))
SAVED = select(saved.c.name, saved.c.author).order_by(saved.c.name)


def add_projects(database: Database, *names: str) -> list[int]:
    with database.write() as tx:
        return [tx.insert_row(project, name=name, created="2026-01-31T10:00:00.000Z") for name in names]


def add_saved(database: Database, key: int, *names: str) -> None:
    about = {"project": key, "kind": "query", "version": 1, "author": "kim", "changed": "2026-01-31", "content": "{}"}
    with database.write() as tx:
        tx.insert_rows(saved, [{"name": name, **about} for name in names])


@pytest.mark.parametrize("asked", ["built", "prepared", "text"])
def test_each_kind_of_statement_reads_alike(database: Database, asked: str) -> None:
    keys = add_projects(database, "walks", "100 %")
    every = select(project.c.name).where(project.c.id >= keys[0]).order_by(project.c.id)
    statement: Any = {
        "built": every,
        "prepared": Prepared(every),
        "text": f"SELECT name FROM project WHERE id >= {keys[0]} ORDER BY id",
    }[asked]
    with database.read() as tx:
        assert [tuple(row) for row in tx.fetch_all(statement)] == [("walks",), ("100 %",)]
        assert tx.fetch_column(statement) == ["walks", "100 %"]
        assert tx.fetch_value(statement) == "walks"
        row = tx.fetch_one(statement)
        assert row is not None
        assert tuple(row) == ("walks",)


def test_no_row_is_none(database: Database) -> None:
    nobody = select(project.c.name).where(project.c.name == bindparam("name"))
    for statement in (nobody, Prepared(nobody)):
        with database.read() as tx:
            assert tx.fetch_all(statement, {"name": "none"}) == []
            assert tx.fetch_one(statement, {"name": "none"}) is None
            assert tx.fetch_value(statement, {"name": "none"}) is None


def test_lists_of_keys(database: Database) -> None:
    keys = add_projects(database, "walks", "jumps", "runs")
    chosen = [keys[2], keys[0]]
    with database.read() as tx:
        assert tx.fetch_all(NAMES, {"keys": chosen}) == [(keys[0], "walks"), (keys[2], "runs")]
        assert tx.fetch_all(NAMES, {"keys": []}) == []
        assert tx.fetch_all(NAMES.where(project.c.name == "runs"), {"keys": chosen}) == [(keys[2], "runs")]
        built = select(project.c.name).where(OneOf(project.c.id, "some", chosen)).order_by(project.c.id)
        assert tx.fetch_column(built) == ["walks", "runs"]


def test_changes_are_counted(database: Database) -> None:
    add_projects(database, "walks", "jumps")
    rename = update(project).where(project.c.name == bindparam("old")).values(name=bindparam("new"))
    with database.write() as tx:
        assert tx.run(rename, {"old": "walks", "new": "strolls"}) == 1
        assert tx.run(Prepared(rename), {"old": "jumps", "new": "leaps"}) == 1
        assert tx.run(Prepared(rename), {"old": "jumps", "new": "leaps"}) == 0
        many = [{"name": name, "created": "2026-01-31T10:00:00.000Z"} for name in ("a", "b", "c")]
        tx.run(insert(project), many)
        assert {"strolls", "leaps", "a", "b", "c"} <= set(tx.projects.names())


def test_damaged_rows_are_refused_in_each_way(database: Database) -> None:
    (key,) = add_projects(database, "walks")
    add_saved(database, key, "one", "two")
    compared = verify(SAVED, saved)
    with database.write() as tx:
        assert list(map(len, tx.stream(compared, 1))) == [1, 1]
        tx.run(text("UPDATE saved SET author = 'eve' WHERE name = 'two'"))
        assert tx.fetch_column(SAVED) == ["one", "two"]
        for read in (tx.fetch_all, tx.fetch_one, tx.fetch_value, tx.fetch_column):
            with pytest.raises(DamageError):
                read(compared)
            with pytest.raises(DamageError):
                read(Prepared(SAVED, saved))
        blocks = tx.stream(compared, 1)
        assert [tuple(row) for row in next(blocks)] == [("one", "kim")]
        with pytest.raises(DamageError):
            next(blocks)


def test_a_remembered_result_is_compared_once_and_another_one_again(database: Database) -> None:
    (key,) = add_projects(database, "walks")
    add_saved(database, key, "one")
    statement = Prepared(SAVED, saved, remember=True)
    with database.write() as tx:
        assert tx.fetch_all(statement) == [("one", "kim")]
        tx.run(text("UPDATE saved SET checksum = checksum + 1"))
        assert tx.fetch_all(statement) == [("one", "kim")]
        tx.run(text("UPDATE saved SET author = 'eve'"))
        with pytest.raises(DamageError):
            tx.fetch_all(statement)


def test_a_savepoint_undoes_its_block_alone(database: Database) -> None:
    with database.write() as tx:
        tx.run(insert(project).values(name="before", created="2026-01-31T10:00:00.000Z"))
        with suppress(ZeroDivisionError), tx.savepoint():
            tx.run(insert(project).values(name="within", created="2026-01-31T10:00:00.000Z"))
            raise ZeroDivisionError
    with database.read() as tx:
        assert "before" in tx.projects.names()
        assert "within" not in tx.projects.names()
