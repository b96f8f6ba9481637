"""What `mcml db check` looks for: that the rows of every document fit together and every block can be read."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

import zstandard
from sqlalchemy import func, select

from service.errors import McmlError
from service.storage.moments import imported
from service.storage.tables import CURRENT, content, document, document_upload, timeline, upload, upload_block

if TYPE_CHECKING:
    from service.storage.database import Transaction


def faults(tx: Transaction) -> list[str]:
    """One sentence a fault. Reads every current track and every kept upload once."""
    found: list[str] = []
    query = select(document.c.id, document.c.uuid, document.c.name).where(imported(tx.at))
    for key, uuid, name in tx.connection.execute(query).all():
        try:
            found += [f"{name} ({uuid}): {fault}" for fault in _document_faults(tx, key)]
        except McmlError as error:
            found.append(f"{name} ({uuid}): {error}")
    for key, sha256, size in tx.connection.execute(
        select(upload.c.id, upload.c.sha256, upload.c.size).where(upload.c.complete)
    ).all():
        fault = _upload_fault(tx, key, sha256, size)
        if fault:
            names = tx.connection.execute(
                select(document_upload.c.file_name).where(document_upload.c.upload == key)
            ).scalars()
            found.append(f"upload {key} ({', '.join(sorted(set(names))) or 'no document'}): {fault}")
    return found


def _document_faults(tx: Transaction, key: int) -> list[str]:
    found = []
    rows = tx.connection.execute(
        select(content.c.frames).where(content.c.document == key, content.c.to_commit == CURRENT)
    ).all()
    if len(rows) != 1:
        return [f"{len(rows)} current contents where one belongs"]
    frames = int(rows[0].frames)
    covered = tx.connection.execute(
        select(func.coalesce(func.sum(timeline.c.count), 0)).where(
            timeline.c.document == key, timeline.c.to_commit == CURRENT
        )
    ).scalar_one()
    if covered != frames:
        found.append(f"the timeline has {covered} frames of {frames}")
    read = 0
    for block in tx.tracks.blocks(key, 1, frames):
        read += len(block)
        if len(block.ids) != len(block):
            found.append("some frames have no id")
    if read != frames:
        found.append(f"{read} of {frames} frames can be read")
    for span in tx.spans.of(key):
        if not 1 <= span.first <= span.last <= frames:
            found.append(f"the name {span.name!r} lies on frames {span.first} to {span.last} of {frames}")
    return found


def _upload_fault(tx: Transaction, key: int, sha256: str, size: int) -> str | None:
    hashed, length = hashlib.sha256(), 0
    decompressor = zstandard.ZstdDecompressor()
    rows = tx.connection.execute(
        select(upload_block.c.number, upload_block.c.data)
        .where(upload_block.c.upload == key)
        .order_by(upload_block.c.number)
        .execution_options(yield_per=16)
    )
    for expected, (number, data) in enumerate(rows):
        if number != expected:
            return f"block {expected} is missing"
        try:
            block = decompressor.decompress(data)
        except zstandard.ZstdError as error:
            return f"block {number}: {error}"
        hashed.update(block)
        length += len(block)
    if length != size or hashed.hexdigest() != sha256:
        return "the kept bytes are not those that were uploaded"
    return None
