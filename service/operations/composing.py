"""New documents from frames of others, and on the skeletons of others."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

import orjson
from pydantic import Field

from schemas.compose import Composed, ComposeRequest, SplitParts, SplitRequest
from schemas.examples import example_of
from schemas.retarget import Retargeted, RetargetedOne, RetargetMany, RetargetRequest
from service.actions.composing import compose_frames, retarget_motion
from service.actions.composing import split_document as splitting
from service.actions.exporting.write_tables import TYPES
from service.motion.clip import ClipStream
from service.operations.arguments import MOST, DocumentId
from service.operations.call import Call, Content
from service.operations.operation import gives

MOTION = (
    "Positions (frames, points, 3) from where the first bone is in the first frame: little-endian f4, frame after frame"
)


def compose(call: Call, request: ComposeRequest) -> Composed:
    """A segment is a range of frames, or the runs that an XPath expression finds. Layers put the bones of one clip on
    the body of another. Pieces that follow one another in their source come out bit by bit. With `preview` nothing is
    stored.
    """
    made = compose_frames.compose_frames(call.database, call.queries, call.settings, request, call.author)
    call.makes(made.document)
    return made


Step = Annotated[int, Field(ge=1, le=MOST, description="Every step-th frame", examples=[4])]


@gives(MOTION, {TYPES["block"]: None})
def show_composition(call: Call, request: ComposeRequest, step: Step = 1) -> Content:
    """Nothing is stored. Bones are those of the composed skeleton, and after them the ends of chains."""
    return _motion(compose_frames.composition_of(call.database, call.queries, request).stream, step)


@gives(MOTION, {TYPES["block"]: None})
def show_retargeted(call: Call, id: DocumentId, request: RetargetRequest, step: Step = 1) -> Content:
    """Nothing is stored. Bones are those of the skeleton that the motion is brought to, and after them the ends of
    chains.
    """
    return _motion(retarget_motion.retargeted_clip(call.database, id, request), step)


def _motion(stream: ClipStream, step: int) -> Content:
    # Imported here: other operations need no kinematics.
    from service.actions.composing.show_motion import positions_of

    positions, origin = positions_of(stream, step)
    facts = {"shape": ",".join(map(str, positions.shape)), "origin": ",".join(map(repr, origin.tolist()))}
    return Content(iter([positions.tobytes()]), TYPES["block"], size=positions.nbytes, facts=facts)


def split_document(call: Call, id: DocumentId, request: SplitRequest) -> SplitParts:
    """The document itself stays. To shorten it, `keep` frames of it: `POST /documents/{id}/frames`."""
    return splitting.split_document(call.database, call.settings, id, request, call.author)


def retarget(call: Call, id: DocumentId, request: RetargetRequest) -> Retargeted:
    """Joints are matched by their MCML names, or as `mapping` says; bones point as they did, the way through the room
    is scaled by the length of the legs. The answer says what was matched, how far bones point elsewhere, and how feet
    slide. With `preview` nothing is stored.
    """
    made = retarget_motion.retarget_motion(call.database, call.settings, id, request, call.author)
    call.makes(made.document)
    return made


@gives(
    "A line of JSON for each document, as soon as it is done",
    {"application/x-ndjson": orjson.dumps(example_of(RetargetedOne)).decode() + "\n"},
)
def retarget_many(call: Call, request: RetargetMany) -> Content:
    """The answer is a line a document, as soon as it is done: what was made, or the problem that kept it from being
    made. Who leaves stops the work; documents that are done stay. With `preview` nothing is stored.
    """
    made = retarget_motion.retarget_many(call.database, call.queries, call.settings, request, call.author)

    def lines() -> Iterator[bytes]:
        for item in made:
            yield item.model_dump_json(exclude_none=True).encode() + b"\n"

    return Content(lines(), "application/x-ndjson", live=True)
