"""Measure quantities in frame ranges of many clips."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from mcml.answers import Content
from mcml.errors import LimitError
from mcml_schemas.measure import MeasureRequest, Measures
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
"""Time limit, as bodies of clips may have to be computed first."""


@gives("One table, or all arrays", dict.fromkeys(TYPES[form] for form in _FORMS))
def measure(call: Call, request: MeasureRequest) -> Measures | Content:
    """Each frame range and quantity has a row: minimum, maximum, mean, standard deviation, range, place of the maximum,
    and how far it is from the other ranges of its group. Values are those of `GET /documents/{id}/frames?quantity=`.

    A range has a curve of 101 values, 0 to 100 % of its duration, by linear interpolation between frames; values next
    to missing samples are missing. Groups have the mean and the standard deviation of these curves. Rows whose modified
    z-score (median and median absolute deviation, Iglewicz and Hoaglin 1993) is over 3.5 in a figure are outliers and
    come first. `warnings` says which clips have no value and why, and which values depend on guesses.

    At most 50,000 rows and 5,000 groups. `npz` has a column of each field of the ranges, `curves` (ranges, 101), and
    arrays of groups: `group_mean`, `group_sd`, `group_count`, and `group_of` each range.
    """
    # Imported here: other operations need no mathematics.
    from mcml_service.actions.measuring.choose_ranges import check_kinds, choose_clips
    from mcml_service.actions.measuring.measure_clips import measure_clips
    from mcml_service.actions.measuring.write_measures import describe_measures, write_measures

    check_kinds(request)
    call.limits.extend(max(_SECONDS, call.settings.query_seconds))
    clips, warnings = choose_clips(call.database, call.queries, request, call.limits)
    bodies = call.queries.caches.bodies

    def check() -> None:
        try:
            call.limits.check()
        except LimitError as error:
            if error.details.get("code") == "query-timeout":
                error.remedy = "Measure fewer clips or quantities at a time; mcml db derive prepares all bodies once."
            raise

    def read_body(tx: Transaction, stored: StoredDocument) -> Body:
        return bodies.read(tx, [cast("Listed", stored)])[0]

    with_curves = request.curves if request.as_ == "json" else request.as_ == "npz" or request.table == "curves"
    with call.database.read() as tx:
        measured = measure_clips(tx, read_body, clips, request, check, with_curves=with_curves)
    measured.warnings[:0] = warnings
    if request.as_ == "json":
        return describe_measures(measured, request.limit, with_curves=request.curves)
    name = "measures" if request.as_ == "npz" or request.table == "ranges" else f"measures-{request.table}"
    content = write_measures(measured, request.as_, request.table, raw=request.raw)
    return Content(content, TYPES[request.as_], f"{name}.{request.as_}")
