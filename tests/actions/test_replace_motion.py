"""A new file for a stored document: frames that differ are replaced, labels stay, other skeletons are refused."""

from __future__ import annotations

import re

import numpy as np
import pytest

from mcml.errors import ConflictError, FormatError
from mcml.files.import_options import ImportOptions
from mcml_schemas.revisions import FileReplaced
from mcml_service.actions.editing.whole_document import add_labels, undo_revision
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.importing.replace_motion import read_motion, replace_motion
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import bvh, one_kind, source, store
from tests.formats.readers.fbx_text import fbx_text


def replace_by(database: Database, uuid: str, content: bytes, name: str = "b.bvh", **options: object) -> FileReplaced:
    dry_run = bool(options.pop("dry_run", False))
    new = read_motion(database, uuid, [source(name, content)], ImportOptions(**options), Settings().file_limits)  # type: ignore[arg-type]
    with database.write("ann") as tx:
        return replace_motion(tx, tx.documents.get(uuid), new, dry_run=dry_run)


def export(database: Database, uuid: str) -> bytes:
    with database.read() as tx:
        return b"".join(export_document(tx, tx.documents.get(uuid), ExportOptions("bvh")).content)


def labels(database: Database, uuid: str) -> list[tuple[str, int, int]]:
    with database.read() as tx:
        return [(span.name, span.first, span.last) for span in tx.spans.of(tx.documents.get(uuid).key)]


def changed(content: bytes, rows: dict[int, str]) -> bytes:
    """A BVH with other numbers in some frames, from 1; "" removes the frame."""
    head, motion = content.split(b"0.0083333\n")
    lines = motion.decode().splitlines()
    for row, text in rows.items():
        lines[row - 1] = text
    lines = [line for line in lines if line]
    head = re.sub(rb"Frames: \d+", b"Frames: %d" % len(lines), head)
    return head + b"0.0083333\n" + "".join(f"{line}\n" for line in lines).encode()


BEFORE = bvh(30)
ROW = " ".join(["7.5000"] * 12)


def test_frames_that_differ_are_replaced_and_labels_stay(database: Database) -> None:
    uuid = store(database, {"a.bvh": BEFORE})[0]
    with database.write("ann") as tx:
        add_labels(tx, tx.documents.get(uuid), [("left-knee-flexion", 8, 20), ("jump", 25, 30)])
    after = changed(BEFORE, {10: ROW, 12: ROW})
    looked = replace_by(database, uuid, after, dry_run=True)
    assert (looked.first, looked.last, looked.revision) == (10, 12, 2)
    made = replace_by(database, uuid, after)
    assert (made.first, made.last, made.frames, made.revision) == (10, 12, 30, 3)
    assert len(made.joints) == 3
    assert made.largest is not None
    assert made.largest.frame in (10, 12)
    assert made.largest.after == 7.5
    assert export(database, uuid) == after
    assert labels(database, uuid) == [("left-knee-flexion", 8, 20), ("jump", 25, 30)]
    with database.write("ann") as tx:
        undo_revision(tx, tx.documents.get(uuid), 3)
    assert export(database, uuid) == BEFORE


@pytest.mark.parametrize("seed", range(6))
@one_kind
def test_more_or_fewer_frames(database: Database, seed: int) -> None:
    chance = np.random.default_rng(seed)
    uuid = store(database, {"a.bvh": BEFORE})[0]
    rows = {int(row): str(chance.choice(["", ROW, f"{ROW}\n{ROW}"])) for row in chance.choice(30, 4, replace=False) + 1}
    after = changed(BEFORE, rows)
    after = re.sub(rb"Frames: \d+", b"Frames: %d" % after.split(b"0.0083333\n")[1].count(b"\n"), after)
    made = replace_by(database, uuid, after)
    assert export(database, uuid) == after
    assert made.frames == after.split(b"0.0083333\n")[1].count(b"\n")


@one_kind
def test_an_equal_file_changes_nothing(database: Database) -> None:
    uuid = store(database, {"a.bvh": BEFORE})[0]
    made = replace_by(database, uuid, BEFORE)
    assert (made.first, made.joints, made.largest, made.revision) == (None, [], None, 1)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (bvh(30, names=("Root", "Spine")), "2 joints, the document 3"),
        (BEFORE.replace(b"JOINT Head", b"JOINT Skull"), "another name"),
        (BEFORE.replace(b"10.5 0.00", b"11.5 0.00", 1), "another offset"),
        (BEFORE.replace(b"Zrotation Xrotation", b"Xrotation Zrotation", 1), "another list of channels"),
        (BEFORE.replace(b"0.0083333", b"0.0333333"), "30 frames a second, the document 120"),
    ],
)
@one_kind
def test_another_skeleton_or_rate_is_refused(database: Database, content: bytes, message: str) -> None:
    uuid = store(database, {"a.bvh": BEFORE})[0]
    with pytest.raises(ConflictError, match=message):
        replace_by(database, uuid, content)
    assert export(database, uuid) == BEFORE


@one_kind
def test_several_takes_need_a_choice(database: Database) -> None:
    uuid = store(database, {"a.fbx": fbx_text(("Walk", "Run"))}, take="Walk")[0]
    with pytest.raises(FormatError, match="hold 2 motions"):
        replace_by(database, uuid, fbx_text(("Walk", "Run")), "a.fbx")
    assert replace_by(database, uuid, fbx_text(("Walk", "Run")), "a.fbx", take="Run").first == 2
