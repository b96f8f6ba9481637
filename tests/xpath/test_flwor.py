"""FLWOR over libraries: what Saxon makes of the same XQuery about all documents."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random
from typing import Any

import pytest
from lxml import etree

from mcml.errors import QueryError
from mcml_schemas.querying.queries import NodeItem, QueryRequest, ValueItem
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.queries import Queries
from tests.builders import MCML, bvh, store
from tests.edits import OTHER_SEEDS

pytestmark = pytest.mark.above_store

saxonche = pytest.importorskip("saxonche")


PROLOG = "".join(
    f'declare namespace {kind} = "http://www.w3.org/2005/xpath-functions/{kind}";' for kind in ("map", "array")
)
PROLOG += "declare variable $d external; "


@dataclass(frozen=True)
class Oracle:
    """Documents in the order of the library."""

    saxon: Any
    documents: list[Any]

    def values(self, text: str) -> list[str]:
        """The string values of the items. text: with `$d` before each absolute path."""
        processor = self.saxon.new_xquery_processor()
        sequence = self.saxon.empty_sequence() if hasattr(self.saxon, "empty_sequence") else None
        value = saxonche.PyXdmValue(self.saxon) if sequence is None else sequence
        for document in self.documents:
            value = value.add_xdm_item(document) or value
        processor.set_parameter("d", value)
        processor.set_query_content(PROLOG + text)
        found = processor.run_query_to_value()
        return [] if found is None else [found.item_at(place).string_value for place in range(found.size)]


@pytest.fixture
def engine(database: Database) -> Iterator[tuple[Queries, Oracle]]:
    uuids = store(database, {"a.mcml": MCML}) + store(database, {"b.bvh": bvh(6, seed=2)})
    uuids += store(database, {"c.bvh": bvh(9, seed=3), "d.bvh": bvh(2, seed=4)})
    saxon = saxonche.PySaxonProcessor(license=False)
    documents = []
    with database.read() as tx:
        for uuid in uuids:
            content = b"".join(
                export_document(tx, tx.documents.get(uuid), ExportOptions("mcml", original=False)).content
            )
            root = etree.fromstring(content, etree.XMLParser(remove_blank_text=True))
            documents.append(saxon.parse_xml(xml_text=etree.tostring(root, encoding="unicode")))
    queries = Queries(database, Settings())
    yield queries, Oracle(saxon, documents)
    queries.close()


SOURCES = {
    "//frame": ("@id", "count($v/frame_bone)", "number($v/frame_bone[1]/@Rx)", "string($v/motion_name[1])"),
    "//frame_bone": ("@name", "number($v/@Rx)", "number($v/@Rz)"),
    "//bone": ("name", "count($v/bone)", "string-length($v/name)"),
    "/mcml": ("header/filename", "count($v//frame)", "count($v//bone)"),
}


MAY_BE_EMPTY = {
    "//frame": ("motion_name[1]", "motion_name[3]", "frame_bone[9]/@name"),
    "//frame_bone": ("@Ry", "@Tx"),
    "//bone": ("bone[1]/name", "bone[2]/name"),
    "/mcml": ("header/filename", "motion/frame[8]/@id"),
}
"""Keys that some items do not have; a key may be empty in XQuery (3.1, §3.12.7 and §3.12.8)."""


def flwor(chance: Random) -> str:
    """An expression with `D` before each absolute path."""
    source = chance.choice(list(SOURCES))
    keys = [key if "$v" in key else f"string($v/{key})" for key in SOURCES[source]]
    numbers = [key for key in keys if not key.startswith("string(")] or ["1"]
    text = f"for $v in D{source}"
    if chance.random() < 0.5:
        text += f" let $n := {chance.choice(numbers)}"
        keys.append("$n")
        numbers.append("$n")
    if chance.random() < 0.6:
        text += f" where {chance.choice(numbers)} {chance.choice(('>', '<', '='))} {chance.choice((0, 1, 2, 3.5))}"
    if chance.random() < 0.4:
        plain = [key for key in keys if key != "$n"] + [f"$v/{key}" for key in MAY_BE_EMPTY[source]]
        text += f" group by $k := {chance.choice(plain)}"
        if has_more := chance.random() < 0.3:
            text += f", $j := {chance.choice(plain)}"
        text += " let $c := count($v)"
        if chance.random() < 0.5:
            text += f" where $c > {chance.choice((0, 1, 3))}"
        if not has_more and chance.random() < 0.5:
            text += f" order by $k{chance.choice(('', ' descending'))}"
        elif not has_more and "$k := $v/" not in text:
            text += f" order by $c{chance.choice(('', ' descending'))}, $k"
        return text + chance.choice((" return concat(string($k), ':', string($c))", " return $c"))
    if chance.random() < 0.7:
        # Keys of one type: texts and numbers do not compare.
        text += f" order by {chance.choice(keys)}{chance.choice(('', ' ascending', ' descending'))}"
        if chance.random() < 0.3:
            text += f", $v/{chance.choice(MAY_BE_EMPTY[source])}{chance.choice(('', ' descending'))}"
        while chance.random() < 0.4:
            text += f", {chance.choice(keys)}{chance.choice(('', ' descending'))}"
    return text + f" return string({chance.choice(keys)})"


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), OTHER_SEEDS[:2], indirect=["kind"])
def test_answers_are_saxons(engine: tuple[Queries, Oracle], seed: int) -> None:
    queries, oracle = engine
    chance = Random(seed)
    filled = 0
    for _ in range(25):
        text = flwor(chance)
        wanted = oracle.values(text.replace("D/", "$d/"))
        answer = queries.answer(QueryRequest(q=text.replace("D/", "/"), limit=1000))
        found = [item.value for item in answer.items or [] if isinstance(item, ValueItem | NodeItem)]
        if answer.items is None and answer.value is not None:
            found = [answer.value]
        shown = [_text(value) for value in found]
        # XQuery leaves the order of groups open.
        if "group by" in text and "order by" not in text:
            shown, wanted = sorted(shown), sorted(wanted)
        assert shown == wanted, text
        filled += bool(wanted)
    assert filled > 10


def _text(value: object) -> str:
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return str(value)


@pytest.mark.parametrize(
    ("text", "column"),
    [
        ("for $a in //frame order by $a, $b return $a", 34),
        ("for $a in //frame where $a", 27),
        ("for $a in //frame group by $a/@id return $a", 31),
        ("for $a in //frame, $b in //bone order $a return $b", 38),
        ("for $a at 1 in //frame return $a", 11),
        ("for $a in //frame count 1 return $a", 25),
        ("for tumbling window $w in //frame return $w", 5),
    ],
)
def test_what_has_no_meaning_is_refused(text: str, column: int) -> None:
    with pytest.raises(QueryError) as caught:
        parse(text)
    assert caught.value.at is not None
    assert abs((caught.value.at.column or 0) - column) <= 2


ABOUT_VALUES = [
    "for $k in sort(distinct-values(D//bone/name), (), function($k) { count(D//bone[name = $k]) })"
    " return count(D//bone[name = $k])",
    "for $k in sort((3, 1, 2), (), function($k) { count(D//frame) mod $k }) return count(D//frame) mod $k",
    "for $v in D//frame group by $k := string($v/@id) order by count($v) descending return count($v)",
    "for $v in D/mcml group by $k := $v/motion/frame[8]/@id order by $k return count($v)",
    "count(distinct-values(D//bone/name)[count(D//frame) > 3])",
    "count(distinct-values(D//bone/name)[count(D//frame) < 3])",
    "distinct-values(D//frame/@id)[count(D/mcml)]",
    "for $v in D//frame order by $v/motion_name[1], $v/@id return string($v/@id)",
]
"""Functions and conditions of values, which are in no document, that ask for all of them."""


@pytest.mark.parametrize("text", ABOUT_VALUES)
def test_paths_about_values_are_those_of_all_documents(engine: tuple[Queries, Oracle], text: str) -> None:
    queries, oracle = engine
    wanted = oracle.values(text.replace("D/", "$d/"))
    answer = queries.answer(QueryRequest(q=text.replace("D/", "/"), limit=1000))
    found = [item.value for item in answer.items or [] if isinstance(item, ValueItem | NodeItem)]
    assert [_text(value) for value in found or [answer.value]] == wanted
    assert wanted


@pytest.mark.parametrize(
    "text",
    [
        "for $x in (3, 1, 2) let $x := $x * 10 where $x > 10 order by $x return $x",
        "for $f in D//frame group by $f := string($f/motion_name[1]) order by $f return $f",
        "for $f in D//frame count $f where $f < 4 return $f",
        "for $x in (3, 1, 2) let $n := $x let $n := $n + 1 order by $n return $n",
        "for $m in D/mcml for $m in $m//bone order by string($m/name) return string($m/name)",
        "for $x in (1, 2) let $c := 5 count $c return $c",
        "for $x in (3, 1, 2) order by $x let $x := $x + 1 return $x",
        "let $n := 5 return (for $f in D//frame let $n := $f/@id group by $k := string($f/motion_name[1])"
        " order by $k return concat($k, count($n)))",
        "let $n := (5, 6) return (for $f in D//frame, $x in 1 group by $k := string($f/motion_name[1])"
        " order by $k return concat($k, count($n), count($f)))",
        "for $x in (1, 2) return (for $x in ($x, 5) order by -$x return $x)",
        "for $k in ('a', 'b') return (for $f in D//frame group by $k := count($f/frame_bone) order by $k return $k)",
    ],
)
def test_variables_of_the_same_name_are_told_apart(engine: tuple[Queries, Oracle], text: str) -> None:
    queries, oracle = engine
    wanted = oracle.values(text.replace("D/", "$d/"))
    answer = queries.answer(QueryRequest(q=text.replace("D/", "/"), limit=1000))
    assert [_text(item.value) for item in answer.items or [] if isinstance(item, ValueItem | NodeItem)] == wanted
    assert wanted


def test_values_are_arranged_too(engine: tuple[Queries, Oracle]) -> None:
    queries, _ = engine
    answer = queries.answer(QueryRequest(q="for $n in (3, 1, 2) where $n < 3 order by $n descending return $n * 10"))
    assert [item.value for item in answer.items or [] if isinstance(item, ValueItem)] == [20, 10]
