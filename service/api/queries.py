"""XPath over HTTP."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Annotated, Any, Literal, TypeVar

import orjson
from fastapi import APIRouter, Query, Request, Response
from starlette.concurrency import run_in_threadpool

from schemas.examples import CURSOR, DOCUMENT, QUERY, RESULTS
from schemas.queries import CompletionItem, Completions, NodeItem, QueryAnswer, QueryRequest
from service.api.dependencies import MOST, ProjectQuery, QueriesDep
from service.api.streaming import begun
from service.xpath.limits import Limits
from service.xpath.run import Queries
from service.xpath.streams import Answer, Shown
from service.xpath.writing import FIELDS, STREAMS, xml_item

router = APIRouter(tags=["xpath"])
Form = Literal["json", "xml", "ndjson", "csv", "runs"]
Result = TypeVar("Result")

LOOK_SECONDS = 0.25
"""How often a running query looks whether its client is still there."""

_SHOWN = dict(zip(FIELDS, (DOCUMENT, 1, "attribute", "/mcml/@version", "1.0"), strict=True))
_OTHERS: dict[int | str, dict[str, Any]] = {
    200: {
        "content": {
            "application/xml": {"example": RESULTS},
            "application/x-ndjson": {"example": orjson.dumps(_SHOWN).decode() + "\n"},
            "text/csv": {"example": ",".join(FIELDS) + "\r\n" + ",".join(map(str, _SHOWN.values())) + "\r\n"},
        }
    }
}


@router.get(
    "/xpath", operation_id="query", response_model=QueryAnswer, response_model_exclude_none=True, responses=_OTHERS
)
async def query(
    http: Request,
    queries: QueriesDep,
    q: Annotated[str, Query(min_length=1, max_length=10_000, description="An XPath expression", examples=[QUERY])],
    document: Annotated[
        list[str] | None, Query(description="Documents to ask; default all", examples=[[DOCUMENT]])
    ] = None,
    project: ProjectQuery = None,
    revision: Annotated[
        int | None,
        Query(ge=1, le=MOST, description="Of the one document asked: as this revision left it", examples=[1]),
    ] = None,
    as_: Annotated[
        Form,
        Query(
            alias="as",
            description="Pages of nodes (json) or runs of frames (runs); or all nodes as a stream (xml, ndjson, csv)",
        ),
    ] = "json",
    limit: Annotated[
        int | None, Query(ge=1, description="Most items; a page has 100 if it is not said, a stream all", examples=[20])
    ] = None,
    cursor: Annotated[
        str | None, Query(max_length=4096, description="`next_cursor` of the page before", examples=[CURSOR])
    ] = None,
    explain: Annotated[bool, Query(description="Say how the query ran")] = False,
) -> Any:
    """Ask one document or all an XPath question, such as `//frame[motion_name='left-arm-abduction']`.

    A node set comes in pages of nodes with canonical addresses, as runs (maximal ranges of frames), or whole as a
    stream. A scalar comes as `value`, or one a document. Pages are stable: a cursor reads the state in which the first
    page was read. A query ends when its time is up, or when its client leaves.
    """
    request = QueryRequest(
        q=q,
        document=document or [],
        project=project,
        revision=revision,
        limit=limit,
        cursor=cursor,
        explain=explain,
        **{"as": as_},
    )
    return await _answer(http, queries, request)


@router.post(
    "/xpath", operation_id="post_query", response_model=QueryAnswer, response_model_exclude_none=True, responses=_OTHERS
)
async def post_query(http: Request, queries: QueriesDep, request: QueryRequest) -> Any:
    """As GET, for long expressions and for such with variables."""
    return await _answer(http, queries, request)


@router.get("/xpath/complete", operation_id="complete_query")
def complete_query(
    queries: QueriesDep,
    q: Annotated[str, Query(max_length=10_000, description="What is typed so far", examples=["//fr"])],
    at: Annotated[
        int | None, Query(ge=0, description="Characters before the cursor; default all", examples=[4])
    ] = None,
    document: Annotated[
        list[str] | None, Query(description="Documents to take names from; default all", examples=[[DOCUMENT]])
    ] = None,
    project: ProjectQuery = None,
) -> Completions:
    """What may come next in an expression: elements, attributes, axes, functions, and names that occur."""
    first, found = queries.completions(q, len(q) if at is None else min(at, len(q)), document or [], project)
    items = [CompletionItem(text=item.text, kind=item.kind, detail=item.detail) for item in found]
    return Completions(first=first, items=items)


async def _answer(http: Request, queries: Queries, request: QueryRequest) -> Any:
    limits = queries.limits(_client(http))
    paged = request.cursor is not None or (request.as_ == "xml" and request.limit is not None)
    if request.as_ in ("json", "runs") or paged:
        answer = await _while_connected(http, limits, lambda: queries.answer(request, limits))
        return Response(_xml_page(answer), media_type="application/xml") if request.as_ == "xml" else answer
    return await _while_connected(http, limits, lambda: _stream(queries.stream(request, limits), request.as_))


def _client(http: Request) -> str:
    """Who asks: those who share the evaluating processes fairly."""
    return f"{http.scope.get('mcml.author', '')}@{http.client.host if http.client else ''}"


def _stream(found: Answer | Shown, form: str) -> Response:
    write, media_type = STREAMS[form]
    return begun(write(found), media_type, {"x-total-count": str(found.total)})


async def _while_connected(http: Request, limits: Limits, ask: Callable[[], Result]) -> Result:
    """Runs a query in a thread; cancels it when its client leaves."""
    running = asyncio.ensure_future(run_in_threadpool(ask))
    while not (await asyncio.wait({running}, timeout=LOOK_SECONDS))[0]:
        if await http.is_disconnected():
            limits.cancel()
    return await running


def _xml_page(answer: QueryAnswer) -> bytes:
    more = f' next_cursor="{answer.next_cursor}"' if answer.next_cursor else ""
    items = [xml_item(item) for item in answer.items or [] if isinstance(item, NodeItem)]
    return "".join([f'<?xml version="1.0" encoding="UTF-8"?>\n<results{more}>\n', *items, "</results>\n"]).encode()
