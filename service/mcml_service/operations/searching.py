"""Search for poses and motions similar to a given one."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from mcml_schemas.querying.search import MOST_HITS, SearchAnswer, SearchRequest
from mcml_service.operations.arguments import MOST, Documents, InProject, at_revision
from mcml_service.operations.call import Call
from mcml_service.operations.uploads import Files


def search_motion(call: Call, request: SearchRequest) -> SearchAnswer:
    """Poses are compared as bodies: position, facing direction, size and rig are ignored.

    A motion may be half as fast or twice as fast.
    """
    # Imported here: other operations need no mathematics.
    from mcml_service.actions.reading.search_motion import Where, ask_document, ask_positions, find_alike

    where = Where(tuple(request.within), request.project, request.limit, request.apart)
    with call.database.read() as tx:
        if request.document is not None:
            then, stored = at_revision(tx, request.document, request.revision)
            asked = ask_document(then, stored, request.first, request.last)
        else:
            asked = ask_positions(request.joints or [], request.positions or [], request.seconds_per_frame, request.up)
        return find_alike(tx, call.queries.caches, asked, where, call.limits)


def search_file(
    call: Call,
    file: Files,
    first: Annotated[int, Field(ge=1, le=MOST, description="Its frame, a position from 1", examples=[100])] = 1,
    last: Annotated[
        int | None,
        Field(ge=1, le=MOST, description="The motion to here; without it the pose in `first`", examples=[160]),
    ] = None,
    within: Documents = None,
    project: InProject = None,
    limit: Annotated[int, Field(ge=1, le=MOST_HITS, description="Most hits", examples=[5])] = 20,
    apart: Annotated[
        float | None,
        Field(
            ge=0,
            le=1e6,
            description="Minimum seconds between hits in one document; default 1, or the duration of the motion",
            examples=[1.0],
        ),
    ] = None,
) -> SearchAnswer:
    """Nothing is stored. The files are those of one clip."""
    from mcml_service.actions.reading.search_motion import Where, ask_file, find_alike

    asked = ask_file(file, call.settings, first, last)
    with call.database.read() as tx:
        where = Where(tuple(within or ()), project, limit, apart)
        return find_alike(tx, call.queries.caches, asked, where, call.limits)
