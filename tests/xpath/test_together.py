"""XPath 3.1 that combines all documents: answers of Saxon and of columns, limits, plans, streams."""

from __future__ import annotations

import json
import sys

import pytest

from mcml.errors import LimitError, QueryError
from mcml_schemas.querying.queries import NodeItem, QueryRequest, RunItem
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath import queries
from mcml_service.xpath.answer.writing import STREAMS
from mcml_service.xpath.queries import Queries
from tests.builders import MCML, store
from tests.motion.bodies.made import person
from tests.xpath.test_flwor import Oracle, engine  # noqa: F401 - a fixture
from tests.xpath.test_tuples import shown

pytestmark = pytest.mark.above_store

TOGETHER = [
    "for $f at $i in D//frame where $i mod 3 = 0 return concat($i, ':', $f/@id)",
    "for $f in D//frame count $n where $n > 10 return $n",
    "for $m in D/mcml order by count($m//frame) descending count $n return concat($n, ' ', $m/header/filename)",
    "for $m in D/mcml, $f in $m//frame group by $n := count($f/frame_bone) order by $n return concat($n, ' ', "
    "count($f), ' ', count($m))",
    "for $m in D/mcml let $c := count($m//frame) group by $k := $c > 5 let $n := string-join($m/header/filename, "
    "'+') order by string($k) return concat(string($k), $n, sum($c))",
    "for $f in D//frame group by $k := string($f/motion_name[1]), $j := count($f/frame_bone) order by count($f) "
    "descending, $k, $j return concat($k, $j, count($f))",
    "for $f in D//frame order by $f/motion_name[1] empty greatest, number($f/@id) return concat($f/@id, "
    "$f/motion_name[1])",
    "for $f in D//frame order by $f/motion_name[1] descending empty greatest, number($f/@id) descending return "
    "concat($f/@id, $f/motion_name[1])",
    "for $x allowing empty in D//nothing return count($x)",
    "for $a in D/mcml for $b in D/mcml where count($a//frame) < count($b//frame) order by count($b//frame) - "
    "count($a//frame), string($a/header/filename) return concat($a/header/filename, '<', $b/header/filename)",
    "fold-left(D//frame/@id, 0, function($a, $b) { $a + number($b) })",
    "fold-right(D//bone/name, '', function($a, $b) { concat($a, '.', $b) })",
    "for-each-pair(D//bone/name, D//frame/@id, function($a, $b) { concat($a, $b) })",
    "filter(D//bone, function($b) { exists($b/bone) }) ! string(name)",
    "for-each(D/mcml, function($m) { count($m//frame) + count(D//frame) })",
    "let $f := D//frame return $f[3]/@id ! string(.)",
    "(D//frame[xs:integer(@id) > 2])[2]/@id ! string(.)",
    "insert-before(D//bone/name, 2, 'x') ! string(.)",
    "deep-equal(D//bone, D//bone)",
    "map:size(map:merge(for $b in D//bone return map{string($b/name): 1}))",
    "array:size(array{D//frame})",
    "let $m := map:merge(for $m in D/mcml return map{string($m/header/filename): count($m//frame)}) return "
    "sort(map:keys($m)) ! concat(., $m(.))",
    "format-number(count(D//frame), '#,##0.00')",
    "string-join(for $i in 1 to 3 return format-integer($i * count(D/mcml), 'w'), ',')",
    "some $x in D//frame satisfies xs:integer($x/@id) = 9",
    "every $x in D//frame satisfies xs:integer($x/@id) < 9",
    "xs:integer(sum(D//frame/@id)) instance of xs:integer",
    "for $b in D//bone return count($b/ancestor::node())",
    "distinct-values(D//frame ! xs:integer(@id))",
    "(D//frame ! xs:integer(@id))[. > 7]",
    "max(D//frame/xs:integer(@id))",
    "avg(D//frame ! xs:integer(@id))",
    "count(D//frame ! xs:integer(@id)) + 1",
    "(1 to 3)[. < xs:integer(count(D/mcml))]",
    "D/mcml => count()",
    "D//frame/@id => sum()",
    "(D//bone/name => distinct-values()) ! upper-case(.)",
    "sort(D//bone/name, (), function($n) { string-length($n) }) ! string(.)",
    "let $all := D//frame/@id ! number(.), $mean := avg($all) return round(sum($all ! ((. - $mean) * (. - $mean))))",
    "for $b in distinct-values(D//bone/name) let $n := count(D//bone[name = $b]) where $n > 1 order by $n "
    "descending, $b return concat($b, ' ', $n)",
    "for $m in D/mcml let $longest := max(D/mcml/count(.//frame)) return xs:string($longest - count($m//frame))",
    "D//frame/xs:integer(@id) ! (. * 2)",
    "count((D//frame, D//bone, xs:integer(3)))",
    "outermost(D//bone) ! string(name)",
    "innermost(D//bone) ! string(name)",
    "head(D//bone) ! string(name)",
    "has-children(head(D//bone))",
    "count(D//bone except head(D//bone))",
    "function-lookup(xs:QName('fn:count'), 1)(D//frame)",
    "apply(count#1, [D//frame])",
    "for $k in ('x', 'y') for $m at $p in D/mcml where $p < 3 return concat($k, $p, count($m//bone))",
    "parse-json('[1,2]')?* ! (. + count(D/mcml))",
    "let $s := function($x) { count(D//frame[@id = $x]) } return (1 to 3) ! $s(.)",
    "string-join(D/mcml ! string(count(root(.)//frame)), ' ')",
    "string-join(D//frame[last()] ! path(.), ' ')",
    "(D//frame, D//bone)[position() = (1, last())] ! name(.)",
    "let $b := (D//bone)[5] return D//bone ! (if (. << $b) then 'before' else if (. is $b) then 'it' else 'after')",
]
"""What combines all documents and has no columns."""


