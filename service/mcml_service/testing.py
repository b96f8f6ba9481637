"""The contracts of analyses and stores: a subclass with samples tests all of it."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from copy import deepcopy
from typing import Any

import numpy as np
import orjson
import pytest
from pydantic import BaseModel
from sqlalchemy import bindparam, insert, select, text, update

from mcml.errors import DamageError
from mcml_service.analysis.interface import Analysis, Answer, Motion, Part, Parts, Progress, silent
from mcml_service.storage.core.seals import verify
from mcml_service.storage.core.sql_expressions import OneOf
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import project
from mcml_service.storage.database import Database
from mcml_service.storage.work.tables import saved


class AnalysisContract:
    """The contract of an analysis.

    analysis: the entry of the catalogue. parameters: those that differ from their defaults. wishes: parameters of a
    call of operations on results, by their names; operations without parameters are not tested.
    """

    analysis: Analysis
    parameters: Mapping[str, Any] = {}
    wishes: Mapping[str, Mapping[str, Any]] = {}

    def motions(self) -> Sequence[Motion]:
        """Return the clips that it is tried on, in order of their documents. Few and short ones are enough."""
        raise NotImplementedError

    @pytest.fixture(scope="class")
    @classmethod
    def first_run(cls) -> tuple[Parts, list[float]]:
        """The parts of a result, and the shares of the work that were reported."""
        contract, shares = cls(), list[float]()
        return contract.run(contract.motions(), lambda stage, share: shares.append(share)), shares

    def run(self, motions: Sequence[Motion], progress: Progress = silent) -> Parts:
        return self.analysis.run(motions, self.analysis.parameters(**self.parameters), progress)

    def test_parts_are_those_that_the_catalogue_lists(self, first_run: tuple[Parts, list[float]]) -> None:
        parts, _ = first_run
        assert parts
        assert {name: part.kind for name, part in parts.items()} == {
            name: self.analysis.parts[name].kind for name in parts
        }
        assert all((part.kind == "clip") == (part.clip is not None) for part in parts.values())

    def test_parts_can_be_stored(self, first_run: tuple[Parts, list[float]]) -> None:
        for name, part in first_run[0].items():
            # JSON has no NaN: it would become null, and another value when it is read again.
            assert orjson.loads(orjson.dumps(part.data)) == _as_lists(part.data), name
            assert all(array.dtype.kind in "biuf" for array in part.arrays.values()), name
            if part.kind == "table":
                assert {len(row) for row in part.data["rows"]} <= {len(part.data["columns"])}, name

    def test_the_same_motions_give_the_same_result(self, first_run: tuple[Parts, list[float]]) -> None:
        motions = self.motions()
        before = deepcopy(motions)
        _require_equal(first_run[0], self.run(motions))
        for motion, copy in zip(motions, before, strict=True):
            assert np.array_equal(motion.rotations, copy.rotations, equal_nan=True), motion.name
            assert np.array_equal(motion.translations, copy.translations, equal_nan=True), motion.name

    def test_progress_goes_forward(self, first_run: tuple[Parts, list[float]]) -> None:
        _, shares = first_run
        assert shares, "tell now and then how far the work is"
        assert all(0 <= share <= 1 for share in shares)
        assert shares == sorted(shares)

    def test_cancelling_ends_the_work(self) -> None:
        def cancel(stage: str, share: float) -> None:
            raise InterruptedError

        with pytest.raises(InterruptedError):
            self.run(self.motions(), cancel)

    def test_operations_give_the_same_answer_for_a_stored_result(self, first_run: tuple[Parts, list[float]]) -> None:
        parts, _ = first_run
        stored = {
            name: Part(part.kind, orjson.loads(orjson.dumps(part.data)), part.arrays) for name, part in parts.items()
        }
        for name, wish in self.wishes.items():
            use = self.analysis.operations[name]
            first, second = (
                _run_operation(self.analysis, name, each, use.parameters(**wish)) for each in (parts, stored)
            )
            assert isinstance(first.value, use.answer), name
            assert first.value == second.value, name
            assert (first.clip is None) == (second.clip is None), name
            if first.clip is not None and second.clip is not None:
                assert np.array_equal(first.clip.rotations, second.clip.rotations), name
                assert np.array_equal(first.clip.translations, second.clip.translations), name

    def test_parameters_are_described(self) -> None:
        models = [self.analysis.parameters, *(use.parameters for use in self.analysis.operations.values())]
        for model in models:
            assert not [name for name, field in model.model_fields.items() if not field.description], model.__name__


def _run_operation(analysis: Analysis, name: str, parts: Parts, parameters: BaseModel) -> Answer:
    return analysis.operations[name].run(analysis.prepare(parts), parameters)


def _as_lists(data: Any) -> Any:
    """Return JSON values with tuples as lists, and numbers of NumPy as none: they have no JSON."""
    if isinstance(data, Mapping):
        return {str(key): _as_lists(value) for key, value in data.items()}
    return list(map(_as_lists, data)) if isinstance(data, list | tuple) else data


def _require_equal(first: Parts, second: Parts) -> None:
    assert list(first) == list(second)
    for name, part in first.items():
        assert part.data == second[name].data, name
        assert list(part.arrays) == list(second[name].arrays), name
        for key, array in part.arrays.items():
            assert np.array_equal(array, second[name].arrays[key], equal_nan=array.dtype.kind == "f"), (name, key)


_CREATED = "2026-01-31T10:00:00.000Z"
_SAVED = select(saved.c.name, saved.c.author).order_by(saved.c.name)


class StoreContract:
    """The contract of a store, for every kind of database. A fixture `database` gives each test a new, empty one."""

    def test_its_schema_is_the_program_s(self, database: Database) -> None:
        found, wanted = database.schema_versions()
        assert found == wanted
        database.require_schema()

    def test_it_is_sound_and_can_be_compacted(self, database: Database) -> None:
        _add_projects(database, "walks")
        assert database.check() == []
        assert database.size()["total"] > 0
        assert database.dialect.compaction().bytes >= 0
        database.dialect.compact(lambda left: None)
        assert database.check() == []

    @pytest.mark.parametrize("kind", ["built", "prepared", "text"])
    def test_each_kind_of_statement_reads_alike(self, database: Database, kind: str) -> None:
        keys = _add_projects(database, "walks", "100 %")
        query = select(project.c.name).where(project.c.id >= keys[0]).order_by(project.c.id)
        statement: Any = {
            "built": query,
            "prepared": Prepared(query),
            "text": f"SELECT name FROM project WHERE id >= {keys[0]} ORDER BY id",
        }[kind]
        with database.read() as tx:
            assert [tuple(row) for row in tx.fetch_all(statement)] == [("walks",), ("100 %",)]
            assert tx.fetch_column(statement) == ["walks", "100 %"]
            assert tx.fetch_value(statement) == "walks"
            row = tx.fetch_one(statement)
            assert row is not None
            assert tuple(row) == ("walks",)

    def test_no_row_is_none(self, database: Database) -> None:
        query = select(project.c.name).where(project.c.name == bindparam("name"))
        with database.read() as tx:
            for statement in (query, Prepared(query)):
                assert tx.fetch_all(statement, {"name": "none"}) == []
                assert tx.fetch_one(statement, {"name": "none"}) is None
                assert tx.fetch_value(statement, {"name": "none"}) is None

    def test_lists_of_keys(self, database: Database) -> None:
        keys = _add_projects(database, "walks", "jumps", "runs")
        some = [keys[2], keys[0]]
        names = Prepared(select(project.c.name).where(OneOf(project.c.id, "keys")).order_by(project.c.id))
        with database.read() as tx:
            assert tx.fetch_column(names, {"keys": some}) == ["walks", "runs"]
            assert tx.fetch_column(names, {"keys": []}) == []
            assert tx.fetch_column(names.where(project.c.name == "runs"), {"keys": some}) == ["runs"]
            built = select(project.c.name).where(OneOf(project.c.id, "some", some)).order_by(project.c.id)
            assert tx.fetch_column(built) == ["walks", "runs"]

    def test_changes_are_counted(self, database: Database) -> None:
        _add_projects(database, "walks", "jumps")
        rename = update(project).where(project.c.name == bindparam("old")).values(name=bindparam("new"))
        with database.write() as tx:
            assert tx.run(rename, {"old": "walks", "new": "strolls"}) == 1
            assert tx.run(Prepared(rename), {"old": "jumps", "new": "leaps"}) == 1
            assert tx.run(Prepared(rename), {"old": "jumps", "new": "leaps"}) == 0
            tx.run(insert(project), [{"name": name, "created": _CREATED} for name in ("a", "b", "c")])
            assert {"strolls", "leaps", "a", "b", "c"} <= set(tx.projects.names())

    def test_names_are_in_order_of_their_code_points(self, database: Database) -> None:
        names = ["b", "B", "ä", "z", "걸음", "\U0001d4b3", "~", "a b", "a-b"]
        _add_projects(database, *names)
        with database.read() as tx:
            assert [name for name in tx.projects.names() if name in names] == sorted(names)

    def test_a_snapshot_does_not_see_later_commits(self, database: Database) -> None:
        with database.read() as tx:
            before = tx.projects.names()
            _add_projects(database, "later")
            assert tx.projects.names() == before
        with database.read() as tx:
            assert "later" in tx.projects.names()

    def test_nothing_stays_of_a_transaction_that_raises(self, database: Database) -> None:
        with suppress(ZeroDivisionError), database.write() as tx:
            tx.run(insert(project).values(name="nothing", created=_CREATED))
            raise ZeroDivisionError
        with database.read() as tx:
            assert "nothing" not in tx.projects.names()

    def test_a_savepoint_undoes_its_block_alone(self, database: Database) -> None:
        with database.write() as tx:
            tx.run(insert(project).values(name="before", created=_CREATED))
            with suppress(ZeroDivisionError), tx.savepoint():
                tx.run(insert(project).values(name="within", created=_CREATED))
                raise ZeroDivisionError
        with database.read() as tx:
            assert "before" in tx.projects.names()
            assert "within" not in tx.projects.names()

    def test_commits_of_several_writers_have_numbers_in_order(self, database: Database) -> None:
        numbers: list[int] = []

        def write() -> None:
            for _ in range(5):
                with database.write() as tx:
                    numbers.append(tx.commit)

        writers = [threading.Thread(target=write) for _ in range(4)]
        for writer in writers:
            writer.start()
        for writer in writers:
            writer.join()
        with database.read() as tx:
            newest = tx.newest_commit()
        assert sorted(numbers) == list(range(newest - len(numbers) + 1, newest + 1))
        assert len(numbers) == 20

    def test_damaged_rows_are_refused_in_each_way(self, database: Database) -> None:
        _add_saved(database, "one", "two")
        compared = verify(_SAVED, saved)
        with database.write() as tx:
            assert list(map(len, tx.stream(compared, 1))) == [1, 1]
            tx.run(text("UPDATE saved SET author = 'eve' WHERE name = 'two'"))
            assert tx.fetch_column(_SAVED) == ["one", "two"]
            for read in (tx.fetch_all, tx.fetch_one, tx.fetch_value, tx.fetch_column):
                with pytest.raises(DamageError):
                    read(compared)
                with pytest.raises(DamageError):
                    read(Prepared(_SAVED, saved))
            blocks = tx.stream(compared, 1)
            assert [tuple(row) for row in next(blocks)] == [("one", "kim")]
            with pytest.raises(DamageError):
                next(blocks)

    def test_a_remembered_result_is_compared_once_and_another_one_again(self, database: Database) -> None:
        _add_saved(database, "one")
        statement = Prepared(_SAVED, saved, remember=True)
        with database.write() as tx:
            assert tx.fetch_all(statement) == [("one", "kim")]
            tx.run(text("UPDATE saved SET checksum = checksum + 1"))
            assert tx.fetch_all(statement) == [("one", "kim")]
            tx.run(text("UPDATE saved SET author = 'eve'"))
            with pytest.raises(DamageError):
                tx.fetch_all(statement)


def _add_projects(database: Database, *names: str) -> list[int]:
    with database.write() as tx:
        return [tx.insert_row(project, name=name, created=_CREATED) for name in names]


def _add_saved(database: Database, *names: str) -> None:
    (key,) = _add_projects(database, "walks")
    about = {"project": key, "kind": "query", "version": 1, "author": "kim", "changed": _CREATED, "content": "{}"}
    with database.write() as tx:
        tx.insert_rows(saved, [{"name": name, **about} for name in names])
