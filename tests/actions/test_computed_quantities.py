"""Quantities of the gait model of stored documents: edits of markers count, trimming changes nothing."""

from __future__ import annotations

import numpy as np
import pytest

from mcml.errors import NotFoundError
from mcml.motion.bodies.quantities import asked_quantity
from mcml.motion.skeleton import Array
from mcml_schemas.frames import AdjustFrames, FrameEdits, InsertFrames, KeepFrames, MirrorFrames, ReverseFrames
from mcml_schemas.querying.queries import NodeItem, QueryRequest
from mcml_service.actions.editing.frame_ranges import edit_frames
from mcml_service.actions.labelling.set_properties import set_properties
from mcml_service.actions.reading.read_quantities import quantity_columns
from mcml_service.clips.bodies import read_bodies
from mcml_service.clips.frame_quantities import FrameQuantities, read_measurements
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.queries import Queries
from tests.builders import store
from tests.laboratory.gait_bodies import LegPose, turn
from tests.laboratory.gait_files import FRAMES, POSES, gait_file, measures_of, walk

NAMES = ("LPelvisAngles,x", "LPelvisAngles,z", "LKneeAngles,x", "RFootProgressAngles,z", "LAJC,x")
FIRST = 286


def trial() -> bytes:
    """Somebody who walks backwards, so that facing does not tell the direction of the walk."""
    return gait_file(walk(way=-40.0), measures_of(), first=FIRST)


def values(database: Database, uuid: str, *names: str) -> Array:
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        body = read_bodies(tx, tx.columns.documents([stored.key]))[stored.key]
        asked = [asked_quantity(f"quantity:{name}") for name in names]
        return quantity_columns(FrameQuantities(tx, stored, body), asked, 1, stored.frames)


def edit(database: Database, uuid: str, *edits: object) -> None:
    with database.write() as tx:
        edit_frames(tx, tx.documents.get(uuid), FrameEdits(edits=list(edits)))


def test_trimmed_documents_have_the_values_of_the_whole(database: Database) -> None:
    (uuid,) = store(database, {"a.c3d": trial()})
    whole = values(database, uuid, *NAMES)
    assert abs(abs(whole[0, 1]) - 180) < 1e-3
    edit(database, uuid, KeepFrames(do="keep", first=8, last=14))
    np.testing.assert_array_equal(values(database, uuid, *NAMES), whole[7:14])


def test_angles_of_somebody_who_turns_round_do_not_jump(database: Database) -> None:
    """Also where the clip begins after the turn."""
    still, whole_turn = walk(), np.linspace(0.0, 400.0, FRAMES)
    turned = {name: np.stack([turn("z", degrees) @ place for degrees, place in zip(whole_turn, places, strict=True)])
              for name, places in still.items()}  # fmt: skip
    (uuid,) = store(database, {"a.c3d": gait_file(turned, measures_of())})
    whole = values(database, uuid, "RPelvisAngles,z")[:, 0]
    assert np.abs(np.diff(whole)).max() < 30
    assert np.ptp(whole) > 390
    edit(database, uuid, KeepFrames(do="keep", first=20, last=FRAMES))
    np.testing.assert_array_equal(values(database, uuid, "RPelvisAngles,z")[:, 0], whole[19:])


def test_values_stay_at_their_frames(database: Database) -> None:
    (uuid,) = store(database, {"a.c3d": trial()})
    whole = values(database, uuid, *NAMES)
    edit(database, uuid, ReverseFrames(do="reverse", first=3, last=20))
    expected = np.concatenate([whole[:2], whole[2:20][::-1], whole[20:]])
    np.testing.assert_array_equal(values(database, uuid, *NAMES), expected)


def test_frames_that_are_not_of_the_file_have_none(database: Database) -> None:
    thin = {"L": LegPose(knee=(60.0, 0.0, 0.0)), "R": LegPose()}
    uuid, other = store(database, {"a.c3d": trial(), "b.c3d": gait_file(walk(poses=thin), measures_of())})
    insert = {"do": "insert", "at": 1, "document": other, "first": 1, "last": 3}
    edit(database, uuid, InsertFrames.model_validate(insert), MirrorFrames(do="mirror", first=10, last=12))
    knee = values(database, uuid, "LKneeAngles,x")[:, 0]
    assert np.flatnonzero(np.isnan(knee)).tolist() == [0, 1, 2, 9, 10, 11]


