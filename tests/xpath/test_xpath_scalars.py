"""Answers that have one form only, and `(…)[n]` in every spelling and form."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from mcml.errors import QueryError
from mcml_schemas.querying.queries import QueryRequest
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.queries import Queries
from tests.builders import bvh, store

pytestmark = pytest.mark.above_store


@pytest.fixture
def queries(database: Database) -> Iterator[Queries]:
    store(database, {"a.bvh": bvh(30)}, labels=())
    store(database, {"b.bvh": bvh(30, seed=1)}, labels=())
    engine = Queries(database, Settings())
    yield engine
    engine.close()


@pytest.mark.parametrize(
    "text", ["(//frame_bone[@Rx>-99])[2]", "(//frame_bone[@Rx>-99]) [ 2 ]", "((//frame_bone[@Rx>-99])[2.0])"]
)
def test_the_nth_of_all_documents_together(queries: Queries, text: str) -> None:
    nodes = queries.answer(QueryRequest(q=text))
    assert nodes.items is not None
    assert [item.address for item in nodes.items] == ["/mcml/motion/frame[1]/frame_bone[2]"]  # type: ignore[union-attr]
    runs = queries.answer(QueryRequest(q=text, **{"as": "runs"}))
    assert runs.items is not None
    assert [(item.first, item.last) for item in runs.items] == [(1, 1)]  # type: ignore[union-attr]


@pytest.mark.parametrize("form", ["runs", "xml"])
@pytest.mark.parametrize("text", ["count(//frame)", "1 + 1", "sum(//@Tx)", "boolean(//frame[motion_name='walk'])"])
def test_a_value_is_no_node_set(queries: Queries, text: str, form: str) -> None:
    with pytest.raises(QueryError, match="not a node set"):
        queries.answer(QueryRequest(q=text, **{"as": form}))  # type: ignore[arg-type]
