"""Functions of bodies in motion against a loop over the frames of each document: documents of several formats, rates
and skeletons, with what is unknown of them, between edits, and as past revisions left them."""

from __future__ import annotations

import math
from contextlib import suppress
from random import Random
from typing import Any

import pytest

from mcml.errors import McmlError
from mcml.formats import FORMATS
from mcml.motion.skeleton import Convention
from mcml.testing import written
from mcml_schemas.querying.queries import NodeItem, QueryRequest, ScalarItem
from mcml_service.actions.editing.frame_ranges import delete_frames, move_frames, reverse
from mcml_service.actions.editing.single_element import Change
from mcml_service.actions.editing.whole_document import add_labels, change_document, delete_document, restore_document
from mcml_service.clips.derive import derive_missing
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.queries import Queries
from tests.builders import ASF, HTR, MCML, TRC, amc, bvh, c3d_file, one_kind, store
from tests.edits import OTHER_SEEDS, change_element, delete_element
from tests.motion.bodies.made import FORMAT_OF, clip_of, person
from tests.xpath.motion_grammar import Chance, Question
from tests.xpath.motion_twin import Document, read_documents
from tests.xpath.test_xpath_many import opened, small_groups

__all__ = ["small_groups"]
EDITS: list[tuple[str, Change | None]] = [
    ("/mcml/motion/frame[2]", None),
    ("/mcml/motion/frame[1]/frame_bone[2]", None),
    ("/mcml/motion/frame[3]/frame_bone[1]/@Rx", None),
    ("/mcml/motion/frame[last()]/frame_bone[1]", Change({"Tz": "7"})),
    ("/mcml/motion/frame[5]/frame_bone[1]", Change({"Rx": "77"})),
    ("/mcml/skeleton/bone/name", Change({}, "renamed")),
    ("/mcml/skeleton/bone[1]", Change({"length": "12"})),
]


def files_of(convention: Convention, name: str, content: bytes) -> dict[str, bytes]:
    """A person in another format."""
    format = FORMATS[FORMAT_OF[convention]]
    return {f"{name}.{ending}": part for ending, part in written(format, clip_of(content, convention)).items()}


class Store:
    """People in several formats and at several rates, and documents that lack what bodies need."""

    def __init__(self, database: Database, seed: int) -> None:
        self.database = database
        self.random = Random(seed)
        self.deleted: list[str] = []
        store(database, {"a.bvh": person(seed, 34), "b.bvh": person(seed + 1, 25, 1 / 30)})
        store(database, files_of(Convention.FIXED, "c", person(seed + 2, 20)))
        store(database, files_of(Convention.BASE, "d", person(seed + 3, 22, 1 / 30)))
        store(database, {"e.bvh": person(seed + 4, 15, 1 / 120, scale=5.0)})  # of an unknown unit
        store(database, {"f.bvh": bvh(9, seed), "leg.asf": ASF, "leg.amc": amc(6), "h.htr": HTR, "m.mcml": MCML})
        store(database, {"t.trc": TRC, "p.c3d": c3d_file(), "none.bvh": bvh(0), "aa.bvh": bvh(0)})
        self.documents = read_documents(database)
        with database.write() as tx:
            for document in self.documents:
                stored = tx.documents.get(document.uuid)
                if stored.frames > 3:
                    first = self.random.randint(1, stored.frames - 2)
                    name = self.random.choice(("walk", "jump"))
                    add_labels(tx, stored, [(name, first, min(stored.frames, first + 9))])
        self.documents = read_documents(database)

    def change(self) -> None:
        """Something happens to a document."""
        kind = self.random.randrange(7)
        uuid = self.random.choice(self.deleted if kind == 0 and self.deleted else [one.uuid for one in self.documents])
        with suppress(McmlError), self.database.write() as tx:
            stored = tx.documents.get(uuid, deleted=True)
            first = self.random.randint(1, max(1, stored.frames))
            last = min(stored.frames, first + self.random.randint(0, 5))
            if uuid in self.deleted:
                restore_document(tx, stored)
                self.deleted.remove(uuid)
            elif kind == 1 and len(self.deleted) < 3:
                delete_document(tx, stored)
                self.deleted.append(uuid)
            elif kind == 2:
                delete_frames(tx, stored, first, last, renumber=False)
                tx.documents.add_revision(stored, "frames")
            elif kind == 3:
                move_frames(tx, stored, first, last, self.random.choice((1, stored.frames + 1)), renumber=False)
                tx.documents.add_revision(stored, "frames")
            elif kind == 4:
                reverse(tx, stored, first, last)
                tx.documents.add_revision(stored, "frames")
            else:
                where, change = self.random.choice(EDITS)
                where = where.replace("last()", str(stored.frames))
                change_element(tx, stored, where, change) if change else delete_element(tx, stored, where)
        self.documents = read_documents(self.database)


