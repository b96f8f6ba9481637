"""Frames as numbers: read as pages or one array, set, and their ranges changed."""

from __future__ import annotations

import io
import math
import zlib
from collections.abc import Iterator
from typing import Annotated, Literal

import numpy as np
import orjson
from pydantic import Field, ValidationError

from schemas.documents import FramePage, FrameRow
from schemas.frames import FrameEdits, FramesEdited, FrameValues
from service.actions.editing import change_frames
from service.actions.reading.read_clip import read_clip
from service.errors import DocumentError, NotFoundError
from service.motion.kinematics import Walker
from service.motion.skeleton import CHANNELS, Array
from service.motion.units import reading_of
from service.operations.arguments import (
    MOST,
    AtRevision,
    DocumentId,
    First,
    IfMatch,
    Last,
    Page,
    at_revision,
    checked_for_write,
    encode_cursor,
    tag,
)
from service.operations.call import Call, Content
from service.operations.operation import Body, gives
from service.storage.blocks import evenly
from service.storage.database import Transaction
from service.storage.documents import StoredDocument

Space = Literal["channels", "positions", "rotations"]
ROWS = {"columns": ["left_up_leg.Rx"], "values": [[45.2], [45.9]]}
NPY = "a NumPy file of (frames, columns), the columns named by `column`"


@gives(
    "A page of frames; or with `format=npy` a NumPy file of one array, numbers little-endian",
    {"application/octet-stream": None},
)
def get_frames(
    call: Call,
    id: DocumentId,
    page: Page,
    revision: AtRevision = None,
    first: First = 1,
    last: Last = None,
    step: Annotated[int, Field(ge=1, le=MOST, description="Every step-th frame, from `first` on", examples=[4])] = 1,
    bone: Annotated[
        list[str] | None, Field(description="Bones by MCML name; default all", examples=[["Root", "left_up_leg"]])
    ] = None,
    space: Annotated[
        Space,
        Field(description="Source channels, or global joint positions (x y z) or rotations (x y z w) by kinematics"),
    ] = "channels",
    dtype: Annotated[Literal["f8", "f4"], Field(description="Numbers of the array")] = "f8",
    format: Annotated[Literal["json", "npy"], Field(description="A page of JSON, or one NumPy array")] = "json",
) -> FramePage | Content:
    """`npy` with channels: (frames, channels) in the order of the header `x-mcml-columns`, missing samples NaN. With
    positions (frames, bones, 3), with rotations (frames, bones, 4), bones in that order.
    """
    if format == "npy":
        then, stored = at_revision(call.read(), id, revision)
        call.tagged(tag(stored, f"npy-{first}-{last}-{step}-{space}-{dtype}-{zlib.crc32(repr(bone).encode())}"))
        return _array(then, stored, first, last, step, bone, space, dtype)
    after = page.after(int)
    start = first if after is None else int(after[0])
    with call.database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        limit = stored.frames if last is None else last
        source = read_clip(
            then, stored, first=start, last=min(limit, start + (page.most(call) - 1) * step), step=step, labelled=False
        )
        wanted = _bones(source.names, bone)
        items: list[FrameRow] = []
        for block in source.clip.blocks():
            for row, frame_id in zip(block.values.tolist(), block.ids, strict=True):
                values: dict[str, dict[str, float]] = {}
                for (number, channel), value in zip(block.columns, row, strict=True):
                    if number in wanted and value == value:
                        values.setdefault(source.names[number], {})[CHANNELS[channel]] = value
                items.append(FrameRow(frame=start + len(items) * step, id=str(frame_id), values=values))
    following = start + len(items) * step
    return FramePage(items=items, next_cursor=encode_cursor(following) if following <= limit else None)


def _bones(names: tuple[str, ...], wanted: list[str] | None) -> dict[int, str]:
    if not wanted:
        return dict(enumerate(names))
    known = {name: number for number, name in enumerate(names)}
    unknown = [name for name in wanted if name not in known]
    if unknown:
        raise NotFoundError(f"The document has no bone {unknown[0]!r}.", remedy=f"It has: {', '.join(names[:60])}.")
    return {known[name]: name for name in wanted}


def _array(
    then: Transaction,
    stored: StoredDocument,
    first: int,
    last: int | None,
    step: int,
    bone: list[str] | None,
    space: Space,
    dtype: str,
) -> Content:
    source = read_clip(then, stored, first=first, last=last, step=step, labelled=False)
    wanted = _bones(source.names, bone)
    skeleton = source.clip.head.skeleton
    if space == "channels":
        columns = [column for column in skeleton.columns() if column[0] in wanted]
        labels = [f"{source.names[number]}.{CHANNELS[channel]}" for number, channel in columns]
        shape: tuple[int, ...] = (source.clip.frames or 0, len(columns))
    else:
        order = list(wanted)
        labels = list(wanted.values())
        shape = (source.clip.frames or 0, len(order), 3 if space == "positions" else 4)

    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": f"<{dtype}", "fortran_order": False, "shape": shape})

    def content() -> Iterator[bytes | memoryview]:
        walker = None if space == "channels" else Walker(skeleton, reading_of(source.clip.head))
        yield header.getvalue()
        for block in source.clip.blocks():
            if walker is None:
                place = {column: index for index, column in enumerate(block.columns)}
                chosen = np.array([place[column] for column in columns], np.int64)
                values = block.values[:, evenly(chosen) if len(chosen) else chosen]
            else:
                positions, rotations = walker.poses(block)
                values = (positions if space == "positions" else rotations)[:, order]
            yield np.ascontiguousarray(values, dtype=f"<{dtype}").reshape(-1).view(np.uint8).data

    return Content(
        content(),
        "application/octet-stream",
        f"{stored.name}.npy",
        size=len(header.getvalue()) + math.prod(shape) * np.dtype(dtype).itemsize,
        facts={"columns": ",".join(labels)},
    )


