"""Motion matching: a body that follows a path, and the library by which a program leads it itself."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from mcml.answers import Content
from mcml_schemas.matching import FollowRequest, MatchingFacts, MatchingSelection, PathFollowed
from mcml_service.operations.arguments import Shown
from mcml_service.operations.call import Call
from mcml_service.operations.operation import gives


def follow_path(call: Call, request: FollowRequest, shown: Shown) -> PathFollowed:
    """At short intervals the frame of all clips is found that continues the pose and leads along the path; the body is
    placed there, and the difference decays (docs/api/motion-matching.md). The clips have one skeleton; others are left
    out. With `preview` nothing is stored.
    """
    # Imported here: other operations need no mathematics.
    from mcml_service.actions.composing import follow_path

    made = follow_path.follow_path(
        call.database, call.queries, call.settings, request, call.author, call.limits.check, shown.window
    )
    call.makes(made.document)
    return made


@gives("Facts as JSON; or with `format=npy` the rows", {"application/octet-stream": None})
def get_matching_library(
    call: Call,
    request: MatchingSelection,
    format: Annotated[
        Literal["json", "npy"],
        Field(
            description="json: facts; npy: an array (rows, 31): 27 features, place (2), facing, 1 where cuts may lead"
        ),
    ] = "json",
) -> MatchingFacts | Content:
    """Features are the way ahead (three places, three directions), places and velocities of both ankles, and the
    velocity of the hips, seen from the root, multiplied by `scales`; NaN where unknown (docs/api/motion-matching.md).
    The facing is in radians, places are in metres.
    """
    from mcml_service.actions.composing.follow_path import read_library
    from mcml_service.actions.exporting.write_tables import npy_of

    stored = read_library(call.database, call.queries, request)
    if format == "json":
        return stored.facts()
    return Content(npy_of(stored.rows()), "application/octet-stream", "matching.npy")
