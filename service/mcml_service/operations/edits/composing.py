"""New documents from frames of others, and on the skeletons of others."""

from __future__ import annotations

from collections.abc import Iterator

import orjson

from mcml.answers import Content
from mcml_schemas.compose import Composed, ComposeRequest, SplitParts, SplitRequest
from mcml_schemas.examples import example_of
from mcml_schemas.retarget import Retargeted, RetargetedOne, RetargetMany, RetargetRequest
from mcml_service.actions.composing import compose_frames, retarget_motion
from mcml_service.actions.composing import split_document as splitting
from mcml_service.operations.arguments import DocumentId, Shown
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


def retarget(call: Call, id: DocumentId, request: RetargetRequest, shown: Shown) -> Retargeted:
    """Joints are matched by their MCML names, or as `mapping` says; bones keep their directions, the travel of the body
    is scaled by the length of the legs. The answer has the matched joints, the errors of directions, and the sliding of
    feet. With `preview` nothing is stored.
    """
    made = retarget_motion.retarget_motion(call.database, call.settings, id, request, call.author, shown.window)
    call.makes(made.document)
    return made


@gives(
    "A line of JSON for each document, as soon as it is done",
    {"application/x-ndjson": orjson.dumps(example_of(RetargetedOne)).decode() + "\n"},
)
def retarget_many(call: Call, request: RetargetMany) -> Content:
    """The answer has one line for each document, sent as soon as it is done: the new document, or the problem.

    If the client disconnects, the work stops; finished documents stay. With `preview` nothing is stored.
    """
    made = retarget_motion.retarget_many(call.database, call.queries, call.settings, request, call.author)

    def lines() -> Iterator[bytes]:
        for item in made:
            yield item.model_dump_json(exclude_none=True).encode() + b"\n"

    return Content(lines(), "application/x-ndjson", live=True)
