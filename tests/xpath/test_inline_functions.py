"""Inline functions and maps over several documents: their bodies are read as the rest of an expression."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from mcml.errors import QueryError
from mcml_schemas.querying.queries import QueryAnswer, QueryRequest, ScalarItem, ValueItem
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.queries import Queries
from tests.builders import bvh, store


@pytest.fixture
def queries(database: Database) -> Iterator[Queries]:
    store(database, {"a.bvh": bvh(6, seed=2), "b.bvh": bvh(9, seed=3)})
    made = Queries(database, Settings())
    yield made
    made.close()


def values_of(answer: QueryAnswer) -> list[object]:
    if answer.items is None:
        return [answer.value]
    return [item.value for item in answer.items if isinstance(item, ValueItem | ScalarItem)]


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("for-each((1, 2), function($x) { $x + $n })", [6, 7]),
        ("map{'a': $n}?a", [5]),
        ("let $f := function($x) { map{'b': $x * $n} } return $f(2)?b", [10]),
    ],
)
def test_variables_of_the_request_have_their_value_in_functions_and_maps(
    queries: Queries, text: str, values: list[object]
) -> None:
    assert values_of(queries.answer(QueryRequest(q=text, variables={"n": 5}))) == values


@pytest.mark.parametrize("text", ["for-each((1, 2), function($x) { $x + $m })", "map{'a': $m}?a"])
def test_variables_without_a_value_are_told(text: str) -> None:
    with pytest.raises(QueryError, match=r"the variable \$m has no value"):
        parse(text)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("for-each((1, 2), function($x) { $x + count(//frame) })", [16, 17]),
        ("filter((1, 2, 3), function($x) { $x <= count(/mcml) })", [1, 2]),
        ("map{'n': count(//frame)}?n", [15]),
    ],
)
def test_functions_that_need_all_documents_are_asked_of_all(queries: Queries, text: str, values: list[object]) -> None:
    assert values_of(queries.answer(QueryRequest(q=text))) == values
    assert values_of(queries.answer(QueryRequest(q=text, per="document")))


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("insert-before((1, 2, 3), count(/mcml), 9)", [1, 9, 2, 3]),
        ("(1, 2, 3)[. = count(/mcml)]", [2]),
        ("(10, 20, 30)[count(/mcml)]", [20]),
        ("(1 to 20)[. mod count(//frame) = 0] ! (. + count(/mcml))", [17]),
    ],
)
def test_values_of_all_documents_are_answered_once(queries: Queries, text: str, values: list[object]) -> None:
    assert values_of(queries.answer(QueryRequest(q=text))) == values


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("for-each(/mcml, function($m) { count($m//frame) })", [6, 9]),
        ("for-each((1, 2), function($x) { -$x })", [-1, -2]),
    ],
)
def test_functions_of_one_document_are_answered(queries: Queries, text: str, values: list[object]) -> None:
    assert values_of(queries.answer(QueryRequest(q=text))) == values
