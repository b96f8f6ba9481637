"""XPath: queries, and completions of expressions."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

import orjson
from pydantic import Field

from mcml.answers import Content
from mcml.errors import QueryError
from mcml_schemas.examples import CURSOR, DOCUMENT, QUERY, RESULTS
from mcml_schemas.querying.queries import (
    WITH,
    AnswerForm,
    CompletionItem,
    Completions,
    NodeItem,
    QueryAnswer,
    QueryRequest,
)
from mcml_service.actions.exporting.write_tables import TYPES, About, Batches, batches_of, write_table
from mcml_service.operations.arguments import MOST, InProject, Raw
from mcml_service.operations.call import Call
from mcml_service.operations.operation import gives, quick_if
from mcml_service.xpath.answer.writing import FIELDS, RAW_CSV, STREAMS, xml_item
from mcml_service.xpath.quick import is_quick

_NUMBER = re.compile(r"-?(\d+(\.\d*)?|\.\d+)")

_SHOWN: dict[str, Any] = dict(zip(FIELDS, (DOCUMENT, 1, "attribute", "/mcml/@version", "1.0"), strict=True))
_OTHERS = {
    "application/xml": RESULTS,
    "application/x-ndjson": orjson.dumps(_SHOWN).decode() + "\n",
    TYPES["arrow"]: None,
    TYPES["parquet"]: None,
    "text/csv": ",".join(FIELDS) + "\r\n" + ",".join(map(str, _SHOWN.values())) + "\r\n",
}
_COLUMNS = dict(zip((*FIELDS, "number"), ("string", "int64", "string", "string", "string", "float64"), strict=True))
_WORDS = "A page of nodes or runs, or all nodes as a stream"


def _is_quick(given: Mapping[str, Any]) -> bool:
    """Whether a query is a page of an expression that columns answer in milliseconds."""
    request = given.get("request")
    text, form = (given["q"], given["as_"]) if request is None else (request.q, request.as_)
    return form in ("json", "runs") and is_quick(text)


@quick_if(_is_quick)
@gives(_WORDS, _OTHERS)
def get_query(
    call: Call,
    q: Annotated[str, Field(min_length=1, max_length=10_000, description="An XPath expression", examples=[QUERY])],
    document: Annotated[
        list[str] | None, Field(description="Documents to ask; default all", examples=[[DOCUMENT]])
    ] = None,
    project: InProject = None,
    revision: Annotated[
        int | None,
        Field(ge=1, le=MOST, description="State after this revision; only for a query of one document", examples=[1]),
    ] = None,
    as_: Annotated[
        AnswerForm,
        Field(
            alias="as",
            description="Pages of nodes (json) or runs of frames (runs); or all nodes as a stream (xml, ndjson, csv; "
            "arrow and parquet with the extra `arrow`)",
        ),
    ] = "json",
    otherwise: Annotated[
        Literal["json"] | None,
        Field(description="For frame ranges: with json, nodes or values if the result has no frames"),
    ] = None,
    limit: Annotated[
        int | None, Field(ge=1, description="Most items; a page has 100 if it is not said, a stream all", examples=[20])
    ] = None,
    cursor: Annotated[
        str | None, Field(max_length=4096, description="`next_cursor` of the page before", examples=[CURSOR])
    ] = None,
    per: Annotated[
        Literal["document"] | None,
        Field(description="document: functions count in each document alone, and each has a value of its own"),
    ] = None,
    guesses: Annotated[
        Literal["yes", "no"],
        Field(description="no: functions of bodies leave out documents whose unit, up axis or floor is guessed"),
    ] = "yes",
    strict: Annotated[bool, Field(description="XPath 3.1 without its mode that is compatible with 1.0")] = False,
    explain: Annotated[bool, Field(description="Say how the query ran")] = False,
    raw: Raw = False,
    with_: Annotated[
        str | None,
        Field(
            alias="with",
            pattern=WITH,
            description="For frame ranges: totals (frames, ranges, documents of all pages), range (minimum, maximum, "
            "mean of the compared sample or quantity), or both",
            examples=["totals,range"],
        ),
    ] = None,
) -> QueryAnswer | Content:
    """A node set is returned in pages of nodes with canonical addresses, as runs (maximal ranges of frames), or whole
    as a stream. A scalar is returned as `value`, or one for each document. Pages are stable: a cursor reads the same
    state of the store as the first page. A query ends at its time limit, or when its client disconnects.
    """
    request = QueryRequest(
        q=q,
        document=document or [],
        project=project,
        revision=revision,
        otherwise=otherwise,
        limit=limit,
        cursor=cursor,
        per=per,
        guesses=guesses,
        strict=strict,
        explain=explain,
        raw=raw,
        **{"as": as_, "with": with_},
    )
    return post_query(call, request)


@quick_if(_is_quick)
@gives(_WORDS, _OTHERS)
def post_query(call: Call, request: QueryRequest) -> QueryAnswer | Content:
    """As GET, for long expressions and for such with variables."""
    paged = request.cursor is not None or (request.as_ == "xml" and request.limit is not None)
    if request.as_ in ("json", "runs") or paged:
        return _page(call, request)
    answer = call.queries.stream(request, call.limits)
    if request.as_ not in STREAMS:
        batches = _batches(STREAMS["ndjson"][0](answer))
        return Content(write_table(request.as_, batches, About(_COLUMNS)), TYPES[request.as_], f"answer.{request.as_}")
    write, media_type = STREAMS[request.as_]
    write = RAW_CSV if request.as_ == "csv" and request.raw else write
    return Content(write(answer), media_type, facts={} if answer.total is None else {"total-count": str(answer.total)})


def complete_query(
    call: Call,
    q: Annotated[str, Field(max_length=10_000, description="The expression typed so far", examples=["//fr"])],
    at: Annotated[
        int | None, Field(ge=0, description="Characters before the cursor; default all", examples=[4])
    ] = None,
    document: Annotated[
        list[str] | None, Field(description="Documents to take names from; default all", examples=[[DOCUMENT]])
    ] = None,
    project: InProject = None,
) -> Completions:
    first, completions = call.queries.completions(q, len(q) if at is None else min(at, len(q)), document or [], project)
    items = [
        CompletionItem(text=item.text, kind=item.kind, detail=item.detail, documents=item.documents)
        for item in completions
    ]
    return Completions(first=first, items=items)


def _batches(blocks: Iterator[bytes]) -> Batches:
    """Nodes as columns; `number` is the value where it is one, as XPath's number() reads it."""

    def rows() -> Iterator[tuple[Any, ...]]:
        rest = b""
        for block in blocks:
            *lines, rest = (rest + block).split(b"\n")
            for line in lines:
                node = orjson.loads(line)
                yield *(node[name] for name in FIELDS), _number(node["value"])

    return batches_of(rows(), list(_COLUMNS))


def _number(text: str) -> float | None:
    return float(text) if _NUMBER.fullmatch(text.strip()) else None


def _page(call: Call, request: QueryRequest) -> QueryAnswer | Content:
    try:
        answer = call.queries.answer(request, call.limits)
    except QueryError as error:
        if request.otherwise is None or request.as_ != "runs" or "as=json" not in (error.remedy or ""):
            raise
        answer = call.queries.answer(request.model_copy(update={"as_": "json", "with_": None}), call.limits)
    if request.as_ != "xml":
        return answer
    more = f' next_cursor="{answer.next_cursor}"' if answer.next_cursor else ""
    items = [xml_item(item) for item in answer.items or [] if isinstance(item, NodeItem)]
    text = "".join([f'<?xml version="1.0" encoding="UTF-8"?>\n<results{more}>\n', *items, "</results>\n"])
    return Content(iter([text.encode()]), "application/xml")
