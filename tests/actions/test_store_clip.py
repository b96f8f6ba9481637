"""A clip that was made here is stored as a document of the same file would be."""

from __future__ import annotations

import io
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mcml.errors import DocumentError, McmlError
from mcml.files.import_options import ImportOptions, Label
from mcml.formats import FORMATS
from mcml.formats.format import ReadOptions, SourceFile
from mcml.motion.clip import ClipStream
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.actions.importing.store_clip import store_stream
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import ASF as LEG
from tests.builders import HTR, TRC, amc, bvh, c3d_file, one_kind

CLIPS = {
    "one frame": ("bvh", {"bvh": bvh(1)}),
    "several chunks": ("bvh", {"bvh": bvh(700)}),
    "bones": ("asf-amc", {"asf": LEG, "amc": amc(9)}),
    "segments": ("htr", {"htr": HTR}),
    "missing samples": ("trc", {"trc": TRC}),
    "markers": ("c3d", {"c3d": c3d_file()}),
}


def read(name: str) -> ClipStream:
    kind, files = CLIPS[name]
    sources = {part: SourceFile(f"clip.{part}", io.BytesIO(content)) for part, content in files.items()}
    clip = FORMATS[kind].read(sources, ReadOptions())
    if name != "several chunks":
        return clip
    named = [
        replace(block, motion_names=[("walk",) if row % 3 else ("walk", "turn") for row in range(len(block))])
        for block in clip.blocks()
    ]
    return ClipStream(clip.head, lambda: iter(named), clip.frames)


def kept(database: Database, uuid: str) -> dict[str, Any]:
    """All that is stored of a document but what is new each time."""
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        receipt = tx.documents.receipt(stored.key)
        return {
            "facts": (stored.name, stored.format, stored.frames, stored.frame_time, stored.intact, stored.next_slot),
            "receipt": receipt.replace(uuid, ""),
            "labels": [(span.name, span.rank, span.first, span.last) for span in tx.spans.of(stored.key)],
            "made": b"".join(export_document(tx, stored, ExportOptions("mcml", original=False)).content),
            "file": b"".join(tx.uploads.read(stored.key, "mcml") or ()),
        }


@one_kind
@pytest.mark.parametrize("name", CLIPS)
def test_it_is_stored_as_its_file_is(database: Database, name: str) -> None:
    labels = (Label("hop", 1, 1),)
    about: dict[str, Any] = {"name": "made", "author": "kim", "labels": labels}
    made = store_stream(database, read(name), Settings(), project="a", provenance={"from": name}, **about)
    file = SourceFile("made.mcml", io.BytesIO(kept(database, made)["file"]))
    options = ImportOptions(project="b", name="made", labels=labels)
    done = import_files(database, [file], options, Settings(), author="kim")
    one, other = kept(database, made), kept(database, done.documents[0].uuid)
    other["receipt"] = other["receipt"].replace(f'"{made}"', "")
    assert one.keys() == other.keys()
    for key in one:
        assert one[key] == other[key], key
    assert database.check() == []


@one_kind
def test_it_is_stored_once_where_that_is_wanted(database: Database) -> None:
    def add(origin: str, *, once: bool) -> str:
        about: dict[str, Any] = {"name": "made", "project": "a", "author": "kim"}
        return store_stream(database, read("bones"), Settings(), provenance={"from": origin}, once=once, **about)

    first = add("x", once=True)
    assert add("x", once=True) == first
    assert len({first, add("y", once=True), add("x", once=False)}) == 3


@one_kind
def test_what_no_document_can_hold_is_refused_whole(database: Database) -> None:
    clip = read("one frame")
    (block,) = clip.blocks()
    beyond = replace(block, values=np.full_like(block.values, np.inf))
    wrong = {
        "numbers": ClipStream(clip.head, lambda: iter([beyond]), 1),
        "rate": ClipStream(replace(clip.head, frame_time="1e-12"), clip.blocks, 1),
        "property": ClipStream(replace(clip.head, properties=(("x" * 300, "1", ""),)), clip.blocks, 1),
    }
    for what, stream in wrong.items():
        with pytest.raises(McmlError):
            store_stream(database, stream, Settings(), name="made", project="a", author="kim", provenance={})
        with database.read() as tx:
            assert tx.documents.everything() == [], what
    about: dict[str, Any] = {"project": "a", "author": "kim", "provenance": {}, "labels": (Label("hop", 1, 9),)}
    with pytest.raises(DocumentError):
        store_stream(database, clip, Settings(), name="made", **about)
    with database.read() as tx:
        assert tx.documents.everything() == []
