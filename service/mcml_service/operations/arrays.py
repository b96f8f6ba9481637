"""Frames of many clips as arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from mcml.answers import Content
from mcml.errors import Notice
from mcml_schemas.arrays import ArraysRequest
from mcml_service.actions.exporting.write_tables import TYPES
from mcml_service.operations.call import Call
from mcml_service.operations.operation import gives

if TYPE_CHECKING:
    from mcml_service.clips.bodies import Body
    from mcml_service.storage.documents.columns import Listed
    from mcml_service.storage.documents.documents import StoredDocument
    from mcml_service.storage.transaction import Transaction

_FORMS = ("csv", "arrow", "parquet", "npz")
_SECONDS = 60.0
"""Time limit of the query and of the look at all columns."""


@gives("All arrays in one npz, or one table", dict.fromkeys(TYPES[form] for form in _FORMS))
def export_arrays(call: Call, request: ArraysRequest) -> Content:
    """The frames of all ranges, one after the other, with the same columns. Missing values are NaN.

    `npz` has `values`: (frames, bones, 3) for positions, (frames, bones, 4) for rotations, (frames, columns) for
    channels and quantities; `columns` (names of the second axis) and `units`; `starts` (ranges + 1), so that the frames
    of range i are `values[starts[i]:starts[i + 1]]`; and for each range `documents`, `names`, `revisions`, `first`,
    `last` (positions from 1), `seconds_per_frame` (NaN if unknown). Positions are in the unit of their clip. A table
    has the columns document, name, frame, id, time, then one for each number.
    """
    # Imported here: other operations need no mathematics.
    from mcml_service.actions.measuring.choose_ranges import choose_clips
    from mcml_service.actions.measuring.read_arrays import read_arrays, write_arrays

    call.limits.extend(max(_SECONDS, call.settings.query_seconds))
    clips, warnings = choose_clips(call.database, call.queries, request, call.limits)
    bodies = call.queries.caches.bodies

    def read_body(tx: Transaction, stored: StoredDocument) -> Body:
        return bodies.read(tx, [cast("Listed", stored)])[0]

    arrays = read_arrays(call.read(), read_body, clips, request, call.limits.check)
    content = write_arrays(arrays, request.as_, request.dtype, raw=request.raw)
    notices = [Notice("warning", text) for text in (*warnings, *arrays.warnings)]
    facts = {"frames": str(arrays.frames), "ranges": str(len(arrays.parts))}
    return Content(content, TYPES[request.as_], f"arrays.{request.as_}", notices=notices, facts=facts)
