"""XPath 1.0: generated expressions over many documents give libxml2's answers, on every kind of database."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from random import Random

import pytest

from mcml_service.storage.database import Database
from mcml_service.xpath.engine import column_source, values
from mcml_service.xpath.engine.samples import frame_bones
from mcml_service.xpath.language.parse import parse
from tests import fuzz
from tests.conftest import shared_folder
from tests.xpath.grammar import Grammar
from tests.xpath.library import Library, library
from tests.xpath.oracle import DifferenceError, check, most_elements
from tests.xpath.shares import Tally, features


@pytest.fixture(scope="module", params=["sqlite", pytest.param("postgresql", marks=pytest.mark.fuzz)])
def documents(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Library]:
    """The library on each kind of database, made once."""
    from tests import postgres

    if request.param == "sqlite":
        database = Database(f"sqlite:///{tmp_path_factory.mktemp('campaign') / 'store.db'}")
        database.migrate()
        with library(database, shared_folder()) as made:
            yield made
        database.close()
        return
    with postgres.new_database(request.getfixturevalue("postgres_template"), "template_store") as url:
        database = Database(url)
        with library(database, shared_folder()) as made:
            yield made
        database.close()


@pytest.fixture(autouse=True)
def all_bones_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of few frames, too; and samples of one bone."""
    monkeypatch.setattr(frame_bones, "FEW", 2)
    monkeypatch.setattr(values, "MANY", 2)


def campaign(made: Library, seed: int, count: int) -> Tally:
    """Asks so many expressions. Raises the differences found, all together."""
    random = Random(seed)
    grammar = Grammar(random, made.trees)
    tally = Tally()
    differences: list[str] = []
    elements = {uuid: sum(1 for _ in tree.iter()) for uuid, tree in made.trees.items()}
    for uuid, text in grammar.expressions():
        if tally.asked + tally.refused >= count:
            break
        relative = text.startswith("/mcml/") and " | " not in text and random.random() < 0.2
        text = text.removeprefix("/") if relative else text
        tree = parse(text).tree
        used = features(tree)
        allowed = most_elements(tree)
        # Expressions that would take libxml2 minutes are asked of the documents that are small enough.
        allowed = min(allowed, random.choice([60, 130, 600, 10**9]))
        small = [other for other, size in elements.items() if size <= allowed]
        about = uuid if uuid in small else random.choice(small)
        chosen = {about}
        if random.random() < 0.2:
            chosen |= set(random.sample(small, random.choice([1, 2, 3, min(8, len(small)), len(small)])))
        trees = {other: tree for other, tree in made.trees.items() if other in chosen}
        try:
            outcome = check(made.engine, trees, text, random, relative=relative)
        except DifferenceError as difference:
            differences.append(str(difference))
            continue
        if outcome is None:
            tally.refused += 1
            continue
        grammar.used(used)
        tally.asked += 1
        tally.features.update(used)
        tally.ways[outcome.way] += 1
        tally.filled += outcome.filled
        tally.excused += outcome.excused
    assert not differences, f"{len(differences)} differences:\n" + "\n".join(differences[:10])
    return tally


def seed_of(made: Library, number: int) -> int:
    """Another one for each kind of database."""
    return zlib.crc32(made.engine.database.name.encode()) + number


def test_answers_are_libxml2s(documents: Library) -> None:
    tally = campaign(documents, seed_of(documents, 0), 100)
    tally.judge()
    assert tally.on_columns >= 0.95


