"""What has no columns, over several documents: its values, and what it must not do: read files, run on, take memory."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from mcml.errors import LimitError, QueryError
from mcml_schemas.querying.queries import NodeItem, QueryRequest, RunItem, ScalarItem, ValueItem
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.bounded_queries import BoundedQueries
from mcml_service.xpath.finding import addresses
from mcml_service.xpath.queries import Queries
from tests.builders import MCML, bvh, store


@pytest.fixture(scope="module")
def queries(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Queries]:
    database = Database(f"sqlite:///{tmp_path_factory.mktemp('saxon') / 'store.db'}")
    database.migrate()
    store(database, {"a.mcml": MCML}, labels=())
    store(database, {"b.bvh": bvh(4)}, labels=())
    engine = Queries(database, Settings())
    yield engine
    engine.close()
    database.close()


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("count(for $f in //frame return ($f, $f))", 14.0),
        ("sum(for $f in //frame return 2)", 14.0),
        ("max(for $f in //frame return count($f/frame_bone))", 3.0),
        ("min(for $f in //frame return count($f/frame_bone))", 1.0),
        ("avg(for $f in //frame return count($f/frame_bone))", 17 / 7),
        ("exists(//frame except //frame[position() <= 3])", True),
        ("empty(//frame except //frame[position() <= 3])", False),
        ("empty(//frame intersect //bone)", True),
        ("string-join(for $b in //bone/name return string($b), ', ')", "left_up_leg, Spine, Head"),
        ("string-join(//bone/name, ', ')", "left_up_leg, Spine, Head"),
        ("max(//frame[@id='none'] except //bone)", None),
    ],
)
def test_calls_around_the_whole_make_one_value_of_all_documents(
    queries: Queries, text: str, value: float | str | bool | None
) -> None:
    answer = queries.answer(QueryRequest(q=text))
    assert answer.items is None
    assert answer.value == pytest.approx(value) if isinstance(value, float) else answer.value == value


def test_different_values_of_all_documents(queries: Queries) -> None:
    answer = queries.answer(QueryRequest(q="distinct-values(for $f in //frame return count($f/frame_bone))"))
    assert [item.value for item in answer.items or [] if isinstance(item, ValueItem)] == [2.0, 1.0, 3.0]


def test_one_value_of_each_document(queries: Queries) -> None:
    answer = queries.answer(QueryRequest(q="if (//frame[@id='5']) then 'five' else string(//frame[1]/@id)"))
    assert [item.value for item in answer.items or [] if isinstance(item, ScalarItem)] == ["five", "1"]


def test_nodes_come_in_pages_and_as_runs(queries: Queries) -> None:
    text = "//frame except //frame[2]"
    addresses: list[str] = []
    cursor = None
    while cursor is not None or not addresses:
        answer = queries.answer(QueryRequest(q=text, limit=2, cursor=cursor))
        addresses += [item.address for item in answer.items or [] if isinstance(item, NodeItem)]
        cursor = answer.next_cursor
    assert addresses == [f"/mcml/motion/frame[{number}]" for number in (1, 3, 1, 3, 4)]
    runs = queries.answer(QueryRequest(q=text, **{"as": "runs"}))
    assert [(r.first, r.last) for r in runs.items or [] if isinstance(r, RunItem)] == [(1, 1), (3, 3), (1, 1), (3, 4)]


@pytest.mark.parametrize(
    "text",
    ["//bone[matches(name, 'none')]", "//bone/(name | length)[. eq 'none']", "for $b in //tail return $b/@id",
     "if (//bone) then //tail else .", "(//tail, //bone[name eq ''])", "//tail/ancestor::bone intersect /"],
)  # fmt: skip
def test_no_nodes_are_nodes_all_the_same(queries: Queries, text: str) -> None:
    answer = queries.answer(QueryRequest(q=text))
    assert (answer.type, answer.items) == ("nodes", [])


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("//frame[. is .]", "nodes", None),
        ("//xs:double(@id)", "values", None),
        ("count(//frame[. is .])", "number", 0.0),
        ("string-join(//frame[. is .]/@id, ', ')", "string", ""),
        ("avg(//frame[. is .]/@id)", "number", None),
    ],
)
def test_of_no_documents(queries: Queries, text: str, kind: str, value: float | str | None) -> None:
    with queries.database.write() as tx:
        tx.projects.get_or_add("empty")
    answer = queries.answer(QueryRequest(q=text, project="empty"))
    assert (answer.type, answer.value) == (kind, value)


def test_functions_may_have_their_prefix(queries: Queries) -> None:
    text = "fn:count(//frame) = 3 and fn:matches('a', 'a')"
    assert queries.answer(QueryRequest(q=text)).value is False
    answer = queries.answer(QueryRequest(q=text, per="document"))
    assert [item.value for item in answer.items or [] if isinstance(item, ScalarItem)] == [True, False]


def test_values_come_in_pages(queries: Queries) -> None:
    values: list[object] = []
    cursor = None
    while cursor is not None or not values:
        answer = queries.answer(QueryRequest(q="for $f in //frame return string($f/@id)", limit=3, cursor=cursor))
        assert answer.type == "values"
        values += [item.value for item in answer.items or [] if isinstance(item, ValueItem)]
        cursor = answer.next_cursor
    assert values == ["1", "2", "5", "1", "2", "3", "4"]


def test_variables_are_bound(queries: Queries) -> None:
    request = QueryRequest(q="for $i in 1 to $n return concat($text, $i)", variables={"n": 2.0, "text": "a'b"})
    values = [item.value for item in queries.answer(request).items or [] if isinstance(item, ValueItem)]
    assert values == ["a'b1", "a'b2"]


@pytest.mark.parametrize(
    "text",
    ["doc('/etc/passwd')", "collection()", "for $x in 'a' return doc($x)", "fn:doc('a')",
     "1 to count(doc-available('a'))", "unparsed-text('/etc/passwd')", "environment-variable('HOME')",
     "function-lookup(xs:QName('fn:doc'), 1)('a')", "doc#1('a')", "'a' => doc()", "error()", "json-doc('a')",
     "let $f := function-lookup(xs:QName('fn:unparsed-text'), 1) return $f('/etc/passwd')",
     "parse-xml('<!DOCTYPE a [<!ENTITY e SYSTEM \"file:///etc/passwd\">]><a>&e;</a>')"],
)  # fmt: skip
def test_nothing_but_the_document_can_be_read(queries: Queries, text: str) -> None:
    with pytest.raises(QueryError):
        queries.answer(QueryRequest(q=text))


def test_nodes_of_several_documents_stream(queries: Queries) -> None:
    """Of each document in turn, at most as many as are asked for; a position around the whole counts over all."""
    every = addresses(queries, QueryRequest(q="//frame[. is .]"))
    assert every == addresses(queries, QueryRequest(q="//frame"))
    assert addresses(queries, QueryRequest(q="//frame[. is .]", limit=4)) == every[:4]
    assert addresses(queries, QueryRequest(q="(//frame[deep-equal(., .)])[5]")) == [every[4]]
    with pytest.raises(QueryError, match="values"):
        addresses(queries, QueryRequest(q="//frame/xs:double(@id)"))


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("map{'a': 1, 'b': (1, 2)}?b", [1, 2]),
        ("[1, [2, 3]]?2?1", 2),
        ("array:size([1, 2, 3])", 3),
        ("fold-left(1 to 5, 0, function($sum, $next) { $sum + $next })", 15),
        ("sort(('b', 'a'))", ["a", "b"]),
        ("format-number(1234.5, '#,##0.00')", "1,234.50"),
        ("xs:date('2026-02-28') + xs:dayTimeDuration('P1D')", "2026-03-01"),
        ("parse-json('[1, 2]')?*", [1, 2]),
        ("9007199254740993 + 2", 9007199254740995),
        ("let $twice := function($n) { 2 * $n } return (1 to 3) ! $twice(.)", [2, 4, 6]),
        ("count(1 to 2000000000)", 2000000000),
        ("(: a comment :) 1", 1),
        ("xs:double('INF')", "Infinity"),
        ("'3' + 1", 4),
        ("'a' = 1", False),
        ("map{'one': [1, 'x']}", '{"one":[1,"x"]}'),
    ],
)
def test_what_asks_no_document_has_one_value(queries: Queries, text: str, values: object) -> None:
    """Of a library of any size, and of none."""
    for project in (None, "nothing here"):
        with queries.database.write() as tx:
            tx.projects.get_or_add("nothing here")
        answer = queries.answer(QueryRequest(q=text, project=project))
        found = answer.value if answer.items is None else [item.value for item in answer.items]  # type: ignore[union-attr]
        assert found == values


@pytest.mark.parametrize(
    ("text", "compatible", "strict"),
    [("'a' = 1", False, "XPTY0004"), ("'3' + 1", 4, "XPTY0004"), ("1 + (2, 3)", 3, "XPTY0004"), ("1 = 1", True, True)],
)
def test_a_request_may_be_strict(queries: Queries, text: str, compatible: object, strict: object) -> None:
    assert queries.answer(QueryRequest(q=text)).value == compatible
    if isinstance(strict, str):
        with pytest.raises(QueryError) as caught:
            queries.answer(QueryRequest(q=text, strict=True))
        assert caught.value.details["xpath_error"] == strict
    else:
        assert queries.answer(QueryRequest(q=text, strict=True)).value == strict
    assert queries.answer(QueryRequest(q="count(//frame[@id castable as xs:integer])", strict=True)).value == 7


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("xs:date('x')", "xs:date"),
        ("'a' = 1", "xs:string"),
        ("xs:date('2026-01-01') + 1", "xs:integer"),
        ("1 + map{}", ""),
    ],
)
def test_errors_name_types_as_xpath_does(queries: Queries, text: str, what: str) -> None:
    with pytest.raises(QueryError) as caught:
        queries.answer(QueryRequest(q=text, strict=True))
    assert what in caught.value.what
    assert "class" not in caught.value.what
    assert "elementpath" not in caught.value.what


def test_nodes_and_maps_of_documents(queries: Queries) -> None:
    answer = queries.answer(QueryRequest(q="//frame ! map{'id': string(@id)} ! ?id"))
    assert [item.value for item in answer.items or [] if isinstance(item, ValueItem)] == [
        "1",
        "2",
        "5",
        "1",
        "2",
        "3",
        "4",
    ]
    answer = queries.answer(QueryRequest(q="for $f in //frame, $g in $f/following-sibling::frame return $g/@id"))
    assert len(answer.items or []) == 9


@pytest.mark.parametrize("text", ["//frame[matches(string-join((1 to 60) ! 'a') || '!', '^(a+)+$') and . is .]",
                                  "sum(for $i in 1 to 100000, $j in 1 to 100000 return $i mod $j)"])  # fmt: skip
def test_what_takes_too_long_is_ended(queries: Queries, text: str) -> None:
    bounded = BoundedQueries(queries.database, Settings(query_seconds=1))
    with pytest.raises(LimitError) as caught:
        bounded.answer(QueryRequest(q=text))
    assert caught.value.details["code"] == "query-timeout"
    bounded.close()
