"""The W3C's cases of XPath 3.1 that need no document (qt3tests), as the repository answers them."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from mcml.errors import McmlError
from mcml_schemas.querying.queries import QueryRequest
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.bounded_queries import BoundedQueries
from tests.fuzz import share
from tests.xpath.qt3 import Case, RefusalError, judge, read_cases

FOLDER = Path(os.environ.get("MCML_SHARED", "../shared")) / "data" / "qt3"
LEAST = {False: 0.97, True: 0.98}
"""Share that is right, by strict: the mode compatible with XPath 1.0 gives values where errors are expected."""
PARTS = 10


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[BoundedQueries]:
    database = Database(f"sqlite:///{tmp_path_factory.mktemp('qt3') / 'store.db'}")
    database.migrate()
    queries = BoundedQueries(database, Settings())
    yield queries
    queries.close()
    database.close()


@pytest.mark.skipif(not FOLDER.is_dir(), reason="the W3C's suite is not here")
@pytest.mark.parametrize("strict", [False, True])
@pytest.mark.parametrize("part", share(range(PARTS), PARTS))
def test_answers_are_those_of_the_w3c(engine: BoundedQueries, part: int, strict: bool) -> None:
    def ask(expression: str) -> bool:
        if not 0 < len(expression) <= 10_000:
            raise RefusalError("too long")
        try:
            answer = engine.answer(QueryRequest(q=expression, strict=strict))
        except McmlError as error:
            raise RefusalError(str(error)) from None
        if not isinstance(answer.value, bool):
            raise RefusalError(f"no truth: {answer.value!r}")
        return answer.value

    verdicts: Counter[str] = Counter()
    others: list[tuple[str, Case]] = []
    for case in list(read_cases(FOLDER))[part::PARTS]:
        verdict = judge(case, ask)
        verdicts[verdict] += 1
        if verdict != "right":
            others.append((verdict, case))
    assert verdicts.total() > 900
    assert verdicts["right"] >= LEAST[strict] * verdicts.total(), [(v, case.name) for v, case in others]
