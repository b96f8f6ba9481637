"""Gait of many trials: parameters by trial, side and subject. Specification: docs/analyses/gait.md."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from mcml.laboratory.gait_events import SIDES
from mcml.laboratory.gait_parameters import PARAMETERS, symmetry
from mcml.laboratory.gait_trials import Group, Trial
from mcml_schemas.analyses.gait import GaitParameters
from mcml_service.analysis.interface import Analysis, Part, PartInfo, Parts, Progress, TrialSource

LISTED = 20_000
"""Limit of rows in a table; omitted rows are counted."""

_MEASURES = [(parameter.name, parameter.unit) for parameter in PARAMETERS]
_MEANS = [column for name, unit in _MEASURES for column in ((name, unit), (f"{name}_sd", unit))]

Columns = Sequence[tuple[str, str]]


def run_gait(sources: Sequence[TrialSource], parameters: GaitParameters, progress: Progress) -> Parts:
    """Measure one trial after the other, then pool the strides of each subject."""
    groups: dict[tuple[str, str], list[Trial]] = {}
    trials: list[list[Any]] = []
    unnamed = 0
    for number, source in enumerate(sources):
        progress("measuring gait", number / len(sources))
        trial = source.measure(parameters.events)
        subject = source.properties.get(parameters.subject, ("", ""))[0].strip()
        unnamed += not subject
        # A clip without a subject has a group of its own: two may have the same name.
        groups.setdefault((subject, "" if subject else trial.document), []).append(trial)
        about = [trial.document, trial.name, subject]
        trials += [[*about, side, *_means(Group((trial,), {}), side)] for side in SIDES if trial.gait is not None]
    subjects = [(subject or group[0].name, Group(tuple(group), {})) for (subject, _), group in groups.items()]
    subjects.sort(key=lambda item: item[0])
    progress("done", 1.0)
    return {
        "trials": _table([("document", ""), ("name", ""), ("subject", ""), ("side", ""), *_list_columns()], trials),
        "subjects": _table(
            [("subject", ""), ("side", ""), ("trials", ""), *_list_columns()],
            [[name, side, _count(group), *_means(group, side)] for name, group in subjects for side in SIDES],
        ),
        "symmetry": _table(
            [("subject", ""), *((name, "%") for name, _ in _MEASURES)],
            [[name, *_symmetries(group)] for name, group in subjects],
        ),
        "warnings": _table(
            [("document", ""), ("name", ""), ("measured", ""), ("warning", "")],
            [*_warn_of_subjects(unnamed, parameters.subject), *_warnings(subjects)],
        ),
    }


def _list_columns() -> Columns:
    return [("strides", ""), *_MEANS]


def _count(group: Group) -> int:
    """Number of trials that could be measured."""
    return sum(trial.gait is not None for trial in group.trials)


def _means(group: Group, side: Any) -> list[Any]:
    """Number of strides of a side, then mean and standard deviation of each parameter."""
    strides = sum(stride.side == side and not stride.rejected for stride in group.strides)
    summaries = [group.summary(side, name) for name, _ in _MEASURES]
    return [strides, *(_value_or_none(value) for summary in summaries for value in (summary.mean, summary.sd))]


def _symmetries(group: Group) -> list[float | None]:
    means = [[group.summary(side, name).mean for side in SIDES] for name, _ in _MEASURES]
    return [_value_or_none(symmetry(left, right)) for left, right in means]


def _warn_of_subjects(unnamed: int, name: str) -> Iterator[list[Any]]:
    if unnamed:
        yield ["", "", True, f"{unnamed} clips have no property {name}: each counts as a person of its own"]


def _warnings(subjects: Sequence[tuple[str, Group]]) -> Iterator[list[Any]]:
    for _, group in subjects:
        for trial in group.trials:
            for warning in trial.warnings:
                yield [trial.document, trial.name, trial.gait is not None, warning]


def _value_or_none(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _table(columns: Columns, rows: Sequence[list[Any]]) -> Part:
    data: dict[str, Any] = {
        "columns": [{"name": name, "unit": unit} for name, unit in columns],
        "rows": list(rows[:LISTED]),
    }
    if len(rows) > LISTED:
        data["left_out"] = len(rows) - LISTED
    return Part("table", data)


GAIT = Analysis(
    name="gait",
    title="Gait parameters",
    description="Spatio-temporal parameters of any number of trials, by trial and side, and pooled by subject.",
    parameters=GaitParameters,
    parts={
        "trials": PartInfo("table", "Number of strides, mean and standard deviation of each parameter by trial, side"),
        "subjects": PartInfo("table", "The same of all strides of a subject"),
        "symmetry": PartInfo("table", "Symmetry index of each parameter by subject (Robinson 1987)"),
        "warnings": PartInfo("table", "Why values are less sure, and which trials could not be measured"),
    },
    run=run_gait,
    reads="trials",
    rules={"gait": "1"},
)