def span(run: RunItem) -> range:
    return range(run.first, run.last + 1)


@pytest.mark.parametrize("asked", TOGETHER)
@pytest.mark.parametrize("kind", ["sqlite"], indirect=True)
def test_all_documents_together_are_saxons(engine: tuple[Queries, Oracle], asked: str) -> None:  # noqa: F811
    held, oracle = engine
    wanted = oracle.values(asked.replace("D/", "$d/"))
    assert shown(held.answer(QueryRequest(q=asked.replace("D/", "/"), limit=1000))) == wanted
    assert wanted


WITH_VALUES = [
    "format-number(count(//frame), '#,##0.00')",
    "concat(string(//filename), ' ', count(//frame), xs:string(1))",
    "map{'a': string(//filename), 'n': count(//frame), 'h': max(//frame_bone/@Rx), 'e': min(//frame_bone/@none)}",
    "xs:integer(sum(//frame/@id)) instance of xs:integer",
    "(count(//frame), sum(//frame/@id), avg(//frame/@id), exists(//nothing)) ! (. instance of xs:integer)",
    "let $n := count(//frame) return for $m in /mcml, $b in $m//bone return xs:integer($n) + count($b)",
    "for $n in (1, 2) return xs:integer(count(//frame[@id = $n]))",
    "//frame[xs:integer(@id) > count(//bone)]/@id ! string(.)",
    "fn:count(//frame) + xs:integer(1)",
    "format-number(avg(//nothing), '0')",
    "fold-left((1, 2), count(//frame), function($a, $b) { $a + $b * count(/mcml) })",
    "xs:string(count(tokenize(string(//filename), 'a')))",
    "string-join((count(//frame), 'of \"count(//frame)\"', xs:string(empty(//frame[9]))), ' ')",
]


