"""XPath 1.0 over many small documents, of few skeletons and of many: libxml2's answers, whatever happens between
questions, however little is kept of columns, from several threads at once, and of states that are past."""

from __future__ import annotations

import io
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path
from random import Random
from typing import Any

import pytest
from lxml import etree

from mcml.errors import McmlError
from mcml.files.import_options import ImportOptions
from mcml.formats.format import SourceFile
from mcml_schemas.querying.queries import NodeItem, QueryRequest
from mcml_service.actions.editing.frame_ranges import delete_frames
from mcml_service.actions.editing.whole_document import add_labels, delete_document, restore_document
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.lists.filtering import DocumentFilter
from mcml_service.xpath.engine import group_scan, values
from mcml_service.xpath.engine.samples import frame_bones
from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.language.types import type_of
from mcml_service.xpath.library import groups
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.queries import Queries
from tests.builders import bvh
from tests.edits import change_element, delete_element
from tests.xpath.grammar import Grammar
from tests.xpath.library import EDITS
from tests.xpath.on_frames import of_any_attribute
from tests.xpath.oracle import DifferenceError, check, most_elements

LIMITS = (0, 100_000, 1 << 20, 1 << 26)
"""Bytes of columns that are kept."""
MOST_NODES = 3000
"""Of an answer; of larger ones only their count is compared."""
PARSER = etree.XMLParser(remove_blank_text=True)


