"""Questions about bodies in motion one by one: contexts, refusals, several documents of a name, runs and pages."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from mcml.errors import QueryError
from mcml_schemas.querying.queries import NodeItem, QueryRequest, RunItem, ScalarItem, ValueItem
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.answer.writing import STREAMS
from mcml_service.xpath.queries import Queries
from tests.builders import ASF, MCML, amc, one_kind, store
from tests.motion.bodies.made import person
from tests.xpath.motion_twin import Document, read_documents

pytestmark = one_kind
FILES = {
    "a.bvh": person(1, 30), "b.bvh": person(2, 20, 1 / 30), "hand.mcml": MCML, "leg.asf": ASF, "leg.amc": amc(4),
}  # fmt: skip


@pytest.fixture
def engine(database: Database) -> Iterator[Queries]:
    store(database, FILES)
    engine = Queries(database, Settings(cache_dir="none"))
    yield engine
    engine.close()


def nodes(engine: Queries, text: str, **asked: Any) -> list[tuple[str, str]]:
    """(name of the document, address) of the nodes of an answer."""
    found = []
    names = {one.uuid: one.name for one in read_documents(engine.database)}
    cursor = None
    while True:
        answer = engine.answer(QueryRequest(q=text, cursor=cursor, **asked))
        found += [(names[i.document], i.address) for i in answer.items or [] if isinstance(i, NodeItem)]
        cursor = answer.next_cursor
        if cursor is None:
            return found


def values(engine: Queries, text: str, **asked: Any) -> list[Any]:
    answer = engine.answer(QueryRequest(q=text, **asked))
    return [item.value for item in answer.items or [] if isinstance(item, ValueItem | ScalarItem)]


def twins(engine: Queries) -> dict[str, Document]:
    return {one.name: one for one in read_documents(engine.database)}


@pytest.mark.parametrize(
    ("text", "column", "what"),
    [
        ("//frame[mo:window(-mo:leg(), 0)]", 19, "the same from in every frame"),
        ("//frame[mo:window(0, position())]", 22, "the same to in every frame"),
        ("mo:runs(//frame, avg(//frame/mo:time()))", 18, "the same least"),
        ("//frame[mo:pose-distance(@id, 1) < 1]", 26, "the same document"),
        ("//frame[mo:rate(position()) > 0]", 17, "cannot ask for position"),
        ("mo:top(2, //frame, last())", 20, "cannot ask for position"),
        ("//frame[mo:angle('left-knee-flexoin') > 0]", 9, "is not the name of an angle"),
        ("//frame[mo:angle('Root', 'Head') > 0]", 9, "three joints"),
        ("//frame[mo:position('Root', 'w') > 0]", 9, "no axis"),
        ("mo:runs('walk', 1)", 9, "where nodes are needed"),
        ("mo:top(1, 3)", 11, "where nodes are needed"),
    ],
)
def test_what_has_no_meaning_is_refused(engine: Queries, text: str, column: int, what: str) -> None:
    with pytest.raises(QueryError, match=what) as caught:
        engine.answer(QueryRequest(q=text))
    assert caught.value.at is not None
    assert caught.value.at.column == column
    assert caught.value.remedy


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("mo:runs(/mcml, 1)", "Runs are of frames"),
        ("mo:top(1, //frame_bone)", "Runs are of frames"),
        ("//frame[mo:window(-1, 0, 'seconds')]", "of seconds, or of 'frames'"),
        ("//frame[mo:pose-distance('nobody', 1) < 1]", "no document 'nobody'"),
        ("//frame[mo:pose-distance('a', 31) < 1]", "no such frames"),
        ("//frame[mo:pose-distance('a', 1.5) < 1]", "no such frames"),
        ("//frame[mo:motion-distance('a', 9, 3) < 1]", "no such frames"),
        ("//frame[mo:pose-distance('a', 0 div 0) < 1]", "Frames have numbers"),
        ("//frame[mo:motion-distance('a', 1, 1 div 0) < 1]", "Frames have numbers"),
    ],
)
def test_what_is_not_there_is_told(engine: Queries, text: str, what: str) -> None:
    with pytest.raises(QueryError, match=what):
        engine.answer(QueryRequest(q=text))


@pytest.mark.parametrize(
    ("text", "per"),
    [
        ("//frame[count(mo:top(1, //frame)) > 0]", None),
        ("mo:top(1, //frame)", "document"),
    ],
)
def test_the_best_are_those_of_the_scope(engine: Queries, text: str, per: str | None) -> None:
    with pytest.raises(QueryError, match="over the whole scope"):
        engine.answer(QueryRequest(q=text, per=per))


@pytest.mark.slow
def test_contexts(engine: Queries) -> None:
    """A node inside of a frame is that frame; a head has no frame, but the document's leg and unit."""
    assert nodes(engine, "//motion_name[mo:time() > 0.05]") == [("hand", "/mcml/motion/frame[3]/motion_name")]
    assert nodes(engine, "//frame_bone/@Tx[mo:time() = 0]") == [
        (name, "/mcml/motion/frame[1]/frame_bone[1]/@Tx") for name in ("a", "b", "hand")
    ]
    assert nodes(engine, "//header[mo:time() >= 0 or mo:contact('Root') or mo:window(-9, 9)]") == []
    assert nodes(engine, "//header[mo:leg() > 0.5]") == [("a", "/mcml/header"), ("b", "/mcml/header")]
    assert nodes(engine, "/mcml[not(mo:unit() > 0)]/header/filename") == []
    assert nodes(engine, "/mcml[not(mo:known(mo:unit()))]/header/filename") == [
        (name, "/mcml/header/filename") for name in ("hand", "leg")
    ]


