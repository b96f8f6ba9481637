"""Answers from tracks and zone maps equal those on columns, after frames were deleted and samples changed too."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from random import Random

import pytest

from mcml.errors import McmlError
from mcml.files.import_options import Label
from mcml_schemas.querying.queries import NodeItem, QueryAnswer, QueryRequest
from mcml_service.actions.editing.frame_ranges import move_frames, reverse
from mcml_service.actions.editing.single_element import Change
from mcml_service.actions.editing.whole_document import add_labels, delete_document, restore_document
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.lists.filtering import DocumentFilter
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath import queries as run
from mcml_service.xpath.answer import streams
from mcml_service.xpath.answer.sources import described
from mcml_service.xpath.engine import group_scan, values
from mcml_service.xpath.engine.samples import frame_bones, stacked
from mcml_service.xpath.engine.scan_plan import plan_scan
from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.language.rules import normal
from mcml_service.xpath.language.tree import Expression
from mcml_service.xpath.library import forest, groups, track_values
from mcml_service.xpath.library.caches import SOME_CHANGES, Caches
from mcml_service.xpath.nodes.node import Node
from mcml_service.xpath.queries import Queries
from tests import fuzz
from tests.builders import HTR, MCML, bvh, store
from tests.edits import change_element, delete_element

CHANNELS = ["Rx", "Ry", "Rz", "Tx", "SF", "weight"]
NUMBERS = ["0", "5", "10.5", "-20", "45.5", "1e3", "(0 div 0)"]


class Maker:
    """Random questions about samples."""

    def __init__(self, random: Random, bones: list[str]) -> None:
        self.random = random
        self.bones = bones

    def number(self, context: str, depth: int = 0) -> str:
        pick = self.random.choice
        channel, bone = pick(CHANNELS), pick(self.bones)
        own = {
            "@": ["."],
            "bone": [f"@{channel}", f"@{channel}", f"../frame_bone[@name='{bone}']/@{channel}"],
            "frame": [f"frame_bone[@name='{bone}']/@{channel}"],
        }[context]
        kind = self.random.randrange(7)
        if kind == 0 and depth < 2:
            return f"({self.number(context, depth + 1)} {pick('+-*')} {self.number(context, depth + 1)})"
        if kind == 1 and depth < 2:
            return pick(["-{}", "abs({})", "floor({})", "round({})", "number({})"]).format(
                self.number(context, depth + 1)
            )
        return pick(NUMBERS) if kind == 2 else pick(own)

    def condition(self, context: str, depth: int = 0) -> str:
        if depth < 2 and self.random.random() < 0.3:
            operator = self.random.choice(["and", "or"])
            return f"({self.condition(context, depth + 1)} {operator} {self.condition(context, depth + 1)})"
        if depth < 2 and self.random.random() < 0.1:
            return f"not({self.condition(context, depth + 1)})"
        operator = self.random.choice(["<", ">", "<=", ">=", "=", "!="])
        return f"{self.number(context)} {operator} {self.number(context)}"

    def of_any(self) -> str:
        """What any frame_bone fulfils."""
        pick = self.random.choice
        some = pick(["", f"[{self.condition('bone')}]"])
        kinds = [
            f"frame_bone{some}/@{pick(CHANNELS)} {pick(['<', '>', '!=', '='])} {pick(NUMBERS)}",
            f"frame_bone[{self.condition('bone')}]",
            f"5 < frame_bone{some}/@Rx or frame_bone{some}/@{pick(CHANNELS)} < {pick(NUMBERS)}",
        ]
        return pick(kinds)

    def of_all(self) -> str:
        """What all frame_bones of a frame are asked for together."""
        pick = self.random.choice
        inner = f"not({self.condition('bone')})" if self.random.random() < 0.2 else self.condition("bone")
        some, operator = pick(["", f"[{inner}]"]), pick(["<", ">", "<=", ">=", "=", "!="])
        function = pick(["max", "min", "sum", "avg"])
        compared = [
            f"count(frame_bone[{inner}]{pick(['', '/@Rx'])})",
            f"{function}(frame_bone{some}/@{pick(CHANNELS)})",
            f"{function}(frame_bone{some}/@{pick(CHANNELS)}[{self.condition('@')}])",
        ]
        sides = [pick(compared), pick([pick(["0", "1", "2", "3", *NUMBERS]), *compared])]
        self.random.shuffle(sides)
        kinds = [
            f"{sides[0]} {operator} {sides[1]}",
            f"{sides[0]} {operator} {sides[1]}",
            f"{pick(['not', 'exists', 'empty', 'boolean'])}(frame_bone[{inner}]{pick(['', '/@Rx'])})",
            f"{pick(['every', 'some'])} $b in frame_bone satisfies $b/@Rx {operator} {pick(NUMBERS)}",
            f"{self.of_any()} and not({self.of_any()})",
        ]
        return pick(kinds)

    def of_frames(self) -> str:
        """A question that looks at all frame_bones of frames."""
        chance, pick = self.random.random, self.random.choice
        text = "//frame" + (f"[{self.condition('frame')}]" if chance() < 0.3 else "") + f"[{self.of_all()}]"
        text += pick(["", "", "/@id", "[last()]", f"[{self.of_any()}]"])
        inner = f"{pick(['sum', 'count', 'max', 'avg'])}($f/frame_bone[{self.condition('bone')}]/@Ry)"
        loop = f"for $f in //frame{pick(['', '[position() mod 3 = 1]'])} return {inner}"
        return pick(["{}", "{}", "count({})", f"{pick(['max', 'count', 'sum'])}({loop})"]).format(text)

    def question(self) -> str:
        chance, pick = self.random.random, self.random.choice
        text = "//frame" + (f"[{self.condition('frame')}]" if chance() < 0.6 else "")
        text += f"[{self.of_any()}]" if chance() < 0.3 else ""
        text += "[motion_name='walk']" if chance() < 0.2 else ""
        target = ""
        if chance() < 0.7:
            text += "/frame_bone" + (f"[@name='{pick(self.bones)}']" if chance() < 0.7 else "")
            text += f"[{self.condition('bone')}]" if chance() < 0.7 else ""
            target = pick(["", "/@Rx", "/@name", f"/@Rz[{self.condition('@')}]"])
        extremes = ["min({})", "max({})"] if target.startswith("/@R") else []
        return pick(["{}", "{}", "count({})", "boolean({})", *extremes]).format(text + target)


@pytest.fixture
def engine(database: Database) -> Queries:
    for files in ({"a.bvh": bvh(700)}, {"b.mcml": MCML}, {"c.htr": HTR}, {"d.bvh": bvh(300)}):
        (uuid,) = store(database, files, labels=(Label("walk"),))[:1]
        for where, change in (
            ("/mcml/motion/frame[5]", None),
            ("/mcml/motion/frame[290]", None),
            ("/mcml/motion/frame[1]/frame_bone[1]", Change({"Tx": "46", "Rx": None})),
        ):
            with database.write() as tx:
                stored = tx.documents.get(uuid)
                if stored.frames < 295:
                    continue
                change_element(tx, stored, where, change) if change else delete_element(tx, stored, where)
    return Queries(database, Settings())


def shown(answer: QueryAnswer) -> tuple[object, list[tuple[str, str, str]]]:
    nodes = [item for item in answer.items or [] if isinstance(item, NodeItem)]
    others = [str(item) for item in answer.items or [] if not isinstance(item, NodeItem)]
    return (answer.value, others), [(node.document, node.address, node.value) for node in nodes]


@pytest.mark.slow
@pytest.mark.parametrize("asked", fuzz.lengths(80, 800))
def test_tracks_answer_as_columns_do(engine: Queries, monkeypatch: pytest.MonkeyPatch, asked: int) -> None:
    with engine.database.read() as tx:
        bones = [*tx.columns.used_names("bone", None), "nothing"]
    maker = Maker(Random(8), bones)
    scanned = found = 0
    for _ in range(asked):
        text = maker.question()
        tree = normal(parse(text).tree)
        inner = getattr(tree, "arguments", (tree,))[0]
        request = QueryRequest(q=text, limit=500)
        first = shown(engine.answer(request))
        with monkeypatch.context() as patched:
            patched.setattr(run, "plan_scan", lambda tree: None)
            assert shown(engine.answer(request)) == first, text
        scanned += plan_scan(inner) is not None
        found += bool(first[1]) or first[0] not in ((0.0, []), (False, []), (None, []))
    assert scanned > asked * 3 / 8
    assert found > asked / 5


@pytest.mark.slow
@pytest.mark.parametrize("asked", fuzz.lengths(100, 1200))
def test_all_bones_at_once_are_as_one_by_one(engine: Queries, monkeypatch: pytest.MonkeyPatch, asked: int) -> None:
    """Of frames with a bone less, with a channel less, deleted, moved and reversed, too."""
    with engine.database.read() as tx:
        bones = [*tx.columns.used_names("bone", None), "nothing"]
    with engine.database.write() as tx:
        stored = next(one for one in tx.documents.page(DocumentFilter(), after=None, limit=9) if one.frames > 600)
        reverse(tx, stored, 100, 130)
        move_frames(tx, tx.documents.get(stored.uuid), 20, 300, 500, renumber=True)
        tx.documents.add_revision(stored, "frames")
    maker = Maker(Random(11), bones)
    answered = found = 0
    used = frame_bones.asked

    def counted(expression: Expression) -> frame_bones.Asked | None:
        nonlocal answered
        question = used(expression)
        answered += question is not None
        return question

    for number in range(asked):
        text = maker.of_frames() if number % 4 else f"count({maker.question().removeprefix('count')})"
        request = QueryRequest(q=text, limit=500)
        with monkeypatch.context() as patched:
            patched.setattr(frame_bones, "FEW", maker.random.choice([1, 1, 64]))
            patched.setattr(frame_bones, "TOGETHER", maker.random.choice([7, 10_000]))
            patched.setattr(group_scan, "MANY_TRACKS", 1)
            patched.setattr(stacked, "TOGETHER", 3)
            patched.setattr(frame_bones, "asked", counted)
            first = asked_of(engine, request)
        with monkeypatch.context() as patched:
            patched.setattr(run, "plan_scan", lambda tree: None)
            patched.setattr(frame_bones, "FEW", 10**9)
            assert asked_of(engine, request) == first, text
        found += bool(first and (first[1] or first[0] not in ((0.0, []), (False, []), (None, []))))
    assert answered > asked * 5 / 8
    assert found > asked * 3 / 10


def asked_of(engine: Queries, request: QueryRequest) -> tuple[object, list[tuple[str, str, str]]] | None:
    """The answer, None for an error."""
    try:
        return shown(engine.answer(request))
    except McmlError:
        return None


def test_zone_maps_rule_tracks_out(engine: Queries) -> None:
    text = "//frame_bone[@name='Root'][@Rx > 1000000]"
    explained = engine.answer(QueryRequest(q=text, explain=True)).explain
    assert explained is not None
    assert explained.way == "index"
    assert explained.tracks_read == 0
    assert explained.tracks_skipped


def test_moved_frames_stay_in_order(engine: Queries, monkeypatch: pytest.MonkeyPatch) -> None:
    with engine.database.write() as tx:
        stored = next(one for one in tx.documents.page(DocumentFilter(), after=None, limit=9) if one.frames > 600)
        move_frames(tx, stored, 600, 650, 3, renumber=True)
        move_frames(tx, tx.documents.get(stored.uuid), 20, 300, 500, renumber=True)
        tx.documents.add_revision(stored, "frames")
    monkeypatch.setattr(group_scan, "FIRST_UNITS", 1)
    monkeypatch.setattr(group_scan, "UNITS", 2)
    for text in ("//frame_bone[@Rx > -1000]", "//frame[frame_bone[@name='Root']/@Rx > -1000]/@id"):
        assert plan_scan(normal(parse(text).tree)) is not None
        request = QueryRequest(q=text, limit=1000)
        first = shown(engine.answer(request))
        with monkeypatch.context() as patched:
            patched.setattr(run, "plan_scan", lambda tree: None)
            assert shown(engine.answer(request)) == first


@pytest.mark.slow
def test_what_is_kept_is_of_the_revision_that_is_read(engine: Queries) -> None:
    questions = [
        "//frame[motion_name='jump']/@id", "//frame[last()]", "count(//frame_bone)", "max(//frame_bone/@Rx)",
        "//header/filename", "//bone/name", "//frame_bone[@Rx > 400]", "//frame[3]/frame_bone[1]",
    ]  # fmt: skip

    def ask(asked: Queries) -> list[object]:
        return [shown(asked.answer(QueryRequest(q=text, limit=1000))) for text in questions]

    changes: list[Callable[[Transaction, StoredDocument], object]] = [
        lambda tx, stored: add_labels(tx, stored, [("jump", 3, 9)]),
        lambda tx, stored: change_element(tx, stored, "/mcml/motion/frame[3]/frame_bone[1]", Change({"Rx": "500"})),
        lambda tx, stored: delete_element(tx, stored, "/mcml/motion/frame[1]"),
        lambda tx, stored: change_element(tx, stored, "/mcml/skeleton/bone/name", Change({}, "other")),
        delete_document,
        restore_document,
    ]
    seen = [ask(engine)]
    with engine.database.read() as tx:
        uuid = tx.documents.page(DocumentFilter(), after=None, limit=1)[0].uuid
    for change in changes:
        with engine.database.write() as tx:
            change(tx, tx.documents.get(uuid, deleted=True))
        seen.append(ask(engine))
        assert seen[-1] == ask(Queries(engine.database, Settings()))
        assert seen[-1] != seen[-2]


@pytest.mark.slow
def test_limits_of_what_is_kept_change_no_answer(engine: Queries, monkeypatch: pytest.MonkeyPatch) -> None:
    questions = [
        "//frame[position() mod 90 = 1]", "//frame[@id='7']/frame_bone/@Rx", "max(//frame_bone[@name='Root']/@Rx)",
        "//frame_bone[@Rx > 5]/@Ry", "//bone/name", "count(//frame[frame_bone/@Rx > 3])", "//@*[. > 11]",
        "//frame[count(frame_bone[@Rx > 3]) = 1]", "//frame[sum(frame_bone/@Rx) > 3]/@id",
        "//frame[frame_bone[@name='Root']/@Rx > following-sibling::frame[1]/frame_bone[@name='Root']/@Rx]",
    ]  # fmt: skip
    requests = [QueryRequest(q=text, limit=200) for text in questions]
    usual = [shown(engine.answer(request)) for request in requests]
    forgetful = Queries(engine.database, Settings())
    for limit, documents, tracks, few, seldom in (
        (0, 1, 0, 10**9, 0), (0, 2, 10**9, 0, 10**9), (1 << 20, 1, 10**9, 10**9, 10**9), (1 << 20, 10**9, 0, 0, 6),
    ):  # fmt: skip
        forgetful.caches = Caches(limit)
        monkeypatch.setattr(groups, "MOST_DOCUMENTS", documents)
        monkeypatch.setattr(group_scan, "MOST_TRACKS", tracks)
        monkeypatch.setattr(track_values, "MOST_TRACKS", tracks)
        monkeypatch.setattr(values, "MANY", 1 + tracks)
        monkeypatch.setattr(group_scan, "FEW", seldom)
        monkeypatch.setattr(forest, "FEW_FRAMES", few)
        for _ in range(2):
            assert [shown(forgetful.answer(request)) for request in requests] == usual
        for request, first in zip(requests, usual, strict=True):
            if first[1]:
                found = streamed(forgetful, request)
                assert [(node.stored.uuid, node.address, node.value) for node in found] == first[1]


@pytest.mark.slow
@pytest.mark.parametrize("chosen", ["all", "a project", "one document"])
def test_what_a_write_has_made_old_is_not_kept(engine: Queries, chosen: str) -> None:
    with engine.database.read() as tx:
        uuid = tx.documents.page(DocumentFilter(), after=None, limit=1)[0].uuid
    scope: dict[str, dict[str, object]] = {"a project": {"project": ""}, "one document": {"document": [uuid]}}
    request = QueryRequest.model_validate(
        {"q": "//frame[sum(frame_bone/@Rx) > 3]/frame_bone[1]/@Rx", **scope.get(chosen, {})}
    )
    caches, kept = engine.caches, []
    for number in range(40):
        with engine.database.write() as tx:
            change_element(
                tx, tx.documents.get(uuid), "/mcml/motion/frame[2]/frame_bone[1]", Change({"Rx": f"{number}"})
            )
        engine.answer(request)
        kept.append(caches.columns.total + caches.samples.total)
    assert kept[0]
    assert max(kept[20:]) == max(kept[:20])
    assert kept[-1] <= 8 * kept[0]
    versions = Counter(key for key, _ in caches.zones._kept)
    tracks = Counter(key[:3] for key in caches.tracks._decoded)
    assert max(versions.values(), default=0) <= SOME_CHANGES + 1
    assert max(tracks.values(), default=0) <= SOME_CHANGES + 1


def streamed(queries: Queries, request: QueryRequest) -> list[Node]:
    answer = queries.stream(request)
    assert isinstance(answer, streams.Answer)
    return [node for nodes in answer.shown(described) for node in nodes]


def test_all_of_an_answer_is_of_the_revision_that_is_asked(engine: Queries) -> None:
    with engine.database.read() as tx:
        uuid = tx.documents.page(DocumentFilter(), after=None, limit=1)[0].uuid
    request = QueryRequest(q="//frame_bone[1]/@Rx", document=[uuid], revision=1, limit=30)
    first = engine.answer(request)
    with engine.database.write() as tx:
        change_element(tx, tx.documents.get(uuid), "/mcml/motion/frame[2]/frame_bone[1]", Change({"Rx": "77"}))
        change_element(tx, tx.documents.get(uuid), "/mcml/motion/frame[40]/frame_bone[1]", Change({"Rx": "78"}))
    later = Queries(engine.database, Settings())
    values = [node.value for node in streamed(later, request)]
    again = Queries(engine.database, Settings()).answer(request)
    assert again.next_cursor is not None
    following = later.answer(request.model_copy(update={"cursor": again.next_cursor, "revision": None}))
    assert values == [value for *_, value in shown(first)[1]]
    assert shown(again) == shown(first)
    assert "78.0" not in [value for *_, value in shown(following)[1]]
    assert "78.0" in [
        value for *_, value in shown(later.answer(request.model_copy(update={"revision": None, "limit": 99})))[1]
    ]


SPELLINGS = [
    [
        "//frame[motion_name='walk']",
        "/mcml/motion/frame['walk'=./motion_name]",
        "//motion/frame[motion_name/text()='walk']",
        "/descendant::frame[child::motion_name='walk']",
        "//frame[motion_name[.='walk']]",
    ],
    [
        "//frame_bone[@name='Root'][@Rx > 3]",
        "//frame/frame_bone[3 < @Rx][@name='Root']",
        "/mcml//frame_bone['Root'=@name and ./@Rx > 3]",
    ],
    ["//frame[5]", "/mcml/motion/frame[position()=5]", "//motion/child::frame[5 = position()]"],
    ["//frame[@id='7']/@id", "//motion/frame['7'=./@id]/attribute::id"],
]


@pytest.mark.parametrize("texts", SPELLINGS, ids=lambda texts: texts[0])
def test_spellings_of_one_meaning_have_one_plan(engine: Queries, texts: list[str]) -> None:
    plans = []
    for text in texts:
        explained = engine.answer(QueryRequest(q=text, explain=True)).explain
        assert explained is not None
        plans.append((explained.way, explained.plan))
    assert plans == [plans[0]] * len(plans)
    assert plans[0][0] == "index"
