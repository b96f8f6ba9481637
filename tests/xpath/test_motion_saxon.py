"""Functions of bodies in motion where only trees answer: against a loop over the frames, and what has no answer."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from mcml.errors import LimitError, QueryError
from mcml_schemas.querying.queries import NodeItem, QueryRequest
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.answer.writing import STREAMS
from mcml_service.xpath.language.motion_functions import MOTION_FUNCTIONS
from mcml_service.xpath.language.parse import Query
from mcml_service.xpath.limits import Limits
from mcml_service.xpath.nodes.pairs import TooWideError
from mcml_service.xpath.queries import Queries
from mcml_service.xpath.trees.evaluate import Items, Tree
from tests.actions.test_measurements import walkway
from tests.builders import MCML, store
from tests.edits import OTHER_SEEDS
from tests.motion.bodies.made import person
from tests.xpath.motion_grammar import SCALES, Asked, Chance, Question, bones
from tests.xpath.motion_twin import Document, read_documents
from tests.xpath.test_motion_functions import run

OF_SEQUENCES = re.compile(r"\b(min|max|sum|avg|count|exists|every|some)\b")


class ByColumns(Chance):
    """Questions of XPath 1.0 and 2.0, but for those of the whole scope."""

    def question(self) -> Question:
        found = super().question()
        return self.question() if "mo:top(" in found.text else found


class Cast(Chance):
    """Questions with what has no columns."""

    def question(self) -> Question:
        held = self.joint_of_a_loop() if self.random.random() < 0.2 else self.condition()
        least, gap = (self.random.choice((0.0, 0.02, 0.05, 1 / 30, 0.1)) for _ in range(2))
        low, high = sorted(self.random.randint(-4, 4) for _ in range(2))
        texts: list[tuple[str, Callable[[Document], list[int]]]] = [
            (f"//frame[{held.text}][. is .]", held_in(held)),
            (f"for $f in //frame[1 castable as xs:double] return $f/self::frame[{held.text}]", held_in(held)),
            (f"//frame[some $f in . satisfies $f[{held.text}] and $f is .]", held_in(held)),
            (
                f"mo:runs(//frame[{held.text}][. is .], {least!r}, {gap!r})",
                lambda d: d.long_runs(held_in(held)(d), least, gap),
            ),
            (
                f"//frame[{held.text}]/mo:window({low}, {high}, 'frames')[. is .]",
                lambda d: sorted({o for i in held_in(held)(d) for o in d.window(i, low, high, by_frames=True)}),
            ),
        ]
        choice = self.random.random()
        if choice < 0.7:
            text, of = self.random.choice(texts)
            return Question(text, lambda ds: [d.address(frame) for d in ds for frame in of(d)])
        kind, number = self.bone() if choice < 0.85 else self.quantity()
        bound = round(self.random.uniform(*SCALES[kind]), 3)
        if choice < 0.85:
            return Question(
                f"//frame[{held.text}]/frame_bone[xs:double({number.text}) > {bound}]",
                lambda ds: bones(ds, held, number, bound),
            )
        while OF_SEQUENCES.search(held.text):  # They have their say in all documents together.
            held = self.condition()
        return Question(
            f"count(//frame[{held.text}][xs:double({number.text}) > {bound}])",
            lambda ds: float(sum(number.of(d, i) > bound for d in ds for i in held_in(held)(d))),
        )

    def joint_of_a_loop(self) -> Asked:
        """A joint that has another name wherever it stands."""
        joint, bound = self.random.choice(("Root", "nobody")), round(self.random.uniform(*SCALES["height"]), 3)
        return Asked(
            f"(some $j in ('Head', '{joint}') satisfies xs:double(mo:height($j)) > {bound})",
            lambda d, i: any(d.quantity("height", name)[i] > bound for name in ("Head", joint)),
        )


def held_in(held: Asked) -> Callable[[Document], list[int]]:
    return lambda document: [frame for frame, holds in enumerate(document.all(held)) if holds]


@pytest.fixture
def by_trees(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What trees are asked."""
    asked: list[str] = []
    items = Tree.items

    def noted(tree: Tree, text: str, *others: Any, **more: Any) -> Items:
        asked.append(text)
        return items(tree, text, *others, **more)

    monkeypatch.setattr(Tree, "items", noted)
    return asked


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), OTHER_SEEDS[1:2], indirect=["kind"])
def test_answers_by_trees_are_those_of_loops(
    database: Database, seed: int, by_trees: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of questions that columns answer too."""
    monkeypatch.setattr(Query, "has_columns", False)
    run(database, seed, rounds=1, asked=3, chance=ByColumns)
    assert any("mo-value" in text for text in by_trees)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), OTHER_SEEDS[4:5], indirect=["kind"])
def test_answers_that_only_trees_have_are_those_of_loops(database: Database, seed: int, by_trees: list[str]) -> None:
    run(database, seed, rounds=1, asked=4, chance=Cast)
    assert any("mo-value" in text for text in by_trees)


@pytest.mark.fuzz(seeds=3)
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("chance", [ByColumns, Cast])
def test_answers_by_trees_many_times(
    database: Database, seed: int, chance: type[Chance], monkeypatch: pytest.MonkeyPatch
) -> None:
    if chance is ByColumns:
        monkeypatch.setattr(Query, "has_columns", False)
    run(database, seed, rounds=20, asked=20, chance=chance)


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Queries]:
    database = Database(f"sqlite:///{tmp_path_factory.mktemp('saxon') / 'store.db'}")
    database.migrate()
    store(database, {"a.bvh": person(1, 30), "b.bvh": person(2, 20, 1 / 30), "hand.mcml": MCML})
    engine = Queries(database, Settings(cache_dir="none"))
    yield engine
    engine.close()
    database.close()


def values(engine: Queries, text: str, **asked: Any) -> list[Any]:
    answer = engine.answer(QueryRequest(q=text, **{"limit": 1000, **asked}))
    if answer.items is None:
        return [answer.value]
    return [item.address if isinstance(item, NodeItem) else getattr(item, "value", None) for item in answer.items]


def twin(engine: Queries, name: str = "a") -> Document:
    return next(one for one in read_documents(engine.database) if one.name == name)


EACH = {
    "mo:time": "mo:time()",
    "mo:unit": "mo:unit()",
    "mo:leg": "mo:leg()",
    "mo:height": "mo:height(frame_bone[3])",
    "mo:position": "mo:position('Head', 'front', frame_bone[1])",
    "mo:distance": "mo:distance(frame_bone[2], frame_bone[last()])",
    "mo:angle": "mo:angle(frame_bone[1], 'left_low_leg', 'left_foot') + mo:angle('left-hip-internal-rotation')",
    "mo:tilt": "mo:tilt('Root', 'Head')",
    "mo:speed": "mo:speed('left_hand', 'Root')",
    "mo:acceleration": "mo:acceleration('left_hand')",
    "mo:heading": "mo:heading()",
    "mo:contact": "mo:contact('left_toes')",
    "mo:activity": "mo:activity('wave')",
    "mo:known": "mo:known(mo:speed('left_hand', 'Root')) + mo:known(mo:contact('left_toes'))",
    "mo:rate": "mo:rate(mo:height('Head') * count(frame_bone))",
    "mo:pose-distance": "mo:pose-distance('b', 3)",
    "mo:motion-distance": "mo:motion-distance('b', 3, 9)",
    "mo:window": "count(mo:window(-0.1, 0.05)) + sum(mo:window(-3, 1, 'frames')/mo:height('Head'))",
    "mo:runs": "count(mo:runs(../frame[mo:height('left_hand') > 0.9], 0.05, 0.04))",
}


OF_FILES = {
    "mo:quantity": "mo:quantity('LKneeAngles', 'x')",
    "mo:analog": "mo:analog('EMG')",
    "mo:force": "mo:force(1, 'z') + mo:force('1', 'x')",
    "mo:cop": "mo:cop('1', 'y')",
    "mo:free-moment": "mo:free-moment('1')",
}


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in MOTION_FUNCTIONS if name != "mo:top" and name not in OF_FILES])
def test_each_function_has_the_numbers_of_columns(engine: Queries, by_trees: list[str], name: str) -> None:
    assert name in EACH[name]
    known = set()
    for document in ("a", "b", "hand"):
        asked = {"document": [twin(engine, document).uuid]}
        wanted = values(engine, f"//frame/number({EACH[name]})", **asked)
        assert not by_trees
        assert values(engine, f"//frame/xs:double({EACH[name]})", **asked) == wanted
        # Of a document that is left out nothing is asked.
        assert by_trees or not wanted
        by_trees.clear()
        known |= {value for value in wanted if value != "NaN"}
    assert len(known) > (name not in ("mo:unit", "mo:leg", "mo:contact", "mo:activity", "mo:known"))


@pytest.mark.parametrize("name", OF_FILES)
def test_measurements_have_the_numbers_of_columns(database: Database, by_trees: list[str], name: str) -> None:
    store(database, {"trial.c3d": walkway()})
    engine = Queries(database, Settings(cache_dir="none"))
    try:
        wanted = values(engine, f"//frame/number({OF_FILES[name]})")
        assert not by_trees
        assert len(set(wanted) - {"NaN"}) > 10
        assert values(engine, f"//frame/xs:double({OF_FILES[name]})") == wanted
        assert by_trees
    finally:
        engine.close()


@pytest.mark.parametrize(
    ("of_columns", "of_saxon"),
    [
        ("//header/number(mo:leg())", "//header/xs:double(mo:leg())"),
        ("//header/mo:height('Head')", "//header/xs:double(mo:height('Head'))"),
        ("//header[not(mo:contact('Root'))]", "//header[. is .][not(mo:contact('Root'))]"),
        ("count(//header/mo:window(-9, 9))", "count(//header/mo:window(-9, 9)[. is .])"),
        ("//motion_name[mo:time() > 0.05]", "//motion_name[. is .][mo:time() > 0.05]"),
        ("//frame_bone/@Tx[mo:time() = 0]", "//frame_bone/@Tx[. is .][mo:time() = 0]"),
        ("//frame_bone[mo:height(.) > 1.6]", "//frame_bone[. is .][mo:height(.) > 1.6]"),
        ("//frame_bone[mo:height(@name) > 1.6]", "//frame_bone[. is .][mo:height(@name) > 1.6]"),
        ("//frame/mo:height(//bone[1])", "//frame[. is .]/mo:height(//bone[1])"),
        ("//frame/mo:speed(//skeleton/bone[1]/name)", "//frame[. is .]/mo:speed(//skeleton/bone[1]/name)"),
        ("//frame[mo:height(@id) > 0]", "//frame[. is .][mo:height(@id) > 0]"),
        ("//frame[mo:time() > 0.2]/@*", "//frame[. is .][mo:time() > 0.2]/@*"),
        (
            "mo:runs((//frame[7], //frame[3], //frame[4]), 0)",
            "mo:runs((//frame[. is .][7], //frame[3], //frame[4]), 0)",
        ),
        ("mo:runs(//frame[mo:time() > 0.2], 1 div 0)", "mo:runs(//frame[. is .][mo:time() > 0.2], 1 div 0)"),
        ("//frame[mo:window(0 div 0, 1)]", "//frame[. is .][mo:window(0 div 0, 1)]"),
        ("//frame[mo:window(-1 div 0, 0)]", "//frame[. is .][mo:window(-1 div 0, 0)]"),
        (
            "//frame[3]/(for $a in frame_bone, $b in frame_bone return mo:distance($a, $b))",
            "//frame[. is .][3]/(for $a in frame_bone, $b in frame_bone return mo:distance($a, $b))",
        ),
        (
            "//frame[3]/(for $a in ('up', 'x') return mo:position('Head', $a))",
            "//frame[. is .][3]/(for $a in ('up', 'x') return mo:position('Head', $a))",
        ),
        (
            "//frame[3]/(for $s in ('left', 'right') return mo:angle(concat($s, '-knee-flexion')))",
            "//frame[. is .][3]/(for $s in ('left', 'right') return mo:angle(concat($s, '-knee-flexion')))",
        ),
        (
            "for $mo-places in //frame return mo:height('Head') > $mo-places/@id",
            "for $mo-places in //frame[. is .] return mo:height('Head') > $mo-places/@id",
        ),
        (
            "//frame[3]/concat('mo:height(1)', \"mo:leg('\", mo:speed('Head') > 0)",
            "//frame[. is .][3]/concat('mo:height(1)', \"mo:leg('\", mo:speed('Head') > 0)",
        ),
    ],
)
def test_contexts_and_arguments(engine: Queries, by_trees: list[str], of_columns: str, of_saxon: str) -> None:
    wanted = values(engine, of_columns, document=[twin(engine).uuid])
    assert not by_trees
    assert values(engine, of_saxon, document=[twin(engine).uuid]) == wanted
    assert by_trees


def test_variables_of_the_request(engine: Queries) -> None:
    text = "//frame[mo:window(-$near, 0)/mo:height($joint) > $low][. is .]"
    found = values(engine, text, variables={"near": 0.1, "joint": "Head", "low": 1.5})
    assert found == values(engine, "//frame[mo:window(-0.1, 0)/mo:height('Head') > 1.5]")
    assert found


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("mo:top(1, //frame[. is .])", "beside functions on document trees"),
        (
            "//frame[some $x in (1, 2) satisfies mo:rate($x * mo:time()) > 3]",
            "mo:rate also reads neighbouring frames",
        ),
        ("//frame[mo:rate(xs:double(@id)) > 1]", "mo:rate also reads neighbouring frames"),
        ("//frame[mo:rate(round-half-to-even(mo:time())) > 1]", "mo:rate also reads neighbouring frames"),
        ("//frame[. is .][(1 to 3)[. < mo:time()]]", "with a value as context"),
        ("//frame[. is .][mo:runs(frame_bone, 0)]", "Runs are of frames"),
        ("//frame[. is .][mo:height('Head', 'Root') > 1]", "takes 1 argument"),
        ("//frame[. is .][mo:window(mo:leg(), 0)]", "takes the same from in every frame"),
        ("//frame[. is .][mo:window(xs:double('1'), 0)]", "takes the same from in every frame"),
        ("//frame[. is .][mo:rate(position()) > 1]", "cannot ask for position"),
        ("//frame[. is .][mo:angle('left-knee-flexoin') > 1]", "is not the name of an angle"),
        ("//frame[. is .][mo:angle(string(@id)) > 1]", "is not the name of an angle"),
        ("//frame[. is .][mo:pose-distance('nobody', 1) > 1]", "no document 'nobody'"),
        ("//frame[. is .][mo:tall('Head') > 1]", "unknown function|not declared"),
        ("//frame[. is .][mo-height('Head') > 1]", "unknown function|not offered"),
    ],
)
def test_what_saxon_has_no_answer_to_is_refused(engine: Queries, text: str, what: str) -> None:
    with pytest.raises(QueryError, match=what) as caught:
        engine.answer(QueryRequest(q=text))
    if caught.value.at is not None:
        assert text[caught.value.at.column or 0 :]


def test_saxon_is_given_no_more_numbers_than_it_may_see_elements(engine: Queries) -> None:
    text = "//frame[. is .][1]/(for $a in //bone/name, $b in //bone/name return mo:distance(string($a), string($b)))"
    limits = Limits(10, 31 * 26)
    with pytest.raises(LimitError, match="more numbers of the frames") as caught:
        engine.answer(QueryRequest(q=text, document=[twin(engine).uuid]), limits)
    assert caught.value.details["code"] == "query-too-large"


def test_what_is_too_wide_for_columns_is_asked_of_trees(engine: Queries, monkeypatch: pytest.MonkeyPatch) -> None:
    def too_wide(*_: Any) -> Any:
        raise TooWideError(1)

    monkeypatch.setattr("mcml_service.xpath.queries._Asking._on_columns", too_wide)
    assert values(engine, "//frame[mo:height('Head') > 1.63]")
    assert values(engine, "//frame[mo:height('Head') gt 1.63]") == values(
        engine, "//frame[. is .][mo:height('Head') > 1.63]"
    )


def test_warnings_guesses_plans_and_streams(engine: Queries) -> None:
    text = "//frame[mo:height('left_hand') > 0.9][mo:known(mo:height('nobdy')) or . is .]"
    answer = engine.answer(QueryRequest(q=text, explain=True))
    assert answer.explain is not None
    assert answer.explain.plan[-2].startswith("the documents as trees")
    assert answer.explain.plan[-1].endswith("mo:height('left_hand'): a number for every frame of 3 documents")
    assert any("guesses=no" in one for one in answer.warnings)
    assert any("have no value: they lack joints of mo:height('nobdy')" in one for one in answer.warnings)
    assert any("no bone here is named 'nobdy'" in one for one in answer.warnings)
    assert values(engine, text, guesses="no") == []
    lines = b"".join(STREAMS["ndjson"][0](engine.stream(QueryRequest(q=text)))).splitlines()
    assert [json.loads(line)["address"] for line in lines] == values(engine, text)
    runs = engine.answer(QueryRequest(q=f"mo:runs({text}, 0.05, 0.04)", **{"as": "runs"})).items
    assert (
        runs
        == engine.answer(
            QueryRequest(q="mo:runs(//frame[mo:height('left_hand') > 0.9], 0.05, 0.04)", **{"as": "runs"})
        ).items
    )
    assert runs
