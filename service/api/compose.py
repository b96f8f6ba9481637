"""New documents from frames of others, and on the skeletons of others."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import orjson
from fastapi import APIRouter, Response
from fastapi.responses import StreamingResponse

from schemas.compose import Composed, ComposeRequest, SplitParts, SplitRequest
from schemas.examples import example_of
from schemas.retarget import Retargeted, RetargetedOne, RetargetMany, RetargetRequest
from service.actions.composing.compose_frames import compose_frames
from service.actions.composing.retarget_motion import retarget_many, retarget_motion
from service.actions.composing.split_document import split_document
from service.api.dependencies import AuthorDep, DatabaseDep, DocumentId, QueriesDep, SettingsDep

router = APIRouter(tags=["compose"])

PREVIEW = "What would be stored, where `preview` was asked"
_LINES: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "A line of JSON for each document, as soon as it is done",
        "content": {"application/x-ndjson": {"example": orjson.dumps(example_of(RetargetedOne)).decode() + "\n"}},
    }
}


@router.post(
    "/compose",
    status_code=201,
    operation_id="compose",
    response_model_exclude_none=True,
    responses={200: {"model": Composed, "description": PREVIEW}},
)
def post_compose(
    request: ComposeRequest,
    response: Response,
    database: DatabaseDep,
    settings: SettingsDep,
    queries: QueriesDep,
    author: AuthorDep,
) -> Composed:
    """Make a document of frames of others, one segment after the other, with transitions between them.

    A segment is a range of frames, or the runs that an XPath expression finds. Layers put the bones of one clip on the
    body of another. Pieces that follow one another in their source come out bit by bit. With `preview` nothing is
    stored.
    """
    made = compose_frames(database, queries, settings, request, author)
    if made.document is None:
        response.status_code = 200
    else:
        response.headers["location"] = f"/api/v1/documents/{made.document}"
    return made


@router.post("/documents/{id}/split", status_code=201, operation_id="split_document")
def post_split(
    id: DocumentId, request: SplitRequest, database: DatabaseDep, settings: SettingsDep, author: AuthorDep
) -> SplitParts:
    """Store parts of a document as documents: cut before frames, or around every range of a motion name.

    The document itself stays. To shorten it, `keep` frames of it: `POST /documents/{id}/frames`.
    """
    return split_document(database, settings, id, request, author)


@router.post(
    "/documents/{id}/retarget",
    status_code=201,
    operation_id="retarget",
    response_model_exclude_none=True,
    responses={200: {"model": Retargeted, "description": PREVIEW}},
)
def post_retarget(
    id: DocumentId,
    request: RetargetRequest,
    response: Response,
    database: DatabaseDep,
    settings: SettingsDep,
    author: AuthorDep,
) -> Retargeted:
    """Bring a motion onto the skeleton of another document, as a new document.

    Joints are matched by their MCML names, or as `mapping` says; bones point as they did, the way through the room is
    scaled by the length of the legs. The answer says what was matched, how far bones point elsewhere, and how feet
    slide. With `preview` nothing is stored.
    """
    made = retarget_motion(database, settings, id, request, author)
    if made.document is None:
        response.status_code = 200
    else:
        response.headers["location"] = f"/api/v1/documents/{made.document}"
    return made


@router.post("/retarget", operation_id="retarget_many", response_class=Response, responses=_LINES)
def post_retarget_many(
    request: RetargetMany, database: DatabaseDep, settings: SettingsDep, queries: QueriesDep, author: AuthorDep
) -> StreamingResponse:
    """Bring the motions of all selected documents onto one skeleton, each as a new document.

    The answer is a line a document, as soon as it is done: what was made, or the problem that kept it from being made.
    Who leaves stops the work; documents that are done stay. With `preview` nothing is stored.
    """
    made = retarget_many(database, queries, settings, request, author)

    def lines() -> Iterator[bytes]:
        for item in made:
            yield item.model_dump_json(exclude_none=True).encode() + b"\n"

    return StreamingResponse(lines(), media_type="application/x-ndjson")
