"""A fit as the parts of a stored result: the model, and data for people.

A table has data `columns` (name, unit) and `rows`; a curve has `x` and `y` (name, unit) and arrays of these names.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from mcml.motion.skeleton import Array
from mcml_service.analysis.interface import Part, Parts
from mcml_service.analysis.reach_blending.accuracy import Errors
from mcml_service.analysis.reach_blending.attribute_space import duplicates
from mcml_service.analysis.reach_blending.blend import Choice
from mcml_service.analysis.reach_blending.evaluation import Prediction, own_prediction, predictions, reconstruction
from mcml_service.analysis.reach_blending.fit import Fitted
from mcml_service.analysis.reach_blending.options import Options
from mcml_service.analysis.reach_blending.stored import to_arrays, to_values

MILLIMETRES = 1000.0


def parts_of(fitted: Fitted, options: Options) -> Parts:
    """All parts of the result of a fit."""
    errors = predictions(fitted)
    own = reconstruction(fitted)
    model = fitted.model
    parts = {
        "model": Part(
            "model", {"model": to_values(model), "summary": _summary(fitted, options, own, errors)}, to_arrays(model)
        ),
        "clips": _clips(fitted),
        "speed": _speed(fitted),
        "variance": _variance(fitted.components.cumulative(), "eigenmotions"),
        "errors": _errors(fitted, own, errors),
        "selection": _selection(fitted),
        "attributes": _attributes(fitted),
    }
    if fitted.pose_shares.size:
        parts["pose_variance"] = _variance(fitted.pose_shares.mean(axis=0), "eigenposes", each=fitted.pose_shares)
    return parts


def plain(value: float) -> float | None:
    """Return a number for JSON: null without one."""
    return float(value) if math.isfinite(value) else None


def _table(columns: Sequence[tuple[str, str]], rows: Sequence[Sequence[Any]]) -> Part:
    heads = [{"name": name, "unit": unit} for name, unit in columns]
    return Part("table", {"columns": heads, "rows": [list(row) for row in rows]})


def _hand_unit(fitted: Fitted) -> tuple[float, str]:
    metres = fitted.model.metres
    return (1.0, "unit") if metres is None else (metres * MILLIMETRES, "mm")


def _measures(fitted: Fitted, errors: Errors) -> list[float | None]:
    factor, _ = _hand_unit(fitted)
    return [
        plain(errors.joints),
        plain(errors.phase_joint),
        plain(errors.hand * factor),
        plain(errors.contact * factor),
    ]


def _summary(fitted: Fitted, options: Options, own: Errors, errors: Sequence[Prediction]) -> dict[str, Any]:
    model, selected = fitted.model, fitted.selected
    mean = fitted.times.mean(axis=0)
    _, hand_unit = _hand_unit(fitted)
    alike = duplicates(model.attribute_space.coordinates(model.attributes))
    names = [source.name for source in model.sources]
    return {
        "method": options.method,
        "space": options.space,
        "attribute_space": options.scaling,
        "used": len(fitted.clips),
        "excluded": len(fitted.excluded),
        "examples": len(selected.groups),
        "subjects": len({source.subject for source in model.sources}),
        "joints": len(model.skeleton),
        "phase_joint": model.skeleton.joints[fitted.body.phase_joint].name,
        "hand_joint": model.skeleton.joints[fitted.body.hand].name,
        "knots": {"t1": model.knots[0], "t2": model.knots[1], "end": model.knots[2], "samples": model.knots[2] + 1},
        "mean_times": {
            name: {"seconds": float(value) / model.base_fps, "frames": float(value)}
            for name, value in zip(("t1", "t2", "end"), mean, strict=True)
        },
        "components": len(model.basis),
        "variance": plain(float(fitted.components.cumulative()[: len(model.basis)][-1])) if len(model.basis) else None,
        "pose_variance": plain(float(fitted.pose_shares[:, -1].mean())) if fitted.pose_shares.size else None,
        "choose_by": options.choose_by,
        "s": selected.s,
        "lam": selected.lam,
        "condition": plain(selected.condition),
        "time_s": selected.time_s,
        "time_lam": selected.time_lam,
        "time_condition": plain(selected.time_condition),
        "hand_unit": hand_unit,
        "reconstruction": _name_values(_measures(fitted, own)),
        "left_out": [
            {
                "left_out": prediction.left_out,
                "predictor": prediction.predictor,
                **_name_values(_measures(fitted, prediction.errors)),
                "times": dict(zip(("t1", "t2", "end"), map(plain, prediction.times.tolist()), strict=True)),
                "clips": prediction.errors.clips,
            }
            for prediction in errors
        ],
        "attributes": [
            {
                "name": name,
                "unit": unit,
                "mean": float(model.attribute_space.mean[place]),
                "deviation": float(model.attribute_space.scale[place]),
                "least": float(model.attributes[:, place].min()),
                "greatest": float(model.attributes[:, place].max()),
                "gaps": [list(gap) for gap in model.gaps[place]],
            }
            for place, (name, unit) in enumerate(zip(model.names, model.units, strict=True))
        ],
        "equal_attributes": [[names[row] for row in group] for group in alike],
        "warnings": [{"code": code, "what": text} for code, text in fitted.warnings],
    }


def _name_values(measures: Sequence[float | None]) -> dict[str, float | None]:
    return dict(zip(("joint_degrees", "phase_joint_degrees", "hand", "hand_at_contact"), measures, strict=True))


def _clips(fitted: Fitted) -> Part:
    """List every clip: used ones with phases, then excluded ones with reasons."""
    model = fitted.model
    columns = [
        *(("document", ""), ("revision", ""), ("name", ""), ("subject", ""), ("used", ""), ("reason", ""), ("why", "")),
        *zip(model.names, model.units, strict=True),
        *((f"{name}_seconds", "s") for name in ("t1", "t2", "end")),
        *((f"{name}_frames", "frames") for name in ("t1", "t2", "end")),
        *(("fps", "1/s"), ("peak_speed", "rad/s"), ("flags", "")),
    ]
    rows: list[list[Any]] = []
    for clip, source in zip(fitted.clips, model.sources, strict=True):
        times, fps = clip.phases.times, clip.motion.fps
        rows.append(
            [source.document, source.revision, source.name, source.subject, True, None, None]
            + clip.attributes.tolist()
            + [time / fps for time in times]
            + list(times)
            + [fps, clip.phases.peak, list(clip.phases.flags)]
        )
    empty = len(columns) - 7
    for left in fitted.excluded:
        motion = left.motion
        rows.append(
            [motion.document, motion.revision, motion.name, None, False, left.code, left.reason]
            + [None] * (empty - 3)
            + [motion.fps, None, []]
        )
    return _table(columns, rows)


def _speed(fitted: Fitted) -> Part:
    """Return the speeds of all clips end to end, including excluded ones; `first` has the start of each."""
    speeds = [clip.speed for clip in fitted.clips] + [left.speed for left in fitted.excluded]
    arms = [clip.arm for clip in fitted.clips] + [np.zeros((len(left.speed), 3)) for left in fitted.excluded]
    documents = [clip.motion.document for clip in fitted.clips] + [left.motion.document for left in fitted.excluded]
    first = np.concatenate([[0], np.cumsum([len(speed) for speed in speeds])]).astype(np.int64)
    data = {"x": {"name": "frame", "unit": ""}, "y": {"name": "speed", "unit": "rad/s"}, "documents": documents}
    return Part("curve", data, {"speed": np.concatenate(speeds), "components": np.concatenate(arms), "first": first})


def _variance(cumulative: Array, what: str, each: Array | None = None) -> Part:
    data = {"x": {"name": "components", "unit": what}, "y": {"name": "cumulative", "unit": ""}}
    arrays = {"components": np.arange(1, len(cumulative) + 1), "cumulative": np.asarray(cumulative)}
    return Part("curve", data, arrays if each is None else {**arrays, "each": each})


def _errors(fitted: Fitted, own: Errors, errors: Sequence[Prediction]) -> Part:
    _, hand_unit = _hand_unit(fitted)
    columns = [
        *(("left_out", ""), ("predictor", ""), ("joint", "degree"), ("phase_joint", "degree")),
        *(("hand", hand_unit), ("hand_at_contact", hand_unit)),
        *((name, "frames") for name in ("t1", "t2", "end")),
        ("clips", ""),
    ]
    of_examples = own_prediction(fitted)
    rows: list[list[Any]] = [
        ["nothing", "components", *_measures(fitted, own), None, None, None, own.clips],
        ["nothing", "model", *_measures(fitted, of_examples), None, None, None, of_examples.clips],
    ]
    for prediction in errors:
        times = [plain(value) for value in prediction.times.tolist()]
        rows.append(
            [
                prediction.left_out,
                prediction.predictor,
                *_measures(fitted, prediction.errors),
                *times,
                prediction.errors.clips,
            ]
        )
    return _table(columns, rows)


def _selection(fitted: Fitted) -> Part:
    """The widths and ridges tried: error of left-out coefficients, or of the hand in the clips' unit, and of times in
    frames; null where skipped.
    """
    rows: list[list[Any]] = []
    for of, choice in (("motion", fitted.selected.choice), ("times", fitted.selected.time_choice)):
        rows += [[of, s, lam, plain(condition), plain(error)] for s, lam, condition, error in _list_trials(choice)]
    return _table([("of", ""), ("s", ""), ("lam", ""), ("condition", ""), ("error", "")], rows)


def _list_trials(choice: Choice | None) -> Sequence[tuple[float, float, float, float]]:
    return choice.tried if choice else ()


def _attributes(fitted: Fitted) -> Part:
    """Return the places of the clips: attributes (N, A), coordinates (N, d), and the coefficients (N, K) of their
    motions.
    """
    model = fitted.model
    data = {
        "names": list(model.names),
        "units": list(model.units),
        "documents": [source.document for source in model.sources],
        "subjects": [source.subject for source in model.sources],
    }
    arrays = {
        "attributes": model.attributes,
        "coordinates": model.attribute_space.coordinates(model.attributes),
        "coefficients": fitted.components.coefficients,
    }
    return Part("points", data, arrays)
