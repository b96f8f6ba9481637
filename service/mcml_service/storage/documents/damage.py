"""Describe damaged rows: document, bone, frames."""

from __future__ import annotations

from typing import Any

from sqlalchemy import Table, select

from mcml.errors import DamageError
from mcml_service.storage.core import tables
from mcml_service.storage.core.schema import CHUNK
from mcml_service.storage.core.seals import REMEDY, SEALS, damage
from mcml_service.storage.core.transaction import BaseTransaction

_WHAT = {
    "content": "its frames, skeleton or frame time",
    "header": "its header",
    "property": "a property",
    "bone": "the name of a bone",
    "timeline": "the order of its frames",
    "frame_run": "the ids of its frames",
    "shape": "which bones its frames have",
    "shape_run": "which bones its frames have",
    "span": "a motion name",
    "revision": "a revision",
    "document": "its name, project or state",
    "document_upload": "which file it came from",
}


def describe_damage(tx: BaseTransaction, table: Table, row: tuple[Any, ...]) -> DamageError:
    """Return the error for a row with a wrong checksum. row: the columns that its seal reads."""
    values = dict(zip((column.name for column in SEALS[table].read), row, strict=True))
    part = _WHAT.get(table.name, f"a row of {table.name!r}")
    if table is tables.span:
        part += f", of frames {values['first']} to {values['last']}"
    if table is tables.document:
        return damage(f"The document {values['name']!r} ({values['uuid']})", part)
    if table is tables.upload_block:
        return damage(f"The kept file {files_of(tx, values['upload'])}", f"block {values['number']}")
    if "document" in values and table.name in _WHAT:
        return damage(name_document(tx, values["document"]), part)
    return DamageError(f"The store is damaged: {part}.", remedy=REMEDY)


def describe_track_damage(tx: BaseTransaction, document: int, chunk: int, bone: int) -> DamageError:
    """The error for a track, or its zone map, that has not its checksum."""
    return damage(
        name_document(tx, document), f"{bone_named(tx, document, bone)}, frames {frames_of(tx, document, chunk)}"
    )


def name_document(tx: BaseTransaction, key: int) -> str:
    """A document as users know it."""
    query = select(tables.document.c.name, tables.document.c.uuid).where(tables.document.c.id == key)
    row = tx.fetch_one(query)
    return "A document that is not there" if row is None else f"The document {row.name!r} ({row.uuid})"


def files_of(tx: BaseTransaction, upload: int) -> str:
    """The names under which a file was uploaded."""
    query = select(tables.document_upload.c.file_name).where(tables.document_upload.c.upload == upload).distinct()
    return " or ".join(map(repr, sorted(tx.fetch_column(query)))) or "of no document"


def bone_named(tx: BaseTransaction, document: int, number: int) -> str:
    query = select(tables.bone.c.name).where(tables.bone.c.document == document, tables.bone.c.bone == number)
    name = tx.fetch_value(query.limit(1))
    return f"bone {number}" if name is None else f"bone {name!r}"


def frames_of(tx: BaseTransaction, document: int, chunk: int) -> str:
    """Return the positions of the frames with samples in a chunk."""
    first, end = chunk * CHUNK, (chunk + 1) * CHUNK
    query = select(tables.timeline.c.first, tables.timeline.c.slot, tables.timeline.c.count)
    pieces = tx.fetch_all(query.where(tables.timeline.c.document == document, tx.valid(tables.timeline)))
    ranges = []
    for start, slot, count in sorted(pieces):
        low, high = max(first, slot), min(end, slot + count)
        if low < high:
            ranges.append(f"{start + low - slot} to {start + high - 1 - slot}")
    return " and ".join(ranges) or f"of the past (chunk {chunk})"
