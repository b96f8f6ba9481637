"""Measurements of a C3D file stay at their frames, whatever is done to the frames, and questions read them."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random

import numpy as np
import pytest

import mcml
from mcml.errors import DocumentError, NotFoundError, QueryError
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
from mcml_service.clips.frame_quantities import FrameQuantities, read_measurements
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.queries import Queries
from tests.builders import bvh, store
from tests.c3d_writer import Value, c3d_bytes

pytestmark = pytest.mark.above_store

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
        return quantity_columns(FrameQuantities(tx, stored, body), [asked_quantity(quantity)], 1, stored.frames)[:, 0]


def values_of(frames: list[int | None]) -> Array:
    """The values of frames, each given by its place in the file; None for frames that are not of the file."""
    return np.array([np.nan if frame in (None, GAP) else KNEE[frame] for frame in frames])


SAMPLES = 4
"""Analog samples of a frame."""


def walkway(seed: int = 0) -> bytes:
    """A trial on a plate of 600 x 400 mm around the origin, with z down, and a channel beside it."""
    chance = np.random.default_rng(seed)
    analog = np.zeros((FRAMES, SAMPLES, 7), np.float32)
    analog[..., :3] = chance.normal([0, 0, -700], 5, (FRAMES, SAMPLES, 3))
    analog[..., 3:6] = chance.normal(0, 9000, (FRAMES, SAMPLES, 3))
    analog[..., 6] = np.arange(FRAMES)[:, None] + np.arange(SAMPLES)
    labels = [f"{name:3}" for name in ("Fx", "Fy", "Fz", "Mx", "My", "Mz", "EMG")]
    corners = np.array([[300, 200, 0], [300, -200, 0], [-300, -200, 0], [-300, 200, 0]], np.float64)
    parameters: dict[str, Value | None] = {
        **TYPED,
        "ANALOG:USED": (2, (), [7]),
        "ANALOG:RATE": (4, (), [100.0 * SAMPLES]),
        "ANALOG:LABELS": (-1, (3, 7), "".join(labels).encode()),
        "ANALOG:UNITS": (-1, (3, 7), b"N  N  N  NmmNmmNmmV  "),
        "FORCE_PLATFORM:USED": (2, (), [1]),
        "FORCE_PLATFORM:TYPE": (2, (1,), [2]),
        "FORCE_PLATFORM:CORNERS": (4, (3, 4, 1), corners.reshape(-1).tolist()),
        "FORCE_PLATFORM:ORIGIN": (4, (3, 1), [0, 0, 0]),
        "FORCE_PLATFORM:CHANNEL": (2, (6, 1), [1, 2, 3, 4, 5, 6]),
    }
    points = chance.normal(500, 100, (FRAMES, len(LABELS), 3)).astype(np.float32)
    return c3d_bytes(
        points, labels=LABELS, parameters=parameters, first=FIRST, analog=analog.reshape(FRAMES, -1), samples=SAMPLES
    )


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
        (knee,) = read_measurements(tx, tx.documents.get(uuid)).describe()
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


def means_of(content: bytes) -> Array:
    """(frames, channels) means of the analog samples of `walkway`, by the places where it writes them."""
    words = np.frombuffer(content, np.uint8)
    start = 512 * (int.from_bytes(content[16:18], "little") - 1)
    row = len(LABELS) * 4 + SAMPLES * 7
    values = words[start : start + FRAMES * row * 4].view("<f4").astype(np.float64).reshape(FRAMES, row)
    return values[:, len(LABELS) * 4 :].reshape(FRAMES, SAMPLES, 7).mean(axis=1)


def test_channels_and_plates_are_means_of_their_frames(database: Database, tmp_path: Path) -> None:
    """Against the formulas of a plate of type 2, whose x points along Y of the laboratory, y along X, and z down."""
    content = walkway()
    (uuid,) = store(database, {"a.c3d": content})
    edit(database, uuid, DeleteFrames(do="delete", first=6, last=10))
    left = [*range(5), *range(10, FRAMES)]
    x, y, z, about_x, about_y, about_z, emg = means_of(content)[left].T
    right, ahead = -about_y / z / 1000, about_x / z / 1000
    expected = {
        "analog:EMG": emg,
        "analog:Fz": z,
        "force:1,x": y,
        "force:1,y": x,
        "force:1,z": -z,
        "cop:1,x": ahead,
        "cop:1,y": right,
        "cop:1,z": 0 * z,
        "free-moment:1": -(about_z / 1000 - right * y + ahead * x),
    }
    for quantity, values in expected.items():
        np.testing.assert_allclose(knees(database, uuid, quantity), values, rtol=1e-9, atol=1e-12, err_msg=quantity)
    (tmp_path / "a.c3d").write_bytes(content)
    motion = mcml.read(tmp_path / "a.c3d")
    np.testing.assert_array_equal(motion.force("1", "z")[left], knees(database, uuid, "force:1,z"))
    np.testing.assert_array_equal(motion.cop("1", "x")[left], knees(database, uuid, "cop:1,x"))
    np.testing.assert_array_equal(motion.free_moment("1")[left], knees(database, uuid, "free-moment:1"))
    np.testing.assert_array_equal(motion.analog("EMG")[left], knees(database, uuid, "analog:EMG"))


def test_forces_on_feet_need_feet(database: Database) -> None:
    (uuid,) = store(database, {"a.c3d": walkway()})
    with pytest.raises(DocumentError, match="Unknown: toes"):
        knees(database, uuid, "force:left,z")
    queries = Queries(database, Settings())
    try:
        outcome = queries.answer(QueryRequest(q="//frame[mo:force('left', 'z') > 5]"))
        assert not outcome.items
        assert any("1 of 1 documents left out" in warning for warning in outcome.warnings)
    finally:
        queries.close()


def test_measurements_say_their_units_and_rates(database: Database) -> None:
    (uuid,) = store(database, {"a.c3d": walkway()})
    with database.read() as tx:
        items = read_measurements(tx, tx.documents.get(uuid)).describe()
    facts = {(item.function, item.name): (item.unit, item.axes, item.rate, item.known) for item in items}
    assert facts["quantity", "LKneeAngles"] == ("deg", ("x", "y", "z"), None, True)
    assert facts["analog", "Mx"] == ("Nmm", (), 400.0, True)
    assert facts["force", "1"] == ("N", ("x", "y", "z"), 400.0, True)
    assert facts["free-moment", "1"] == ("N m", (), 400.0, True)
    assert facts["cop", "left"] == ("m", ("x", "y", "z"), 400.0, True)


def test_questions_find_frames_by_forces(database: Database) -> None:
    content = walkway()
    uuid, _ = store(database, {"a.c3d": content, "walk.bvh": bvh(5)})
    queries = Queries(database, Settings())
    try:
        outcome = queries.answer(QueryRequest(q="//frame[mo:force(1, 'z') > 701]"))
        expected = np.flatnonzero(-means_of(content)[:, 2] > 701) + 1
        assert len(expected)
        addresses = [item.address for item in outcome.items if isinstance(item, NodeItem)]
        assert addresses == [f"/mcml/motion/frame[{place}]" for place in expected.tolist()]
        assert {item.document for item in outcome.items if isinstance(item, NodeItem)} == {uuid}
    finally:
        queries.close()


def test_plates_without_the_kept_file_are_refused(database: Database) -> None:
    (uuid,) = store(database, {"a.c3d": walkway()})
    with database.read() as tx:
        content = b"".join(export_document(tx, tx.documents.get(uuid), ExportOptions("mcml")).content)
    (again,) = store(database, {"again.mcml": content})
    with pytest.raises(NotFoundError, match="no force plate '1'") as refused:
        knees(database, again, "force:1,z")
    assert "whose uploads are kept" in str(refused.value.remedy)


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