@pytest.mark.parametrize("asked", WITH_VALUES)
@pytest.mark.parametrize("kind", ["sqlite"], indirect=True)
def test_values_of_columns_are_those_of_trees(
    engine: tuple[Queries, Oracle],  # noqa: F811
    asked: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Numbers of all documents, which columns have, in expressions that they do not answer."""
    found = engine[0].answer(QueryRequest(q=asked))
    monkeypatch.setattr(queries, "ONE_VALUE", frozenset())
    assert shown(found) == shown(engine[0].answer(QueryRequest(q=asked)))
    assert shown(found)


def test_numbers_need_no_trees(database: Database) -> None:
    store(database, {"a.bvh": person(1, 30), "b.bvh": person(2, 30)})
    held = Queries(database, Settings(cache_dir="none", query_elements=1000))
    answer = held.answer(QueryRequest(q="format-number(count(//frame_bone) div count(//frame), '0.0')", explain=True))
    assert answer.explain is not None
    assert answer.explain.way != "projection"
    assert answer.value == "21.0"
    held.close()


BODIES = [
    ("//frame ! mo:height('left_hand')", "array{//frame ! mo:height('left_hand')}?*"),
    ("//frame ! mo:time()", "map{'t': //frame ! mo:time()}?t"),
    ("//frame ! count(mo:window(-0.1, 0.1))", "array{//frame ! count(mo:window(-0.1, 0.1))}?*"),
    ("//frame_bone ! mo:height(.)", "array{//frame_bone ! mo:height(.)}?*"),
    (
        "max(//frame ! mo:speed('Head'))",
        "fold-left(//frame ! mo:speed('Head'), (), function($a, $b) { max(($a, $b)) })",
    ),
    ("/mcml ! mo:leg()", "array{/mcml ! mo:leg()}?*"),
]
"""On columns, and where all documents are trees."""


@pytest.mark.parametrize(("columns", "trees"), BODIES)
@pytest.mark.parametrize("kind", ["sqlite"], indirect=True)
def test_bodies_are_those_of_columns(database: Database, columns: str, trees: str) -> None:
    store(database, {"a.bvh": person(1, 12), "hand.mcml": MCML, "b.bvh": person(2, 9, 1 / 30)})
    held = Queries(database, Settings(cache_dir="none"))
    wanted = shown(held.answer(QueryRequest(q=columns, limit=1000)))
    answer = held.answer(QueryRequest(q=trees, limit=1000, explain=True))
    assert answer.explain is not None
    assert (answer.explain.way, shown(answer)) == ("projection", wanted)
    assert len(set(wanted)) > 1 or columns.startswith("max")
    held.close()


@pytest.mark.parametrize(
    "asked",
    [
        "concat(string(//filename), count(tail(//frame ! xs:double(mo:height('Head')))))",
        "array{mo:runs(//frame, 1)}",
    ],
)
@pytest.mark.parametrize("kind", ["sqlite"], indirect=True)
def test_bodies_of_each_document_beside_all_are_refused(engine: tuple[Queries, Oracle], asked: str) -> None:  # noqa: F811
    with pytest.raises(QueryError, match="combines all documents") as caught:
        engine[0].answer(QueryRequest(q=asked))
    assert "per=document" in str(caught.value.remedy)


@pytest.mark.parametrize("kind", ["sqlite"], indirect=True)
def test_documents_together_are_limited(database: Database) -> None:
    store(database, {"a.bvh": person(1, 30), "b.bvh": person(2, 30)})
    held = Queries(database, Settings(cache_dir="none", query_elements=1000))
    assert shown(held.answer(QueryRequest(q="format-number(count(//bone), '0.0')")))
    asked = "count(//frame_bone ! xs:string(@name))"
    assert shown(held.answer(QueryRequest(q=f"1 + {asked}", per="document")))
    with pytest.raises(LimitError, match="of 2 documents together, the limit is 1,000"):
        held.answer(QueryRequest(q=f"1 + {asked}"))
    held.close()


TOO_DEEP = [
    "xs:integer(count(reverse(//" + "/".join(["*"] * 1000) + "))) + xs:integer(1)",
    "xs:integer(1) = 1 and (" + " or ".join(["//frame = 1"] * 400) + ")",
    "fold-left(//frame, 0, function($a, $b) { $a }) + xs:integer(" + " + ".join(["1"] * 1000) + ")",
    "//frame" + " ! (.)" * 1000 + " ! xs:string(@id)",
]
DEEP = [
    "for $a in //frame, $z in 1 order by xs:integer(1) return " + "for $a in ($a) return " * 400 + "xs:string($a)",
    "(//frame)" + "[xs:boolean(1)]" * 400,
]
"""Python 3.11 counts calls of C as well and refuses these; later versions answer."""


@pytest.mark.parametrize(
    ("asked", "plan"),
    [
        ("for $a in /mcml, $b in //bone order by $b/name return $b/name", "all together, without frames"),
        ("fold-left(//frame/@id, 0, function($a, $b) { $a + $b })", "all together, without the bones of frames"),
        ("//frame_bone/xs:double(@Rx)", "one after the other, whole"),
    ],
)
@pytest.mark.parametrize("kind", ["sqlite"], indirect=True)
def test_the_plan_says_how_documents_are_read(engine: tuple[Queries, Oracle], asked: str, plan: str) -> None:  # noqa: F811
    explained = engine[0].answer(QueryRequest(q=asked, explain=True)).explain
    assert explained is not None
    assert (explained.plan, explained.documents) == ([f"the documents as trees, {plan}"], 4)


@pytest.mark.parametrize("asked", TOO_DEEP)
@pytest.mark.parametrize("kind", ["sqlite"], indirect=True)
def test_depth_is_limited(engine: tuple[Queries, Oracle], asked: str) -> None:  # noqa: F811
    with pytest.raises(LimitError, match="too deeply"):
        engine[0].answer(QueryRequest(q=asked))


@pytest.mark.parametrize("asked", DEEP)
@pytest.mark.parametrize("kind", ["sqlite"], indirect=True)
def test_deep_expressions_are_answered_or_refused(engine: tuple[Queries, Oracle], asked: str) -> None:  # noqa: F811
    if sys.version_info >= (3, 12):
        assert shown(engine[0].answer(QueryRequest(q=asked)))
    else:
        with pytest.raises(LimitError, match="too deeply"):
            engine[0].answer(QueryRequest(q=asked))


@pytest.mark.parametrize(
    "asked",
    [
        "(//frame[xs:integer(@id) > 1])[position() < 6]",
        "for $m in /mcml, $f in $m//frame order by xs:integer($f/@id) descending return $f",
        "map{'a': //frame}?a",
    ],
)
@pytest.mark.parametrize("kind", ["sqlite"], indirect=True)
def test_streams_and_runs_are_those_of_all_documents(engine: tuple[Queries, Oracle], asked: str) -> None:  # noqa: F811
    held, _ = engine
    items = held.answer(QueryRequest(q=asked, limit=1000)).items or []
    wanted = [(item.document, item.address) for item in items if isinstance(item, NodeItem)]
    lines = b"".join(STREAMS["ndjson"][0](held.stream(QueryRequest(q=asked)))).splitlines()
    assert [(json.loads(line)["document"], json.loads(line)["address"]) for line in lines] == wanted
    runs = held.answer(QueryRequest(q=asked, limit=1000, **{"as": "runs"})).items or []
    covered = [(run.document, frame) for run in runs if isinstance(run, RunItem) for frame in span(run)]
    assert sorted(covered) == sorted((document, int(address.rpartition("[")[2][:-1])) for document, address in wanted)
    assert not any((run.document, run.last + 1) in covered for run in runs if isinstance(run, RunItem))
    assert len(wanted) > 2
