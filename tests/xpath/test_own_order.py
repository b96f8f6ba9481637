"""Answers in an order of their own: sequences and the best runs, in every form of an answer."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest

from mcml_schemas.querying.queries import NodeItem, QueryRequest, RunItem
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.answer.writing import STREAMS
from mcml_service.xpath.queries import Queries
from tests.builders import bvh, one_kind, store

SEQUENCES = [
    ["//frame[@id=20]", "//frame[@id=10]"],
    ["//frame[position() > 25]", "//frame[position() < 5]", "//frame[position() = 7]"],
    ["//frame[12]", "//frame[12]"],
    ["//frame[3]", "//frame[4]", "//frame[2]"],
    ["//frame[9]/frame_bone[2]", "//frame[9]/frame_bone[1]", "//frame[4]"],
    ["//frame[9]/frame_bone[2]/@Rx", "//frame[3]/@id", "//frame[9]/frame_bone[1]/@Ry"],
]


@pytest.fixture
def engine(database: Database) -> Iterator[Queries]:
    store(database, {"a.bvh": bvh(30), "b.bvh": bvh(30, seed=2)})
    queries = Queries(database, Settings(cache_dir="none"))
    yield queries
    queries.close()


def nodes(engine: Queries, text: str, limit: int = 1000) -> list[tuple[str, str, str]]:
    found: list[tuple[str, str, str]] = []
    request = QueryRequest(q=text, limit=limit)
    while True:
        answer = engine.answer(request)
        found += [(i.document, i.address, i.value) for i in answer.items or [] if isinstance(i, NodeItem)]
        if answer.next_cursor is None:
            return found
        request = QueryRequest(q=text, limit=limit, cursor=answer.next_cursor)


def runs(engine: Queries, text: str) -> list[tuple[str, int, int]]:
    answer = engine.answer(QueryRequest(q=text, limit=1000, **{"as": "runs"}))
    return [(i.document, i.first, i.last) for i in answer.items or [] if isinstance(i, RunItem)]


@one_kind
@pytest.mark.parametrize("parts", SEQUENCES)
def test_a_sequence_is_its_parts_one_after_the_other(engine: Queries, parts: list[str]) -> None:
    text = f"({', '.join(parts)})"
    wanted = [node for part in parts for node in nodes(engine, part)]
    assert nodes(engine, text) == wanted
    assert nodes(engine, text, limit=1) == wanted
    lines = b"".join(STREAMS["ndjson"][0](engine.stream(QueryRequest(q=text)))).splitlines()
    assert [(line["document"], line["address"], line["value"]) for line in map(json.loads, lines)] == wanted


@one_kind
@pytest.mark.parametrize("parts", SEQUENCES)
def test_runs_hold_every_frame_of_a_sequence_in_its_order(engine: Queries, parts: list[str]) -> None:
    frames: list[tuple[str, int]] = []
    for document, address, _ in (node for part in parts for node in nodes(engine, part)):
        place = document, int(address.partition("frame[")[2].partition("]")[0])
        frames += [place] * (not frames or frames[-1] != place)
    found = runs(engine, f"({', '.join(parts)})")
    assert [(document, frame) for document, first, last in found for frame in range(first, last + 1)] == frames


@one_kind
@pytest.mark.parametrize("count", [1, 3, 24])
def test_the_best_runs_are_all_there_the_best_one_first(engine: Queries, count: int) -> None:
    text = "//frame[frame_bone[1]/@Rx > 0]"
    single = runs(engine, text)
    best = runs(engine, f"mo:top({count}, {text})")
    assert sorted(best) == sorted(best_of(single, count))
    assert [last - first for _, first, last in best] == sorted((last - first for _, first, last in best), reverse=True)


def best_of(single: list[tuple[str, int, int]], count: int) -> list[tuple[str, int, int]]:
    return sorted(single, key=lambda run: run[1] - run[2])[:count]
