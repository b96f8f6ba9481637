"""Frames as numbers: JSON pages, or one NumPy array."""

from __future__ import annotations

import io
import math
import zlib
from collections.abc import Iterator
from typing import Annotated, Any, Literal

import numpy as np
from fastapi import APIRouter, Query, Request, Response

from schemas.documents import FramePage, FrameRow
from service.actions.reading.read_clip import read_clip
from service.api.dependencies import (
    MOST,
    DatabaseDep,
    DocumentId,
    First,
    Last,
    PageDep,
    RevisionQuery,
    at_revision,
    decode_cursor,
    encode_cursor,
    etag,
)
from service.api.streaming import Bytes, attachment, streamed, unchanged
from service.errors import NotFoundError
from service.motion.kinematics import Walker
from service.motion.skeleton import CHANNELS
from service.motion.units import reading_of
from service.storage.blocks import evenly
from service.storage.database import Transaction

router = APIRouter(tags=["frames"])


_ARRAY: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "A page of frames; or with `format=npy` a NumPy file of one array, numbers little-endian",
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}


@router.get("/documents/{id}/frames", operation_id="get_frames", response_model=FramePage, responses=_ARRAY)
def get_frames(
    id: DocumentId,
    request: Request,
    database: DatabaseDep,
    page: PageDep,
    revision: RevisionQuery = None,
    first: First = 1,
    last: Last = None,
    step: Annotated[int, Query(ge=1, le=MOST, description="Every step-th frame, from `first` on", examples=[4])] = 1,
    bone: Annotated[
        list[str] | None, Query(description="Bones by MCML name; default all", examples=[["Root", "left_up_leg"]])
    ] = None,
    space: Annotated[
        Literal["channels", "positions", "rotations"],
        Query(description="Source channels, or global joint positions (x y z) or rotations (x y z w) by kinematics"),
    ] = "channels",
    dtype: Annotated[Literal["f8", "f4"], Query(description="Numbers of the array")] = "f8",
    format: Annotated[Literal["json", "npy"], Query(description="A page of JSON, or one NumPy array")] = "json",
) -> Any:
    """Frames of a document as numbers in the source's units.

    `npy` with channels: (frames, channels) in the order of the header `x-mcml-columns`, missing samples NaN. With
    positions (frames, bones, 3), with rotations (frames, bones, 4), bones in that order.
    """
    if format == "npy":
        return _array(request, database, id, revision, first, last, step, bone, space, dtype)
    start = first if page.cursor is None else int(decode_cursor(page.cursor, int)[0])
    with database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        end = min(stored.frames if last is None else last, start + (page.limit - 1) * step)
        source = read_clip(then, stored, first=start, last=end, step=step, labelled=False)
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
    limit = stored.frames if last is None else last
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
    request: Request,
    database: DatabaseDep,
    uuid: str,
    revision: int | None,
    first: int,
    last: int | None,
    step: int,
    bone: list[str] | None,
    space: str,
    dtype: str,
) -> Response:
    def make(tx: Transaction) -> tuple[Iterator[Bytes], str, dict[str, str]] | Response:
        then, stored = at_revision(tx, uuid, revision)
        tag = etag(stored, f"npy-{first}-{last}-{step}-{space}-{dtype}-{zlib.crc32(repr(bone).encode())}")
        cached = unchanged(request, tag)
        if cached is not None:
            return cached
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

        def content() -> Iterator[Bytes]:
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

        headers = {
            "etag": tag,
            "content-length": str(len(header.getvalue()) + math.prod(shape) * np.dtype(dtype).itemsize),
            "x-mcml-columns": ",".join(labels).encode("utf-8").decode("latin-1"),
            "content-disposition": attachment(f"{stored.name}.npy"),
        }
        return content(), "application/octet-stream", headers

    return streamed(database, make)