def test_edits_of_markers_count(database: Database) -> None:
    (uuid,) = store(database, {"a.c3d": trial()})
    before = values(database, uuid, "LHipAngles,z", "RHipAngles,z")
    knees = {"do": "adjust", "first": 5, "last": 9, "channels": ["Ty"], "bones": ["LTHI"], "offset": 20.0}
    edit(database, uuid, AdjustFrames.model_validate(knees))
    after = values(database, uuid, "LHipAngles,z", "RHipAngles,z")
    changed = np.abs(after - before) > 0.5
    assert np.flatnonzero(changed[:, 0]).tolist() == [4, 5, 6, 7, 8]
    assert not changed[:, 1].any()


def test_they_are_listed_with_units_and_notes(database: Database) -> None:
    (uuid,) = store(database, {"a.c3d": trial()})
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        listed = {each.name: each for each in read_measurements(tx, stored).describe()}
        asked = [asked_quantity(f"quantity:{name},x") for name in ("LKneeAngles", "cgm1:LAJC", "landmarks:LKneeAngles")]
        (body,) = read_bodies(tx, [stored]).values()
        assert FrameQuantities(tx, stored, body).units(asked) == ["deg", "mm", "deg"]
    assert listed["LKneeAngles"].known
    assert not listed["LKneeMoment"].known
    assert "force plates" in listed["LKneeMoment"].reason
    with pytest.raises(NotFoundError, match="force plates"):
        values(database, uuid, "LKneeMoment,x")


def test_questions_find_frames_by_them(database: Database) -> None:
    bent = {"L": LegPose(knee=(60.0, 0.0, 0.0)), "R": POSES["R"]}
    _, uuid = store(database, {"a.c3d": trial(), "b.c3d": gait_file(walk(poses=bent), measures_of())})
    queries = Queries(database, Settings())
    try:
        outcome = queries.answer(QueryRequest(q="//frame[mo:quantity('LKneeAngles', 'x') > 50]"))
        assert len(outcome.items) == FRAMES
        assert all(isinstance(item, NodeItem) and item.document == uuid for item in outcome.items)
        none = queries.answer(QueryRequest(q="//frame[mo:quantity('LKneeMoment', 'x') > 0]"))
        assert not none.items
        assert any("2 of 2 documents left out" in warning for warning in none.warnings)
    finally:
        queries.close()


def test_properties_state_what_a_file_lacks(database: Database) -> None:
    """Answers of queries follow properties that are set later."""
    bare = {name: value for name, value in measures_of().items() if "KneeWidth" not in name}
    (uuid,) = store(database, {"a.c3d": gait_file(walk(), bare)})
    queries = Queries(database, Settings())
    question = QueryRequest(q="//frame[mo:quantity('RKneeAngles', 'x') > 30]")
    try:
        assert not queries.answer(question).items
        with pytest.raises(NotFoundError, match="measure LKneeWidth"):
            values(database, uuid, "LKneeAngles,x")
        with database.write() as tx:
            table = f"document,gait LKneeWidth (mm),gait RKneeWidth (cm)\n{uuid},100,10.4\n"
            set_properties(tx, table.encode())
        np.testing.assert_allclose(values(database, uuid, "LKneeAngles,x")[:, 0], POSES["L"].knee[0], atol=2e-3)
        np.testing.assert_allclose(values(database, uuid, "RKneeAngles,x")[:, 0], POSES["R"].knee[0], atol=2e-3)
        assert len(queries.answer(question).items) == FRAMES
    finally:
        queries.close()
    with database.read() as tx:
        listed = {each.name: each for each in read_measurements(tx, tx.documents.get(uuid)).describe()}
    assert "measures from properties: LKneeWidth" in listed["LKneeAngles"].notes