def edit_frames(call: Call, id: DocumentId, edits: FrameEdits, if_match: IfMatch = None) -> FramesEdited:
    """All of the list, or nothing, becomes one revision.

    What stays is not written again. Positions in a later edit are those that the earlier ones left.
    """
    with call.database.write(call.author) as tx:
        changed = change_frames.edit_frames(tx, checked_for_write(tx, id, if_match), edits)
    return _edited(call, changed)


def put_frames(
    call: Call,
    id: DocumentId,
    content: Annotated[
        bytes,
        Body({"application/json": ROWS, "application/octet-stream": NPY}, most=256 << 20, model=FrameValues),
        Field(description="JSON {columns, values}; or a NumPy file of (frames, columns), the columns named"),
    ],
    first: Annotated[int, Field(ge=1, le=MOST, description="Frame of the first row", examples=[100])] = 1,
    last: Annotated[
        int | None, Field(ge=1, le=MOST, description="Frame of the last row; so many rows are needed", examples=[142])
    ] = None,
    column: Annotated[
        list[str] | None,
        Field(description="BONE.CHANNEL of each column of an array", examples=[["left_up_leg.Rx"]]),
    ] = None,
    bone: Annotated[
        list[str] | None, Field(description="Or bones, each with every `channel`", examples=[["left_up_leg"]])
    ] = None,
    channel: Annotated[list[str] | None, Field(description="Channels of every `bone`", examples=[["Rx"]])] = None,
    if_match: IfMatch = None,
) -> FramesEdited:
    """Only what changes is written.

    Columns are named by `column`, or by `bone` and `channel`, which may be repeated: all channels of the first bone,
    then those of the next. JSON is `{columns, values}`, or a list of numbers or rows where the query names the columns.
    """
    stated = [*(column or []), *(f"{one}.{other}" for one in bone or [] for other in channel or [])]
    plain = call.media_type in ("", "application/json") and not content.startswith(b"\x93NUMPY")
    columns, values = _from_json(content, stated) if plain else (stated, _from_npy(content))
    if last is not None and last < first:
        raise DocumentError(
            f"The last frame, {last}, comes before the first, {first}.", remedy="Both ends are included."
        )
    if last is not None and len(values) != last - first + 1:
        raise DocumentError(
            f"Frames {first} to {last} need {last - first + 1} rows, there are {len(values)}.",
            remedy="Send a row for each frame, or leave `last` out.",
        )
    if values.shape[1] != len(columns):
        raise DocumentError(
            f"The array has {values.shape[1]} columns, {len(columns)} are named.", remedy="Name each: BONE.CHANNEL."
        )
    named = [(text.rpartition(".")[0], text.rpartition(".")[2]) for text in columns]
    with call.database.write(call.author) as tx:
        return _edited(call, _put(tx, checked_for_write(tx, id, if_match), first, named, values))


def _put(
    tx: Transaction, stored: StoredDocument, first: int, columns: list[tuple[str, str]], values: Array
) -> StoredDocument:
    if change_frames.write_values(tx, stored, first, columns, values):
        names = ", ".join(".".join(column) for column in columns[:4])
        tx.documents.add_revision(stored, "frames", f"set {names} of frames {first} to {first + len(values) - 1}")
    return tx.documents.get(stored.uuid)


def _edited(call: Call, changed: StoredDocument) -> FramesEdited:
    call.tag = tag(changed)
    return FramesEdited(revision=changed.revision, frames=changed.frames)


def _from_json(content: bytes, stated: list[str]) -> tuple[list[str], Array]:
    """Columns and values. stated: the columns, where the body has numbers alone."""
    try:
        sent = orjson.loads(content or b"{}")
        if isinstance(sent, list):
            rows = sent if sent and isinstance(sent[0], list) else [[number] for number in sent]
            sent = {"columns": stated, "values": rows}
        found = FrameValues.model_validate(sent)
    except ValidationError as error:
        fault = error.errors()[0]
        raise _unread(f"{'.'.join(str(part) for part in fault['loc'])}: {fault['msg']}") from error
    except ValueError as error:
        raise _unread("the body is no JSON") from error
    if len({len(row) for row in found.values}) > 1:
        raise _unread("the rows have different lengths")
    return found.columns, np.array(found.values, dtype=np.float64)


def _unread(what: str) -> DocumentError:
    return DocumentError(f"The numbers cannot be read: {what}.", remedy="Send {columns, values}.")


def _from_npy(content: bytes) -> Array:
    try:
        values = np.load(io.BytesIO(content), allow_pickle=False)
        numbers: Array = np.ascontiguousarray(values, dtype=np.float64)
    except (ValueError, OSError, EOFError, TypeError) as error:
        raise DocumentError(
            "The array cannot be read.", remedy="Send what numpy.save writes, numbers of (frames, columns)."
        ) from error
    if numbers.ndim == 1:
        numbers = numbers[:, None]
    if numbers.ndim != 2 or not len(numbers):
        raise DocumentError(f"The array has the shape {values.shape}.", remedy="Send (frames, columns).")
    return numbers
