"""C3D of edited documents has the forces and the EMG of its frames, from the uploaded file."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest

from mcml.formats.c3d.analog import Channels, read_channels
from mcml.formats.c3d.plates import plates_of
from mcml.laboratory.force_plates import plate_forces
from mcml_schemas.frames import DeleteFrames, FrameEdits, MirrorFrames, MoveFrames, ResampleFrames, ReverseFrames
from mcml_service.actions.editing.frame_ranges import edit_frames
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.storage.database import Database
from tests.actions.test_measurements import FIRST, FRAMES, SAMPLES, walkway
from tests.builders import bvh, store

pytestmark = pytest.mark.above_store

Edit = DeleteFrames | MirrorFrames | MoveFrames | ResampleFrames | ReverseFrames


def edit(database: Database, uuid: str, *edits: Edit) -> None:
    with database.write() as tx:
        edit_frames(tx, tx.documents.get(uuid), FrameEdits(edits=list(edits)))


def export(database: Database, uuid: str, **options: object) -> tuple[bytes, list[str]]:
    with database.read() as tx:
        done = export_document(tx, tx.documents.get(uuid), ExportOptions("c3d", **options))  # type: ignore[arg-type]
        return b"".join(done.content), [notice.what for notice in done.notices]


def channels_of(content: bytes) -> Channels:
    return read_channels(io.BytesIO(content))


def samples_of(content: bytes) -> np.ndarray:
    """(frames, samples, channels)."""
    channels = channels_of(content)
    return channels.read().reshape(channels.frames, channels.samples, len(channels))


def test_an_export_without_edits_is_the_uploaded_file(database: Database) -> None:
    (uuid,) = store(database, {"a.c3d": walkway()})
    assert export(database, uuid) == (walkway(), [])


def test_samples_stay_at_their_frames(database: Database) -> None:
    (uuid,) = store(database, {"a.c3d": walkway()})
    edit(database, uuid, DeleteFrames(do="delete", first=1, last=10))
    content, told = export(database, uuid)
    whole = samples_of(walkway())
    assert channels_of(content).first == FIRST + 10
    assert samples_of(content).tobytes() == whole[10:].tobytes()
    assert "7 analog channels and 1 force plate are written from the source file, without later edits" in told
    content, _ = export(database, uuid, first=3, last=7)
    assert samples_of(content).tobytes() == whole[12:17].tobytes()
    edit(
        database,
        uuid,
        ReverseFrames(do="reverse", first=1, last=5),
        MirrorFrames(do="mirror", first=7, last=9),
    )
    content, told = export(database, uuid)
    rows = [14, 13, 12, 11, 10, *range(15, FRAMES)]
    values = samples_of(content)
    assert np.isnan(values[6:9]).all()
    kept = [*range(6), *range(9, len(rows))]
    assert values[kept].tobytes() == whole[rows][kept].tobytes()
    assert "3 frames are not of the source file: their analog samples are missing (NaN)" in told


def test_forces_of_an_export_that_is_imported_again(database: Database) -> None:
    (uuid,) = store(database, {"a.c3d": walkway()})
    edit(database, uuid, DeleteFrames(do="delete", first=1, last=10))
    content, _ = export(database, uuid)
    (again,) = store(database, {"again.c3d": content})
    edit(database, again, DeleteFrames(do="delete", first=1, last=5))
    twice, _ = export(database, again)
    for file, first in ((content, 10), (twice, 15)):
        channels, original = channels_of(file), channels_of(walkway())
        (plate,), (own,) = plates_of(channels), plates_of(original)
        expected = plate_forces(own, original.read(channels=own.channels))
        forces = plate_forces(plate, channels.read(channels=plate.channels))
        assert forces.force.tobytes() == expected.force[first * SAMPLES :].tobytes()
        assert forces.centre_of_pressure.tobytes() == expected.centre_of_pressure[first * SAMPLES :].tobytes()


@pytest.mark.parametrize(
    ("options", "plates", "corner"),
    [
        ({"unit": "m"}, 1, [0.3, 0.2, 0.0]),
        ({"scale": 2.0}, 0, None),
        ({"fps": 50.0}, 0, None),
    ],
)
def test_plates_of_another_unit_size_and_rate(
    database: Database, options: dict[str, object], plates: int, corner: list[float] | None
) -> None:
    (uuid,) = store(database, {"a.c3d": walkway()})
    content, told = export(database, uuid, **options)
    channels = channels_of(content)
    assert len(channels) == (0 if "fps" in options else 7)
    assert len(plates_of(channels)) == plates
    assert any("left out" in words for words in told) == (not plates)
    if corner is not None:
        corners = channels.said.numbers("FORCE_PLATFORM:CORNERS")
        assert corners[:3] == np.float32(corner).tolist()
        np.testing.assert_allclose(plates_of(channels)[0].corners[0], [0.3, 0.2, 0.0], rtol=1e-6)


def test_documents_at_another_rate_and_without_a_file(database: Database) -> None:
    (uuid,) = store(database, {"a.c3d": walkway()})
    edit(database, uuid, ResampleFrames(do="resample", rate=50))
    content, told = export(database, uuid)
    assert not len(channels_of(content))
    assert any("it has 100 frames a second, the clip 50" in words for words in told)
    (body,) = store(database, {"walk.bvh": bvh(5)})
    assert not len(channels_of(export(database, body)[0]))
    with database.write() as tx:
        tx.uploads.forget(tx.documents.get(uuid).key)
    content, told = export(database, uuid)
    assert not len(channels_of(content))
    assert "the uploaded file is not kept: any analog channels and force plates are left out" in told


def test_real_trials_after_a_trim(database: Database, shared: Path) -> None:
    for name in ("s4_am_gait04.c3d", "bmc_gait.c3d"):
        data = (shared / "lab" / name).read_bytes()
        (uuid,) = store(database, {name: data})
        edit(database, uuid, DeleteFrames(do="delete", first=1, last=40), DeleteFrames(do="delete", first=60, last=70))
        content, _ = export(database, uuid)
        whole = samples_of(data)
        rows = np.delete(np.arange(len(whole)), [*range(40), *range(99, 110)])
        assert samples_of(content).tobytes() == whole[rows].tobytes()
        assert len(plates_of(channels_of(content))) == len(plates_of(channels_of(data)))
