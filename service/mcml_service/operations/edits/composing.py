"""New documents from frames of others, and on the skeletons of others."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

import orjson
from pydantic import Field

from mcml.answers import Content
from mcml_schemas.compose import Composed, ComposeRequest, MadeSkeletons, SkeletonsRequest, SplitParts, SplitRequest
from mcml_schemas.examples import example_of
from mcml_schemas.retarget import Retargeted, RetargetedOne, RetargetMany, RetargetRequest, RetargetTable
from mcml_service.actions.composing import compose_frames, retarget_motion
from mcml_service.actions.composing import make_skeletons as making
from mcml_service.actions.composing import split_document as splitting
from mcml_service.actions.composing.describe_retargeting import retarget_table, table_csv
from mcml_service.operations.arguments import DocumentId, Raw, Shown
from mcml_service.operations.call import Call
from mcml_service.operations.operation import gives


def compose(call: Call, request: ComposeRequest, shown: Shown) -> Composed:
    """A segment is a range of frames, or the runs that an XPath expression finds.

    Layers put the bones of one clip on the body of another. Consecutive pieces of one source are joined bit by bit.
    With `preview` nothing is stored.
    """
    made = compose_frames.compose_frames(call.database, call.queries, call.settings, request, call.author, shown.window)
    call.makes(made.document)
    return made


def split_document(call: Call, id: DocumentId, request: SplitRequest) -> SplitParts:
    """The document itself stays. To shorten it, `keep` frames of it: `POST /documents/{id}/frames`."""
    return splitting.split_document(call.database, call.settings, id, request, call.author)


def make_skeletons(call: Call, id: DocumentId, request: SkeletonsRequest) -> MadeSkeletons:
    """Joints are at the centres that the markers of a known set tell; bones have one length, and point as the centres
    do. The answer says how far each joint is from its centre. With `preview` nothing is stored.
    """
    made = making.make_skeletons(call.database, call.settings, id, request, call.author)
    if request.preview or len(made.items) == 1:
        call.makes(made.items[0].document)
    return made


def retarget(call: Call, id: DocumentId, request: RetargetRequest, shown: Shown) -> Retargeted:
    """Joints are matched by their MCML names, or as `mapping` says; bones keep their directions, the travel of the body
    is scaled by the length of the legs. The answer has the matched joints, the errors of directions, and the sliding of
    feet. With `preview` nothing is stored.
    """
    made = retarget_motion.retarget_motion(call.database, call.settings, id, request, call.author, shown.window)
    call.makes(made.document)
    return made


_BULK: dict[str, list[str]] = {"bones": [], "matches": [], "feet": [], "hands": [], "clamped": []}
"""Parts of answers that tables do not show: many documents are kept without them."""


@gives(
    "A line of JSON for each document, as soon as it is done; or one table",
    {"application/x-ndjson": orjson.dumps(example_of(RetargetedOne)).decode() + "\n", "text/csv": None},
)
def retarget_many(
    call: Call,
    request: RetargetMany,
    format: Annotated[
        Literal["ndjson", "json", "csv"],
        Field(description="Lines of JSON; or, after the last document, one table as JSON or CSV, outliers first"),
    ] = "ndjson",
    summary: Annotated[bool, Field(description="Lines of JSON end with one more, `table`: the table as JSON")] = False,
    raw: Raw = False,
) -> RetargetTable | Content:
    """The answer has one line for each document, sent as soon as it is done: the new document, or the problem. A table
    has a row for each document, with mean errors of limbs, hips, shoulders, trunk and head, the slide of feet and
    warnings: problems first, then outliers.

    If the client disconnects, the work stops; finished documents stay. With `preview` nothing is stored.
    """
    made = retarget_motion.retarget_many(call.database, call.queries, call.settings, request, call.author)
    if format != "ndjson":
        table = retarget_table(made)
        if format == "json":
            return table
        return Content(iter([table_csv(table, raw=raw).encode()]), "text/csv; charset=utf-8", "retarget.csv")

    def lines() -> Iterator[bytes]:
        items = []
        for item in made:
            yield item.model_dump_json(exclude_none=True).encode() + b"\n"
            if summary:
                items.append(item.model_copy(update={"made": item.made and item.made.model_copy(update=_BULK)}))
        if summary:
            yield b'{"table":' + retarget_table(items).model_dump_json(exclude_none=True).encode() + b"}\n"

    return Content(lines(), "application/x-ndjson", live=True)
