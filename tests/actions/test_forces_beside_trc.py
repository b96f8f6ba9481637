"""A trial of markers with its table of forces: questions, edits and exports read it, and its files come back."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

import mcml
from mcml.motion.bodies.quantities import asked_quantity
from mcml.motion.skeleton import Array
from mcml_schemas.frames import DeleteFrames, FrameEdits, InsertFrames
from mcml_schemas.querying.queries import NodeItem, QueryRequest
from mcml_service.actions.editing.frame_ranges import edit_frames
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.keeping.check_uploads import compare_all
from mcml_service.actions.reading.read_quantities import quantity_columns
from mcml_service.clips.bodies import read_bodies
from mcml_service.clips.frame_quantities import FrameQuantities
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.queries import Queries
from tests.builders import bvh, store
from tests.force_trials import Trial, make_trial

pytestmark = pytest.mark.above_store


@pytest.fixture
def trial() -> Trial:
    return make_trial(1, first=20, start=0.19)


@pytest.fixture
def files(trial: Trial, tmp_path: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in trial.write(tmp_path)}


def column(database: Database, uuid: str, quantity: str) -> Array:
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        body = read_bodies(tx, tx.columns.documents([stored.key]))[stored.key]
        return quantity_columns(FrameQuantities(tx, stored, body), [asked_quantity(quantity)], 1, stored.frames)[:, 0]


def export(database: Database, uuid: str, form: str) -> bytes:
    with database.read() as tx:
        return b"".join(export_document(tx, tx.documents.get(uuid), ExportOptions(form)).content)


def edit(database: Database, uuid: str, *edits: DeleteFrames | InsertFrames) -> None:
    with database.write() as tx:
        edit_frames(tx, tx.documents.get(uuid), FrameEdits(edits=list(edits)))


def members(content: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_questions_and_arrays_read_the_table(database: Database, files: dict[str, bytes], trial: Trial) -> None:
    uuid, _ = store(database, files | {"walk.bvh": bvh(5)})
    upward = trial.means(trial.force)[:, 0, 1]
    np.testing.assert_allclose(column(database, uuid, "force:1,y"), upward, rtol=1e-12)
    limit = float(np.median(upward))
    queries = Queries(database, Settings())
    try:
        outcome = queries.answer(QueryRequest(q=f"//frame[mo:force('1', 'y') > {limit!r}]"))
    finally:
        queries.close()
    found = [item.address for item in outcome.items if isinstance(item, NodeItem)]
    assert found == [f"/mcml/motion/frame[{place + 1}]" for place in np.flatnonzero(upward > limit).tolist()]


def test_forces_stay_at_their_frames(database: Database, files: dict[str, bytes], trial: Trial) -> None:
    (uuid,) = store(database, files)
    edit(database, uuid, DeleteFrames(do="delete", first=2, last=4))
    edit(database, uuid, InsertFrames(do="insert", at=2, first=1, last=1))
    upward = trial.means(trial.force)[:, 1, 1]
    expected = [upward[0], np.nan, *upward[4:]]
    np.testing.assert_allclose(column(database, uuid, "force:2,y"), expected, rtol=1e-12)


def test_the_files_come_back_byte_for_byte(database: Database, files: dict[str, bytes]) -> None:
    (uuid,) = store(database, files)
    assert members(export(database, uuid, "original")) == files
    assert export(database, uuid, "trc") == files["walk.trc"]
    with database.read() as tx:
        assert [compared.faults for compared in compare_all(tx, Settings())] == [()]


def test_exports_are_read_again_with_the_same_forces(database: Database, files: dict[str, bytes], trial: Trial) -> None:
    (uuid,) = store(database, files)
    again = store(database, members(export(database, uuid, "opensim")))
    again += store(database, {"walk.c3d": export(database, uuid, "c3d")})
    for other in again:
        for quantity in ("force:1,x", "force:2,y", "cop:1,z", "free-moment:2"):
            values = column(database, uuid, quantity)
            np.testing.assert_allclose(np.abs(column(database, other, quantity)), np.abs(values), rtol=1e-4, atol=1e-5)


def test_a_trial_without_a_table_has_no_trial_for_opensim(database: Database, files: dict[str, bytes]) -> None:
    (uuid,) = store(database, {"walk.trc": files["walk.trc"]})
    with pytest.raises(mcml.Error, match="this document has none"):
        export(database, uuid, "opensim")
