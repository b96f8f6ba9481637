"""Lists from memory are those of the store: the same pages, places and counts, whatever happened in between."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from random import Random

import pytest

from mcml.errors import McmlError
from mcml_service.actions.editing import whole_document as changes
from mcml_service.actions.keeping.purge_documents import purge_documents
from mcml_service.listing import register as registers
from mcml_service.listing.register import Register
from mcml_service.storage.database import Database
from mcml_service.storage.lists import facets
from mcml_service.storage.lists.filtering import DocumentFilter
from mcml_service.storage.lists.orders import NEWEST, TYPES, Order
from tests.builders import TRC, bvh, one_kind, store
from tests.edits import OTHER_SEEDS

NAMES = ("walk", "Walk 2", "WALK", "걸음", "Ärger", "ärger", "a_b%c", "reach 14", "reach", "z")
TEXTS = ("calm", "Calm and slow", "50%", "x" * 300, "12", "12.0", "-3.5", "")
MOTIONS = ("wave", "left-arm-abduction", "Ärger", "walk")
PROJECTS = ("default", "Reach", "걸음")
WORDS = (
    "walk",
    "WALK",
    "ä",
    "Ä",
    "걸음",
    "_",
    "%",
    "1",
    "bvh",
    "calm slow",
    "wave reach",
    "nothing",
    "x",
    " ",
    "shelf",
)
ORDERS = (*(Order(column, down) for column in TYPES for down in (False, True)), NEWEST)


class Library:
    """A store to which things happen."""

    def __init__(self, database: Database, seed: int) -> None:
        self.database = database
        self.random = Random(seed)
        self.uuids: list[str] = []
        for _ in range(12):
            self.add()

    def add(self) -> None:
        pick = self.random.choice
        content = bvh(pick((1, 2, 3, 9)), seed=pick(range(3)), names=("Hips", "Spine", "Head")[: pick((2, 3))])
        content = content.replace(b"0.0083333", pick((b"0.0083333", b"0.0333333", b"0", b"1e-2")))
        files = {f"{pick(NAMES)}.bvh": content} if self.random.random() < 0.8 else {"hand.trc": TRC}
        options = {"project": pick(PROJECTS), "description": pick(("", "For the Shelf.", "über alles"))}
        self.uuids += store(self.database, files, name=pick(NAMES), labels=(), properties=self.properties(), **options)

    def properties(self) -> tuple[tuple[str, str, str], ...]:
        names = self.random.sample(("age", "take", "Note"), self.random.randrange(4))
        return tuple((name, self.random.choice(TEXTS), "") for name in names)

    def happen(self) -> None:
        """One thing, which is refused now and then."""
        pick, uuid = self.random.choice, self.random.choice(self.uuids)
        kind = self.random.randrange(10)
        if kind == 0:
            self.add()
            return
        if kind == 1 and self.random.random() < 0.3:
            purge_documents(self.database, [uuid])
            self.uuids.remove(uuid)
            return
        with suppress(McmlError), self.database.write() as tx:
            stored = tx.documents.get(uuid, deleted=True)
            if kind < 4:
                changes.delete_document(tx, tx.documents.get(uuid))
            elif kind == 4:
                changes.restore_document(tx, stored)
            elif kind == 5:
                changes.undo_revision(tx, tx.documents.get(uuid), stored.revision)
            elif kind == 6:
                changes.add_labels(tx, tx.documents.get(uuid), [(pick(MOTIONS), 1, 1)])
            elif kind == 7:
                changes.restore_revision(tx, tx.documents.get(uuid), 1)
            else:
                facts = {"name": pick(NAMES), "project": pick(PROJECTS), "properties": list(self.properties())}
                facts |= {"description": pick(("", "Calm.")), "frame_time": pick(("0.01", "0.02"))}
                chosen = self.random.sample(list(facts), 2)
                changes.change_document(tx, tx.documents.get(uuid), **{name: facts[name] for name in chosen})

    def filter(self) -> DocumentFilter:
        """Some conditions, none of them now and then."""
        pick = self.random.choice
        with self.database.read() as tx:
            keys = [row[0] for row in tx.documents.everything()]
            skeletons = [listed.skeleton for listed in tx.columns.documents()]
        conditions = {
            "project": lambda: pick((*PROJECTS, "no such one")),
            "name": lambda: pick(NAMES),
            "id": lambda: pick(self.uuids)[: pick((1, 9, 36))].upper() + pick(("", "", "0%")),
            "text": lambda: pick(WORDS),
            "motion_name": lambda: pick((*MOTIONS, "no such one")),
            "format": lambda: pick(("bvh", "trc", "c3d")),
            "skeleton": lambda: pick((*skeletons, 0)),
            "properties": lambda: (
                pick((("age", 1.0, None, None), ("take", -5.0, 12.0, None), ("age", None, None, pick(TEXTS)))),
            ),
            "length": lambda: pick(((0.01, None), (None, 0.02), (0.0, 1.0))),
            "rate": lambda: pick(((31.0, None), (None, 60.0))),
            "among": lambda: tuple(self.random.sample(keys, len(keys) // 2)),
            "deleted": lambda: True,
        }
        chosen = self.random.sample(list(conditions), pick((0, 1, 1, 2, 3)))
        return DocumentFilter(**{name: conditions[name]() for name in chosen})


def assert_same(database: Database, register: Register, wanted: DocumentFilter, order: Order, random: Random) -> None:
    with database.read() as tx:
        whole = tx.documents.places(wanted, order, None, 1000, 0)
        assert tx.documents.count(wanted) == len(whole)
        found = register.page(tx, wanted, order, None, 1000, 0)
        assert (found.places, found.total) == (whole, len(whole))
        if whole:
            offset, limit = random.randrange(len(whole) + 1), random.randrange(1, 5)
            assert register.page(tx, wanted, order, None, limit, offset).places == whole[offset : offset + limit]
            at = random.randrange(len(whole))
            behind = whole[at + 1 :]
            assert tx.documents.places(wanted, order, whole[at], 1000, 0) == behind
            assert register.page(tx, wanted, order, whole[at], 1000, 0).places == behind
            assert [one.key for one in tx.documents.get_many([place.key for place in whole])] == [
                one.key for one in whole
            ]
        for most, bins in ((100, 12), (2, 3)):
            assert register.facets(tx, wanted, most, bins) == facets.facets(tx, wanted, most, bins)


def campaign(database: Database, seed: int, rounds: int) -> None:
    library = Library(database, seed)
    # As processes that look after each change, and now and then.
    registers_of = [Register(patience=0), Register(patience=0)]
    for number in range(rounds):
        # A cursor may name a document that is not so any more.
        before, order = library.filter(), library.random.choice(ORDERS)
        with database.read() as tx:
            old = tx.documents.places(before, order, None, 1000, 0)
        library.happen()
        if old:
            place = library.random.choice(old)
            with database.read() as tx:
                wanted = tx.documents.places(before, order, place, 1000, 0)
                assert registers_of[0].page(tx, before, order, place, 1000, 0).places == wanted
        for register in registers_of[: 1 + (number % 7 == 6)]:
            for _ in range(3):
                assert_same(database, register, library.filter(), library.random.choice(ORDERS), library.random)
    last = registers_of[0]._last  # the lists came from memory
    assert last is not None
    with database.read() as tx:
        assert len(last) == len(tx.documents.everything())


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), OTHER_SEEDS[:2], indirect=["kind"])
def test_lists_from_memory_are_those_of_the_store(database: Database, seed: int) -> None:
    campaign(database, seed, 6)


@pytest.mark.fuzz(seeds=30)
def test_lists_from_memory_in_the_long_run(database: Database, seed: int) -> None:
    campaign(database, seed, 150)


@pytest.fixture
def three(database: Database) -> Iterator[Database]:
    for name in ("b", "a", "c"):
        store(database, {f"{name}.bvh": bvh(2)}, name=name, labels=())
    return database


def names(database: Database, register: Register, **wanted: object) -> list[str]:
    with database.read() as tx:
        found = register.page(tx, DocumentFilter(**wanted), Order("frames"), None, 10, 0)  # type: ignore[arg-type]
        return [place.name for place in found.places]


@one_kind
def test_who_asks_once_waits_for_no_columns(three: Database) -> None:
    register = Register()
    assert names(three, register) == ["a", "b", "c"]
    assert register._last is None
    assert names(three, register) == ["a", "b", "c"]
    assert register._last is not None


@one_kind
def test_first_pages_need_no_columns(three: Database) -> None:
    register = Register(patience=0)
    with three.read() as tx:
        for order in (Order(), NEWEST):
            assert register.page(tx, DocumentFilter(), order, None, 10, 0).total == 3
    assert register._last is None


@one_kind
def test_a_library_with_too_much_text_is_listed_by_the_store(three: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registers, "MOST_CHARACTERS", 2)
    register = Register(patience=0)
    assert names(three, register, text="a") == ["a"]
    assert register._last is None


@one_kind
def test_an_older_state_is_read_from_the_store(three: Database) -> None:
    register = Register(patience=0)
    with three.read() as old:
        before = old.newest_commit()
        store(three, {"d.bvh": bvh(2)}, name="d", labels=())
        assert names(three, register) == ["a", "b", "c", "d"]
        assert before == old.newest_commit()
        assert register.page(old, DocumentFilter(), Order("frames"), None, 10, 0).total == 3
    assert names(three, register) == ["a", "b", "c", "d"]


@one_kind
def test_values_that_are_gone_are_forgotten(three: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    register = Register(patience=0)
    names(three, register)
    known = register._last
    assert known is not None
    monkeypatch.setattr(register, "_whole", 1)
    with three.write() as tx:
        changes.change_document(tx, tx.documents.get_many([int(known["keys"][0])])[0], name="renamed")
    assert names(three, register, name="renamed") == ["renamed"]
    last = register._last
    assert last is not None
    assert last.words is not known.words
    assert "a" not in last.words.texts.values
