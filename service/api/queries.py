"""XPath over HTTP."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import APIRouter, Query

from schemas.queries import QueryAnswer, QueryRequest
from service.api.dependencies import DatabaseDep, SettingsDep
from service.xpath.run import answer_query

router = APIRouter(tags=["xpath"])


@router.get("/xpath", operation_id="query", response_model_exclude_none=True)
def query(
    database: DatabaseDep,
    settings: SettingsDep,
    q: Annotated[str, Query(min_length=1, max_length=10_000, description="An XPath 1.0 expression")],
    document: Annotated[list[str] | None, Query(description="Documents to ask; default all")] = None,
    project: Annotated[str | None, Query(description="Ask this project only")] = None,
    as_: Annotated[
        Literal["json", "xml", "runs"], Query(alias="as", description="Nodes, nodes as XML, or runs of frames")
    ] = "json",
    limit: Annotated[int, Query(ge=1)] = 100,
    cursor: Annotated[str | None, Query(max_length=4096)] = None,
    explain: Annotated[bool, Query(description="Say how the query ran")] = False,
) -> QueryAnswer:
    """Ask one document or all an XPath question, such as `//frame[motion_name='left-arm-abduction']`.

    A node set comes in pages of nodes with canonical addresses, or as runs: maximal ranges of frames. A scalar comes as
    `value`, or one a document. Pages are stable: a cursor reads the state in which the first page was read.
    """
    request = QueryRequest(
        q=q, document=document or [], project=project, limit=limit, cursor=cursor, explain=explain, **{"as": as_}
    )
    return answer_query(database, settings, request)


@router.post("/xpath", operation_id="post_query", response_model_exclude_none=True)
def post_query(database: DatabaseDep, settings: SettingsDep, request: QueryRequest) -> QueryAnswer:
    """As GET, for long expressions."""
    return answer_query(database, settings, request)
