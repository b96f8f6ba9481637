"""Angles of each of several people in a trial are those of the person alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mcml
from mcml.errors import NotFoundError
from mcml.motion.bodies.limb_angles import angle_names, turn_named
from mcml.motion.skeleton import Array
from mcml_schemas.querying.queries import NodeItem, QueryRequest
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.queries import Queries
from tests.builders import store
from tests.laboratory.gait_files import gait_file, two_people
from tests.laboratory.walkers import Gait, make_c3d
from tests.motion.bodies.made import person

NAMES = [name for name in angle_names() if turn_named(name) is None]


def trial() -> bytes:
    """Markers of both people."""
    markers = {f"{who}:{name}": place for who, (own, _) in two_people().items() for name, place in own.items()}
    return gait_file(markers, {}, subjects=["Anna", "Bert"])


def read(path: Path, content: bytes) -> mcml.Motion:
    path.write_bytes(content)
    return mcml.read(path, up="Z")


def angle_of(motion: mcml.Motion, name: str) -> Array | str:
    try:
        return motion.angle(name)
    except NotFoundError as error:
        return error.what.split(",")[0].replace("Anna:", "").replace("Bert:", "")


def test_angles_are_those_of_the_person_alone(tmp_path: Path) -> None:
    both = read(tmp_path / "both.c3d", trial())
    known = 0
    for who, (own, _) in two_people().items():
        alone = read(tmp_path / f"{who}.c3d", gait_file(own, {}))
        for name in NAMES:
            expected, found = angle_of(alone, name), angle_of(both, f"{who}:{name}")
            assert type(expected) is type(found), name
            np.testing.assert_array_equal(found, expected, err_msg=f"{who} {name}")
            known += isinstance(found, np.ndarray) and bool(np.isfinite(found).all())
    assert known > 20
    assert not np.allclose(both.angle("Anna:left-knee-flexion"), both.angle("Bert:left-knee-flexion"))


def test_refusals_name_the_people(tmp_path: Path) -> None:
    both = read(tmp_path / "both.c3d", trial())
    for call, remedy in (
        (lambda: both.angle("left-knee-flexion"), "Begin the name with one of: Anna:, Bert:"),
        (lambda: both.height("left_foot"), "Name one of: Anna:left_foot, Bert:left_foot"),
        (lambda: both.angle("Carl:left-knee-flexion"), "There are: "),
    ):
        with pytest.raises(NotFoundError) as refused:
            call()
        assert remedy in str(refused.value.remedy)


def test_contacts_are_those_of_the_person_alone(database: Database, tmp_path: Path) -> None:
    alone = read(tmp_path / "alone.c3d", make_c3d(Gait()))
    content = make_c3d(Gait(), people=("Anna:", "Bert:"))
    both = read(tmp_path / "both.c3d", content)
    uuid, _ = store(database, {"both.c3d": content, "walk.bvh": person(1, 60)})
    queries = Queries(database, Settings())
    try:
        for who in ("Anna", "Bert"):
            for side in ("left", "right"):
                expected = alone.contact(side)
                assert 0 < np.nansum(expected) < len(expected)
                np.testing.assert_array_equal(both.contact(f"{who}:{side}"), expected)
                answer = queries.answer(QueryRequest(q=f"count(//frame[mo:contact('{who}:{side}')])"))
                assert answer.value == np.nansum(expected)
                computed = f"count(for $who in '{who}' return //frame[mo:contact(concat($who, ':{side}'))])"
                assert queries.answer(QueryRequest(q=computed)).value == np.nansum(expected)
                assert any("1 of 2 documents left out: no step tells" in warning for warning in answer.warnings)
        none = queries.answer(QueryRequest(q="count(//frame[mo:contact('Carl:left')])"))
        assert none.value == 0
        assert any("2 of 2 documents left out" in warning for warning in none.warnings), uuid
    finally:
        queries.close()


def test_questions_find_frames_of_a_person(database: Database) -> None:
    people = two_people()
    (uuid,) = store(database, {"both.c3d": trial()}, up="Z")
    queries = Queries(database, Settings())
    try:
        for who in people:
            expected = queries.answer(QueryRequest(q=f"//frame/mo:angle('{who}:left-knee-flexion')"))
            least = min(float(item.value) for item in expected.items)
            outcome = queries.answer(QueryRequest(q=f"//frame[mo:angle('{who}:left-knee-flexion') > {least - 1e-9!r}]"))
            found = [item.document for item in outcome.items if isinstance(item, NodeItem)]
            assert found == [uuid] * len(expected.items)
    finally:
        queries.close()


def test_warnings_of_angles_name_the_person(database: Database) -> None:
    """A foot of Bert has no line from heel to toe; the facts of a document are those of all its people."""
    markers = {f"{who}:{name}": place for who, (own, _) in two_people().items() for name, place in own.items()}
    del markers["Bert:LHEE"]
    store(database, {"both.c3d": gait_file(markers, {}, subjects=["Anna", "Bert"])}, up="Z")
    store(database, {"whole.c3d": trial()}, up="Z")
    queries = Queries(database, Settings())
    try:
        for name, warning in (
            ("Bert:left-ankle-dorsiflexion", "1 of 2 documents may have Bert:left-ankle-dorsiflexion in the frame of"),
            ("Anna:left-leg-flexion", "Anna:left-hip-flexion is the clinical angle of the same movement"),
        ):
            warnings = queries.answer(QueryRequest(q=f"count(//frame[mo:angle('{name}') > 0])")).warnings
            assert any(warning in each for each in warnings), warnings
    finally:
        queries.close()