def differs(engine: Queries, question: Question, documents: list[Document], random: Random, **asked: Any) -> str:
    """How the answer is another one, if it is."""
    wanted = question.of(documents)
    if isinstance(wanted, float):
        answer = engine.answer(QueryRequest(q=question.text, **asked))
        value = math.nan if answer.value in (None, "NaN") else float(answer.value or 0)
        # Poses are compared with floats of single precision.
        within = 1e-5 if "-distance(" in question.text else 1e-9
        return "" if _same(value, wanted, within) else f"{question.text}\n  {value} is not {wanted}"
    limit = random.choice((3, 40, 1000)) if len(wanted) < 60 else 1000
    found = []
    cursor = None
    while True:
        answer = engine.answer(QueryRequest(q=question.text, limit=limit, cursor=cursor, **asked))
        found += [(item.document, item.address) for item in answer.items or [] if isinstance(item, NodeItem)]
        cursor = answer.next_cursor
        if cursor is None:
            break
    if found == wanted:
        return ""
    only, lacking = sorted(set(found) - set(wanted)), sorted(set(wanted) - set(found))
    return f"{question.text}\n  {len(found)} and {len(wanted)}; not: {only[:3]}; but: {lacking[:3]}"


def _same(value: float, wanted: float, within: float) -> bool:
    both = value != value and wanted != wanted
    return both or abs(value - wanted) <= within * max(1.0, abs(wanted))


def run(database: Database, seed: int, rounds: int, asked: int, chance: type[Chance] = Chance) -> None:
    made = Store(database, seed)
    random = Random(seed)
    engine = Queries(database, Settings(query_seconds=600, cache_dir="none"))
    differences: list[str] = []
    filled = 0
    with opened(engine):
        for _ in range(rounds):
            if random.random() < 0.3:
                engine.caches = Caches(random.choice((0, 100_000, 1 << 26)))
            if random.random() < 0.5:
                derive_missing(database, lambda done, of: None)
            for _ in range(asked):
                question = chance(random, made.documents).question()
                filled += bool(question.of(made.documents))
                differences.append(differs(engine, question, made.documents, random))
                if "mo:" in question.text and random.random() < 0.3:
                    known = [one for one in made.documents if one.is_known(question.text)]
                    differences.append(differs(engine, question, known, random, guesses="no"))
            one = random.choice([one for one in made.documents if one.revision > 1])
            past = read_documents(database, {one.uuid: random.randint(1, one.revision)})
            for _ in range(asked // 4):
                question = chance(random, past).question()
                at = {"document": [one.uuid], "revision": past[0].revision}
                differences.append(differs(engine, question, past, random, **at))
            for _ in range(random.choice((1, 3))):
                made.change()
    found = [difference for difference in differences if difference]
    assert not found, f"{len(found)} of {len(differences)} differ:\n" + "\n".join(found[:10])
    assert filled > len(differences) / 5


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), OTHER_SEEDS[1:3], indirect=["kind"])
def test_answers_are_those_of_loops(database: Database, seed: int) -> None:
    run(database, seed, rounds=1, asked=16)


def test_documents_without_frames_have_facts_of_their_own(database: Database) -> None:
    """Not those of the document behind them."""
    legs = ("Hips", "LeftUpLeg", "LeftLeg", "LeftFoot")
    store(database, {"a.bvh": bvh(0, names=legs), "b.bvh": bvh(9), "c.bvh": bvh(0), "d.bvh": bvh(5, names=legs)})
    with database.write() as tx:
        for document, unit in zip(tx.columns.documents(), ("cm", "m", "mm", "inch"), strict=True):
            change_document(tx, tx.documents.get(document.uuid), unit=unit)
    engine = Queries(database, Settings(cache_dir="none"))
    with opened(engine):
        units = engine.answer(QueryRequest(q="mo:unit()")).items or []
        assert [item.value for item in units if isinstance(item, ScalarItem)] == [0.01, 1.0, 0.001, 0.0254]
        legged = engine.answer(QueryRequest(q="/mcml[mo:leg() > 0]/header/filename")).items or []
        names = [item.value for item in legged if isinstance(item, NodeItem)]
        assert names == ["<filename>a.bvh</filename>", "<filename>d.bvh</filename>"]


@one_kind
def test_attributes_that_frames_of_a_window_lack_are_no_unknown_values(database: Database) -> None:
    """They are NaN, as outside of windows: only quantities of a body are neither true nor false."""
    store(database, {"f.bvh": bvh(9), "p.c3d": c3d_file(), "m.mcml": MCML})
    engine = Queries(database, Settings(cache_dir="none"))
    root = "number(frame_bone[@name='Root'][1]/@Rx)"
    with opened(engine):
        for asked in (root, f"mo:window(0, 2, 'frames')/{root}", f"mo:window(0, 0)/{root}"):
            answer = engine.answer(QueryRequest(q=f"count(//frame[not({asked} > 1000)])"))
            assert float(answer.value or 0) == 18, asked
        unknown = "count(//frame[not(mo:window(0, 0)/mo:speed('Root') > 1000)])"
        assert float(engine.answer(QueryRequest(q=unknown)).value or 0) == 0, "their unit is not known"


@pytest.mark.slow
@pytest.mark.above_store
@pytest.mark.usefixtures("small_groups")
def test_answers_are_those_of_loops_over_many_groups(database: Database) -> None:
    run(database, 5, rounds=2, asked=10)


@pytest.mark.usefixtures("small_groups")
@pytest.mark.fuzz(seeds=4)
@pytest.mark.timeout(7200)
def test_answers_are_those_of_loops_many_times(database: Database, seed: int) -> None:
    run(database, seed, rounds=30, asked=40)
