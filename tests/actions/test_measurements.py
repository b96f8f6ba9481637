"""Measurements of a C3D file stay at their frames, whatever is done to the frames, and questions read them."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random

import numpy as np
import pytest

import mcml
from mcml.errors import NotFoundError, QueryError
from mcml.motion.bodies.quantities import asked_quantity
from mcml.motion.skeleton import Array
from mcml_schemas.frames import (
    AdjustFrames,
    DeleteFrames,
    FrameEdits,
    InsertFrames,
    KeepFrames,
    MirrorFrames,
    MoveFrames,
    ResampleFrames,
    ReverseFrames,
    SmoothFrames,
)
from mcml_schemas.querying.queries import NodeItem, QueryRequest
from mcml_service.actions.editing.frame_ranges import edit_frames
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.reading.read_quantities import quantity_columns
from mcml_service.clips.bodies import read_bodies
from mcml_service.clips.frame_quantities import read_measurements
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.queries import Queries
from tests.builders import bvh, store
from tests.c3d_writer import Value, c3d_bytes

FIRST, FRAMES = 91, 40
LABELS = ["LASI", "RASI", "SACR", "LHEE", "RHEE", "LKneeAngles"]
TYPED: dict[str, Value | None] = {"POINT:ANGLES": (-1, (11,), b"LKneeAngles"), "POINT:UNITS": (-1, (2,), b"mm")}
KNEE = np.arange(FRAMES, dtype=np.float64) + 0.5
"""Degrees about x in each frame of the file, so that a value tells its frame."""

GAP = 7
"""A frame of the file without a sample of the knee."""


def trial(seed: int = 0) -> bytes:
    points = np.random.default_rng(seed).normal(500, 100, (FRAMES, len(LABELS), 3)).astype(np.float32)
    points[:, -1, 0] = KNEE
    fourth = np.zeros((FRAMES, len(LABELS)))
    fourth[GAP, -1] = -1
    return c3d_bytes(points, fourth, labels=LABELS, parameters=TYPED, first=FIRST)


def knees(database: Database, uuid: str, quantity: str = "quantity:LKneeAngles,x") -> Array:
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        body = read_bodies(tx, tx.columns.documents([stored.key]))[stored.key]
        return quantity_columns(tx, stored, body, [asked_quantity(quantity)], 1, stored.frames)[:, 0]


def values_of(frames: list[int | None]) -> Array:
    """The values of frames, each given by its place in the file; None for frames that are not of the file."""
    return np.array([np.nan if frame in (None, GAP) else KNEE[frame] for frame in frames])


def edit(database: Database, uuid: str, *edits: object) -> None:
    with database.write() as tx:
        edit_frames(tx, tx.documents.get(uuid), FrameEdits(edits=list(edits)))


@pytest.mark.parametrize("seed", range(12))
def test_values_stay_at_their_frames(database: Database, seed: int) -> None:
    """Against a list of frames that is edited beside the document."""
    chance = Random(seed)
    uuid, other = store(database, {"a.c3d": trial(), "b.c3d": trial(1)})
    frames: list[int | None] = list(range(FRAMES))
    for _ in range(6):
        first = chance.randint(1, len(frames) - 3)
        last = chance.randint(first, min(len(frames) - 1, first + 6))
        some = slice(first - 1, last)
        deed = chance.choice(["delete", "keep", "reverse", "move", "insert", "own", "mirror", "smooth", "adjust"])
        if deed == "delete":
            edit(database, uuid, DeleteFrames(do="delete", first=first, last=last))
            del frames[some]
        elif deed == "keep":
            edit(database, uuid, KeepFrames(do="keep", first=2, last=len(frames) - 1))
            frames = frames[1:-1]
        elif deed == "reverse":
            edit(database, uuid, ReverseFrames(do="reverse", first=first, last=last))
            frames[some] = frames[some][::-1]
        elif deed == "move":
            edit(database, uuid, MoveFrames(do="move", first=first, last=last, to=1))
            frames = [*frames[some], *frames[: first - 1], *frames[last:]]
        elif deed == "insert":
            edit(
                database,
                uuid,
                InsertFrames.model_validate({"do": "insert", "at": first, "document": other, "first": 1, "last": 3}),
            )
            frames[first - 1 : first - 1] = [None] * 3
        elif deed == "own":
            edit(
                database,
                uuid,
                InsertFrames.model_validate({"do": "insert", "at": 1, "document": uuid, "first": first, "last": last}),
            )
            frames = [*[None] * (last - first + 1), *frames]
        elif deed == "mirror":
            edit(database, uuid, MirrorFrames(do="mirror", first=first, last=last))
            frames[some] = [None] * (last - first + 1)
        elif deed == "smooth":
            edit(database, uuid, SmoothFrames(do="smooth", first=first, last=last, seconds=0.05))
        else:
            edit(database, uuid, AdjustFrames(do="adjust", first=first, last=last, channels=["Tx"], offset=1.0))
        np.testing.assert_array_equal(knees(database, uuid), values_of(frames), err_msg=deed)


def test_frames_at_another_rate_have_none(database: Database) -> None:
    (uuid,) = store(database, {"a.c3d": trial()})
    edit(database, uuid, ResampleFrames(do="resample", rate=50))
    assert np.isnan(knees(database, uuid)).all()
    with database.read() as tx:
        (knee,) = read_measurements(tx, tx.documents.get(uuid)).list()
    assert not knee.known
    assert knee.reason == "the file has 100 frames a second, the document 50"
    edit(database, uuid, ResampleFrames(do="resample", rate=100))
    assert np.isnan(knees(database, uuid)).all()


def test_a_trimmed_document_keeps_them_through_mcml_and_c3d(database: Database) -> None:
    (uuid,) = store(database, {"a.c3d": trial()})
    edit(database, uuid, DeleteFrames(do="delete", first=1, last=10))
    files = {}
    with database.read() as tx:
        for form in ("mcml", "c3d"):
            files[form] = b"".join(export_document(tx, tx.documents.get(uuid), ExportOptions(form)).content)
    for form, content in files.items():
        (again,) = store(database, {f"again.{form}": content})
        np.testing.assert_array_equal(knees(database, again), values_of(list(range(10, FRAMES))), err_msg=form)


def test_questions_find_frames_by_them(database: Database) -> None:
    uuid, _ = store(database, {"a.c3d": trial(), "walk.bvh": bvh(5)})
    edit(database, uuid, DeleteFrames(do="delete", first=1, last=10))
    queries = Queries(database, Settings())
    try:
        outcome = queries.answer(QueryRequest(q="//frame[mo:quantity('LKneeAngles', 'x') > 30]"))
        addresses = [item.address for item in outcome.items if isinstance(item, NodeItem)]
        expected = [f"/mcml/motion/frame[{place + 1}]" for place in np.flatnonzero(KNEE[10:] > 30).tolist()]
        assert addresses == expected
        assert any("1 of 2 documents left out" in warning and "'walk'" in warning for warning in outcome.warnings)
        none = queries.answer(QueryRequest(q="//frame[mo:quantity('LKneeAngels', 'x') > 30]"))
        assert not none.items
        assert any("2 of 2 documents left out" in warning for warning in none.warnings)
        with pytest.raises(QueryError, match="'up' is no axis of 'LKneeAngles'"):
            queries.answer(QueryRequest(q="//frame[mo:quantity('LKneeAngles', 'up') > 30]"))
    finally:
        queries.close()


def test_what_a_file_has_not_is_refused_with_what_it_has(database: Database) -> None:
    uuid, walk = store(database, {"a.c3d": trial(), "walk.bvh": bvh(5)})
    with pytest.raises(NotFoundError, match="'LKnee'") as refused:
        knees(database, uuid, "quantity:LKnee,x")
    assert "LKneeAngles" in str(refused.value.remedy)
    with pytest.raises(NotFoundError) as refused:
        knees(database, walk)
    assert "Only C3D files" in str(refused.value.remedy)


def test_angles_of_a_laboratory_are_those_that_ezc3d_reads(shared: Path) -> None:
    folder = shared / "lab"
    expected = json.loads((folder / "expected.json").read_text())
    compared = 0
    for name, facts in expected.items():
        if not isinstance(facts, dict) or "vendor_angles_deg_at_frame_index" not in facts:
            continue
        motion = mcml.read(folder / name)
        for label, frames in facts["vendor_angles_deg_at_frame_index"].items():
            for place, axis in enumerate("xyz"):
                values = motion.quantity(label, axis)
                for frame, angles in frames.items():
                    np.testing.assert_allclose(values[int(frame)], angles[place], atol=6e-5)
                    compared += 1
    assert compared
