"""Gait of many trials: strides of a subject count together, and no trial is measured twice."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mcml_schemas.analyses.gait import GaitParameters
from mcml_service.analysis.gait import analyses
from mcml_service.analysis.gait.analyses import run_gait
from mcml_service.analysis.interface import Part, Parts, silent
from tests.analysis.gait.walks import Walk
from tests.laboratory.walkers import Gait

ANNA, BEN = {"subject": ("Anna", "")}, {"subject": (" Ben ", "")}
WALKS = [
    Walk("1", Gait(), ANNA),
    Walk("2", Gait(stride_time=1.3), ANNA),
    Walk("3", Gait(stride_time=0.95, speed=1.5), BEN),
    Walk("4", Gait(late=0.46)),
    Walk("5", Gait(late=0.46)),
    Walk("6", None, ANNA),
]


@pytest.fixture(scope="module")
def parts() -> Parts:
    return run_gait(WALKS, GaitParameters(), silent)


def rows_of(part: Part) -> list[dict[str, Any]]:
    names = [each["name"] for each in part.data["columns"]]
    return [dict(zip(names, row, strict=True)) for row in part.data["rows"]]


def test_strides_of_a_subject_count_together(parts: Parts) -> None:
    lengths = [
        stride.stride_length
        for walk in WALKS[:2]
        for gait in [walk.measure("auto").gait]
        if gait is not None
        for stride in gait.strides
        if stride.side == "left"
    ]
    anna = rows_of(parts["subjects"])[0]
    assert (anna["subject"], anna["side"], anna["trials"], anna["strides"]) == ("Anna", "left", 2, len(lengths))
    assert anna["stride_length"] == pytest.approx(np.mean(lengths))
    assert anna["stride_length_sd"] == pytest.approx(np.std(lengths, ddof=1))
    assert {"name": "stride_length_sd", "unit": "m"} in parts["subjects"].data["columns"]


def test_each_trial_has_a_row_for_each_side(parts: Parts) -> None:
    rows = rows_of(parts["trials"])
    assert [(row["document"], row["side"]) for row in rows[:4]] == [
        ("1", "left"), ("1", "right"), ("2", "left"), ("2", "right")
    ]  # fmt: skip
    assert rows[0]["stride_time"] == pytest.approx(1.1)
    assert rows[4]["subject"] == "Ben"
    assert {row["document"] for row in rows} == set("12345")


def test_trials_without_a_subject_are_kept_apart(parts: Parts) -> None:
    """Also where their names are equal."""
    others = [row for row in rows_of(parts["subjects"]) if row["subject"].startswith("walk")]
    assert [row["trials"] for row in others] == [1, 1, 1, 1]
    warnings = rows_of(parts["warnings"])
    assert warnings[0]["warning"] == "2 clips have no property subject: each counts as a person of its own"
    assert {"document": "6", "name": "walk 6", "measured": False, "warning": "it has no feet"} in warnings


def test_asymmetry_shows(parts: Parts) -> None:
    rows = {row["subject"]: row for row in rows_of(parts["symmetry"])}
    assert abs(rows["Anna"]["step_time"]) < 1
    assert abs(rows["walk 4"]["step_time"]) > 5


def test_trials_are_measured_once_and_progress_is_told_of_each() -> None:
    walks, shares = [Walk("1", Gait()), Walk("2", Gait())], list[float]()
    run_gait(walks, GaitParameters(), lambda stage, share: shares.append(share))
    assert [walk.measured for walk in walks] == [1, 1]
    assert shares == [0.0, 0.5, 1.0]


def test_long_tables_are_cut_and_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(analyses, "LISTED", 3)
    trials = run_gait([Walk("1", Gait()), Walk("2", Gait())], GaitParameters(), silent)["trials"]
    assert len(trials.data["rows"]) == 3
    assert trials.data["left_out"] == 1
