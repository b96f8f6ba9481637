"""Results of analyses: listed, read part by part, used, deleted."""

from __future__ import annotations

import io
from typing import Annotated, Any, Literal

import numpy as np
from fastapi import APIRouter, Path, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field, create_model

from schemas.examples import DOCUMENT, RESULT, example_of, shown
from schemas.jobs import ArrayValues, ClipMotion, PartSummary, Result, ResultPage, Saving
from service.actions.analysing.describe_job import part_answer, result_answer
from service.actions.analysing.use_result import Done, Results
from service.actions.importing.store_clip import clip_file
from service.analysis.catalogue import ANALYSES
from service.analysis.interface import MadeClip
from service.analysis.interface import ResultUse as Operation
from service.api.dependencies import (
    MOST,
    AuthorDep,
    DatabaseDep,
    PageDep,
    ProjectQuery,
    decode_cursor,
    encode_cursor,
)
from service.api.streaming import attachment
from service.errors import NotFoundError, SizeError
from service.motion.hub import walked
from service.storage.database import Transaction
from service.storage.results import StoredPart, StoredResult

router = APIRouter(tags=["results"])

ResultId = Annotated[str, Path(description="Id of the result", examples=[RESULT])]
PartName = Annotated[str, Path(description="Name of the part", examples=["speed"])]

INLINE_NUMBERS = 2_000_000
"""Most numbers in one JSON answer."""

_FILE: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "What the operation gives; with another `format` the clip alone, as a file",
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}
_ARRAY: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "Rows of the array; or with `format=npy` a NumPy file",
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}


@router.get("/results", operation_id="list_results", response_model_exclude_none=True)
def list_results(
    database: DatabaseDep,
    page: PageDep,
    project: ProjectQuery = None,
    analysis: Annotated[str | None, Query(description="Results of this analysis", examples=["beats"])] = None,
    parent: Annotated[str | None, Query(description="Results made from this one", examples=[RESULT])] = None,
) -> ResultPage:
    """Results, the newest first, without their parts."""
    before = None if page.cursor is None else int(decode_cursor(page.cursor, int)[0])
    with database.read() as tx:
        found = tx.results.page(
            project_name=project, analysis=analysis, parent=parent, before=before, limit=page.limit + 1
        )
    shown = found[: page.limit]
    more = encode_cursor(shown[-1].key) if len(found) > page.limit else None
    return ResultPage(items=[result_answer(result) for result in shown], next_cursor=more)


@router.get("/results/{id}", operation_id="get_result", response_model_exclude_none=True)
def get_result(id: ResultId, database: DatabaseDep) -> Result:
    """A result with its parts; arrays are fetched one by one."""
    with database.read() as tx:
        stored = tx.results.get(id)
        return result_answer(stored, tx.results.parts(stored.key))


@router.delete("/results/{id}", status_code=204, operation_id="delete_result")
def delete_result(id: ResultId, http: Request, database: DatabaseDep, author: AuthorDep) -> Response:
    """Delete a result and the results made from it. Documents that were stored from it stay."""
    with database.write(author) as tx:
        tx.results.remove(tx.results.get(id).key)
    http.app.state.results.forget(id)
    return Response(status_code=204)


@router.get("/results/{id}/{part}", operation_id="get_result_part", response_model_exclude_none=True)
def get_part(id: ResultId, part: PartName, database: DatabaseDep) -> PartSummary:
    """One part of a result."""
    with database.read() as tx:
        return part_answer(_part(tx, id, part)[1])


@router.get(
    "/results/{id}/{part}/{array}", operation_id="get_result_array", response_model=ArrayValues, responses=_ARRAY
)
def get_array(
    id: ResultId,
    part: PartName,
    array: Annotated[str, Path(description="Name of the array", examples=["speed"])],
    database: DatabaseDep,
    first: Annotated[int, Query(ge=0, le=MOST, description="First row, from 0", examples=[0])] = 0,
    rows: Annotated[int | None, Query(ge=1, le=MOST, description="Most rows; default all", examples=[100])] = None,
    format: Annotated[Literal["json", "npy"], Query(description="JSON, or a NumPy file")] = "json",
) -> Any:
    """An array of a part, or some of its rows."""
    with database.read() as tx:
        stored, found = _part(tx, id, part)
        values = tx.results.array(stored.key, found, array)
    chosen = values[first : None if rows is None else first + rows] if values.ndim else values
    if format == "npy":
        return _npy(chosen, f"{part}-{array}")
    if chosen.size > INLINE_NUMBERS:
        raise SizeError(
            f"The array has {chosen.size:,} numbers.", remedy="Fetch it with format=npy, or some rows of it."
        )
    plain = chosen.astype(object) if chosen.dtype.kind == "f" else chosen
    if chosen.dtype.kind == "f":
        plain[~np.isfinite(chosen)] = None
    return ArrayValues(
        dtype=values.dtype.str, shape=list(values.shape), first=first, values=np.atleast_1d(plain).tolist()
    )