def test_documents_are_contexts_of_what_is_asked_of_nothing_else(engine: Queries) -> None:
    legs = [one.quantity("leg")[0] for one in twins(engine).values()]
    assert values(engine, "mo:leg() > 0") == [leg > 0 for leg in legs]
    assert values(engine, "mo:leg() * count(//header)")[0] == pytest.approx(legs[0] * len(legs))
    assert values(engine, "mo:height('Root')") == ["NaN"] * len(legs)
    assert values(engine, "not(mo:contact('Root'))") == [False] * len(legs)
    assert values(engine, "mo:known(mo:contact('Root'))") == [False] * len(legs)
    assert values(engine, "(1, 2) ! mo:height('Root')") == ["NaN", "NaN"]


@pytest.mark.slow
def test_bounds_that_are_no_numbers(engine: Queries) -> None:
    """No frames are between such; what has no end ends with the document."""
    everything = nodes(engine, "//frame", limit=1000)
    assert nodes(engine, "//frame[mo:window(0 div 0, 1) or mo:window(0, 0 div 0, 'frames')]") == []
    assert nodes(engine, "//frame[count(mo:window(-1 div 0, 1 div 0, 'frames')) = count(../frame)]") == everything
    assert nodes(engine, "mo:runs(//frame, 0 div 0)") == nodes(engine, "mo:runs(//frame, 1 div 0)") == []
    assert nodes(engine, "mo:top(0 div 0, //frame)") == []
    assert sorted(nodes(engine, "mo:top(1 div 0, //frame, 1)")) == sorted(everything)


@pytest.mark.slow
def test_runs_of_sequences(engine: Queries) -> None:
    """They are those of their nodes, each once, in the order of documents."""
    known = "//frame[mo:time() >= 0]"
    one, two = f"{known}[2]", f"{known}[1]"
    wanted = nodes(engine, f"mo:runs({one} | {two}, 0)")
    assert len(wanted) == 6
    for sequence in (f"({one}, {two})", f"({two}, {one}, {two})", f"mo:top(9, ({one}, {two}))"):
        assert nodes(engine, f"mo:runs({sequence}, 0)") == wanted
        assert nodes(engine, f"mo:top(9, {sequence}, 1)") == wanted
    assert nodes(engine, f"mo:runs(head({known}), 0)") == wanted[:1]


def test_a_frame_bone_is_the_joint_of_its_name(engine: Queries) -> None:
    a = twins(engine)["a"]
    names = [name for name, _ in a.frames[0].bones]
    found = values(engine, "//frame[3]/frame_bone/mo:height(.)", document=[a.uuid], limit=100)
    assert found == [a.quantity("height", name)[2] for name in names]
    both = "//frame[mo:distance(frame_bone[@name='Head'], 'Root') != mo:distance('Root', 'Head')]"
    assert nodes(engine, both, document=[a.uuid]) == []


