"""Results of retargeting as answers: of one document, and tables of many."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

import numpy as np

from mcml.motion.retargeting.retarget import Retargeted as Result
from mcml.motion.skeleton import Skeleton
from mcml_schemas.retarget import (
    BoneError,
    ClampedJoint,
    FootSliding,
    FrameSpan,
    HandContact,
    JointMatch,
    PartError,
    Retargeted,
    RetargetedOne,
    RetargetRow,
    RetargetTable,
)
from mcml_service.cells import safe_cell

_COLUMNS = ("limbs", "hips", "shoulders", "trunk", "head", "foot_slide")
_LEAST = 1.0
"""Degrees, or centimetres a second: smaller deviations of a column are no outliers."""
_NORMAL = 1.4826
"""Standard deviations of a normal distribution in its median absolute deviation."""
_HEADINGS = (
    *("name", "source", "document"),
    *(f"{name} (deg)" for name in _COLUMNS[:-1]),
    *("foot_slide (cm/s)", "deviation", "warnings", "problem"),
)


def describe_retargeted(
    document: str | None, made: Result, source: Skeleton, target: Skeleton, notices: list[str]
) -> Retargeted:
    """Describe a result. document: the new one, if it was stored. notices: more of them, which come first."""
    report = made.report
    found = [*report.notices(source, target), *made.shortfall.notices(target)]
    worst = max((bone for bone in report.bones if bone.leads), key=lambda bone: bone.largest, default=None)
    return Retargeted(
        document=document,
        frames=len(made.block),
        scale=report.scale,
        matches=[
            JointMatch(
                source=source.names[match.source],
                target=target.names[match.target],
                confidence=match.confidence,
                reason=match.reason,
            )
            for match in report.matches
        ],
        unmatched_source=[source.names[index] for index in report.missing],
        unmatched_target=[target.names[index] for index in report.extra],
        bones=[
            BoneError(
                bone=target.names[bone.joint],
                end=target.names[bone.end],
                leads=bone.leads,
                mean=bone.mean,
                largest=bone.largest,
                frame=bone.frame + 1,
            )
            for bone in report.bones
        ],
        feet=[
            FootSliding(
                foot=target.names[foot.joint],
                stances=len(foot.contacts),
                before=foot.before,
                after=foot.after,
                contacts=[FrameSpan(first=first + 1, last=last + 1) for first, last in foot.contacts],
            )
            for foot in report.feet
        ],
        parts=[
            PartError(
                part=part.what,
                joint=target.names[part.joint],
                mean=part.mean,
                largest=part.largest,
                frame=part.frame + 1,
            )
            for part in report.parts
        ],
        clamped=[
            ClampedJoint(
                joint=target.names[each.joint],
                frames=sum(last - first + 1 for first, last in each.spans),
                largest=each.largest,
                spans=[FrameSpan(first=first + 1, last=last + 1) for first, last in each.spans],
            )
            for each in report.clamped
        ],
        hands=[
            HandContact(
                hand=target.names[each.hand],
                other=target.names[each.other],
                first=each.first + 1,
                last=each.last + 1,
                before=each.before,
                after=each.after,
            )
            for each in report.hands
        ],
        worst_frame=None if worst is None else worst.frame + 1,
        warnings=[notice.what for notice in found if notice.kind == "warning"],
        notices=notices + [notice.what for notice in found],
    )


def retarget_table(items: Iterable[RetargetedOne]) -> RetargetTable:
    """Return a table of results: problems first, then rows by how far a value is above the median of its column.

    Deviations are in robust standard deviations (Iglewicz and Hoaglin, "How to detect and handle outliers", 1993).
    """
    rows = [_row_of(item) for item in items]
    deviations = _deviations([row for row in rows if row.problem is None])
    for row, deviation in zip([row for row in rows if row.problem is None], deviations, strict=True):
        row.deviation = deviation
    rows.sort(key=lambda row: (row.problem is None, -(row.deviation or 0.0), -(row.limbs or 0.0), row.name))
    failed = sum(row.problem is not None for row in rows)
    return RetargetTable(rows=rows, made=len(rows) - failed, failed=failed)


def table_csv(table: RetargetTable, *, raw: bool = False) -> str:
    """The table as CSV. raw: do not escape names that spreadsheets read as formulas."""
    shown = str if raw else safe_cell
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(_HEADINGS)
    for row in table.rows:
        numbers = [getattr(row, name) for name in (*_COLUMNS, "deviation")]
        cells = ["" if value is None else f"{value:.4g}" for value in numbers]
        words = [shown("; ".join(row.warnings)), shown(row.problem or "")]
        writer.writerow([shown(row.name), row.source, row.document or "", *cells, *words])
    return text.getvalue()


def _row_of(item: RetargetedOne) -> RetargetRow:
    row = RetargetRow(source=item.source, name=item.name, warnings=[])
    if item.made is None:
        problem = item.problem
        row.problem = "" if problem is None else f"{problem.detail} {problem.remedy or ''}".rstrip()
        return row
    means: dict[str, float] = {part.part: part.mean for part in item.made.parts}
    limbs = [mean for part, mean in means.items() if part.endswith((" arm", " leg"))]
    return row.model_copy(
        update={
            "document": item.made.document,
            "limbs": max(limbs, default=None),
            **{name: means.get(name) for name in _COLUMNS[1:-1]},
            "foot_slide": item.made.foot_slide,
            "warnings": item.made.warnings,
        }
    )


def _deviations(rows: Sequence[RetargetRow]) -> list[float]:
    """For each row the largest deviation above the median of a column; 0 where none is above."""
    if not rows:
        return []
    values = np.array([[getattr(row, name) for name in _COLUMNS] for row in rows], dtype=np.float64)
    known = np.isfinite(values).any(axis=0)
    values = values[:, known]
    middle = np.nanmedian(values, axis=0)
    spread = np.maximum(_NORMAL * np.nanmedian(np.abs(values - middle), axis=0), _LEAST)
    above = np.nan_to_num((values - middle) / spread)
    found: list[float] = np.maximum(above.max(axis=1, initial=0.0), 0.0).round(6).tolist()
    return found