def _part(tx: Transaction, uuid: str, name: str) -> tuple[StoredResult, StoredPart]:
    stored = tx.results.get(uuid)
    parts = {part.name: part for part in tx.results.parts(stored.key)}
    if name not in parts:
        raise NotFoundError(f"The result has no part {name!r}.", remedy=f"It has: {', '.join(parts) or 'none'}.")
    return stored, parts[name]


def _npy(values: Any, name: str) -> Response:
    content = io.BytesIO()
    np.save(content, values)
    headers = {"content-disposition": attachment(f"{name}.npy")}
    return Response(content.getvalue(), media_type="application/octet-stream", headers=headers)


def _answer_model(name: str, operation: Operation) -> type[BaseModel]:
    example = {"value": example_of(operation.answer), "document": DOCUMENT}
    model: type[BaseModel] = create_model(
        f"{name.title().replace('-', '')}Done",
        __config__=ConfigDict(json_schema_extra=shown(example)),
        __doc__="What the operation gave. document, result: ids of what was stored of it.",
        value=(operation.answer, ...),
        clip=(ClipMotion | None, Field(None, description="The clip that was made")),
        document=(str | None, Field(None, description="Where the clip was stored")),
        result=(str | None, Field(None, description="Where what was made was kept")),
    )
    return model


def _request_model(name: str, operation: Operation) -> type[BaseModel]:
    needed = any(field.is_required() for field in operation.parameters.model_fields.values())
    model: type[BaseModel] = create_model(
        f"{name.title().replace('-', '')}Request",
        __base__=Saving,
        __doc__=operation.description,
        parameters=(operation.parameters, ... if needed else Field(default_factory=operation.parameters)),
    )
    model.model_config["json_schema_extra"] = shown({"parameters": example_of(operation.parameters), "save": False})
    model.model_rebuild(force=True)
    return model


def _offer(name: str, operation: Operation) -> None:
    asked, told = _request_model(name, operation), _answer_model(name, operation)

    def use(
        id: ResultId,
        request: Any,
        http: Request,
        author: AuthorDep,
        format: Annotated[
            str,
            Query(
                description="json; or the clip alone: npy (positions: frames, joints, 3), or bvh, htr, mcml …",
                examples=["json"],
            ),
        ] = "json",
        positions: Annotated[bool, Query(description="Put joint positions of every frame into the JSON")] = False,
    ) -> Any:
        results: Results = http.app.state.results
        done = results.use(
            id,
            name,
            request.parameters.model_dump(mode="json"),
            author=author,
            save=request.save,
            name=request.name,
            project=request.project,
        )
        if format == "json":
            return told(
                value=done.answer.value,
                clip=None if done.answer.clip is None else _motion(done.answer.clip, positions),
                document=done.document,
                result=done.result,
            )
        return _clip_file(done, format)

    use.__annotations__["request"] = asked
    router.add_api_route(
        f"/results/{{id}}/{name}",
        use,
        methods=["POST"],
        operation_id=f"use_{name.replace('-', '_')}",
        summary=operation.description.partition(".")[0],
        description=operation.description,
        response_model=told,
        response_model_exclude_none=True,
        responses=_FILE,
    )


def _motion(clip: MadeClip, positions: bool) -> ClipMotion:
    found = walked(clip.skeleton, clip.translations, clip.rotations)[0] if positions else None
    if found is not None and found.size > INLINE_NUMBERS:
        raise SizeError(f"The clip has {found.size:,} numbers.", remedy="Fetch it with format=npy.")
    return ClipMotion(
        name=clip.name,
        frames=len(clip.rotations),
        seconds_per_frame=clip.frame_time,
        joints=list(clip.skeleton.names),
        parents=[joint.parent for joint in clip.skeleton.joints],
        positions=None if found is None else found.round(5).tolist(),
    )


def _clip_file(done: Done, format: str) -> Response:
    clip = done.answer.clip
    if clip is None:
        raise NotFoundError("The operation makes no clip.", remedy="Ask for format=json.")
    headers = {} if done.document is None else {"x-mcml-document": done.document}
    if format == "npy":
        answer = _npy(walked(clip.skeleton, clip.translations, clip.rotations)[0].astype("<f4"), clip.name)
        answer.headers.update(headers)
        return answer
    file_name, media_type, content = clip_file(clip, format)
    headers["content-disposition"] = attachment(file_name)
    return Response(content, media_type=media_type, headers=headers)


for _analysis in ANALYSES.values():
    for _name, _operation in _analysis.operations.items():
        _offer(_name, _operation)