def test_extremes_of_what_is_not_known(engine: Queries) -> None:
    """As XPath says, NaN; so a document without frame times is not longer than anything."""
    assert engine.answer(QueryRequest(q="max(//frame/mo:time())")).value == "NaN"
    assert engine.answer(QueryRequest(q="max(//frame[mo:time() >= 0]/mo:time())")).value == pytest.approx(19 / 30)
    longer = nodes(engine, "/mcml[max(motion/frame/mo:time()) > 0.1]/header/filename")
    assert [name for name, _ in longer] == ["a", "b"]
    assert nodes(engine, "//frame[min(mo:window(-0.1, 0)[mo:time() >= 0]/mo:speed('Root')) > 1000]") == []


def test_values_of_documents(engine: Queries) -> None:
    found = values(engine, "count(//frame[mo:height('Head') > 1.6])", per="document")
    known = [one for one in twins(engine).values() if not one.lacks("mo:height('Head')")]
    assert len(known) < len(twins(engine))
    wanted = [sum(height > 1.6 for height in one.quantity("height", "Head")) for one in known]
    assert found == wanted
    assert sum(wanted) > 0


@pytest.mark.parametrize("limit", [1, 2, 100])
def test_runs_and_their_pages(engine: Queries, limit: int) -> None:
    text = "mo:runs(//frame[mo:height('left_hand') > 0.9], 0.05, 0.04)"
    twin = twins(engine)
    wanted = []
    for one in twin.values():
        high = [n for n, height in enumerate(one.quantity("height", "left_hand")) if height > 0.9]
        kept = one.long_runs(high, 0.05, 0.04)
        wanted += [(one.uuid, first + 1, last + 1) for first, last in one.runs(kept, 0.0)]
    found = []
    cursor = None
    while True:
        answer = engine.answer(QueryRequest(q=text, limit=limit, cursor=cursor, **{"as": "runs"}))
        found += [(item.document, item.first, item.last) for item in answer.items or [] if isinstance(item, RunItem)]
        cursor = answer.next_cursor
        if cursor is None:
            break
    assert found == wanted
    assert len(wanted) > 1


@pytest.mark.parametrize(
    "text",
    [
        "mo:top(5, //frame[mo:height('left_hand') > 1], mo:speed('left_hand'))",
        "mo:top(5, //frame[mo:height('left_hand') > 1], mo:speed('left_hand'))[2]",
        "mo:top(2, //frame[mo:height('left_hand') > 1])/frame_bone[1]",
        "mo:top(1, mo:top(3, //frame[mo:height('left_hand') > 1], mo:speed('Root')))",
        "mo:runs(//frame[mo:height('left_hand') > 1], 0.05)",
        "//frame[mo:speed('Root') > 1]/frame_bone[mo:height(.) > 1]",
        "(//frame[mo:height('left_hand') > 1])[3]",
    ],
)
def test_streams_are_the_pages(engine: Queries, text: str) -> None:
    names = {one.uuid: one.name for one in read_documents(engine.database)}
    lines = b"".join(STREAMS["ndjson"][0](engine.stream(QueryRequest(q=text)))).splitlines()
    found = [(names[node["document"]], node["address"]) for node in map(json.loads, lines)]
    assert found == nodes(engine, text, limit=11)
    assert found


@pytest.mark.slow
def test_the_best_runs_come_best_first(engine: Queries) -> None:
    """On every page, and as runs; those of one score in the order of the scope."""
    frames = "//frame[mo:height('left_hand') > 1]"
    whole = nodes(engine, f"mo:top(5, {frames}, mo:speed('left_hand'))", limit=1000)
    assert nodes(engine, f"mo:top(5, {frames}, mo:speed('left_hand'))", limit=7) == whole
    runs = engine.answer(QueryRequest(q=f"mo:top(5, {frames}, mo:speed('left_hand'))", **{"as": "runs"})).items or []
    twin = twins(engine)
    found = [
        max(twin[run.name].quantity("speed", "left_hand")[run.first - 1 : run.last])
        for run in runs
        if isinstance(run, RunItem)
    ]
    assert found == sorted(found, reverse=True)
    assert len(found) > 1
    assert nodes(engine, "mo:top(1, //frame[mo:time() = 0], 7)") == [("a", "/mcml/motion/frame[1]")]
    assert nodes(engine, "mo:top(0, //frame)") == nodes(engine, "mo:top(-3, //frame)") == []
    assert nodes(engine, "mo:top(9, //frame[mo:time() = 0], mo:height('nobody'))") == []


