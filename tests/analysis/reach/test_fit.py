"""What a fitted model must show."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.formats import FORMATS
from mcml.formats.format import ReadOptions, SourceFile
from mcml.motion.hub import HubReader
from mcml.motion.rotations import to_euler
from mcml.motion.skeleton import Skeleton
from mcml_service.actions.importing.store_clip import clip_file
from mcml_service.analysis.interface import Motion
from mcml_service.analysis.reach_blending.accuracy import Ruler
from mcml_service.analysis.reach_blending.blend import fit_blend, linear_left_out, nearest_left_out
from mcml_service.analysis.reach_blending.durations import about_cuts, from_time_values, to_time_values
from mcml_service.analysis.reach_blending.evaluation import predictions, reconstruction
from mcml_service.analysis.reach_blending.fit import fit
from mcml_service.analysis.reach_blending.options import options_of
from mcml_service.analysis.reach_blending.quaternion_tracks import angle_between, exp
from mcml_service.analysis.reach_blending.stored import to_arrays
from mcml_service.analysis.reach_blending.synthesis import Wish, synthesize
from tests import fuzz
from tests.analysis.reach.reach_motions import fitted, generated, on_grid

WISH = Wish({"age": 25.0, "height": 168.0, "hbp": 270.0})


def same(first: dict[str, np.ndarray], second: dict[str, np.ndarray], tolerance: float = 0.0) -> bool:
    return first.keys() == second.keys() and all(
        np.allclose(first[name], second[name], rtol=tolerance, atol=tolerance) for name in first
    )


@pytest.mark.slow
@fuzz.examples(5)
@given(st.integers(0, 1000), st.sampled_from(["robust", "paper"]))
def test_order_of_clips_changes_nothing(seed: int, method: str) -> None:
    motions = generated()[0]
    shuffled = [motions[place] for place in np.random.default_rng(seed).permutation(len(motions))]
    options = {"duplicates": "mean"} if method == "paper" else {}
    again = fit(shuffled, options_of(method, **options))  # type: ignore[arg-type]
    assert same(to_arrays(again.model), to_arrays(fitted(method=method, **options).model))


@pytest.mark.slow
@fuzz.examples(5)
@given(st.integers(0, 1000), st.sampled_from(["robust", "paper"]), st.sampled_from([None, "global"]))
def test_signs_of_quaternions_change_nothing(seed: int, method: str, space: str | None) -> None:
    rng = np.random.default_rng(seed)
    flipped = [
        replace(motion, rotations=motion.rotations * rng.choice([-1.0, 1.0], (*motion.rotations.shape[:2], 1)))
        for motion in generated()[0]
    ]
    options = {"duplicates": "mean", "space": space} if method == "paper" else {"space": space}
    again = fit(flipped, options_of(method, **options))  # type: ignore[arg-type]
    assert same(to_arrays(again.model), to_arrays(fitted(method=method, **options).model), 1e-9)


@pytest.mark.slow
def test_the_rate_of_the_clips_changes_next_to_nothing() -> None:
    made = [
        synthesize(fit(generated(fps=fps, noise=False)[0], options_of()).model, replace(WISH, fps=30))
        for fps in (30, 60, 120)
    ]
    for other in made[1:]:
        assert np.abs(np.subtract(other.times, made[0].times)).max() < 0.5 / 30
        count = min(len(made[0].clip.rotations), len(other.clip.rotations))
        away = angle_between(made[0].clip.rotations[:count], other.clip.rotations[:count])
        assert away.mean() < 0.3
        assert away.max() < 3


@pytest.mark.parametrize("space", ["tangent", "eigenposes", "global"])
def test_interpolation_gives_the_examples_back(space: str) -> None:
    motions = on_grid(generated()[0])
    found = fit(motions, options_of("robust", interpolate=True, space=space, components=6))
    model = found.model
    assert model.coefficients.lam == model.times.lam == 0
    for place in (0, 7, 23, 39):
        x = model.attribute_space.coordinates(model.attributes[place : place + 1])[0]
        vector = model.mean + found.components.coefficients[place : place + 1] @ model.basis
        root, rotations = model.motion_space.motions(vector)
        made_root, made_rotations = model.samples(x)
        assert np.abs(made_root - root[0]).max() < 1e-5
        assert angle_between(made_rotations, rotations[0]).max() < 1e-3
        assert np.allclose(model.phase_times(x), found.times[place], atol=1e-5)
        weights = model.weights(x)
        assert weights[place] == pytest.approx(1, abs=1e-5)


def test_all_components_and_interpolation_give_the_measured_motion_back() -> None:
    motions = on_grid(generated()[0])
    found = fit(motions, options_of("robust", interpolate=True, variance=1.0))
    model = found.model
    for place in (3, 31):
        root, rotations = model.samples(model.attribute_space.coordinates(model.attributes[place : place + 1])[0])
        assert np.abs(root - found.sampled.root[place]).max() < 1e-4
        assert angle_between(rotations, found.sampled.rotations[place]).max() < 1e-2


def test_equal_attributes_are_averaged_where_examples_are_met() -> None:
    motions = on_grid(generated()[0])
    motions[5] = replace(motions[5], properties=motions[4].properties)
    found = fit(motions, options_of("robust", interpolate=True))
    assert len(found.model.centres) == len(motions) - 1
    x = found.model.attribute_space.coordinates(found.model.attributes[4:5])
    mean = found.components.coefficients[4:6].mean(axis=0)
    assert np.allclose(found.model.coefficients(x)[0], mean, atol=1e-6)
    kept = fit(motions, options_of("robust", lam=0.1))
    assert len(kept.model.centres) == len(motions)


@pytest.mark.slow
def test_people_not_seen_are_predicted_no_worse_than_by_line_or_neighbour() -> None:
    found = {way.predictor: way for way in predictions(fitted(few=False)) if way.left_out == "subject"}
    model = found["model"]
    for other in ("linear", "nearest"):
        assert model.errors.joints <= found[other].errors.joints
        assert model.errors.hand <= found[other].errors.hand
    assert model.errors.clips == 185


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
def test_the_choice_is_no_worse_than_line_or_neighbour_by_its_own_measure(seed: int) -> None:
    selected = fit(generated(seed, few=False)[0], options_of()).selected
    assert selected.choice is not None
    assert selected.subjects is not None
    x, y = selected.centres, selected.coefficients
    for predicted in (linear_left_out(x, y, 1, selected.subjects), nearest_left_out(x, y, selected.subjects)):
        assert selected.choice.error <= np.sqrt(np.mean(np.sum((predicted - y) ** 2, axis=1)))


def test_predictions_without_a_person_are_those_of_a_refit() -> None:
    found = fitted()
    selected, model = found.selected, found.model
    assert selected.subjects is not None
    errors = {(way.left_out, way.predictor): way for way in predictions(found)}
    degrees, times = [], []
    for rows in selected.subjects:
        others = np.setdiff1d(np.arange(len(selected.centres)), rows)
        blend = fit_blend(selected.centres[others], selected.coefficients[others], selected.s, selected.lam)
        time_blend = fit_blend(
            selected.centres[others], selected.time_values[others], selected.time_s, selected.time_lam
        )
        vectors = model.mean + blend(selected.centres[rows]) @ model.basis
        _, rotations = model.motion_space.motions(vectors)
        degrees += angle_between(rotations, found.sampled.rotations[rows]).mean(axis=(1, 2)).tolist()
        times.append(np.abs(from_time_values(time_blend(selected.centres[rows]), True) - found.times[rows]))
    assert errors["subject", "model"].errors.joints == pytest.approx(np.mean(degrees), rel=1e-6)
    assert np.allclose(errors["subject", "model"].times, np.concatenate(times).mean(axis=0))


def test_more_components_reconstruct_better() -> None:
    errors = [reconstruction(fitted(components=count)).joints for count in (2, 10, 39)]
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-4


def test_hands_are_where_forward_kinematics_puts_them() -> None:
    motion = generated()[0][0]
    found = fitted()
    ruler = Ruler(found.body.phase_joint, found.body.chain, motion.translations[0], 0)
    positions, _ = motion.walk()
    hand = ruler.hand(motion.translations[:, 0], motion.rotations)
    assert found.body.skeleton.joints[found.body.hand].name == "right_hand"
    assert np.allclose(hand, positions[:, found.body.hand])


@pytest.mark.parametrize("method", ["robust", "paper"])
@pytest.mark.parametrize("fps", [24.0, 30.0, 120.0])
def test_made_motions_are_sound(method: str, fps: float) -> None:
    model = fitted(method=method, **({"duplicates": "mean"} if method == "paper" else {})).model
    made = synthesize(model, replace(WISH, fps=fps))
    clip = made.clip
    assert np.abs(np.linalg.norm(clip.rotations, axis=2) - 1).max() < 1e-12
    assert (np.sum(clip.rotations[1:] * clip.rotations[:-1], axis=2) > 0).all()
    assert clip.frame_time == 1 / fps
    assert len(clip.rotations) == round(made.times[2] * fps) + 1
    assert [joint.channels for joint in clip.skeleton.joints] == [
        joint.channels for joint in generated()[0][0].skeleton.joints
    ]
    for index, joint in enumerate(clip.skeleton.joints):
        angles = to_euler(clip.rotations[:, index], joint.rotation_order)
        steps = np.abs(np.diff(angles, axis=0))
        assert steps.max() <= np.pi + 1e-9
        assert np.abs(np.diff(clip.translations[:, index], axis=0)).max() < 2
        if index:
            assert np.allclose(clip.translations[:, index], [float(text) for text in joint.offset or ()])


@fuzz.examples(40)
@given(st.floats(0, 120), st.floats(50, 250), st.floats(0, 2000), st.sampled_from(["robust", "global"]))
def test_any_wish_gives_unit_rotations_and_ordered_times(age: float, height: float, hbp: float, way: str) -> None:
    model = fitted(**({"space": "global"} if way == "global" else {})).model
    made = synthesize(model, Wish({"age": age, "height": height, "hbp": hbp}, clamp=True))
    assert np.abs(np.linalg.norm(made.clip.rotations, axis=2) - 1).max() < 1e-12
    assert (np.sum(made.clip.rotations[1:] * made.clip.rotations[:-1], axis=2) > 0).all()
    assert 0 < made.times[0] < made.times[1] < made.times[2]
    assert made.in_hull


@pytest.mark.parametrize("order", ["XYZ", "ZXY"])
def test_bvh_of_a_made_motion_has_the_templates_channels(order: str) -> None:
    def other(motion: Motion) -> Motion:
        turns = tuple(f"R{letter.lower()}" for letter in order)
        joints = (
            replace(joint, channels=(*joint.channels[:-3], *turns), rotation_order=order)
            for joint in motion.skeleton.joints
        )
        return replace(motion, skeleton=Skeleton(tuple(joints)))

    made = synthesize(fit([other(motion) for motion in generated()[0]], options_of()).model, WISH).clip
    _, _, text = clip_file(made, "bvh")
    names = " ".join(f"{letter}rotation" for letter in order)
    lines = [line.split(maxsplit=2) for line in text.decode().splitlines() if "CHANNELS" in line]
    assert len(lines) == 23
    assert all(line[2].endswith(names) for line in lines)
    clip = FORMATS["bvh"].read({"bvh": SourceFile("made.bvh", io.BytesIO(text))}, ReadOptions())
    frames = HubReader(clip.head.skeleton).read(next(iter(clip.blocks())))
    assert angle_between(frames.rotations, made.rotations).max() < 1e-4
    assert np.allclose(frames.translations, made.translations, atol=1e-6)


def test_the_body_is_the_nearest_clips_or_the_one_named() -> None:
    model = fitted().model
    made = synthesize(model, WISH)
    x = model.attribute_space.coordinates(np.array([[25.0, 168.0, 270.0]]))
    nearest = int(np.argmin(np.linalg.norm(model.attribute_space.coordinates(model.attributes) - x, axis=1)))
    assert made.template == nearest
    named = synthesize(model, replace(WISH, template=model.sources[3].document))
    assert named.template == 3
    first = next(motion for motion in generated()[0] if motion.document == model.sources[3].document)
    for joint, own in zip(named.clip.skeleton.joints[1:], first.skeleton.joints[1:], strict=True):
        assert [float(text) for text in joint.offset or ()] == [float(text) for text in own.offset or ()]
        for site, own_site in zip(joint.end_sites, own.end_sites, strict=True):
            assert [float(text) for text in site.offset] == [float(text) for text in own_site.offset]


def test_people_between_the_ages_are_in_a_gap_though_inside() -> None:
    model = fitted().model
    made = synthesize(model, Wish({"age": 45.0, "height": 167.0, "hbp": 262.0}))
    assert made.in_hull
    assert made.support == "gap"
    assert made.in_gaps == ("age",)
    assert "in-gap" in [code for code, _ in made.warnings]


def test_far_wishes_are_outside_and_sparse_or_clamped() -> None:
    model = fitted().model
    far = Wish({"age": 100.0, "height": 200.0, "hbp": 420.0})
    made = synthesize(model, far)
    assert made.support == "outside"
    assert made.nn_ratio > 2
    assert "sparse-region" in [code for code, _ in made.warnings]
    clamped = synthesize(model, replace(far, clamp=True))
    assert clamped.in_hull
    assert clamped.used["age"] < 80
    again = synthesize(model, Wish(clamped.used))
    assert np.allclose(again.clip.rotations, clamped.clip.rotations, atol=1e-6)


def test_weights_are_of_the_examples_that_count_most() -> None:
    model = fitted().model
    made = synthesize(model, WISH)
    x = model.attribute_space.coordinates(np.array([[25.0, 168.0, 270.0]]))[0]
    weights = model.weights(x)
    assert weights.sum() == pytest.approx(1)
    assert len(made.weights) == 10
    assert [abs(weight) for _, weight in made.weights] == sorted(np.abs(weights), reverse=True)[:10]


def test_times_with_logarithms_keep_their_order_anywhere() -> None:
    model = fitted().model
    rng = np.random.default_rng(0)
    for x in rng.normal(0, 20, (200, 3)):
        times = from_time_values(model.times(x[None]), True)[0]
        assert 0 < times[0] < times[1] < times[2]


def test_a_reach_that_begins_at_once_has_half_a_frame_of_preparation() -> None:
    """Where no clip tells how long the preparation is."""
    times = np.array([[0.0, 20.0, 50.0], [0.4, 30.0, 70.0]])
    values = to_time_values(times, True, 30.0)
    assert np.allclose(from_time_values(values, True), [[0.5, 20.5, 50.5], [0.5, 30.1, 70.1]])
    assert np.array_equal(from_time_values(to_time_values(times, False, 30.0), False), times)
    assert about_cuts(times, 30.0) == []


def test_clips_that_are_cut_do_not_tell_how_long_motions_go_on() -> None:
    """The mean of logarithms would play a rest of 40 frames, mixed with one of half a frame, in under five."""
    times = np.array([[9.0, 30.0, 70.0], [11.0, 30.0, 80.0], [2.0, 25.0, 90.0], [10.0, 30.0, 30.2]])
    durations = np.diff(from_time_values(to_time_values(times, True, 30.0), True), axis=1, prepend=0.0)
    assert durations[3, 2] == pytest.approx(50.0)
    assert durations[2, 0] == pytest.approx(10.0)
    whole = np.diff(times, axis=1, prepend=0.0)
    assert np.allclose(durations[:2], whole[:2])
    warnings = about_cuts(times, 30.0)
    assert [code for code, _ in warnings] == ["cut-clips"] * 2
    assert warnings[1][1].startswith("1 of 4 clips end within 0.1 s")


@pytest.mark.parametrize("space", ["tangent", "eigenposes", "global"])
def test_a_joint_that_turns_all_round_stays_continuous(space: str) -> None:
    def spinning(motion: Motion) -> Motion:
        rotations = motion.rotations.copy()
        turn = np.linspace(0, 4 * np.pi, len(motion))[:, None] * np.array([0.0, 1.0, 0.0])
        rotations[:, 16] = exp(turn)
        return replace(motion, rotations=rotations)

    found = fit([spinning(motion) for motion in generated()[0]], options_of(space=space))
    made = synthesize(found.model, WISH).clip
    assert (np.sum(made.rotations[1:] * made.rotations[:-1], axis=2) >= 0).all()
    assert np.abs(np.linalg.norm(made.rotations, axis=2) - 1).max() < 1e-12


def test_height_in_metres_gives_the_same_motion() -> None:
    in_metres = [
        replace(m, properties={**m.properties, "height": (repr(float(m.properties["height"][0]) / 100), "m")})
        for m in generated()[0]
    ]
    again = synthesize(fit(in_metres, options_of()).model, WISH)
    assert np.allclose(again.clip.rotations, synthesize(fitted().model, WISH).clip.rotations, atol=1e-9)


def test_two_axes_become_three_since_blends_leave_them() -> None:
    def two(motion: Motion) -> Motion:
        joints = motion.skeleton.joints
        bent = replace(joints[9], channels=("Rz", "Rx"), rotation_order="ZX")
        return replace(motion, skeleton=replace(motion.skeleton, joints=(*joints[:9], bent, *joints[10:])))

    model = fit([two(motion) for motion in generated()[0]], options_of()).model
    assert model.skeleton.joints[9].channels == ("Rz", "Rx", "Ry")
    assert model.skeleton.joints[9].rotation_order == "ZXY"
