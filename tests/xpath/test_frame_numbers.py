"""Frames by conditions on their ids or positions alone: for every kind of ids what libxml2 answers."""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

import pytest

from mcml_schemas.querying.queries import QueryRequest
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.nodes import number_runs
from mcml_service.xpath.queries import Queries
from tests.builders import MCML, mcml_of, store
from tests.xpath.library import exported
from tests.xpath.oracle import check

pytestmark = pytest.mark.above_store

IDS: dict[str, list[int | str]] = {
    "plain": list(range(1, 40)),
    "later": list(range(7000, 7030)),
    "sparse": list(range(3, 90, 3)),
    "backwards": list(range(20, -5, -1)),
    "repeated": [4, 4, 4, 7, 7, 8],
    "texts": ["a", "b", "007", " 7 ", "7.0", "1e1", "-0", "+5", "NaN"],
    "mixed": [1, 2, 3, "x", 4, 5, "05", 6, 7],
    "large": [2**53 - 1, 2**53, 2**53 + 1, 2**53 + 2],
    "far": [1, 10**12, 2, 5],
    "one": [7],
    "none": [],
}
NUMBERS = ("7", "4", "0", "-2", "3.5", "7029", "8", "9007199254740992", "1 div 0", "0 div 0", "-0")
TEXTS = ("'7'", "'007'", "'a'", "' 7 '", "'7.0'", "''", "'-2'", "'9007199254740993'")
OPERATORS = ("=", "!=", "<", "<=", ">", ">=")


def make_condition(rng: Random, own: tuple[str, ...], texts: tuple[str, ...], depth: int = 0) -> str:
    """A condition on some spellings of one number."""
    kind = rng.randrange(8 if depth < 3 else 4)
    if kind < 4:
        left = rng.choice(own)
        if rng.random() < 0.3:
            left = rng.choice(
                (f"{left} mod 3", f"{left} * 2 - 1", f"floor({left} div 4)", f"-{left}", f"round({left})")
            )
        sides = [left, rng.choice(NUMBERS + texts if left in own else NUMBERS)]
        rng.shuffle(sides)
        return f"{sides[0]} {rng.choice(OPERATORS)} {sides[1]}"
    if kind == 4:
        return f"not({make_condition(rng, own, texts, depth + 1)})"
    if kind == 5 and "@id" in own:
        return f"@id[{make_condition(rng, ('.', 'number(.)'), texts, depth + 1)}]"
    joint = f" {rng.choice(('and', 'or'))} "
    return "(" + joint.join(make_condition(rng, own, texts, depth + 1) for _ in range(2)) + ")"


def make_question(rng: Random) -> str:
    if rng.random() < 0.35:
        first = make_condition(rng, ("position()",), ())
        predicates = [first, *([make_condition(rng, ("@id",), TEXTS)] if rng.random() < 0.4 else [])]
    else:
        predicates = [make_condition(rng, ("@id", "number(@id)"), TEXTS) for _ in range(rng.choice((1, 1, 2)))]
        if rng.random() < 0.2:
            predicates.append(make_condition(rng, ("position()",), ()))
    if rng.random() < 0.2:
        predicates.insert(rng.randrange(len(predicates) + 1), "motion_name='walk'")
    path = "//frame" + "".join(f"[{one}]" for one in predicates) + rng.choice(("", "", "/@id", "/frame_bone/@Rx"))
    return f"count({path})" if rng.random() < 0.4 else path


@pytest.fixture
def engine(database: Database) -> Iterator[Queries]:
    files = {f"{name}.mcml": mcml_of(ids) for name, ids in IDS.items()} | {"hand.mcml": MCML}
    store(database, files)
    engine = Queries(database, Settings(query_seconds=600, cache_dir="none"))
    yield engine
    engine.close()


def compare(engine: Queries, questions: int, seed: int) -> None:
    rng = Random(seed)
    documents = dict(exported(engine.database))
    filled = 0
    for _ in range(questions):
        outcome = check(engine, documents, make_question(rng), rng, whole=True)
        filled += outcome is not None and outcome.filled
    assert filled > questions // 4


def test_answers_are_libxml2s(engine: Queries) -> None:
    compare(engine, 150, 1)


def test_numbers_that_are_too_many_are_looked_at_one_by_one(engine: Queries, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(number_runs, "MOST_NUMBERS", 10)
    compare(engine, 60, 2)


@pytest.mark.fuzz
@pytest.mark.parametrize("seed", range(20))
def test_answers_are_libxml2s_many_times(engine: Queries, seed: int) -> None:
    compare(engine, 500, seed)


@pytest.mark.parametrize(
    ("text", "way"),
    [
        ("//frame[@id >= 20 and @id <= 90]", "frames with @id >= 20 and @id <= 90, by arithmetic on runs of ids"),
        ("//frame[not('7' = @id)]", "frames with not(@id = 7), by arithmetic on runs of ids"),
        ("//frame except //frame[@id > 3]", "frames with not(@id > 3), by arithmetic on runs of ids"),
        ("//frame[position() mod 10 = 1]", "frames with position() mod 10 = 1, by arithmetic on positions"),
    ],
)
def test_the_plan_says_so(engine: Queries, text: str, way: str) -> None:
    plan = engine.answer(QueryRequest(q=text, explain=True)).explain
    assert plan is not None
    assert way in plan.plan