@pytest.mark.slow
def test_documents_are_named_by_their_names_or_ids(engine: Queries) -> None:
    twin = twins(engine)["a"]
    by_name = nodes(engine, "//frame[mo:pose-distance('a', 3) < 0.3]")
    assert by_name == nodes(engine, f"//frame[mo:pose-distance('{twin.uuid}', 3) < 0.3]")
    assert ("a", "/mcml/motion/frame[3]") in by_name
    assert values(engine, "//frame[3]/mo:pose-distance('a', 3)", document=[twin.uuid]) == [pytest.approx(0, abs=1e-6)]
    store(engine.database, {"a.bvh": person(3, 5)})
    with pytest.raises(QueryError, match="2 documents are named 'a'") as caught:
        nodes(engine, "//frame[mo:pose-distance('a', 3) < 0.3]")
    assert twin.uuid in (caught.value.remedy or "")


def test_guesses(engine: Queries) -> None:
    """Everything here rests on some: no document is left."""
    assert nodes(engine, "//frame[mo:height('Head') > 0]", guesses="no") == []
    assert len(nodes(engine, "//header", guesses="no")) == 4
    warnings = engine.answer(QueryRequest(q="//frame[mo:height('Head') > 0]")).warnings
    assert any("guesses=no" in one for one in warnings)


def test_guesses_of_documents_that_are_left_out_do_not_count(database: Database) -> None:
    """A document without the joint is left out for that; its guessed unit changes nothing."""
    arms_only = person(2, 6).replace(b"left_foot", b"tail9")
    store(database, {"whole.bvh": person(1, 6), "part.bvh": arms_only})
    engine = Queries(database, Settings(cache_dir="none"))
    try:
        warnings = engine.answer(QueryRequest(q="//frame[mo:speed('left_foot') >= 0]")).warnings
        assert any(each.startswith("1 of 2 documents left out: they lack joints") for each in warnings)
        assert any(each.startswith("1 of 2 documents rest on a guessed unit") for each in warnings)
    finally:
        engine.close()


def test_guessed_names_of_joints(database: Database) -> None:
    """A knee without a word is a guess; questions that do not ask for it do not rest on it."""
    text = person(1, 6).decode().replace("left_low_leg", "Bone12").replace("torso7", "Chest").replace("_up_", "_upper_")
    store(database, {"guessed.bvh": text.encode()})
    engine = Queries(database, Settings(cache_dir="none"))
    try:
        for joint, told in (("left_low_leg", True), ("Head", False)):
            answer = engine.answer(QueryRequest(q=f"//frame[mo:distance('{joint}', 'right_foot') > 0]"))
            assert len(answer.items or []) == 6
            assert any("rest on guessed names of joints" in each for each in answer.warnings) == told
        assert nodes(engine, "//frame[mo:angle('left_up_leg', 'left_low_leg', 'left_foot') > 0]", guesses="no") == []
        assert len(nodes(engine, "//bone[name = 'left_low_leg' and @confidence = 0.6]")) == 1
    finally:
        engine.close()


def test_markers_have_a_body(database: Database, shared: Path) -> None:
    """Centres of joints that markers tell are asked for as joints are."""
    store(database, {"walk.trc": (shared / "trc" / "walk_free_01.trc").read_bytes()})
    engine = Queries(database, Settings(cache_dir="none"))
    try:
        answer = engine.answer(QueryRequest(q="//frame[mo:height('Root') > 0.8 and mo:height('left_toes') < 0.2]"))
        assert len(answer.items or []) > 50
        lacking = engine.answer(QueryRequest(q="//frame[mo:height('left_low_leg') > 0]"))
        assert lacking.items == []
        assert any("lack joints" in each for each in lacking.warnings)
    finally:
        engine.close()


def test_plans_say_what_is_looked_at(engine: Queries) -> None:
    def plan(text: str) -> list[str]:
        explained = engine.answer(QueryRequest(q=text, explain=True)).explain
        assert explained is not None
        return explained.plan

    rise = "//frame[mo:height('Root') - min(mo:window(-1, 0)/mo:height('Root')) > 0.2]"
    assert plan(rise)[-2:] == [
        "columns of mo:height('Root'): a number for every frame of 4 documents",
        "mo:window(-1, 0) of all frames together",
    ]
    fast = plan("count(mo:top(2, //frame, mo:rate(mo:angle('left-knee-flexion'))))")
    assert fast[-1].startswith("columns of mo:rate(mo:angle('left-knee-flexion')), mo:angle('left-knee-flexion'): ")
    assert not any("columns of mo" in step for step in plan("//frame[@id='1']"))
