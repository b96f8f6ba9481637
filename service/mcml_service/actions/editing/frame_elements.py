"""Single frames and their frame_bone elements. An edit of one value rewrites one track row, nothing else."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from mcml.errors import DocumentError, NotFoundError, Place
from mcml.language.addresses import address_attribute, address_child
from mcml.language.lexical import ILLEGAL
from mcml.language.vocabulary import FRAME_BONE
from mcml.motion.clip import Shape
from mcml.motion.skeleton import CHANNELS
from mcml_service.storage.core.schema import CHUNK
from mcml_service.storage.core.tables import shape_run
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction


def rewrite_frame_bone(
    tx: Transaction, stored: StoredDocument, position: int, number: int, changes: Mapping[int, float | None] | None
) -> None:
    """Set or remove (None) channels of the number-th frame_bone of a frame; changes None deletes it whole."""
    address = address_child(position, FRAME_BONE, number)
    slot = tx.tracks.slot_of(stored.key, position)
    shape = tx.tracks.shape_at(stored.key, slot)
    if not 1 <= number <= len(shape):
        raise NotFoundError(f"Frame {position} has {len(shape)} frame_bone elements.", at=Place(element=address))
    bone, bits = shape[number - 1]
    wanted = {channel: None for channel in range(len(CHANNELS)) if bits >> channel & 1} if changes is None else changes
    new_bits = bits
    for channel, value in wanted.items():
        if value is None and not bits >> channel & 1:
            raise NotFoundError(
                "The frame_bone has no such attribute.", at=Place(element=address_attribute(address, CHANNELS[channel]))
            )
        new_bits = new_bits & ~(1 << channel) if value is None else new_bits | 1 << channel
    if wanted:
        _rewrite_track(tx, stored, slot, bone, wanted)
    if changes is None:
        new_shape: Shape = shape[: number - 1] + shape[number:]
    else:
        new_shape = (*shape[: number - 1], (bone, new_bits), *shape[number:])
    if new_shape != shape:
        _reshape(tx, stored, slot, new_shape)
    tx.documents.write_content(stored.key, tx.commit, intact=False)


def _rewrite_track(
    tx: Transaction, stored: StoredDocument, slot: int, bone: int, changes: Mapping[int, float | None]
) -> None:
    chunk, offset = divmod(slot, CHUNK)
    track = tx.tracks.chunk(stored.key, chunk, bone)
    length = tx.tracks.chunk_length(stored.key, chunk)
    channels, columns = track if track is not None else ([], np.empty((0, length)))
    for channel, value in changes.items():
        if channel not in channels:
            channels = [*channels, channel]
            columns = np.vstack([columns, np.full((1, columns.shape[1]), np.nan)])
        columns[channels.index(channel), offset] = math.nan if value is None else value
    tx.tracks.rewrite_chunk(stored.key, chunk, bone, channels, columns)


def _reshape(tx: Transaction, stored: StoredDocument, slot: int, shape: Shape) -> None:
    """Give one stored frame another shape: its run is split in up to three."""
    number = tx.tracks.shape_number(stored.key, shape)
    run = tx.tracks.close_run(shape_run, stored.key, shape_run.c.slot, slot)
    start, count = run["slot"], run["count"]
    rows = [
        {"slot": start, "count": slot - start, "shape": run["shape"]},
        {"slot": slot, "count": 1, "shape": number},
        {"slot": slot + 1, "count": start + count - slot - 1, "shape": run["shape"]},
    ]
    tx.tracks.write_shape_runs(stored.key, [row for row in rows if row["count"]], tx.commit)


def rename_frame(tx: Transaction, stored: StoredDocument, position: int, frame_id: str) -> None:
    """Give a frame another id."""
    if not 1 <= position <= stored.frames:
        raise NotFoundError(f"The document has {stored.frames} frames.")
    if not frame_id.strip() or len(frame_id) > 256:
        raise DocumentError("A frame id is a text of 1 to 256 characters.")
    if ILLEGAL.search(frame_id):
        raise DocumentError(f"The frame id {frame_id!r} holds a control character.", remedy="Leave it out.")
    before = tx.tracks.frame_ids(stored.key, 1, position - 1)
    after = tx.tracks.frame_ids(stored.key, position + 1, stored.frames)
    tx.tracks.rewrite_frame_ids(stored.key, [before, [frame_id], after])
    tx.documents.write_content(stored.key, tx.commit, intact=False)
