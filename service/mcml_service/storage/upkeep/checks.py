"""The checks of `mcml db check`: rows are undamaged and consistent, and blocks can be read."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Collection, Iterable, Iterator
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
import zstandard
from sqlalchemy import Table, and_, func, select
from sqlalchemy.exc import SQLAlchemyError

from mcml.errors import DamageError, McmlError
from mcml.motion.clip import FrameBlock
from mcml_service.storage.core.schema import CURRENT
from mcml_service.storage.core.seals import SEALS, TRACK_FACTS, data_checksum, track_checksums, visible
from mcml_service.storage.core.tables import (
    content,
    document,
    document_upload,
    property_,
    revision,
    skeleton,
    skeleton_element,
    timeline,
    track,
    upload,
    upload_block,
)
from mcml_service.storage.documents.damage import describe_damage, describe_track_damage, files_of
from mcml_service.storage.documents.encoding import channels_of
from mcml_service.storage.documents.heads import properties_of
from mcml_service.storage.documents.rows import ELEMENT_COLUMNS, to_rows, to_skeleton
from mcml_service.storage.layout import require_layout

if TYPE_CHECKING:
    from mcml_service.storage.transaction import Transaction

ROWS = 1000
MOST_OF_A_KIND = 100
"""Limit of faults reported for one table."""
_NAMED = upload.c.id.in_(select(document_upload.c.upload))


def faults(tx: Transaction, *, past: bool = False) -> list[str]:
    """One sentence a fault. Reads every row and every kept upload once. past: fits the rows of all past revisions
    together too."""
    messages = _collect("The database", lambda: tx.dialect.faults(tx.connection))
    messages += _collect("The store", lambda: _layout_faults(tx))
    for table in SEALS:
        messages += _collect(f"The table {table.name}", lambda table=table: _find_row_faults(tx, table))  # type: ignore[misc]
    messages += _collect("The table track", lambda: _track_faults(tx))
    messages += _collect("The skeletons", lambda: _skeleton_faults(tx))
    for row in _rows(tx.documents.everything, messages):
        messages += _document_faults(tx, *row, past=past)
    files = select(upload.c.id, upload.c.sha256, upload.c.size).where(_NAMED)
    for key, sha256, size in _rows(lambda: tx.fetch_all(files), messages):
        messages += _collect("An upload", partial(_upload_faults, tx, key, sha256, size))
    return list(dict.fromkeys(messages))


def document_faults(tx: Transaction, keys: Collection[int]) -> list[str]:
    """One sentence for each fault of some documents, in all of their revisions."""
    wanted = set(keys)
    documents = [row for row in tx.documents.everything() if row[0] in wanted]
    return [fault for row in documents for fault in _document_faults(tx, *row, past=True)]


def _document_faults(tx: Transaction, key: int, uuid: str, name: str, *, past: bool) -> list[str]:
    whose = f"{name} ({uuid})"
    messages = _collect(whose, lambda: _head_faults(tx, key), whose)
    for then in _states(tx, key, past=past):
        messages += _collect(whose, lambda then=then: _motion_faults(then, key), whose)  # type: ignore[misc]
    return messages


def _collect(where: str, look: Callable[[], Iterator[str]], whose: str = "") -> list[str]:
    """Collect the faults that a check finds; unreadable data is a fault too."""
    messages: list[str] = []
    prefix = f"{whose}: " if whose else ""
    try:
        for fault in look():
            messages.append(prefix + fault)
            if len(messages) == MOST_OF_A_KIND:
                return [*messages, f"{where}: and more"]
    except DamageError as error:
        messages.append(error.what)
    except McmlError as error:
        messages.append(f"{prefix}{error.what}")
    # Damaged rows can cause any error; the check continues.
    except Exception as error:
        messages.append(f"{where} cannot be read: {_describe_error(error)}")
    return messages


def _rows(read: Callable[[], Iterable[Any]], messages: list[str]) -> list[Any]:
    try:
        return list(read())
    except Exception as error:
        messages.append(f"The store cannot be read: {_describe_error(error)}")
        return []


def _describe_error(error: Exception) -> str:
    """Return the message of a database error; for other errors only the kind."""
    cause = getattr(error, "orig", error)
    return str(cause).splitlines()[0] if isinstance(error, SQLAlchemyError) and str(cause) else type(cause).__name__


def _states(tx: Transaction, key: int, *, past: bool) -> list[Transaction]:
    """The present one; or one for each revision."""
    if not past:
        return [tx]
    query = select(revision.c.commit).where(revision.c.document == key).distinct().order_by(revision.c.commit)
    return [tx.at_commit(number) for number in tx.fetch_column(query)]


def _layout_faults(tx: Transaction) -> Iterator[str]:
    require_layout(tx)
    yield from ()


# -- rows --------------------------------------------------------------------------------------------------------------


def _find_row_faults(tx: Transaction, table: Table) -> Iterator[str]:
    seal = SEALS[table]
    for row in chain.from_iterable(tx.stream(select(*seal.read), ROWS)):
        if not seal.holds(tuple(row)):
            yield describe_damage(tx, table, tuple(row)).what


def _track_faults(tx: Transaction) -> Iterator[str]:
    read = (*TRACK_FACTS, "from_commit", "to_commit", "checksum", "data")
    for block in tx.stream(select(*(track.c[name] for name in read)), ROWS):
        rows = [tuple(row) for row in block]
        for (key, chunk, bone, *_), sound in zip(rows, _sound_tracks(rows), strict=True):
            if not sound:
                yield describe_track_damage(tx, key, chunk, bone).what


def _sound_tracks(rows: list[tuple[Any, ...]]) -> list[bool]:
    """Whether each track has its two checksums."""
    try:
        integers = np.array([row[:8] for row in rows], np.int64).T
        ends = np.array([row[8 : len(TRACK_FACTS)] for row in rows], np.float64).T
        sums = track_checksums(np.ascontiguousarray(integers), ends).tolist()
        return [
            data_checksum(row[6], row[-1]) == row[7] and total + visible(row[-4], row[-3]) == row[-2]
            for row, total in zip(rows, sums, strict=True)
        ]
    except (TypeError, ValueError, OverflowError):
        # One of them has a value of another type.
        return [False] if len(rows) == 1 else [sound for row in rows for sound in _sound_tracks([row])]


def _skeleton_faults(tx: Transaction) -> Iterator[str]:
    for key, hashed in tx.fetch_all(select(skeleton.c.id, skeleton.c.hash)):
        columns = [skeleton_element.c[name] for name in ELEMENT_COLUMNS]
        query = select(*columns).where(skeleton_element.c.skeleton == key).order_by(skeleton_element.c.pre)
        rows = [tuple(row) for row in tx.fetch_all(query)]
        used = f"skeleton {key}, used by {', '.join(_users(tx, key)) or 'no document'}"
        try:
            if to_rows(to_skeleton([row[2:] for row in rows], hashed), level=1) != rows:
                yield f"{used}: its elements do not fit together"
        except (McmlError, TypeError, ValueError):
            yield f"{used}: its elements are not those that were written"


def _users(tx: Transaction, key: int) -> list[str]:
    query = select(document.c.name).join(content, content.c.document == document.c.id)
    return sorted(set(tx.fetch_column(query.where(content.c.skeleton == key).limit(5))))


# -- documents ---------------------------------------------------------------------------------------------------------


def _head_faults(tx: Transaction, key: int) -> Iterator[str]:
    tx.documents.receipt(key)
    query = select(*(property_.c[name] for name in ("name", "number", "text", "unit")))
    held = {tuple(row) for row in tx.fetch_all(query.where(property_.c.document == key))}
    rows = properties_of(key, tx.heads.header(key))
    if held != {(row["name"], row["number"], row["text"], row["unit"]) for row in rows}:
        yield "its properties are not those of its header"
    joined = and_(upload.c.id == document_upload.c.upload, document_upload.c.document == key)
    if tx.fetch_one(select(upload.c.id).join(document_upload, joined).where(~upload.c.complete)):
        yield "a file it came from is not whole"


def _motion_faults(tx: Transaction, key: int) -> Iterator[str]:
    rows = tx.fetch_all(select(content).where(content.c.document == key, tx.valid(content)))
    if len(rows) != 1:
        yield f"{len(rows)} {'current ' if tx.at >= CURRENT - 1 else ''}contents instead of one"
        return
    frames = int(rows[0].frames)
    tx.heads.header(key)
    tx.heads.skeleton(rows[0].skeleton)
    covered = tx.fetch_value(
        select(func.coalesce(func.sum(timeline.c.count), 0)).where(timeline.c.document == key, tx.valid(timeline))
    )
    if covered != frames:
        yield f"the timeline has {covered} frames of {frames}"
    read = 0
    for block in tx.tracks.blocks(key, 1, frames):
        if len(block.ids) != len(block):
            yield "some frames have no id"
        if not _is_whole(block):
            yield f"frames {read + 1} to {read + len(block)}: their bones have other samples than is said of them"
        read += len(block)
    if read != frames:
        yield f"{read} of {frames} frames can be read"
    for span in tx.spans.of(key):
        if not 1 <= span.first <= span.last <= frames:
            yield f"the name {span.name!r} is on frames {span.first} to {span.last} of {frames}"


def _is_whole(block: FrameBlock) -> bool:
    """Whether frames have just the samples that their shapes announce."""
    there = ~np.isnan(block.values)
    for number, shape in enumerate(block.shapes):
        announced = {(bone, channel) for bone, bits in shape for channel in channels_of(bits)}
        if not announced <= set(block.columns):
            return False
        own = there if block.shape_of is None else there[block.shape_of == number]
        if (own != [column in announced for column in block.columns]).any():
            return False
    return True


def _upload_faults(tx: Transaction, key: int, sha256: str, size: int) -> Iterator[str]:
    hashed, length = hashlib.sha256(), 0
    rows = tx.fetch_all(
        select(upload_block.c.number, upload_block.c.data)
        .where(upload_block.c.upload == key)
        .order_by(upload_block.c.number)
        .execution_options(yield_per=16)
    )
    for expected, (number, data) in enumerate(rows):
        if number != expected:
            yield f"the kept file {files_of(tx, key)}: block {expected} is missing"
            return
        block = zstandard.ZstdDecompressor().decompress(data)
        hashed.update(block)
        length += len(block)
    if length != size or hashed.hexdigest() != sha256:
        yield f"the kept file {files_of(tx, key)}: its bytes are not those that were uploaded"
