"""Quantities that one pass over a clip finds: a question about one of them leaves no work for the others."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from mcml.errors import QueryError
from mcml.motion.bodies.activities.recognition import recognize_activities
from mcml.motion.bodies.activities.signals import JOINTS, BodySignals
from mcml_schemas.querying.queries import QueryRequest
from mcml_service.clips import bodies as clip_bodies
from mcml_service.clips.bodies import LONG, Body, read_bodies
from mcml_service.clips.derive import derive_missing
from mcml_service.clips.frame_quantities import FrameQuantities
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.documents.bodies import StoredBody
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.queries import Queries
from tests.builders import MCML, one_kind, store
from tests.laboratory.walkers import Gait, make_c3d
from tests.motion.bodies.made import person

pytestmark = one_kind
FILES = {
    "walk.c3d": make_c3d(Gait(seconds=3, on_belt=True)),
    "way.c3d": make_c3d(Gait(seconds=4)),
    "a.bvh": person(1, 60),
    "hand.mcml": MCML,
}
ACTIVITIES = ("walk", "turn", "turn left", "jump", "wave", "right reach")


@pytest.fixture
def engine(database: Database) -> Iterator[Queries]:
    store(database, FILES)
    engine = Queries(database, Settings(cache_dir="none"))
    yield engine
    engine.close()


def count(engine: Queries, call: str) -> float:
    answer = engine.answer(QueryRequest(q=f"count(//frame[{call}])"))
    assert isinstance(answer.value, float)
    return answer.value


def counts(database: Database, calls: list[str]) -> list[float]:
    """Each by an engine of its own, which has found nothing yet."""
    found = []
    for call in calls:
        engine = Queries(database, Settings(cache_dir="none"))
        found.append(count(engine, call))
        engine.close()
    return found


def test_the_contacts_of_both_feet(engine: Queries, monkeypatch: pytest.MonkeyPatch) -> None:
    left, right = counts(engine.database, ["mo:contact('left')", "mo:contact('right')"])
    assert min(left, right) > 100
    assert count(engine, "mo:contact('left')") == left
    monkeypatch.setattr(FrameQuantities, "read_known", lambda *_: pytest.fail("measured again"))
    assert count(engine, "mo:contact('right')") == right
    assert count(engine, "mo:contact('left') and mo:contact('right')") <= min(left, right)


def test_all_activities(engine: Queries, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = [f"mo:activity('{name}')" for name in ACTIVITIES]
    expected = counts(engine.database, calls)
    assert count(engine, calls[1]) == expected[1]
    monkeypatch.setattr(BodySignals, "of", lambda *_: pytest.fail("recognised again"))
    assert [count(engine, call) for call in calls] == expected


def test_names_that_are_found_in_the_documents(engine: Queries) -> None:
    with pytest.raises(QueryError, match="'1' is no activity"):
        engine.answer(QueryRequest(q="//frame[mo:activity(@id)]"))
    contacts = count(engine, "mo:contact(concat('le', 'ft'))")
    assert contacts == count(engine, "mo:contact('left')")


def test_many_frames_have_one_quantity_at_a_time(engine: Queries, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = [f"mo:activity('{name}')" for name in ACTIVITIES]
    expected = counts(engine.database, calls)
    monkeypatch.setattr("mcml_service.xpath.library.bodies.MOST_VALUES", 1)
    assert [count(engine, call) for call in calls] == expected


def test_a_stored_body_knows_its_activities(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    store(database, FILES)
    caches = Caches(1 << 20)
    with database.read() as tx:
        fresh = {key: body.activities for key, body in read_bodies(tx, tx.columns.documents()).items()}
    assert any(fresh.values())
    assert derive_missing(database, lambda *_: None) == len(FILES)
    with database.read() as tx:
        for body in caches.bodies.read(tx, tx.columns.documents()):
            stretch = body.stretch(JOINTS)
            held = stretch.kept["recognize_activities", ()]
            stretch.kept.clear()
            assert held == recognize_activities(stretch) == body.activities
            # Part of a clip has activities of its own.
            assert "recognize_activities" not in [key[0] for key in body.stretch(JOINTS, 1).kept]
        assert {key: body.activities for key, body in read_bodies(tx, tx.columns.documents()).items()} == fresh


def test_a_long_document_finds_them_when_it_is_asked(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    store(database, {"a.bvh": FILES["a.bvh"]})
    with database.read() as tx:
        (short,) = read_bodies(tx, tx.columns.documents()).values()
        monkeypatch.setattr(clip_bodies, "LONG", 10)
        (long,) = read_bodies(tx, tx.columns.documents()).values()
    assert LONG > short.frames > 10
    assert long.activities is None
    assert recognize_activities(long.stretch(JOINTS)) == short.activities
    assert Body.restore(StoredBody(long.facts(), long.blocks)) is not None
    assert np.array_equal(long.stretch(("Head",)).at("Head"), short.stretch(("Head",)).at("Head"), equal_nan=True)