class Many:
    """A store of small documents. trees: libxml2's, of those that are there, in order of the answer."""

    def __init__(self, database: Database, count: int, skeletons: int, seed: int) -> None:
        self.database = database
        self.random = Random(seed)
        self.deleted: list[str] = []
        files = []
        for number in range(count):
            pick = self.random.choice
            names = ("Hips", "LeftUpLeg", "LeftLeg")[: pick([2, 3])]
            content = bvh(pick([1, 2, 3, 5, 8]), seed=number, names=names)
            content = content.replace(b"10.5 0.00", b"%d.5 0.00" % (10 + number % skeletons))
            files.append(SourceFile(f"{pick('abc')}{number}.bvh", io.BytesIO(content)))
        done = import_files(database, files, ImportOptions(unit="cm"), Settings())
        assert not done.problems
        self.trees: dict[str, Any] = {}
        for one in done.documents[:: max(1, count // 40)]:
            with database.write() as tx:
                stored = tx.documents.get(one.uuid)
                add_labels(tx, stored, [(self.random.choice(("walk", "bar-1")), 1, stored.frames)])
        self.read([one.uuid for one in done.documents])

    def read(self, uuids: list[str]) -> None:
        """Parse documents anew; those that are deleted have no tree."""
        with self.database.read() as tx:
            order = [one.uuid for one in tx.documents.page(DocumentFilter(), after=None, limit=10_000)]
            for uuid in uuids:
                self.trees.pop(uuid, None)
                if uuid in set(order):
                    content = b"".join(export_document(tx, tx.documents.get(uuid), ExportOptions("mcml")).content)
                    self.trees[uuid] = etree.parse(io.BytesIO(content), PARSER)
        self.trees = {uuid: self.trees[uuid] for uuid in order}

    def change(self, *, restores: bool) -> None:
        """Something happens to a document. restores: a deleted one may come back, as if it had never been away."""
        kind = self.random.randrange(0 if restores else 1, 6)
        uuid = self.random.choice(self.deleted if kind == 0 and self.deleted else list(self.trees))
        with suppress(McmlError), self.database.write() as tx:
            stored = tx.documents.get(uuid, deleted=True)
            if uuid in self.deleted:
                restore_document(tx, stored)
                self.deleted.remove(uuid)
            elif kind == 1:
                delete_document(tx, stored)
                self.deleted.append(uuid)
            elif kind == 2:
                delete_frames(tx, stored, 1, 1, renumber=False)
                tx.documents.add_revision(stored, "frames")
            else:
                where, change = self.random.choice(EDITS)
                where = where.replace("last()", str(stored.frames))
                change_element(tx, stored, where, change) if change else delete_element(tx, stored, where)
        self.read([uuid])


def ask(engine: Queries, made: Many, text: str, random: Random) -> str:
    """How the answer differs, if it does."""
    if type_of(parse(text).tree) == "nodes":
        try:
            total = sum(int(tree.xpath(f"count({text})")) for tree in made.trees.values())
        except etree.XPathError:
            return ""
        text = text if total <= MOST_NODES else f"count({text})"
    try:
        check(engine, made.trees, text, random, whole=True)
    except DifferenceError as difference:
        return str(difference)
    return ""


def questions(made: Many, random: Random, count: int) -> list[str]:
    """About elements that are there; none that takes libxml2 long."""
    found: list[str] = []
    largest = max(sum(1 for _ in tree.iter()) for tree in made.trees.values())
    for _, text in Grammar(random, made.trees).expressions():
        if largest <= most_elements(parse(text).tree):
            found.append(text)
        if len(found) == count:
            break
    return found


def pages_of(engine: Queries, text: str) -> Iterator[list[tuple[str, str, str]]]:
    cursor = None
    while True:
        answer = engine.answer(QueryRequest(q=text, limit=100, cursor=cursor))
        yield [(item.document, item.address, item.value) for item in answer.items or [] if isinstance(item, NodeItem)]
        cursor = answer.next_cursor
        if cursor is None:
            return


def run(
    database: Database, count: int, skeletons: int, rounds: int, asked: int, seed: int, folder: str = "none"
) -> None:
    """folder: where columns are kept on disk."""
    made = Many(database, count, skeletons, seed)
    random = Random(seed)
    engine = Queries(database, Settings(query_seconds=600, cache_dir=folder))
    differences: list[str] = []
    with opened(engine), ThreadPoolExecutor(3) as threads:
        for _ in range(rounds):
            if random.random() < 0.5:
                # As in a fresh process; what was kept on disk is there.
                engine.caches = Caches(random.choice(LIMITS), engine.caches.sidecar)
            texts = questions(made, random, asked)
            texts += [of_any_attribute(random, tree) for tree in random.sample(list(made.trees.values()), 3)]
            seeds = [Random(random.random()) for _ in texts]
            differences += threads.map(lambda text, own: ask(engine, made, text, own), texts, seeds)
            # A page, a change, and the rest as it was.
            past = random.choice(["//frame_bone[@Rx > 5]", "//bone/name", "//frame[2]", "//header/*"])
            whole = [item for page in pages_of(Queries(database, Settings()), past) for item in page]
            pages = pages_of(engine, past)
            seen = next(pages)
            for _ in range(random.choice([1, 1, 4])):
                made.change(restores=False)
            seen += [item for page in pages for item in page]
            differences += [f"past: {past}"] if seen != whole else []
            made.change(restores=True)
    found = [difference for difference in differences if difference]
    assert not found, f"{len(found)} differences:\n" + "\n".join(found[:10])


@contextmanager
def opened(engine: Queries) -> Iterator[None]:
    try:
        yield
    finally:
        engine.close()


@pytest.fixture
def small_groups(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(groups, "DOCUMENTS", 12)
    monkeypatch.setattr(groups, "MOST_DOCUMENTS", 40)
    monkeypatch.setattr(groups, "LASTING", 1)
    monkeypatch.setattr(group_scan, "FIRST_UNITS", 4)
    monkeypatch.setattr(group_scan, "MANY_TRACKS", 4)
    monkeypatch.setattr(frame_bones, "FEW", 4)
    monkeypatch.setattr(values, "MANY", 4)


@pytest.mark.slow
@pytest.mark.usefixtures("small_groups")
@pytest.mark.parametrize(("kind", "skeletons"), [("sqlite", 2), ("sqlite", 90), ("postgresql", 90)], indirect=["kind"])
def test_answers_are_libxml2s(database: Database, skeletons: int) -> None:
    run(database, count=90, skeletons=skeletons, rounds=1, asked=8, seed=skeletons)


@pytest.mark.slow
@pytest.mark.above_store
@pytest.mark.usefixtures("small_groups")
def test_answers_are_libxml2s_with_columns_on_disk(database: Database, tmp_path: Path) -> None:
    run(database, count=90, skeletons=2, rounds=1, asked=8, seed=3, folder=str(tmp_path))


@pytest.mark.usefixtures("small_groups")
@pytest.mark.fuzz(seeds=4)
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("skeletons", [2, 500])
def test_answers_are_libxml2s_many_times(database: Database, skeletons: int, seed: int, tmp_path: Path) -> None:
    run(database, count=600, skeletons=skeletons, rounds=40, asked=12, seed=seed, folder=str(tmp_path))
