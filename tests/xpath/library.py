"""A store with documents of every format, labelled, edited and real ones, and libxml2's trees of what it exports."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

from lxml import etree

from mcml.errors import McmlError
from mcml_service.actions.editing.frame_ranges import delete_frames, move_frames, reverse
from mcml_service.actions.editing.single_element import Change
from mcml_service.actions.editing.whole_document import add_labels
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.lists.filtering import DocumentFilter
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.queries import Queries
from tests.builders import ASF, HTR, MCML, amc, bvh, mcml_of, store
from tests.edits import change_element, delete_element

FILES: list[dict[str, bytes]] = [
    {"e_chain.bvh": bvh(12)},
    {"b_hand.mcml": MCML},
    {"c_leg.asf": ASF, "c_leg.amc": amc(4)},
    {"d_two.htr": HTR},
    {"a_empty.bvh": bvh(0)},
    {"g_ids.mcml": mcml_of([5, 5, 5, 9, 9, 8, 7, 7, 2, 2, 2, 2, -1, -1, 30, 60, 90, 91, 91])},
    {"h_ids.mcml": mcml_of([4, 4, "4", "04", "x", 4, 900719925474099301, 900719925474099302, 0, 0, -3])},
    {"i_ids.mcml": mcml_of([6] * 5)},
]
EDITS: list[tuple[str, Change | None]] = [
    ("/mcml/motion/frame[2]", None),
    ("/mcml/motion/frame[1]/frame_bone[2]", None),
    ("/mcml/motion/frame[2]/frame_bone[1]/@Rx", None),
    ("/mcml/motion/frame[1]/frame_bone[1]", Change({"Tz": "7", "SF": "2"})),
    ("/mcml/motion/frame[1]", Change({"id": "x1"})),
    ("/mcml/motion/frame[last()]", Change({"id": "-3.5 or so"})),
    ("/mcml/motion/frame[3]", Change({"id": "0x1"})),
    ("/mcml/skeleton/bone/name", Change({}, "renamed")),
]
LONG = {"f_long.bvh": bvh(700, seed=5, names=("Hips", "Spine"))}
"""Longer than two chunks of the store."""
REAL = ("bvh/*/ya_throw1.bvh", "bvh/*/classic_example1.bvh", "bvh/*/sinusoidal.bvh", "htr/maya_tail_export.htr")
REAL_LEGS = ("asfamc/cmu_misc/07-walk.asf", "asfamc/cmu_misc/07_05-walk.amc")
NAMES = ("walk", "bar-1", "left-arm-abduction", "left-leg-flexion", "nothing")


@dataclass(frozen=True)
class Library:
    """trees: of every document by its uuid, in order of the answer."""

    engine: Queries
    trees: dict[str, Any]


@contextmanager
def library(database: Database, shared: Path | None, *, long: bool = True) -> Iterator[Library]:
    """shared: the folder of real capture files, if it is there."""
    random = Random(1)
    for edited in (False, True):
        for files in [*FILES, *real_files(shared), *([LONG] if long else [])]:
            _add(database, files, random, edited=edited)
    # The campaign is about answers: a limit of time would only tell how busy the machine is.
    engine = Queries(database, Settings(query_seconds=600))
    try:
        yield Library(engine, dict(exported(database)))
    finally:
        engine.close()


def real_files(shared: Path | None) -> list[dict[str, bytes]]:
    """A few real clips, the first frames of long ones."""
    if shared is None:
        return []
    paths = [path for pattern in REAL for path in sorted(shared.glob(pattern))[:1]]
    found = [{path.name: path.read_bytes()} for path in paths]
    asf, amc_path = (shared / name for name in REAL_LEGS)
    if asf.exists() and amc_path.exists():
        lines = amc_path.read_bytes().splitlines(keepends=True)
        stop = next(number for number, line in enumerate(lines) if line.strip() == b"31")
        found.append({asf.name: asf.read_bytes(), amc_path.name: b"".join(lines[:stop])})
    return found


def _add(database: Database, files: dict[str, bytes], random: Random, *, edited: bool) -> None:
    uuid = store(database, files, labels=())[0]
    with database.write() as tx:
        stored = tx.documents.get(uuid)
        ends = [
            sorted((random.randint(1, stored.frames), random.randint(1, stored.frames))) for _ in "abc" if stored.frames
        ]
        add_labels(tx, stored, [(random.choice(NAMES[:3]), first, last) for first, last in ends])
    for where, change in EDITS if edited else ():
        with database.read() as tx:
            frames = tx.documents.get(uuid).frames
        where = where.replace("last()", str(frames))
        try:
            with database.write() as tx:
                stored = tx.documents.get(uuid)
                change_element(tx, stored, where, change) if change else delete_element(tx, stored, where)
        except McmlError:  # not every document has what is edited
            continue
    for _ in range(4 if edited else 0):
        with suppress(McmlError), database.write() as tx:
            _move_frames(tx, tx.documents.get(uuid), random)


def _move_frames(tx: Transaction, stored: StoredDocument, random: Random) -> None:
    """Some frames deleted, moved or reversed."""
    first, last = sorted(random.randint(1, max(1, stored.frames)) for _ in "ab")
    match random.choice(["delete", "move", "reverse"]):
        case "delete":
            delete_frames(tx, stored, first, min(last, first + 1), renumber=False)
        case "move":
            move_frames(tx, stored, first, last, random.randint(1, stored.frames + 1), renumber=False)
        case "reverse":
            reverse(tx, stored, first, last)


def exported(database: Database) -> Iterator[tuple[str, Any]]:
    """(uuid, tree) of every document, in order of the answer."""
    parser = etree.XMLParser(remove_blank_text=True)
    with database.read() as tx:
        for stored in tx.documents.page(DocumentFilter(), after=None, limit=1000):
            content = b"".join(export_document(tx, stored, ExportOptions("mcml")).content)
            yield stored.uuid, etree.parse(io.BytesIO(content), parser)
