"""Questions about all documents together, over documents in many small groups: Saxon's answers, and each alone."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from saxonche import PySaxonProcessor

from mcml_schemas.querying.queries import NodeItem, QueryRequest
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.library import groups
from mcml_service.xpath.queries import Queries
from tests.xpath import whole
from tests.xpath.oracle import pages, plain, same, same_value
from tests.xpath.test_xpath_many import Many, opened
from tests.xpath.test_xpath_xpath2 import wanted

DOCS = (Path(__file__).resolve().parents[2] / "docs" / "xpath.md").read_text(encoding="utf-8")
CASES = re.findall(r"^\| [^|`]+ \| [^|`]+ \| `(.+)` \|$", DOCS, re.MULTILINE)
OTHERS = [
    "for $x in //bone return position()", "1 + last()", "(sort(//bone/name)/..)[3]", "count(sort(//frame)/@id)",
    "distinct-values((//bone/name)[2])", "exists(for $f in //frame return $f/@nothing)", "sort((3, 1, 2))",
    "for $m in /mcml return sort($m//bone/name)[1]", "count((//bone/name)[4])", "distinct-values(reverse(//bone)/name)",
    "count((//frame)[3])", "min(//@Rx) + 1", "for $i in 1 to 3 return //frame[$i]/@id",
    "count(for $m in /mcml return $m//frame[1])", "head(sort(//@Rx))", "tail(//filename)[position() < 4]",
    "remove(//filename, 2)[3]", "index-of(//bone/name, 'left_up_leg')[2]", "count(//frame intersect //frame[2])",
    "//bone/name ! concat(position(), '/', last(), .)", "(//filename, //bone/name)[11]", "data(//bone/name)[5]",
    "let $x := //bone/name return count($x[. = 'left_up_leg'])",
    "let $x := max(//@Rx) return //frame[frame_bone/@Rx = $x]",
    "for $n in ('left_up_leg', 'Head') return count(//frame_bone[@name = $n])",
    "//frame[every $b in frame_bone satisfies $b/@Rx > 0]",
    "//frame[some $b in frame_bone satisfies $b/@Rx > 5 and $b/@name != 'root']/@id",
    "string-join(//filename ! substring(., 1, 1))", "count(//frame[@id = (1, 3)])",
    "//frame[position() = 2 to 3]/@id", "(for $m in /mcml return count($m//frame)) = 8",
    "for $f in //filename, $i in 1 to 2 return concat($f, $i)", "math:sqrt(count(//frame)) > 4",
    "exists(//frame[9]) and //frame[2]", "for $f in //frame[frame_bone/@Rx > 5] return string($f/frame_bone[1]/@Rx)",
    "sort(//@Rx, (), function($x) { -$x })[1]", "for $m in /mcml return if ($m//frame[3]) then 'long' else 'short'",
    "distinct-values(//frame/string-join(frame_bone/@name, ' '))",
    "replace(string-join(distinct-values(//bone/name), '-'), '[aeiou]', '')",
    "//header/(filename | property)/name(.)", "count(//frame[let $n := count(frame_bone) return $n > 1])",
    "(//frame/@id)[. > 2] ! (. * 2)", "sum(for $x in //frame/@id return $x * 2)", "empty(//frame[@id = 'none'])",
    "1 to count(/mcml)", "avg(()) = 3", "max(//bone/name/string(.))",
    "for $x in //bone/name return string(/mcml/header/filename)", "//bone[name = //bone[2]/name]/name",
    "sort(distinct-values(//frame/count(frame_bone)))", "for $m in /mcml return $m/header/filename || '!'",
    "//filename ! (. => upper-case())", "'' || count(//frame) * 1000000", "(//frame)[7]",
    "(//frame[2], //frame[1])/@id", "count((//frame[1], //frame, //frame[1])/@id)", "(reverse(//bone), //root)/name",
    "(//frame[3], //frame[1], //frame[3])/frame_bone[1]/@name", "(//frame)[position() < 4]/@id", "(//frame)[last()]",
    "sum((//frame)[position() <= 5]/frame_bone/@Rx)", "let $x := //frame return $x[3]/@id", "head(//bone) | //filename",
    "(//frame)[2]/following-sibling::frame[1]", "for $i in 1 to 3 return (//frame)[$i]/@id", "string((//frame)[2]/@id)",
    "if (//frame) then (//bone)[2] else ()", "(//frame)[@id > 1][2]/@id", "count((//frame | //bone)[position() > 4])",
    "for $f in //frame[1] return concat($f/ancestor::mcml/header/filename, $f/@id)",
    "//frame[2] ! string(../../header/filename)", "reverse(//frame)/ancestor::mcml/header/filename",
    "string-join(for $x in /mcml/@* return string($x/../header/filename), ' ')",
    "sort(//frame, (), function($f) { string($f/ancestor::mcml/header/filename) })/@id",
    "(//frame[1], //frame[2])[ancestor::mcml/header/num_frames > 3]/@id", "(//bone) ! (position() * 2)",
    "some $f in //frame satisfies $f/ancestor::mcml/header/filename = 'x'", "//frame/(ancestor::mcml//bone[1]/name)",
    "(//bone)[2] | (//bone)[4]", "sort(//bone/name)[1] | //filename[1]", "((//frame)[position() > 2])[2]/frame_bone[1]",
]  # fmt: skip
BY_TREES = [
    "reverse(for $f in //frame return ($f/@id, 1))", "count(//bone except head(//bone))", "(//frame, 1, //bone/name)",
    "//bone[name = 'left_up_leg'] intersect head(//bone[name = 'left_up_leg'])", "insert-before(//bone/name, 2, 'x')",
    "for $a in /mcml, $b in /mcml return concat($a/header/filename, count($b//frame))",
    "string-join((//frame/@id, 'end', 2), ' ')", "for $f in (//frame)[position() < 3] return ($f/@id, 'of', $f/..)",
]  # fmt: skip
"""Expressions that columns do not answer."""


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Queries, Many]]:
    database = Database(f"sqlite:///{tmp_path_factory.mktemp('whole') / 'store.db'}")
    database.migrate()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(groups, "DOCUMENTS", 3)
        patch.setattr(groups, "MOST_DOCUMENTS", 5)
        many = Many(database, 17, 5, seed=4)
        many.change(restores=False)
        engine = Queries(database, Settings())
        with opened(engine):
            yield engine, many
    database.close()


@pytest.fixture(scope="module")
def saxon() -> Any:
    return PySaxonProcessor(license=False)


def test_there_are_twenty_cases() -> None:
    assert len(CASES) >= 20


@pytest.mark.parametrize("limit", [3, 1000])
@pytest.mark.parametrize("text", [*CASES, *OTHERS])
def test_answers_are_saxons(made: tuple[Queries, Many], saxon: Any, text: str, limit: int) -> None:
    engine, many = made
    expected = whole.answer(saxon, text, many.trees)
    compare(engine, text, expected, limit, None)


@pytest.mark.parametrize("text", [*CASES, *OTHERS])
def test_each_document_answers_alone(made: tuple[Queries, Many], saxon: Any, text: str) -> None:
    engine, many = made
    expected = [item for items in wanted(saxon, text, many.trees) for item in items]
    compare(engine, text, expected, 1000, "document")


def compare(engine: Queries, text: str, expected: list[Any], limit: int, per: str | None) -> None:
    got: list[Any] = []
    for answer in pages(engine, text, [], limit, per=per):
        assert answer.explain is None
        if answer.items is None:
            got += [] if answer.value is None else [answer.value]
        for item in answer.items or []:
            node = isinstance(item, NodeItem)
            got.append((item.document, item.kind, item.address, plain(item.kind, item.value)) if node else item.value)
    same(len(got), len(expected), text)
    for one, other in zip(got, expected, strict=True):
        same_value(one, other, text)


@pytest.mark.parametrize("limit", [3, 1000])
@pytest.mark.parametrize("text", BY_TREES)
def test_answers_of_trees_are_saxons(made: tuple[Queries, Many], saxon: Any, text: str, limit: int) -> None:
    engine, many = made
    compare(engine, text, whole.answer(saxon, text, many.trees), limit, None)


@pytest.mark.parametrize("text", [*CASES, *OTHERS])
def test_all_of_it_is_on_columns(made: tuple[Queries, Many], text: str) -> None:
    explained = made[0].answer(QueryRequest(q=text, limit=1, explain=True)).explain
    assert explained is not None
    assert explained.way in ("columns", "index")
