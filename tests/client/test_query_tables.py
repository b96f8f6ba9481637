"""Answers of questions as tables: every value has its document, frame and time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

import mcml
from mcml.client.repository import Repository
from mcml.errors import QueryError
from mcml_service.storage.database import Database
from tests.builders import bvh, one_kind, store
from tests.motion.bodies.made import person

pytest.importorskip("pandas")


@pytest.fixture
def repo(database: Database, database_url: str) -> Iterator[Repository]:
    store(database, {"body.bvh": person(40), "other.bvh": bvh(10)})
    with mcml.open(database_url) as found:
        yield found


@one_kind
def test_values_of_frames_have_their_frames(repo: Repository) -> None:
    query = repo.xpath("//frame[mo:known(mo:speed('right_hand'))]/mo:speed('right_hand')")
    table = query.to_pandas()
    assert list(table.columns) == ["document", "frame", "time", "value"]
    assert table["value"].tolist() == query.value()
    assert len(table) > 30
    body = next(document for document in repo.documents() if document.name.startswith("body"))
    assert set(table["document"]) == {body.id}
    assert np.allclose(table["time"], (table["frame"] - 1) * body.frame_time)
    runs = repo.xpath("//frame[mo:known(mo:speed('right_hand'))]").runs()
    assert table["frame"].tolist() == [frame for run in runs for frame in range(run.first, run.last + 1)]


@one_kind
def test_frames_with_quantities(repo: Repository) -> None:
    table = repo.xpath("//frame[@id < 8]").to_pandas(speed="mo:speed('right_hand')", up="mo:height('Head')")
    assert list(table.columns[:3]) == ["document", "frame", "time"]
    assert len(table) == 14
    assert table["speed"].notna().sum() == 7
    assert (
        table.loc[table["speed"].notna(), "speed"].tolist()
        == repo.xpath("//frame[@id < 8][mo:known(mo:speed('right_hand'))]/mo:speed('right_hand')").value()
    )


@one_kind
def test_loops_and_scalars(repo: Repository) -> None:
    table = repo.xpath("for $f in //frame return $f/mo:speed('right_hand')").to_pandas()
    assert len(table) == 50
    assert table["frame"].tolist() == [*range(1, 41), *range(1, 11)]
    assert len(repo.xpath("count(//frame)", per="document").to_pandas()) == 2


@one_kind
def test_nodes_are_no_value(repo: Repository) -> None:
    for text in ("//frame", "//nothing", "//frame/@id"):
        with pytest.raises(QueryError, match="nodes, not a value"):
            repo.xpath(text).value()


@one_kind
@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("for $f in //frame return mo:speed('right_hand')", "$f/mo:speed"),
        ("mo:height('Head')", "//frame/mo:height"),
        ("some $f in //frame satisfies mo:height('Head') > 1", "$f/mo:height"),
    ],
)
def test_who_asks_the_document_is_told_what_is_meant(repo: Repository, text: str, meant: str) -> None:
    (page,) = repo.xpath(text)._pages("json")
    assert any(meant in warning for warning in page.warnings)


@one_kind
@pytest.mark.parametrize(
    "text",
    ["//frame/mo:speed('right_hand')", "//motion/count(frame)", "for $f in //frame return $f/mo:speed('right_hand')"],
)
def test_right_questions_get_no_hint(repo: Repository, text: str) -> None:
    pages = list(repo.xpath(text)._pages("json"))
    assert not any("is in no frame" in warning or "holds no" in warning for warning in pages[0].warnings)
