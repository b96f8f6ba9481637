"""Readable cases: the expected answer, libxml2's, that of the pool of processes, and that of columns and indexes."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from mcml.files.import_options import ImportOptions
from mcml.formats.format import SourceFile
from mcml_schemas.querying.queries import NodeItem, QueryRequest
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.queries import Queries
from mcml_service.xpath.trees.evaluate import Found, Tree
from tests.xpath.small import DOCUMENT, answer, tree


@dataclass(frozen=True)
class Case:
    expression: str
    lines: tuple[str, ...]

    @property
    def expected(self) -> list[str]:
        return [line for line in self.lines if line != "indexed"]

    def check(self, value: Any) -> None:
        """value: a scalar, or (address, value) of each node."""
        if isinstance(value, list):
            found = [f"{address} = {text}" for address, text in value] or ["nothing"]
            assert len(found) == len(self.expected)
            for got, wanted in zip(found, self.expected, strict=True):
                assert got == wanted if " = " in wanted else got.partition(" = ")[0] == wanted
            return
        kind, _, text = self.expected[0].partition(" ")
        if isinstance(value, bool):
            assert (kind, text) == ("boolean", str(value).lower())
        elif isinstance(value, str):
            assert (kind, text) == ("string", value)
        else:
            wanted = float(text.replace("Infinity", "inf"))
            assert kind == "number"
            assert math.isnan(value) if math.isnan(wanted) else value == wanted


def cases() -> Iterator[Case]:
    for path in sorted((Path(__file__).parent / "cases").glob("*.txt")):
        lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
        for block in "\n".join(lines).strip().split("\n\n"):
            expression, *answers = block.splitlines()
            yield Case(expression, tuple(line.strip() for line in answers))


CASES = list(cases())


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Queries]:
    database = Database(f"sqlite:///{tmp_path_factory.mktemp('cases') / 'store.db'}")
    database.migrate()
    done = import_files(
        database, [SourceFile("small.mcml", io.BytesIO(DOCUMENT.encode()))], ImportOptions(), Settings()
    )
    assert not done.problems
    queries = Queries(database, Settings())
    yield queries
    queries.close()
    database.close()


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.expression)
def test_trees_answer_as_expected(case: Case) -> None:
    assert case.expected
    query = parse(case.expression)
    found = Tree([[DOCUMENT.encode()]]).items(query.text, variables={}, offset=0, limit=1000)
    nodes = [(item.address, item.value) for item in found.items if isinstance(item, Found)]
    case.check(nodes if nodes or not found.items else found.items[0])


@pytest.mark.parametrize("case", [case for case in CASES if case.expression != "/"], ids=lambda case: case.expression)
def test_libxml2_agrees(case: Case) -> None:
    case.check(answer(tree(), parse(case.expression).text))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.expression)
def test_columns_answer_as_expected(case: Case, engine: Queries) -> None:
    found = engine.answer(QueryRequest(q=case.expression, limit=1000, explain=True))
    assert found.explain is not None
    assert found.explain.way != "projection"
    if "indexed" in case.lines:
        assert found.explain.way == "index"
    if found.type == "nodes":
        items = [item for item in found.items or [] if isinstance(item, NodeItem)]
        case.check([(item.address, item.value) for item in items])
    else:
        value = found.value
        special = {"NaN": math.nan, "Infinity": math.inf, "-Infinity": -math.inf}
        case.check(special.get(value, value) if found.type == "number" and isinstance(value, str) else value)


def test_pages_and_totals() -> None:
    found = Tree([[DOCUMENT.encode()]]).items("//frame/@id", variables={}, offset=3, limit=2)
    assert [item.value for item in found.items if isinstance(item, Found)] == ["4", "5"]
    assert found.total == 6
