"""Errors of a fitted model: from omitted components, and for new clips and people."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from mcml.motion.skeleton import Array
from mcml_service.analysis.reach_blending.accuracy import Errors, errors_of
from mcml_service.analysis.reach_blending.blend import Groups, invert, leave_out, linear_left_out, nearest_left_out
from mcml_service.analysis.reach_blending.durations import from_time_values
from mcml_service.analysis.reach_blending.fit import Fitted

Predictor = Literal["model", "linear", "nearest"]
LeftOut = Literal["clip", "subject"]


@dataclass(frozen=True)
class Prediction:
    """Errors of one method of predicting left-out clips.

    times: (3,) mean absolute differences of t1, t2, end, in frames at base_fps.
    """

    left_out: LeftOut
    predictor: Predictor
    errors: Errors
    times: Array


def reconstruction(fitted: Fitted) -> Errors:
    """Errors of the clips themselves, from their K coefficients."""
    return _errors(fitted, fitted.components.coefficients)


def own_prediction(fitted: Fitted) -> Errors:
    """Errors of the model's own motions at the attributes of its clips, of which none is left out."""
    return _errors(fitted, fitted.model.coefficients(fitted.selected.centres)[fitted.model.example_of])


def predictions(fitted: Fitted) -> list[Prediction]:
    """Return the errors for each clip, and for each subject's clips if subjects are known, when left out.

    The components stay those of all clips; a full refit is about 4 % higher.
    """
    selected = fitted.selected
    ways: list[tuple[LeftOut, Groups]] = [("clip", selected.alone)]
    if selected.subjects:
        ways.append(("subject", selected.subjects))
    x, degree = selected.centres, fitted.model.coefficients.degree
    inverse = invert(x, selected.s, selected.lam, degree)
    time_inverse = invert(x, selected.time_s, selected.time_lam, degree)
    made = []
    for left, groups in ways:
        if not groups:
            continue
        both = selected.coefficients, selected.time_values
        tries: list[tuple[Predictor, list[Array]]] = [
            ("model", [leave_out(inverse, both[0], groups), leave_out(time_inverse, both[1], groups)]),
            ("linear", [linear_left_out(x, y, degree, groups) for y in both]),
            ("nearest", [nearest_left_out(x, y, groups) for y in both]),
        ]
        for name, (of_examples, of_times) in tries:
            coefficients = of_examples[fitted.model.example_of]
            values = of_times[fitted.model.example_of]
            times = from_time_values(values, fitted.model.log_times)
            missed = np.abs(times - fitted.times)
            made.append(Prediction(left, name, _errors(fitted, coefficients), np.nanmean(missed, axis=0)))
    return made


def _errors(fitted: Fitted, coefficients: Array) -> Errors:
    model = fitted.model
    rows = np.asarray(np.isfinite(coefficients).all(axis=1))
    return errors_of(
        model.motion_space,
        lambda part: model.mean + coefficients[part] @ model.basis,
        fitted.sampled,
        fitted.ruler,
        rows,
    )
