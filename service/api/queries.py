"""XPath over HTTP."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import APIRouter, Query, Response

from schemas.examples import CURSOR, DOCUMENT, QUERY, RESULTS
from schemas.queries import NodeItem, QueryAnswer, QueryRequest
from service.api.dependencies import ProjectQuery, QueriesDep
from service.mcml.writer import attribute_bytes, text_bytes
from service.xpath.run import Queries

router = APIRouter(tags=["xpath"])


_XML: dict[int | str, dict[str, Any]] = {200: {"content": {"application/xml": {"example": RESULTS}}}}


@router.get(
    "/xpath", operation_id="query", response_model=QueryAnswer, response_model_exclude_none=True, responses=_XML
)
def query(
    queries: QueriesDep,
    q: Annotated[str, Query(min_length=1, max_length=10_000, description="An XPath 1.0 expression", examples=[QUERY])],
    document: Annotated[
        list[str] | None, Query(description="Documents to ask; default all", examples=[[DOCUMENT]])
    ] = None,
    project: ProjectQuery = None,
    as_: Annotated[
        Literal["json", "xml", "runs"], Query(alias="as", description="Nodes, nodes as XML, or runs of frames")
    ] = "json",
    limit: Annotated[int, Query(ge=1, description="Most items on the page", examples=[20])] = 100,
    cursor: Annotated[
        str | None, Query(max_length=4096, description="`next_cursor` of the page before", examples=[CURSOR])
    ] = None,
    explain: Annotated[bool, Query(description="Say how the query ran")] = False,
) -> Any:
    """Ask one document or all an XPath question, such as `//frame[motion_name='left-arm-abduction']`.

    A node set comes in pages of nodes with canonical addresses, or as runs: maximal ranges of frames. A scalar comes as
    `value`, or one a document. Pages are stable: a cursor reads the state in which the first page was read.
    """
    request = QueryRequest(
        q=q, document=document or [], project=project, limit=limit, cursor=cursor, explain=explain, **{"as": as_}
    )
    return _answer(queries, request)


@router.post(
    "/xpath", operation_id="post_query", response_model=QueryAnswer, response_model_exclude_none=True, responses=_XML
)
def post_query(queries: QueriesDep, request: QueryRequest) -> Any:
    """As GET, for long expressions."""
    return _answer(queries, request)


def _answer(queries: Queries, request: QueryRequest) -> Any:
    answer = queries.answer(request)
    return Response(_xml(answer), media_type="application/xml") if request.as_ == "xml" else answer


def _xml(answer: QueryAnswer) -> bytes:
    """Nodes as one XML document: `results`, in it a `result` for each node with its place and the node itself."""
    more = f' next_cursor="{answer.next_cursor}"' if answer.next_cursor else ""
    parts = [f'<?xml version="1.0" encoding="UTF-8"?>\n<results{more}>\n'.encode()]
    for item in answer.items or []:
        if isinstance(item, NodeItem):
            value = item.value.encode() if item.kind in ("element", "document") else text_bytes(item.value)
            place = f'<result document="{item.document}" revision="{item.revision}" address="'.encode()
            parts += [place, attribute_bytes(item.address), b'">', value, b"</result>\n"]
    parts.append(b"</results>\n")
    return b"".join(parts)
