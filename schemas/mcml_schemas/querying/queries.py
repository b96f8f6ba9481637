"""XPath queries and answers."""

from __future__ import annotations

from typing import Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import CURSOR, DOCUMENT, NODE, QUERY, shown
from mcml_schemas.request_body import RequestBody

AnswerForm: TypeAlias = Literal["json", "xml", "ndjson", "csv", "runs", "arrow", "parquet"]
"""How an answer is written."""

WITH = r"^(totals|range)(,(totals|range))*$"
MOST_DOCUMENTS = 10_000
"""Limit of documents named in one query."""

_RUN = {
    "document": DOCUMENT,
    "name": "walk",
    "revision": 1,
    "first": 100,
    "last": 142,
    "first_id": "100",
    "last_id": "142",
    "frames": 43,
}


class NodeItem(BaseModel):
    """One node of a result. address: a canonical XPath that finds it in its document."""

    kind: Literal["document", "element", "attribute", "text", "comment", "processing-instruction", "namespace"]
    document: str
    revision: int
    address: str
    value: str = Field(description="The element as XML, or the value of the attribute or text")


class ScalarItem(BaseModel):
    """One value a document. NaN and infinities are texts."""

    document: str
    revision: int
    value: str | int | float | bool


class RunItem(BaseModel):
    """A maximal range of frames (positions from 1, both ends included)."""

    document: str
    name: str
    revision: int
    first: int
    last: int
    first_id: str
    last_id: str
    frames: int
    range: list[float] | None = Field(None, description="Minimum and maximum of `range_of` in the range, if requested")
    mean: float | None = Field(None, description="Mean of `range_of` in the range, with `range`")


class RunTotals(BaseModel):
    """Of all runs of an answer, on all pages."""

    frames: int
    runs: int
    documents: int


class ValueItem(BaseModel):
    """One of several values, such as those of distinct-values().

    document, frame, time: of the node, if it is the value of a node; time in seconds since frame 1.
    """

    value: str | int | float | bool
    document: str | None = None
    frame: int | None = None
    time: float | None = None


class Explain(BaseModel):
    """How the query ran."""

    way: Literal["index", "columns", "projection"] = Field(
        description="Answered from indexes, on columns, or on documents as XML"
    )
    plan: list[str]
    documents: int = Field(description="Documents that were looked at")
    tracks_read: int | None = Field(None, description="Tracks (a bone over 256 frames) whose samples were compared")
    tracks_skipped: int | None = Field(None, description="Tracks that their zone maps decided")
    milliseconds: float


class QueryAnswer(BaseModel):
    """type: nodes, runs, or the type of the scalar. For one scalar `value`; else `items`, a page."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"type": "nodes", "items": [NODE], "next_cursor": CURSOR, "complete": True, "warnings": []},
            {
                "type": "runs",
                "items": [{**_RUN, "range": [45.1, 71.9], "mean": 60.2}],
                "totals": {"frames": 1204, "runs": 37, "documents": 9},
                "range_of": "left_up_arm.Rx",
                "complete": True,
                "warnings": [],
            },
            {"type": "number", "value": 42.0, "complete": True, "warnings": []},
        )
    )

    type: Literal["nodes", "runs", "number", "string", "boolean", "strings", "values"]
    value: str | int | float | bool | None = None
    items: list[NodeItem | RunItem | ScalarItem | ValueItem] | None = None
    next_cursor: str | None = None
    total: int | None = Field(None, description="All items on all pages, where it is known without more work")
    totals: RunTotals | None = Field(None, description="For frame ranges, if requested")
    range_of: str | None = Field(
        None,
        description="The value of `range` and `mean`, if requested: the compared sample as BONE.CHANNEL, or the "
        "first quantity of bodies, in m, s and degrees",
    )
    complete: bool = Field(True, description="False where a limit ended the query early")
    warnings: list[str] = Field(default_factory=list)
    explain: Explain | None = None


class QueryRequest(RequestBody):
    """An XPath query in a body, for long expressions."""

    model_config = ConfigDict(
        populate_by_name=True,
        json_schema_extra=shown({"q": QUERY, "document": [DOCUMENT], "as": "runs", "explain": True}),
    )

    q: str = Field(min_length=1, max_length=10_000)
    document: list[str] = Field(
        default_factory=list, max_length=MOST_DOCUMENTS, description="Documents to ask; none: all"
    )
    project: str | None = None
    revision: int | None = Field(
        None, ge=1, le=2**31 - 1, description="State after this revision; only for a query of one document"
    )
    as_: AnswerForm = Field("json", alias="as")
    otherwise: Literal["json"] | None = Field(
        None,
        description="For frame ranges: with json, nodes or values if the result has no frames",
    )
    limit: int | None = Field(None, ge=1, description="Most items; pages have 100, streams (xml, ndjson, csv) all")
    cursor: str | None = None
    per: Literal["document"] | None = Field(
        None, description="document: every function counts in one document, and each document has a value of its own"
    )
    guesses: Literal["yes", "no"] = Field(
        "yes", description="no: functions of bodies leave out documents whose unit, up axis or floor is guessed"
    )
    strict: bool = Field(False, description="XPath 3.1 without its mode that is compatible with 1.0")
    explain: bool = False
    raw: bool = Field(False, description="csv: also texts that spreadsheets take for formulas as they are")
    with_: str | None = Field(
        None, alias="with", pattern=WITH, description="Of runs: totals, range (minimum, maximum and mean), or both"
    )
    variables: dict[str, str | int | float | bool] = Field(
        default_factory=dict, max_length=100, description="Values of $name in the expression"
    )


class CompletionItem(BaseModel):
    """A completion at the cursor. text: replaces the characters from `first` on."""

    text: str
    kind: Literal["element", "attribute", "axis", "function", "motion name", "bone name", "angle", "word"]
    detail: str = ""
    documents: int | None = Field(None, description="Of names: how many documents have it")


class Completions(BaseModel):
    """first: the place of the first character that a completion replaces."""

    model_config = ConfigDict(
        json_schema_extra=shown({"first": 2, "items": [{"text": "frame", "kind": "element", "detail": ""}]})
    )

    first: int
    items: list[CompletionItem]
