"""What is unknown about a body is neither true nor false, whatever stands around it, in every engine."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from mcml.errors import QueryError
from mcml_schemas.querying.queries import NodeItem, QueryRequest
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.queries import Queries
from tests.builders import bvh, one_kind, store
from tests.motion.bodies.made import person

UNKNOWN = [
    "mo:speed('nothere') > 1",
    "not(mo:speed('nothere') > 1)",
    "mo:speed('nothere') != 1",
    "mo:speed('nothere') = mo:speed('nothere')",
    "not(not(mo:speed('nothere') > 1))",
    "not(mo:speed('nothere') > 1 and @id = 3)",
    "not(mo:speed('nothere') > 1 or @id = 3)",
    "not(mo:speed('nothere'))",
    "boolean(mo:speed('nothere'))",
    "not(mo:contact('nothere'))",
    "mo:contact('nothere') or true()",
    "count(../frame[mo:speed('nothere') > 1]) = 0",
    "empty(../frame[mo:contact('nothere')])",
    "not(../frame[mo:contact('nothere')])",
    "every $j in ('nothere', 'Head') satisfies mo:speed($j) < 1000",
    "not(some $j in ('nothere') satisfies mo:speed($j) < 1000)",
    "if (mo:contact('nothere')) then false() else true()",
    "not(mo:speed('nothere') > 1)][xs:double(@id) > 0",
    "not(mo:speed('nothere') gt 1)",
    "not(mo:speed('nothere') + 1 > 1)",
    "not(frame_bone/mo:speed('nothere') > 1)",
    "not(mo:rate(mo:height('nothere')) > 1)",
]


@pytest.fixture
def engine(database: Database) -> Iterator[Queries]:
    store(database, {"body.bvh": person(40), "other.bvh": bvh(30), "third.bvh": bvh(20)})
    queries = Queries(database, Settings(cache_dir="none"))
    yield queries
    queries.close()


def names(engine: Queries, text: str) -> set[str]:
    answer = engine.answer(QueryRequest(q=text, limit=1000))
    return {item.document for item in answer.items or [] if isinstance(item, NodeItem)}


@one_kind
@pytest.mark.parametrize("condition", UNKNOWN)
def test_no_document_is_in_an_answer_that_is_left_out_of_it(engine: Queries, condition: str) -> None:
    answer = engine.answer(QueryRequest(q=f"//frame[{condition}]", limit=1000))
    assert not answer.items
    assert engine.answer(QueryRequest(q=f"count(//frame[{condition}])")).value == 0
    assert not engine.answer(QueryRequest.model_validate({"q": f"//frame[{condition}]", "as": "runs"})).items


@one_kind
def test_counts_say_who_is_left_out(engine: Queries) -> None:
    answer = engine.answer(QueryRequest(q="count(//frame[not(mo:contact('left_foot'))])"))
    assert answer.value == 40
    assert any(one.startswith("2 of 3 documents left out: they lack joints") for one in answer.warnings)
    each = engine.answer(QueryRequest(q="count(//frame[not(mo:contact('left_foot'))])", per="document"))
    assert (each.value, each.items) == (40, None)


@one_kind
def test_both_halves_are_what_is_known(engine: Queries) -> None:
    """A condition, its opposite, and what is unknown are all there is."""
    for condition in ("mo:speed('left_hand') > 3.3", "mo:contact('left_toes')", "mo:height('Head') < 1.6"):
        asked = condition.split(" ")[0]
        counts = [
            engine.answer(QueryRequest(q=f"count(//frame[{one}])")).value
            for one in (condition, f"not({condition})", f"not(mo:known({asked}))")
        ]
        assert sum(map(float, counts)) == 90, (condition, counts)  # type: ignore[arg-type]  # numbers
        assert counts[2] == 50


@one_kind
def test_values_outside_of_conditions_are_shown(engine: Queries) -> None:
    answer = engine.answer(QueryRequest(q="//frame[2]/mo:speed('left_hand')"))
    assert [item.value == "NaN" for item in answer.items or []].count(True) == 2
    assert any("have no value" in one for one in answer.warnings)


def test_what_asks_no_body_stays_as_it_is() -> None:
    for text in ("//frame[not(@id > 3)]", "//frame[@id != 3]", "count(//frame[not(frame_bone/@Rx > 3)])"):
        assert parse(text).text == parse(text).text.replace("known", "")


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("//frame[not(mo:speed('a') > 1)]", "mo:speed('a') <= 1"),
        ("//frame[mo:speed('a') != 1]", "mo:speed('a') < 1 or mo:speed('a') > 1"),
        ("//frame[not(mo:contact('a'))]", "not(mo:contact('a')) and mo:known(mo:contact('a'))"),
        ("//frame[not(mo:speed('a') > 1 and @id = 3)]", "mo:speed('a') <= 1 or not(attribute::id = 3)"),
    ],
)
def test_conditions_are_rewritten(text: str, tree: str) -> None:
    assert parse(text).text.partition("[")[2].removesuffix("]").replace("@", "attribute::") in (tree, f"{tree}")


@pytest.mark.parametrize(
    ("condition", "is_refused"),
    [
        ("mo:speed('Head') != 1", True),
        ("mo:speed('Head') ne 1", True),
        ("@id and (if (mo:contact('Head')) then false() else true())", True),
        ("frame_bone[mo:speed('Head') != 1]", True),
        ("mo:known(mo:speed('Head')) and mo:speed('Head') != 1", False),
        ("not(mo:speed('Head') = 1)", False),
        ("mo:speed('Head') > 1][@id != '3'", False),
        ("mo:speed('ne') > 1 or @ne = 'if ('", False),
        ("@id != '3'", False),
    ],
)
def test_what_only_saxon_reads_takes_nothing_unknown_as_known(condition: str, is_refused: bool) -> None:
    text = f"//frame[{condition}][xs:double(@id) > 0]"
    if not is_refused:
        parse(text)
        return
    with pytest.raises(QueryError, match="unknown as known") as told:
        parse(text)
    assert told.value.at is not None
    assert "mo:known" in (told.value.remedy or "")