UP_AND_ASIDE = [
    "//frame_bone[@Rx > 5]/..",
    "//frame_bone/@Rx/../@name",
    "//frame_bone[2]/parent::*/@id",
    "//frame_bone[@Rx > 5]/ancestor::frame",
    "//frame_bone[@Rx > 5]/ancestor-or-self::frame_bone/..",
    "//frame_bone[1]/../motion_name/text()",
    "//motion_name/following-sibling::frame_bone[1]",
    "//frame_bone[last()]/preceding-sibling::*[1]",
    "//frame/@id/..",
    "//frame_bone/../..",
    "//frame_bone[@Rx > 5]/ancestor::*",
    "//frame[2]/following-sibling::frame[1]",
    "//frame[frame_bone/@Rx > 5]/preceding-sibling::frame[2]/@id",
    "//frame[@id > 2]/following-sibling::frame[1][motion_name]",
    "//frame[frame_bone[1]/@Rx > preceding-sibling::frame[1]/frame_bone[1]/@Rx]",
    "//frames/following-sibling::frame[1]",
    "//motion/*/following-sibling::frame[1]/@id",
    "//frame[position() < 5]/preceding-sibling::*[1]",
    "//frame[position() < 5]/preceding-sibling::frame[1][1]/following-sibling::frame[2]",
    "//frame[position() < 9]/following-sibling::frame[motion_name]/@id",
    "//frame_bone[@Rx > 5]/../following-sibling::frame[1]/frame_bone[1]",
    "//frame_bone[@Rx > 5]/../../frames/text()",
    "//frame/following-sibling::frame[99999999999999999999]",
    "//frame/preceding-sibling::frame[position() = 1]/@id",
    "//frame[position() < 5]/preceding-sibling::frame[0.5]",
]


@pytest.mark.parametrize("text", fuzz.share(UP_AND_ASIDE, 3))
def test_frames_in_slices(documents: Library, monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    """Steps that go up or aside, from a few frames at a time."""
    monkeypatch.setattr(column_source, "SLICE_FRAMES", 2)
    small = {uuid: tree for uuid, tree in documents.trees.items() if sum(1 for _ in tree.iter()) < 600}
    outcome = check(documents.engine, small, text, Random(1))
    assert outcome is not None
    assert outcome.way != "projection"


WINDOWS = [
    "position() <= 3", "position() < 3.5", "3 >= position()", "position() > 2", "position() >= 1.5", "position() = 2",
    "2 = position()", "position() > 1 and position() < 4", "position() >= 3 and position() <= 2", "position() < 0.5",
    "position() > -1", "position() = 1.5", "position() <= 99999999999999999999", "position() > 1 div 0",
]  # fmt: skip
AXES = ("following", "preceding")
NEAR = [
    "//frame[{}-sibling::frame[{}][motion_name='walk']]/@id",
    "//frame[{}-sibling::frame[{}]/motion_name='walk']",
    "//frame[{}-sibling::frame[{}]/frame_bone[1]/@Rx > 5]/@id",
    "count(//frame[not({}-sibling::frame[{}][frame_bone/@Rx > 5][motion_name])])",
    "//frame[count({}-sibling::frame[{}]) > 1][position() < 9]/@id",
    "//frame[count({}-sibling::frame[{}][@id > 3]) = 2]/@id",
    "//frame[{}-sibling::frame[{}][last()]/@id > 3]/@id",
    "//frame[{}-sibling::frame[{}][2]]/@id",
    "//frame[2]/{}-sibling::frame[{}]/@id",
    "boolean(//frame_bone[../{}-sibling::frame[{}]/frame_bone/@Rx > 100])",
]


@pytest.mark.parametrize("text", fuzz.share([text.format(axis, "{}") for text in NEAR for axis in AXES], 7))
def test_windows_of_frames(documents: Library, text: str) -> None:
    small = {uuid: tree for uuid, tree in documents.trees.items() if sum(1 for _ in tree.iter()) < 1500}
    for window in WINDOWS:
        outcome = check(documents.engine, small, text.format(window), Random(1))
        assert outcome is not None, window
        assert outcome.way != "projection", window


@pytest.mark.fuzz(seeds=8)
@pytest.mark.timeout(7200)
def test_answers_are_libxml2s_many_times(documents: Library, seed: int) -> None:
    tally = campaign(documents, seed_of(documents, seed), 2600)
    print(tally)
    tally.judge()
    assert tally.on_columns >= 0.95
