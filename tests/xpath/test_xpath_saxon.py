"""What Saxon answers over several documents, and what it must not do: read files, run on, take all memory."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator

import psutil
import pytest

from mcml.errors import LimitError, QueryError
from mcml_schemas.querying.queries import NodeItem, QueryRequest, RunItem, ScalarItem, ValueItem
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.finding import addresses
from mcml_service.xpath.limits import Limits
from mcml_service.xpath.queries import Queries
from mcml_service.xpath.xml import saxon
from mcml_service.xpath.xml.saxon import Saxon
from tests.builders import MCML, bvh, store

DOCUMENT = b"<mcml><motion><frame id='1'/><frame id='2'/></motion></mcml>"


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


@pytest.fixture
def pool() -> Iterator[Saxon]:
    made = Saxon(processes=1)
    yield made
    made.close()


def ask(pool: Saxon, text: str, seconds: float = 10, client: str = "") -> list[object]:
    limits = Limits(seconds, 1000, client)
    return list(pool.items(text, [DOCUMENT], variables={}, offset=0, limit=100, limits=limits).items)


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
     "for $x in (//a) return trace($x, 'b')",
     "static-base-uri()", "resolve-uri('a')", "base-uri(a)", "error()"],
)  # fmt: skip
def test_nothing_but_the_document_can_be_read(queries: Queries, text: str) -> None:
    with pytest.raises(QueryError):
        queries.answer(QueryRequest(q=text))


@pytest.mark.parametrize("text", ["doc('file:///etc/hostname')", "unparsed-text('file:///etc/hostname')"])
def test_saxon_itself_reads_no_files(pool: Saxon, text: str) -> None:
    with pytest.raises(QueryError, match="Saxon refuses"):
        ask(pool, text)


@pytest.mark.timeout(60)
def test_expressions_that_take_too_long_are_ended(pool: Saxon) -> None:
    with pytest.raises(LimitError) as caught:
        ask(pool, "sum(for $i in 1 to 100000000, $j in 1 to 1000 return $i mod $j)", seconds=2)
    assert caught.value.details["code"] == "query-timeout"
    assert ask(pool, "count(//frame)") == [2.0]


def test_expressions_that_take_too_much_memory_are_ended() -> None:
    pool = Saxon(memory_bytes=400 << 20, processes=1, seconds=60)
    try:
        with pytest.raises(LimitError) as caught:
            ask(pool, "count(reverse(for $i in 1 to 60000000 return string($i)))", seconds=60)
        assert caught.value.details["code"] == "query-memory"
        assert ask(pool, "count(//frame)") == [2.0]
    finally:
        pool.close()


def test_memory_that_saxon_takes_by_itself_is_seen_from_outside() -> None:
    """One array of 8 GB that no limit of the system refuses: it is seen while the system fills it with zeros."""
    pool = Saxon(memory_bytes=400 << 20, processes=1)
    most = 0
    done = threading.Event()

    def look() -> None:
        nonlocal most
        with contextlib.suppress(psutil.NoSuchProcess):
            while not done.wait(0.05):
                most = max(most, child.memory_info().rss)

    before = set(psutil.Process().children())
    ask(pool, "1")
    (child,) = set(psutil.Process().children()) - before
    looking = threading.Thread(target=look)
    looking.start()
    try:
        with pytest.raises(LimitError) as caught:
            ask(pool, "1 to 1000000000", seconds=60)
    finally:
        done.set()
        looking.join()
        pool.close()
    assert caught.value.details["code"] == "query-memory"
    # How much more than it may is a matter of how soon a busy machine lets the watch look again.
    assert most < 4 << 30


EXPLODES = f"matches('{'a' * 60}!', '^(a+)+$')"


def test_long_questions_leave_a_place_for_others() -> None:
    """Those who ask much hold all places but one, others get that one at once, and who waits is served in turn."""
    pool = Saxon(processes=3, seconds=60)
    limits = [Limits(60, 1000, "busy") for _ in range(4)]
    ended: list[str] = []

    def explode(one: Limits) -> None:
        with contextlib.suppress(LimitError, QueryError):
            pool.items(EXPLODES, [DOCUMENT], variables={}, offset=0, limit=1, limits=one)
        ended.append("long")

    threads = [threading.Thread(target=explode, args=(one,)) for one in limits]
    try:
        for thread in threads:
            thread.start()
        for _ in range(3):
            assert ask(pool, "count(//frame)", seconds=50, client="quick") == [2.0]
        assert not ended
    finally:
        for one in limits:
            one.cancel()
        for thread in threads:
            thread.join()
        pool.close()


def test_regular_expressions_that_explode_are_ended(pool: Saxon) -> None:
    with pytest.raises((LimitError, QueryError)):
        ask(pool, EXPLODES, seconds=2)


def test_without_saxon_the_error_says_what_to_install(queries: Queries, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(saxon, "installed", lambda: False)
    with pytest.raises(QueryError, match="Saxon is not installed") as caught:
        queries.answer(QueryRequest(q="//frame[. is .]"))
    assert "xpath2" in str(caught.value.remedy)
    assert queries.answer(QueryRequest(q="max(//@Rx)")).value is not None


def test_nodes_of_several_documents_stream(queries: Queries) -> None:
    """Of each document in turn, at most as many as are asked for; a position around the whole counts over all."""
    every = addresses(queries, QueryRequest(q="//frame[. is .]"))
    assert every == addresses(queries, QueryRequest(q="//frame"))
    assert addresses(queries, QueryRequest(q="//frame[. is .]", limit=4)) == every[:4]
    assert addresses(queries, QueryRequest(q="(//frame[deep-equal(., .)])[5]")) == [every[4]]
    with pytest.raises(QueryError, match="values"):
        addresses(queries, QueryRequest(q="//frame/xs:double(@id)"))


def test_what_would_take_too_long_is_refused_before_it_begins(
    queries: Queries, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mcml_service.xpath.xml.sequences.SAXON_SECONDS", 60)
    monkeypatch.setattr(queries.saxon, "items", None)
    with pytest.raises(LimitError, match="about 120 s for 2") as caught:
        queries.answer(QueryRequest(q="count(//frame[. is .])"))
    assert caught.value.details["code"] == "query-needs-saxon"
    assert "as=ndjson" in str(caught.value.remedy)
