"""Every expression of docs/xpath.md, on the demo library, against libxml2 on the exported documents."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from lxml import etree

from mcml_schemas.querying.queries import NodeItem, QueryRequest, ScalarItem, ValueItem
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.importing.load_demo import load_demo
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.lists.filtering import DocumentFilter
from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.language.tree import Written
from mcml_service.xpath.queries import Queries
from mcml_service.xpath.trees.evaluate import Addresses
from tests.xpath.libxml2 import describe

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "xpath.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"^\| [^|`]+ \| `(.+)` \|$", TEXT, re.MULTILINE)
LATER = {
    "distinct-values(//motion_name)": lambda trees: sorted({e.text for t in trees for e in t.iter("motion_name")}),
    "max(//frame_bone[@name='left_low_arm']/@Rz)": lambda trees: max(_turns(trees)),
    "avg(//frame_bone[@name='left_low_arm']/@Rz)": lambda trees: sum(_turns(trees)) / len(_turns(trees)),
    "exists(//frame[motion_name='dance'])": lambda trees: any(t.xpath("//frame[motion_name='dance']") for t in trees),
    "for $f in //frame return string-join(($f/@id, $f/motion_name), ' ')": lambda trees: _names(trees),
}

SAME = {
    "//frame[motion_name='walk'] except //frame[@id='7']": "//frame[motion_name='walk'][not(@id='7')]",
    "//bone[matches(name, '^left_')]/name": "//bone[starts-with(name, 'left_')]/name",
}
"""What XPath 1.0 asks instead."""


def _turns(trees: list[Any]) -> list[float]:
    return [float(value) for tree in trees for value in tree.xpath("//frame_bone[@name='left_low_arm']/@Rz")]


def _names(trees: list[Any]) -> list[str]:
    frames = [frame for tree in trees for frame in tree.iter("frame")][:1000]
    return sorted(" ".join([frame.get("id"), *(name.text for name in frame.iter("motion_name"))]) for frame in frames)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Queries, list[tuple[str, Any]]]]:
    database = Database(f"sqlite:///{tmp_path_factory.mktemp('demo') / 'store.db'}")
    database.migrate()
    load_demo(database, Settings(), ["people"])
    trees = []
    parser = etree.XMLParser(remove_blank_text=True)
    with database.read() as tx:
        for stored in tx.documents.page(DocumentFilter(), after=None, limit=100):
            content = b"".join(export_document(tx, stored, ExportOptions("mcml")).content)
            trees.append((stored.uuid, etree.parse(io.BytesIO(content), parser)))
    queries = Queries(database, Settings())
    yield queries, trees
    queries.close()
    database.close()


def test_the_tables_are_found() -> None:
    assert len(EXAMPLES) >= 20
    assert set(LATER) <= set(EXAMPLES)


@pytest.mark.parametrize("text", EXAMPLES)
def test_examples(text: str, library: tuple[Queries, list[tuple[str, Any]]]) -> None:
    engine, trees = library
    answer = engine.answer(QueryRequest(q=text, limit=1000, explain=True))
    assert answer.warnings == []
    assert answer.explain is not None
    by_saxon = isinstance(parse(text).tree, Written)
    assert (answer.explain.way == "projection") == by_saxon
    if text in LATER:
        values = [item.value for item in answer.items or [] if isinstance(item, ValueItem)]
        wanted = LATER[text]([tree for _, tree in trees])
        found = sorted(map(str, values)) if values else answer.value
        assert found == (wanted if isinstance(wanted, list) else pytest.approx(wanted))
        return
    wanted = [(uuid, tree.xpath(parse(SAME.get(text, text)).text)) for uuid, tree in trees]
    if answer.type == "number":
        assert answer.value == pytest.approx(math.fsum(value for _, value in wanted))
        return
    nodes = []
    for uuid, found in wanted:
        addresses = Addresses()
        nodes += [(uuid, describe(node, addresses)[1]) for node in found]
    items = [(item.document, item.address) for item in answer.items or [] if isinstance(item, NodeItem)]
    assert not any(isinstance(item, ScalarItem) for item in answer.items or [])
    assert items == nodes[:1000]


def test_examples_find_something(library: tuple[Queries, list[tuple[str, Any]]]) -> None:
    engine, _ = library
    answers = {text: engine.answer(QueryRequest(q=text, limit=1)) for text in EXAMPLES}
    assert [text for text, answer in answers.items() if not answer.items and not answer.value] == []
