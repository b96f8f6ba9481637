"""Every named error and warning, and the clips that bring it about."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mcml.motion.rotations import multiply
from mcml.motion.skeleton import Convention, Skeleton
from mcml_service.analysis.interface import AnalysisError, Motion
from mcml_service.analysis.reach_blending.blend import invert
from mcml_service.analysis.reach_blending.fit import Fitted, fit
from mcml_service.analysis.reach_blending.options import options_of
from mcml_service.analysis.reach_blending.quaternion_tracks import exp
from mcml_service.analysis.reach_blending.synthesis import Wish, synthesize
from tests.analysis.reach.reach_motions import fitted, generated, labelled, on_grid

Change = Callable[[Motion], Motion]
WISH = {"age": 25.0, "height": 168.0, "hbp": 270.0}


def clips() -> list[Motion]:
    return list(generated()[0])


def code_of(motions: list[Motion], method: str = "robust", **options: Any) -> str:
    with pytest.raises(AnalysisError) as error:
        fit(motions, options_of(method, **options))  # type: ignore[arg-type]
    assert error.value.what
    return error.value.code


def excluded(change: Change, **options: Any) -> tuple[str, Fitted]:
    """Why one changed clip is left out of a fit."""
    motions = clips()
    motions[2] = change(motions[2])
    found = fit(motions, options_of(**options))
    assert [left.motion.document for left in found.excluded] == [motions[2].document]
    assert len(found.clips) == len(motions) - 1
    return found.excluded[0].code, found


def still(motion: Motion) -> Motion:
    return replace(motion, rotations=np.repeat(motion.rotations[:1], len(motion), axis=0))


def cut(first: int, last: int) -> Change:
    return lambda motion: replace(
        motion, rotations=motion.rotations[first:last], translations=motion.translations[first:last]
    )


def without_samples(first: int, last: int) -> Change:
    def change(motion: Motion) -> Motion:
        present = np.ones(motion.rotations.shape[:2], dtype=bool)
        present[first:last, 5] = False
        return replace(motion, present=present)

    return change


def with_nan(motion: Motion) -> Motion:
    translations = motion.translations.copy()
    translations[20:40, 0] = np.nan
    return replace(motion, translations=translations)


def with_zero(motion: Motion) -> Motion:
    rotations = motion.rotations.copy()
    rotations[7, 3] = 0.0
    return replace(motion, rotations=rotations)


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (still, "too-slow"),
        (cut(0, 7), "too-few-frames"),
        (cut(25, 60), "peak-at-border"),
        (lambda motion: labelled(motion, hbp=""), "missing-attribute"),
        (lambda motion: labelled(motion, hbp="far"), "attribute-not-a-number"),
        (lambda motion: labelled(motion, age="nan"), "attribute-not-a-number"),
        (lambda motion: labelled(motion, age="inf"), "attribute-not-a-number"),
        (without_samples(10, 20), "missing-samples"),
        (with_nan, "missing-samples"),
        (with_zero, "zero-quaternion"),
    ],
)
def test_bad_clips_are_left_out_with_the_reason_or_refused(change: Change, code: str) -> None:
    if code == "peak-at-border":
        motion = clips()[2]
        place = motion.skeleton.names.index("right_up_arm")
        turns = motion.rotations[:, place]
        peak = int(np.argmin(np.abs(np.sum(turns[1:] * turns[:-1], axis=1)))) + 1
        change = cut(peak, len(motion))
    found, _ = excluded(change)
    assert found == code
    motions = clips()
    motions[2] = change(motions[2])
    assert code_of(motions, on_bad_clip="error") == code


def test_short_gaps_are_filled_and_said() -> None:
    motions = clips()
    motions[2] = without_samples(10, 14)(motions[2])
    found = fit(motions, options_of())
    assert [code for code, _ in found.warnings] == ["gap-filled"]
    assert not found.excluded


def test_jumps_are_said() -> None:
    motions = clips()
    rotations = motions[2].rotations.copy()
    rotations[30:, 16] = multiply(rotations[30:, 16], exp(np.array([0.0, 2.5, 0.0])))
    motions[2] = replace(motions[2], rotations=rotations)
    warnings = dict(fit(motions, options_of()).warnings)
    assert "frame 31" in warnings["jump"]
    assert motions[2].skeleton.names[16] in warnings["jump"]


def test_rotations_far_from_the_mean_are_said() -> None:
    motions = clips()
    rotations = motions[2].rotations.copy()
    rotations[:, 16] = multiply(rotations[:, 16], exp(np.array([0.0, 3.0, 0.0])))
    motions[2] = replace(motions[2], rotations=rotations)
    assert "far-from-reference" in dict(fit(motions, options_of()).warnings)


def test_the_phase_joint_is_found_by_both_names_or_refused() -> None:
    by_source = fit(clips(), options_of(phase_joint="Bip01 R UpperArm"))
    assert by_source.body.phase_joint == fitted().body.phase_joint
    with pytest.raises(AnalysisError) as error:
        fit(clips(), options_of(phase_joint="tail"))
    assert error.value.code == "phase-joint-not-found"
    assert "right_up_arm" in str(error.value)
    assert code_of(clips(), hand_joint="claw") == "hand-joint-not-found"
    assert fit(clips(), options_of(hand_joint="Head")).body.skeleton.joints[16].name != "Head"


def shorter(motion: Motion, count: int = 22) -> Motion:
    return replace(
        motion,
        skeleton=Skeleton(motion.skeleton.joints[:count]),
        rotations=motion.rotations[:, :count],
        translations=motion.translations[:, :count],
    )


def test_other_skeletons_are_refused_or_cut_to_what_is_common() -> None:
    motions = clips()
    motions[2] = shorter(motions[2])
    with pytest.raises(AnalysisError) as error:
        fit(motions, options_of())
    assert error.value.code == "skeleton-mismatch"
    assert "Joint 23" in error.value.what
    assert error.value.details["leave_out"] == [motions[2].document]
    common = fit(motions, options_of(joints="intersection"))
    whole = fit([shorter(motion) for motion in motions[:2] + motions[3:]] + [motions[2]], options_of())
    assert len(common.model.skeleton) == 22
    assert np.allclose(common.components.coefficients, whole.components.coefficients)
    renamed = replace(motions[2].skeleton.joints[0], name="other")
    motions[2] = replace(motions[2], skeleton=Skeleton((renamed, *motions[2].skeleton.joints[1:])))
    assert code_of(motions, joints="intersection") == "skeleton-mismatch"


def test_joints_below_other_parents_are_not_common() -> None:
    motions = clips()
    joints = list(motions[2].skeleton.joints)
    joints[6] = replace(joints[6], parent=4)
    motions[2] = replace(motions[2], skeleton=Skeleton(tuple(joints)))
    found = fit(motions, options_of(joints="intersection"))
    assert "Head" not in found.model.skeleton.names
    assert len(found.model.skeleton) == 22


def test_markers_have_no_rotations() -> None:
    motions = clips()
    joints = tuple(replace(joint, convention=Convention.MARKER) for joint in motions[2].skeleton.joints)
    motions[2] = replace(motions[2], skeleton=Skeleton(joints))
    assert code_of(motions) == "no-rotations"


def test_units_of_length_have_to_agree() -> None:
    motions = clips()
    motions[2] = replace(motions[2], metres=1.0)
    with pytest.raises(AnalysisError) as error:
        fit(motions, options_of())
    assert (error.value.code, error.value.details["leave_out"]) == ("unit-mismatch", [motions[2].document])


def test_suspect_values_are_refused_unless_forced() -> None:
    motions = clips()
    motions[2] = labelled(motions[2], height="1.72")
    assert code_of(motions) == "unit-suspect"
    assert len(fit(motions, options_of(force=True)).clips) == len(motions)
    mixed = [
        replace(motion, properties={**motion.properties, "load": ("3", unit)})
        for motion, unit in zip(clips(), ["kg", "lb"] * 20, strict=True)
    ]
    assert code_of(mixed, attributes=("age", "load")) == "unit-suspect"


def test_bones_that_differ_are_said() -> None:
    motions = clips()
    translations = motions[2].translations.copy()
    translations[:, 9] *= 1.3
    motions[2] = replace(motions[2], translations=translations)
    warnings = dict(fit(motions, options_of()).warnings)
    assert motions[2].skeleton.names[9] in warnings["bones-differ"]


@pytest.mark.parametrize("method", ["robust", "paper"])
def test_too_few_clips_are_refused(method: str) -> None:
    few = on_grid(clips())[:3]
    assert code_of(few, method) == "too-few-examples"
    assert code_of(few[:1], method) == "too-few-examples"
    alike = [labelled(motion, age="23", height="170", hbp="265") for motion in clips()[:10]]
    assert code_of(alike, method, duplicates="mean") == "degenerate-attributes"
    assert code_of([still(motion) for motion in clips()], method) == "too-few-examples"


def test_leaving_out_needs_one_more_clip_than_fitting() -> None:
    four = on_grid(clips())[::10]
    assert len(four) == 4
    assert code_of(four, subject="") == "too-few-examples"
    assert len(fit(four, options_of(subject="", s=1.0, lam=0.0)).model.centres) == 4
    assert len(fit(four, options_of("paper")).model.centres) == 4


def test_dependent_attributes_are_refused_by_one_method_and_reduced_by_the_other() -> None:
    dependent = [
        replace(motion, properties={**motion.properties, "double": (str(2 * float(motion.properties["age"][0])), "")})
        for motion in on_grid(clips())
    ]
    names = ("age", "double", "height")
    assert code_of(dependent, "paper", attributes=names) == "degenerate-attributes"
    found = fit(dependent, options_of(attributes=names))
    assert "collinear-attributes" in dict(found.warnings)
    made = synthesize(found.model, Wish({"age": 30.0, "double": 60.0, "height": 170.0}))
    assert "attributes-off-plane" not in dict(made.warnings)
    made = synthesize(found.model, Wish({"age": 30.0, "double": 90.0, "height": 170.0}))
    assert "attributes-off-plane" in dict(made.warnings)


@pytest.mark.parametrize("method", ["robust", "paper"])
def test_a_constant_attribute_is_left_out_and_said(method: str) -> None:
    motions = [labelled(motion, height="170") for motion in on_grid(clips())]
    found = fit(motions, options_of(method))  # type: ignore[arg-type]
    assert "constant-attribute" in dict(found.warnings)
    same = synthesize(found.model, Wish({**WISH, "height": 170.0}))
    other = synthesize(found.model, Wish({**WISH, "height": 180.0}))
    assert "attribute-not-modelled" in dict(other.warnings)
    assert "attribute-not-modelled" not in dict(same.warnings)
    assert np.array_equal(same.clip.rotations, other.clip.rotations)


def test_equal_attributes_are_refused_by_the_paper_with_the_clips() -> None:
    motions = on_grid(clips())
    motions[5] = replace(motions[5], properties=motions[4].properties)
    with pytest.raises(AnalysisError) as error:
        fit(motions, options_of("paper"))
    assert error.value.code == "duplicate-attributes"
    assert error.value.details["groups"] == [[motions[4].name, motions[5].name]]
    assert error.value.details["leave_out"] == [motions[5].document]
    assert len(fit(motions, options_of("paper", duplicates="mean")).model.centres) == len(motions) - 1


def test_singular_equations_are_refused_or_given_a_ridge() -> None:
    motions = on_grid(clips())
    assert code_of(motions, s=1e4, lam=0.0) == "singular"
    assert code_of(motions, "paper", s=1e5) == "singular"
    assert code_of(motions, s=1e4, interpolate=True) == "singular"
    assert fit(motions, options_of(s=1e4)).selected.lam > 0
    kept = on_grid(clips())
    kept[5] = replace(kept[5], properties=kept[4].properties)
    assert code_of(kept, s=1.0, lam=0.0, duplicates="keep") == "singular"


def test_ill_conditioned_equations_are_said() -> None:
    centres = fit(on_grid(clips()), options_of(s=1.0, lam=1.0)).model.centres
    widths = [s for s in np.geomspace(1, 100, 60) if 1e12 < invert(centres, s, 0.0, 1).condition < 1e14]
    assert widths
    found = fit(on_grid(clips()), options_of(s=float(widths[0]), lam=0.0))
    assert "ill-conditioned" in dict(found.warnings)


def test_times_set_by_a_person_count() -> None:
    motions = clips()
    document = motions[2].document
    found = fit(motions, options_of(times={document: (5.0, 25.0, 50.0)}))
    clip = next(clip for clip in found.clips if clip.motion.document == document)
    assert clip.phases.times == (5.0, 25.0, 50.0)
    assert clip.phases.flags == ("given",)
    assert code_of(motions, times={document: (5.0, 4.0, 50.0)}) == "phase-order"


def test_the_papers_times_may_leave_their_order_far_away() -> None:
    model = fitted(method="paper", duplicates="mean").model
    codes = set()
    for age in (-3000.0, 3000.0):
        try:
            synthesize(model, Wish({"age": age, "height": -900.0, "hbp": 9000.0}, force=True))
        except AnalysisError as error:
            codes.add(error.code)
    assert codes == {"time-order"}


@pytest.mark.parametrize(
    ("wish", "code"),
    [
        (Wish({"age": 25.0, "height": 168.0}), "missing-attribute"),
        (Wish({**WISH, "weight": 70.0}), "unknown-attribute"),
        (Wish({**WISH, "age": float("nan")}), "attribute-not-a-number"),
        (Wish({**WISH, "age": float("inf")}), "attribute-not-a-number"),
        (Wish({**WISH, "height": 1.68}), "unit-suspect"),
        (Wish({**WISH, "age": 110.0}, extrapolate=False), "outside-hull"),
        (Wish(WISH, template="nothing"), "unknown-template"),
    ],
)
def test_wishes_that_cannot_be_answered(wish: Wish, code: str) -> None:
    with pytest.raises(AnalysisError) as error:
        synthesize(fitted().model, wish)
    assert error.value.code == code


def test_two_values_and_two_people_are_told() -> None:
    """Forty clips are not few: they show too little. That is said, with what to do."""
    motions, _ = generated()
    ages = [labelled(motion, age="23" if place % 2 else "67") for place, motion in enumerate(motions)]
    codes = dict(fit(ages, options_of(attributes=("age",))).warnings)
    assert "age has only two values in the clips, 23 and 67" in codes["two-values"]
    assert "Add clips with other values of age" in codes["two-values"]
    people = sorted({motion.properties["subject"][0] for motion in motions})
    pair = [motion for motion in motions if motion.properties["subject"][0] in people[:2]]
    codes = dict(fit(pair, options_of(attributes=("hbp",))).warnings)
    assert f"two people, {people[0]} and {people[1]}" in codes["two-people"]
    assert "two-people" not in dict(fit(pair, options_of(attributes=("hbp",), subject="")).warnings)
    assert not {"two-values", "two-people"} & set(dict(fit(motions, options_of()).warnings))


def test_a_fit_that_two_values_forbid_says_so() -> None:
    motions, _ = generated()
    two = [labelled(motion, age="23" if place % 2 else "67") for place, motion in enumerate(motions)]
    with pytest.raises(AnalysisError) as error:
        fit(two, options_of(attributes=("age",), duplicates="mean"))
    assert error.value.code == "too-few-examples"
    assert "age has only two values" in error.value.what
    assert error.value.details["reasons"] == ["two-values"]
