"""Ranges of frames changed, and their numbers set as arrays."""

from __future__ import annotations

import io
from typing import Annotated, Any

import numpy as np
import orjson
from fastapi import APIRouter, Query, Request, Response
from pydantic import ValidationError
from starlette.concurrency import run_in_threadpool

from schemas.frames import FrameEdits, FramesEdited, FrameValues
from service.actions.editing.change_frames import edit_frames, write_values
from service.api.dependencies import (
    MOST,
    AuthorDep,
    DatabaseDep,
    DocumentId,
    IfMatch,
    checked_for_write,
    etag,
)
from service.api.streaming import read_body
from service.errors import DocumentError
from service.motion.skeleton import Array
from service.storage.database import Transaction
from service.storage.documents import StoredDocument

router = APIRouter(tags=["frames"])

MOST_BYTES = 256 << 20
_VALUES: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "content": {
            "application/json": {
                "schema": FrameValues.model_json_schema(),
                "example": {"columns": ["left_up_leg.Rx"], "values": [[45.2], [45.9]]},
            },
            "application/octet-stream": {
                "schema": {"type": "string", "format": "binary"},
                "example": "a NumPy file of (frames, columns), the columns named by `column`",
            },
        },
    }
}


@router.post("/documents/{id}/frames", operation_id="edit_frames")
def post_edits(
    id: DocumentId,
    edits: FrameEdits,
    response: Response,
    database: DatabaseDep,
    author: AuthorDep,
    if_match: IfMatch = None,
) -> FramesEdited:
    """Delete, keep, move, insert or reverse ranges of frames. All of the list, or nothing, becomes one revision.

    What stays is not written again. Positions in a later edit are those that the earlier ones left.
    """
    with database.write(author) as tx:
        changed = edit_frames(tx, checked_for_write(tx, id, if_match), edits)
    return _edited(response, changed)


@router.put("/documents/{id}/frames", operation_id="put_frames", openapi_extra=_VALUES)
async def put_values(
    id: DocumentId,
    request: Request,
    response: Response,
    database: DatabaseDep,
    author: AuthorDep,
    first: Annotated[int, Query(ge=1, le=MOST, description="Frame of the first row", examples=[100])] = 1,
    last: Annotated[
        int | None, Query(ge=1, le=MOST, description="Frame of the last row; so many rows are needed", examples=[142])
    ] = None,
    column: Annotated[
        list[str] | None,
        Query(description="BONE.CHANNEL of each column of an array", examples=[["left_up_leg.Rx"]]),
    ] = None,
    bone: Annotated[
        list[str] | None, Query(description="Or bones, each with every `channel`", examples=[["left_up_leg"]])
    ] = None,
    channel: Annotated[list[str] | None, Query(description="Channels of every `bone`", examples=[["Rx"]])] = None,
    if_match: IfMatch = None,
) -> FramesEdited:
    """Set channels of consecutive frames to numbers: JSON, or a NumPy file. Only what changes is written.

    Columns are named by `column`, or by `bone` and `channel`, which may be repeated: all channels of the first bone,
    then those of the next. JSON is `{columns, values}`, or a list of numbers or rows where the query names the columns.
    """
    content = await read_body(request, MOST_BYTES)
    plain = request.headers.get("content-type", "").partition(";")[0].strip() in ("", "application/json")

    def write() -> StoredDocument:
        stated = [*(column or []), *(f"{one}.{other}" for one in bone or [] for other in channel or [])]
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
        with database.write(author) as tx:
            return _put(tx, checked_for_write(tx, id, if_match), first, named, values)

    return _edited(response, await run_in_threadpool(write))


def _put(
    tx: Transaction, stored: StoredDocument, first: int, columns: list[tuple[str, str]], values: Array
) -> StoredDocument:
    if write_values(tx, stored, first, columns, values):
        names = ", ".join(".".join(column) for column in columns[:4])
        tx.documents.add_revision(stored, "frames", f"set {names} of frames {first} to {first + len(values) - 1}")
    return tx.documents.get(stored.uuid)


def _edited(response: Response, changed: StoredDocument) -> FramesEdited:
    response.headers["etag"] = etag(changed, "json")
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
