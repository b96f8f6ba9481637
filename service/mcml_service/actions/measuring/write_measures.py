"""Measured ranges and groups as an answer, as tables, and as arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from mcml.numerics.curves import POINTS
from mcml_schemas.measure import MeanOfRanges, MeasuredGroup, MeasuredRange, Measures, MeasureTable
from mcml_service.actions.exporting.write_tables import About, Batches, batches_of, npy_of, npz_blocks, write_table
from mcml_service.actions.measuring.measure_clips import (
    FIGURES,
    Measured,
    RangeFigures,
    RangeGroup,
    side_of,
    summarise_group,
)
from mcml_service.actions.reading.read_gait import value_or_none

MOST_GROUPS_SHOWN = 500

_TEXT, _WHOLE, _NUMBER = "string", "int64", "float64"
_PLACE = {"document": _TEXT, "name": _TEXT, "project": _TEXT, "revision": _WHOLE, "quantity": _TEXT, "unit": _TEXT}
_RANGE = {"label": _TEXT, "side": _TEXT, "first": _WHOLE, "last": _WHOLE, "start": _NUMBER, "seconds": _NUMBER}
_FIGURES = {
    "missing": _WHOLE, **dict.fromkeys(("minimum", "maximum", "mean", "sd", "range"), _NUMBER), "max_frame": _WHOLE,
    "max_time": _NUMBER, "score": _NUMBER, "score_of": _TEXT, "outlier": "bool",
}  # fmt: skip
_POINT = {"percent": _WHOLE, "value": _NUMBER}
_GROUP = {"quantity": _TEXT, "unit": _TEXT, "ranges": _WHOLE, "documents": _WHOLE, "outliers": _WHOLE}
_MEANS = {f"{name}_{what}": _NUMBER for name in FIGURES for what in ("mean", "sd")}
_MEAN_POINT = {"percent": _WHOLE, "count": _WHOLE, "mean": _NUMBER, "sd": _NUMBER}


def describe_measures(measured: Measured, limit: int, *, with_curves: bool) -> Measures:
    """The first rows and groups as an answer, with a warning where more are left out."""
    warnings = list(measured.warnings)
    if len(measured.rows) > limit:
        rest = len(measured.rows) - limit
        warnings.append(f"The last {rest:,} of {len(measured.rows):,} rows are not shown; a table (as=csv) has all.")
    if len(measured.groups) > MOST_GROUPS_SHOWN:
        count = len(measured.groups)
        warnings.append(f"{MOST_GROUPS_SHOWN} of {count:,} groups are shown; table=groups with as=csv has all.")
    return Measures(
        ranges=[_describe_range(row, with_curve=with_curves) for row in measured.rows[:limit]],
        groups=[_describe_group(group) for group in measured.groups[:MOST_GROUPS_SHOWN]],
        total_ranges=len(measured.rows),
        total_groups=len(measured.groups),
        documents=measured.documents,
        warnings=warnings,
    )


def _describe_range(row: RangeFigures, *, with_curve: bool) -> MeasuredRange:
    values = {name: _or_none(value) for name, value in zip(_row_types(()), _values(row, ()), strict=True)}
    curve = None if row.curve is None or not with_curve else list(map(value_or_none, row.curve.tolist()))
    return MeasuredRange(**values, group=dict(row.group.values), curve=curve)


def _or_none(value: Any) -> Any:
    return value_or_none(value) if isinstance(value, float) else value


def _describe_group(group: RangeGroup) -> MeasuredGroup:
    figures = {
        name: MeanOfRanges(mean=mean, sd=value_or_none(sd)) for name, (mean, sd) in summarise_group(group).items()
    }
    quantity, unit, ranges, documents, outliers = _counts(group)
    return MeasuredGroup(
        quantity=quantity,
        unit=unit,
        group=dict(group.values),
        ranges=ranges,
        documents=documents,
        outliers=outliers,
        **figures,
        mean_curve=list(map(value_or_none, group.curves.mean.tolist())),
        sd_curve=list(map(value_or_none, group.curves.sd.tolist())),
        count=group.curves.count.tolist(),
    )


def _counts(group: RangeGroup) -> tuple[str, str, int, int, int]:
    documents = len({row.clip.document for row in group.rows})
    outliers = sum(row.is_outlier for row in group.rows)
    return group.quantity.text, group.unit, len(group.rows), documents, outliers


def _own_keys(by: Sequence[str]) -> list[str]:
    """Keys of groups that have no column of their own in the table of ranges."""
    return [key for key in by if key not in ("clip", "label", "side", "project")]


def _row_types(keys: Sequence[str]) -> dict[str, str]:
    return {**_PLACE, **dict.fromkeys(keys, _TEXT), **_RANGE, **_FIGURES}


def _values(row: RangeFigures, keys: Sequence[str]) -> tuple[Any, ...]:
    """The values of `_row_types`; unknown numbers are NaN."""
    clip, place, found, group = row.clip, row.range, row.figures, row.group
    seconds = float("nan") if clip.frame_time is None else clip.frame_time
    greatest = place.first + found.place
    return (
        clip.document, clip.name, clip.project, clip.revision, group.quantity.text, group.unit,
        *(group.values[key] for key in keys),
        place.label, side_of(group.quantity, place), place.first, place.last,
        place.begin * seconds, (place.end - place.begin) * seconds,
        found.missing, found.minimum, found.maximum, found.mean, found.sd, found.range,
        greatest, (greatest - 1) * seconds, row.score, row.score_of, row.is_outlier,
    )  # fmt: skip


def write_measures(measured: Measured, form: str, table: MeasureTable, *, raw: bool) -> Iterator[bytes]:
    """Write all rows. form: csv, arrow or parquet: the table; or npz: all arrays.

    Raises UnsupportedError where a form needs a library that is not installed.
    """
    if form == "npz":
        return npz_blocks({name: partial(npy_of, values) for name, values in _arrays(measured).items()})
    types, rows = _table(measured, table)
    return write_table(form, _batches(rows, types), About(types, raw=raw))


def _batches(rows: Iterator[tuple[Any, ...]], types: Mapping[str, str]) -> Batches:
    """Batches of rows; of no row an empty one, so that tables have their columns."""
    empty = True
    for batch in batches_of(rows, list(types)):
        empty = False
        yield batch
    if empty:
        yield {name: [] for name in types}


def _table(measured: Measured, table: MeasureTable) -> tuple[dict[str, str], Iterator[tuple[Any, ...]]]:
    keys = _own_keys(measured.by)
    if table == "ranges":
        return _row_types(keys), (_values(row, keys) for row in measured.rows)
    if table == "curves":
        place = {**_PLACE, **dict.fromkeys(keys, _TEXT), **_RANGE}
        return {**place, **_POINT}, _points(measured, keys, len(place))
    types = {**_GROUP, **dict.fromkeys(measured.by, _TEXT)}
    return {**types, **_MEANS, **_MEAN_POINT}, _mean_points(measured)


def _points(measured: Measured, keys: Sequence[str], width: int) -> Iterator[tuple[Any, ...]]:
    for row in measured.rows:
        about = _values(row, keys)[:width]
        for percent, value in enumerate([] if row.curve is None else row.curve.tolist()):
            yield *about, percent, value


def _mean_points(measured: Measured) -> Iterator[tuple[Any, ...]]:
    for group in measured.groups:
        figures = [value for pair in summarise_group(group).values() for value in pair]
        about = (*_counts(group), *group.values.values(), *figures)
        curves = (group.curves.count.tolist(), group.curves.mean.tolist(), group.curves.sd.tolist())
        for percent, (count, mean, sd) in enumerate(zip(*curves, strict=True)):
            yield *about, percent, count, mean, sd


def _arrays(measured: Measured) -> dict[str, Any]:
    """Columns of ranges by name, their `curves` (n, 101), and arrays of groups: `group_of` a range is its place."""
    keys = _own_keys(measured.by)
    types = _row_types(keys)
    columns = zip(*(_values(row, keys) for row in measured.rows), strict=True) if measured.rows else [()] * len(types)
    arrays = {name: _column(values, types[name]) for name, values in zip(types, columns, strict=True)}
    places = {id(group): place for place, group in enumerate(measured.groups)}
    groups = measured.groups
    return {
        **arrays,
        "curves": _stack([row.curve for row in measured.rows if row.curve is not None]),
        "percent": np.arange(POINTS),
        "group_of": np.array([places[id(row.group)] for row in measured.rows], np.int64),
        "group_quantity": _column([group.quantity.text for group in groups], _TEXT),
        "group_unit": _column([group.unit for group in groups], _TEXT),
        **{f"group_{key}": _column([group.values[key] for group in groups], _TEXT) for key in measured.by},
        "group_mean": _stack([group.curves.mean for group in groups]),
        "group_sd": _stack([group.curves.sd for group in groups]),
        "group_count": _stack([group.curves.count for group in groups]),
        "warnings": _column(measured.warnings, _TEXT),
    }


def _column(values: Sequence[Any], kind: str) -> Any:
    return np.array(values, dtype={_TEXT: np.str_, _WHOLE: np.int64, _NUMBER: np.float64, "bool": np.bool_}[kind])


def _stack(curves: Sequence[Any]) -> Any:
    return np.stack(curves) if curves else np.empty((0, POINTS))
