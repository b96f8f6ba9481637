"""The catalogue entry: parameters, parts that survive storage, operations."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from mcml_schemas.analyses.reach import ReachClipChoice, ReachMotion, ReachParameters, ReachPhases, ReachWish
from mcml_service.analysis.interface import AnalysisError, Part, Parts, silent
from mcml_service.analysis.reach_blending.analyses import REACH, options_from
from mcml_service.analysis.reach_blending.evaluation import reconstruction
from mcml_service.analysis.reach_blending.time_normalisation import PAPER_KNOTS
from tests.analysis.reach.reach_motions import FEW, fitted, generated, labelled

WISH = ReachWish(attributes={"age": 25, "height": 168, "hbp": 270})


@cache
def result(method: str = "robust", **stated: Any) -> Parts:
    parameters = ReachParameters(method=method, duplicates="mean" if method == "paper" else None, **stated)  # type: ignore[arg-type]
    return REACH.run(generated()[0], parameters, silent)


def stored(parts: Parts) -> Parts:
    """The parts as a store gives them back."""
    return {
        name: Part(part.kind, json.loads(json.dumps(part.data, allow_nan=False)), dict(part.arrays))
        for name, part in parts.items()
    }


@pytest.mark.parametrize("stated", [{}, {"method": "paper"}, {"space": "global"}])
def test_a_stored_model_makes_the_same_motions(stated: dict[str, str]) -> None:
    parts = result(**stated)
    fresh = REACH.operations["synthesize"].run(REACH.prepare(parts), WISH)
    again = REACH.operations["synthesize"].run(REACH.prepare(stored(parts)), WISH)
    assert fresh.value == again.value
    assert fresh.clip is not None
    assert again.clip is not None
    assert np.array_equal(fresh.clip.rotations, again.clip.rotations)
    assert np.array_equal(fresh.clip.translations, again.clip.translations)
    assert fresh.clip.skeleton == again.clip.skeleton


@pytest.mark.parametrize("stated", [{}, {"method": "paper"}, {"space": "global"}])
def test_parts_are_those_announced(stated: dict[str, str]) -> None:
    parts = result(**stated)
    for name, part in parts.items():
        assert REACH.parts[name].kind == part.kind
    absent = set(REACH.parts) - set(parts)
    assert absent == (set() if stated else {"pose_variance"})


def test_tables_are_tables() -> None:
    for name, part in result().items():
        if part.kind == "table":
            assert part.data["rows"], name
            assert all(len(row) == len(part.data["columns"]) for row in part.data["rows"])


def test_the_summary_says_what_was_fitted() -> None:
    summary = result().get("model").data["summary"]  # type: ignore[union-attr]
    assert summary["used"] == sum(map(sum, FEW))
    assert summary["excluded"] == 0
    assert summary["subjects"] == 10
    assert summary["components"] == 10
    assert summary["hand_unit"] == "mm"
    ways = {(way["left_out"], way["predictor"]) for way in summary["left_out"]}
    assert ways == {(left, way) for left in ("clip", "subject") for way in ("model", "linear", "nearest")}
    assert summary["attributes"][0]["name"] == "age"
    assert [29.0, 60.0] not in summary["attributes"][1]["gaps"]
    assert all(low <= 30 and high >= 59 for low, high in summary["attributes"][0]["gaps"][:1])


def test_hands_are_measured_in_millimetres_where_the_unit_is_known() -> None:
    own = reconstruction(fitted()).hand
    summary = result()["model"].data["summary"]
    assert summary["reconstruction"]["hand"] == pytest.approx(10 * own)
    rows = result()["errors"].data["rows"]
    assert rows[0][4] == pytest.approx(10 * own)
    unknown = [replace(motion, metres=None) for motion in generated()[0]]
    summary = REACH.run(unknown, ReachParameters(), silent)["model"].data["summary"]
    assert summary["hand_unit"] == "unit"
    assert summary["reconstruction"]["hand"] == pytest.approx(own)


def test_a_stored_model_remembers_directions_that_were_left_out() -> None:
    motions = [
        replace(motion, properties={**motion.properties, "double": (str(2 * float(motion.properties["age"][0])), "")})
        for motion in generated()[0]
    ]
    parts = REACH.run(motions, ReachParameters(attributes=["age", "double", "hbp"]), silent)
    wish = ReachWish(attributes={"age": 25, "double": 90, "hbp": 270})
    answer = REACH.operations["synthesize"].run(REACH.prepare(stored(parts)), wish).value
    assert isinstance(answer, ReachMotion)
    assert "attributes-off-plane" in [warning.code for warning in answer.warnings]


def test_answers_tell_of_trust() -> None:
    answer = REACH.operations["synthesize"].run(REACH.prepare(result()), WISH)
    value = answer.value
    assert isinstance(value, ReachMotion)
    assert value.support == "inside"
    assert value.frames == len(answer.clip.rotations)  # type: ignore[union-attr]
    assert 0 < value.t1.seconds < value.t2.seconds < value.end.seconds
    assert value.t1.frames == pytest.approx(value.t1.seconds * value.fps)
    assert len(value.weights) == 10
    assert len(value.speed) == value.frames
    assert value.t1.frames < int(np.argmax(value.speed)) < value.t2.frames
    assert value.attributes == WISH.attributes


def test_phases_of_a_clip_used_and_of_one_left_out() -> None:
    motions = list(generated()[0])
    motions[4] = labelled(motions[4], age="")
    ready = REACH.prepare(stored(REACH.run(motions, ReachParameters(), silent)))
    phases = REACH.operations["phases"]
    value = phases.run(ready, ReachClipChoice(document=motions[3].document)).value
    assert isinstance(value, ReachPhases)
    assert value.used
    assert len(value.speed) == len(value.components) == len(motions[3])
    assert value.t2 is not None
    assert value.t2.frames == pytest.approx(generated()[1][3].times[1], abs=2)
    left = phases.run(ready, ReachClipChoice(document=motions[4].document)).value
    assert isinstance(left, ReachPhases)
    assert (left.used, left.reason, left.t1) == (False, "missing-attribute", None)
    assert len(left.speed) == len(motions[4])
    with pytest.raises(AnalysisError) as error:
        phases.run(ready, ReachClipChoice(document="nothing"))
    assert error.value.code == "unknown-clip"


def test_methods_are_sets_of_options() -> None:
    robust, paper = (options_from(ReachParameters(method=method)) for method in ("robust", "paper"))
    assert (robust.space, robust.scaling, robust.knots, robust.lam, robust.log_times) == (
        "tangent",
        "whiten",
        None,
        None,
        True,
    )
    assert (paper.space, paper.scaling, paper.knots, paper.lam, paper.log_times) == (
        "eigenposes",
        "rotate",
        PAPER_KNOTS,
        0.0,
        False,
    )
    mixed = options_from(ReachParameters(method="paper", space="tangent", lam=0.5, subject=None))
    assert (mixed.space, mixed.lam, mixed.scaling, bool(mixed.subject)) == ("tangent", 0.5, "rotate", False)


@pytest.mark.parametrize(
    "wrong",
    [
        {"method": "best"},
        {"components": 0},
        {"variance": 1.5},
        {"s": 0},
        {"lam": -1},
        {"s": float("nan")},
        {"attributes": []},
        {"colour": "red"},
    ],
)
def test_wrong_parameters_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        ReachParameters(**wrong)


def test_knots_have_to_be_in_order() -> None:
    with pytest.raises(AnalysisError) as error:
        options_from(ReachParameters(knots=(5, 5, 49)))
    assert error.value.code == "knot-order"


@pytest.mark.parametrize("model", [ReachParameters, ReachWish, ReachMotion, ReachPhases, ReachClipChoice])
def test_every_field_is_described(model: Any) -> None:
    for name, field in model.model_fields.items():
        assert field.description, name
    shown = model.model_config["json_schema_extra"]["examples"][0]
    model.model_validate(shown)


def test_one_attribute_of_any_name_will_do() -> None:
    motions = [labelled(motion, reach=str(place % 7)) for place, motion in enumerate(generated()[0])]
    parts = REACH.run(motions, ReachParameters(attributes=["reach"], subject=None), silent)
    answer = REACH.operations["synthesize"].run(REACH.prepare(parts), ReachWish(attributes={"reach": 2.5}))
    assert isinstance(answer.value, ReachMotion)
    assert answer.value.in_hull
    assert {way["left_out"] for way in parts["model"].data["summary"]["left_out"]} == {"clip"}
