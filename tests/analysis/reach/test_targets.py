"""Reaches whose hand arrives at a target."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from mcml.motion.feet.legs import legs_of
from mcml.motion.hub import walked
from mcml.motion.rotation_vectors import from_vector
from mcml.motion.rotations import multiply, rotate
from mcml.motion.skeleton import Array
from mcml_schemas.analyses.reach import ReachMotion, ReachParameters, ReachWish
from mcml_service.analysis.interface import AnalysisError, MadeClip, Motion, Part
from mcml_service.analysis.reach_blending.analyses import REACH
from mcml_service.analysis.reach_blending.arrival import SHORTEST_FADE, find_weights, smoothstep
from mcml_service.analysis.reach_blending.evaluation import own_prediction, predictions
from mcml_service.analysis.reach_blending.fit import fit, middle_hold
from mcml_service.analysis.reach_blending.options import options_of
from mcml_service.analysis.reach_blending.synthesis import Made, Wish, synthesize
from tests.analysis.reach.reach_motions import fitted, generated

ATTRIBUTES = {"age": 25.0, "height": 168.0, "hbp": 270.0}


def made(target: Array | None = None, **wish: object) -> Made:
    goal = None if target is None else target.tolist()
    return synthesize(fitted().model, Wish(ATTRIBUTES, target=goal, **wish))  # type: ignore[arg-type]


def place(**wish: object) -> Array:
    """Where the hand of the blend is at t2, metres."""
    hand = made(**wish).hand
    assert hand is not None
    return hand.place


def outward() -> Array:
    """Direction from the shoulder to the hand at t2."""
    blend = made()
    assert blend.hand is not None
    shoulder = positions(blend.clip)[blend.hand.frame, fitted().body.phase_joint]
    way: Array = place() - shoulder
    return way / np.linalg.norm(way)


def positions(clip: MadeClip) -> Array:
    """Metres."""
    return walked(clip.skeleton, clip.translations, clip.rotations)[0] * (clip.metres or 1.0)


@given(st.tuples(*[st.floats(-0.08, 0.08)] * 3), st.sampled_from([30.0, 60.0, 120.0]))
def test_the_hand_arrives(way: tuple[float, float, float], fps: float) -> None:
    target = place(fps=fps) + way
    answer = made(target, fps=fps)
    assert answer.method == "arrive"
    assert answer.hand is not None
    assert answer.hand.error is not None
    assert answer.hand.error < 0.001
    hand = positions(answer.clip)[answer.hand.frame, fitted().body.hand]
    assert np.linalg.norm(hand - target) < 0.001
    assert answer.hand.frame == round(answer.times[1] * fps)


@pytest.mark.slow
@given(st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda parts: np.linalg.norm(parts) > 0.1))
def test_the_hand_has_its_orientation_at_the_target(parts: tuple[float, float, float, float]) -> None:
    wanted = np.array(parts) / np.linalg.norm(parts)
    target = place() + np.array([0.03, 0.02, -0.03])
    usual, turned = made(target), made(target, orientation=wanted.tolist())
    assert usual.hand is not None
    assert turned.hand is not None
    assert usual.hand.turn_error is None
    clip, frame, wrist = turned.clip, turned.hand.frame, fitted().body.hand
    world = walked(clip.skeleton, clip.translations, clip.rotations)[1][frame, wrist]
    assert abs(world @ wanted) == pytest.approx(1.0, abs=1e-9)
    assert turned.hand.turn_error == pytest.approx(0.0, abs=1e-3)
    # The place of the hand, and all joints but the wrist, are as without it; the turn fades.
    assert np.allclose(turned.hand.place, usual.hand.place)
    others = np.delete(np.arange(len(clip.skeleton)), wrist)
    assert np.array_equal(clip.rotations[:, others], usual.clip.rotations[:, others])
    assert np.allclose(np.abs((clip.rotations[[0, -1], wrist] * usual.clip.rotations[[0, -1], wrist]).sum(axis=1)), 1)
    far = turned.hand.beyond > 1
    assert ("wrist-beyond-examples" in [code for code, _ in turned.warnings]) is far


def test_an_orientation_needs_a_target_and_a_unit_quaternion() -> None:
    for wish in ({}, {"method": "blend"}):
        with pytest.raises(AnalysisError) as error:
            made(place() if wish else None, orientation=[0, 0, 0, 1], **wish)
        assert error.value.code == "no-target"
    with pytest.raises(ValidationError, match="unit quaternion"):
        ReachWish(attributes=ATTRIBUTES, target=(0, 0, 0), orientation=(0, 0, 0, 0.5))


def test_only_the_way_to_the_hand_is_changed() -> None:
    blend, arrived = made(), made(place() + np.array([0.05, 0.05, -0.05]))
    chain = list(fitted().body.chain)
    legs = [joint for leg in legs_of(blend.clip.skeleton) for joint in (leg.hip, leg.knee, leg.ankle)]
    others = np.setdiff1d(np.arange(len(blend.clip.skeleton)), [*chain, *legs])
    assert np.array_equal(blend.clip.rotations[:, others], arrived.clip.rotations[:, others])
    assert np.array_equal(blend.clip.translations[:, 1:], arrived.clip.translations[:, 1:])
    assert np.allclose(blend.clip.rotations[0, chain], arrived.clip.rotations[0, chain], atol=1e-12)
    assert blend.times == arrived.times


def test_without_target_motions_are_the_blend() -> None:
    plain, blend = made(), made(method="blend")
    assert plain.method == "blend"
    assert np.array_equal(plain.clip.rotations, blend.clip.rotations)
    target = place() + np.array([0.1, 0.0, 0.0])
    missed = made(target, method="blend")
    assert np.array_equal(missed.clip.rotations, blend.clip.rotations)
    assert missed.hand is not None
    assert missed.hand.error == pytest.approx(0.1)
    assert missed.hand.moved is None


def test_the_arm_goes_first_then_the_spine_then_the_pelvis() -> None:
    near, far, farther = (made(place() + way * outward(), clamp=True) for way in (0.02, 0.1, 0.3))
    shares = [answer.hand.moved for answer in (near, far, farther)]  # type: ignore[union-attr]
    assert all(share is not None for share in shares)
    assert shares[0].spine < 1e-6  # type: ignore[union-attr]
    assert shares[0].arm == pytest.approx(0.02, abs=1e-4)  # type: ignore[union-attr]
    assert shares[1].spine > 0.01  # type: ignore[union-attr]
    assert shares[2].pelvis > 0.01  # type: ignore[union-attr]


@pytest.mark.slow
def test_places_out_of_reach_are_refused_with_the_distance() -> None:
    target = place() + np.array([0.0, 0.0, 2.0])
    with pytest.raises(AnalysisError) as error:
        made(target)
    assert error.value.code == "out-of-reach"
    distance, nearest = error.value.details["distance"], np.array(error.value.details["nearest"])
    assert 0.5 < distance < 2.0
    assert f"{100 * distance:.1f} cm" in error.value.what
    assert np.linalg.norm(target - nearest) == pytest.approx(distance, abs=1e-4)
    clamped = made(target, clamp=True)
    assert clamped.hand is not None
    assert clamped.hand.error == pytest.approx(distance, abs=0.05)
    assert "out-of-reach" in [code for code, _ in clamped.warnings]
    # The nearest place that the error names can be reached.
    again = made(nearest, clamp=True)
    assert again.hand is not None
    assert again.hand.error is not None
    assert again.hand.error < 0.02


def test_a_target_is_needed_to_arrive_and_a_unit_and_an_arm_for_a_target() -> None:
    with pytest.raises(AnalysisError) as error:
        made(method="arrive")
    assert error.value.code == "no-target"
    model = fitted().model
    wish = Wish(ATTRIBUTES, target=(0.0, 0.0, 0.0))
    for changed, code in (({"metres": None}, "unknown-unit"), ({"reaching": None}, "no-arm")):
        for method in ("arrive", "blend"):
            with pytest.raises(AnalysisError) as error:
                synthesize(replace(model, **changed), replace(wish, method=method))  # type: ignore[arg-type]
            assert error.value.code == code
        answer = synthesize(replace(model, **changed), Wish(ATTRIBUTES))  # type: ignore[arg-type]
        assert answer.hand is None


def test_models_of_earlier_releases_still_blend() -> None:
    parts = dict(REACH.run(generated()[0], ReachParameters(), lambda stage, share: None))
    stored = parts["model"]
    values = {name: value for name, value in stored.data["model"].items() if name != "reaching"}
    new = ("range_", "hinge", "contacts")
    arrays = {name: array for name, array in stored.arrays.items() if not name.startswith(new)}
    parts["model"] = replace(stored, data={**stored.data, "model": values}, arrays=arrays)
    ready = REACH.prepare(parts)
    use = REACH.operations["synthesize"].run
    value = use(ready, ReachWish(attributes=ATTRIBUTES)).value
    assert isinstance(value, ReachMotion)
    assert value.hand_place is None
    with pytest.raises(AnalysisError) as error:
        use(ready, ReachWish(attributes=ATTRIBUTES, target=(0.0, 0.0, 0.0)))
    assert error.value.code == "no-arm"


def slide(clip: MadeClip, joint: int, contacts: Sequence[tuple[int, int]]) -> float:
    """Metres over the ground, with Y up."""
    ground = positions(clip)[:, joint][:, [0, 2]]
    return sum(float(np.linalg.norm(np.diff(ground[a : b + 1], axis=0), axis=1).sum()) for a, b in contacts)


@pytest.mark.parametrize("way", [0.05, 0.3])
def test_feet_stay_where_they_stand_even_if_the_pelvis_moves(way: float) -> None:
    blend, arrived = made(), made(place() + way * outward())
    assert arrived.hand is not None
    assert arrived.hand.moved is not None
    assert arrived.hand.error is not None
    assert arrived.hand.error < 0.001
    assert (arrived.hand.moved.pelvis > 0.02) == (way > 0.2)
    assert blend.feet == ()
    assert len(arrived.feet) == 2
    for report in arrived.feet:
        assert sum(last - first for first, last in report.contacts) > 30
        before, after = (slide(answer.clip, report.joint, report.contacts) for answer in (blend, arrived))
        assert before > 0.01
        assert after < 0.005
        assert report.before * 0.01 == pytest.approx(before)
        assert report.after * 0.01 == pytest.approx(after, abs=1e-9)


def test_without_an_axis_that_points_up_hands_arrive_and_feet_are_left_alone() -> None:
    model = fit([replace(motion, up=None) for motion in generated()[0]], options_of()).model
    assert model.contacts is None
    answer = synthesize(model, Wish(ATTRIBUTES, target=(place() + 0.05).tolist()))
    assert answer.feet == ()
    assert answer.hand is not None
    assert answer.hand.error is not None
    assert answer.hand.error < 0.001


def test_a_stored_model_arrives_alike() -> None:
    parts = REACH.run(generated()[0], ReachParameters(), lambda stage, share: None)
    stored = {
        name: Part(part.kind, json.loads(json.dumps(part.data, allow_nan=False)), dict(part.arrays))
        for name, part in parts.items()
    }
    wish = ReachWish(attributes=ATTRIBUTES, target=tuple((place() + 0.1).tolist()), clamp=True)
    fresh, again = (REACH.operations["synthesize"].run(REACH.prepare(each), wish) for each in (parts, stored))
    assert fresh.value == again.value
    assert fresh.clip is not None
    assert again.clip is not None
    assert np.array_equal(fresh.clip.rotations, again.clip.rotations)
    assert np.array_equal(fresh.clip.translations, again.clip.translations)


def test_answers_tell_of_the_hand() -> None:
    parts = REACH.run(generated()[0], ReachParameters(), lambda stage, share: None)
    use, ready = REACH.operations["synthesize"].run, REACH.prepare(parts)
    blend = use(ready, ReachWish(attributes=ATTRIBUTES)).value
    assert isinstance(blend, ReachMotion)
    assert (blend.method, blend.target, blend.hand_error, blend.moved) == ("blend", None, None, None)
    assert blend.hand_place == pytest.approx(place().tolist())
    target = (blend.hand_place[0] + 0.05, *blend.hand_place[1:])
    value = use(ready, ReachWish(attributes=ATTRIBUTES, target=target)).value
    assert isinstance(value, ReachMotion)
    assert value.method == "arrive"
    assert value.hand_error is not None
    assert value.hand_error < 0.001
    assert value.moved is not None
    assert value.moved.arm == pytest.approx(0.05, abs=1e-3)
    assert {foot.joint for foot in value.feet} == {"left_toes", "right_toes"}
    assert all(foot.slide < 0.002 < foot.slide_before for foot in value.feet)
    assert all(1 <= span.first <= span.last <= value.frames for foot in value.feet for span in foot.contacts)


@given(st.integers(2, 400), st.data())
def test_a_correction_grows_stays_and_fades_without_jumps(frames: int, data: st.DataObject) -> None:
    contact = data.draw(st.integers(1, frames - 1))
    first = data.draw(st.integers(0, contact - 1))
    hold = data.draw(st.floats(0.0, 1.0))
    fps = data.draw(st.sampled_from([24.0, 30.0, 120.0]))
    weights = find_weights(frames, first, contact, hold, fps)
    assert weights.shape == (frames,)
    assert weights[contact] == 1.0
    assert np.all((weights >= 0) & (weights <= 1))
    assert np.all(np.diff(weights[: contact + 1]) >= 0)
    assert np.all(np.diff(weights[contact:]) <= 1e-12)
    # A smoothstep is nowhere steeper than 1.5 over its length.
    if contact >= SHORTEST_FADE * fps:
        assert np.abs(np.diff(weights)).max() <= 1.5 / (SHORTEST_FADE * fps) + 1e-9
    if frames - 1 - contact >= SHORTEST_FADE * fps:
        assert weights[-1] == pytest.approx(0.0)


def test_a_smoothstep_is_even_about_its_middle() -> None:
    parts = np.linspace(0, 1, 11)
    assert np.allclose(smoothstep(parts) + smoothstep(parts[::-1]), 1.0)


def test_hands_hold_until_they_are_far() -> None:
    ways = np.zeros((3, 11, 3))
    ways[0, 5:, 0] = 1.0
    ways[1, 3:, 0] = 1.0
    assert middle_hold(ways[:2], 0.5) == pytest.approx((0.4 + 0.2) / 2)
    assert middle_hold(ways, 2.0) == 1.0
    assert middle_hold(ways[:0], 1.0) == 1.0


def moved_anywhere(motions: list[Motion]) -> list[Motion]:
    """The motions at other places, with other headings, of a world whose Y is up."""
    rng = np.random.default_rng(3)
    result = []
    for motion in motions:
        turn = from_vector(np.array([0.0, rng.uniform(-3, 3), 0.0]))
        shift = np.array([rng.uniform(-300, 300), 0.0, rng.uniform(-300, 300)])
        rotations, translations = motion.rotations.copy(), motion.translations.copy()
        rotations[:, 0] = multiply(turn, rotations[:, 0])
        translations[:, 0] = rotate(turn, translations[:, 0]) + shift
        result.append(replace(motion, rotations=rotations, translations=translations))
    return result


@pytest.mark.slow
def test_clips_captured_anywhere_are_brought_to_one_start() -> None:
    here = fit(generated()[0], options_of(align="start")).model
    anywhere = fit(moved_anywhere(generated()[0]), options_of(align="start")).model
    first, second = (synthesize(model, Wish(ATTRIBUTES)) for model in (here, anywhere))
    assert np.allclose(positions(first.clip), positions(second.clip), atol=1e-6)
    t1 = round(first.times[0] * here.base_fps)
    assert np.abs(first.clip.translations[t1, 0, [0, 2]]).max() < 1.0
    scattered = fit(moved_anywhere(generated()[0]), options_of()).model
    assert not np.allclose(positions(synthesize(scattered, Wish(ATTRIBUTES)).clip), positions(second.clip), atol=0.1)


def test_a_clip_without_up_axis_has_no_start() -> None:
    motions = [replace(motion, up=None) for motion in generated()[0]]
    with pytest.raises(AnalysisError) as error:
        fit(motions, options_of(align="start", on_bad_clip="error"))
    assert error.value.code == "no-up-axis"


def test_courses_of_the_hand_stay_smooth() -> None:
    blend, arrived = made(), made(place() + np.array([0.06, 0.06, -0.06]))
    steps = [np.diff(positions(answer.clip)[:, fitted().body.hand], 2, axis=0) for answer in (blend, arrived)]
    before, after = (float(np.percentile(np.linalg.norm(step, axis=1), 99)) for step in steps)
    assert after < 1.2 * before


@pytest.mark.slow
def test_width_and_ridge_by_the_hand_have_the_least_error_of_hands() -> None:
    by_hand = fitted(choose_by="hand")
    assert by_hand.selected.choice is not None
    tried = {(s, lam): error for s, lam, _, error in by_hand.selected.choice.tried}
    people = {way.predictor: way.errors for way in predictions(by_hand) if way.left_out == "subject"}
    assert tried[by_hand.selected.s, by_hand.selected.lam] == pytest.approx(people["model"].contact)
    for s, lam in ((by_hand.selected.s, 100.0), (2 * by_hand.selected.s, by_hand.selected.lam)):
        other = fitted(s=s, lam=lam)
        contact = next(
            w.errors.contact for w in predictions(other) if (w.left_out, w.predictor) == ("subject", "model")
        )
        assert contact >= people["model"].contact - 1e-9
        assert tried[s, lam] == pytest.approx(contact) if (s, lam) in tried else True


def test_the_table_of_errors_has_the_hand_at_the_contact() -> None:
    parts = REACH.run(generated()[0], ReachParameters(choose_by="hand"), lambda stage, share: None)
    table = parts["errors"].data
    names = [column["name"] for column in table["columns"]]
    unit = next(column["unit"] for column in table["columns"] if column["name"] == "hand_at_contact")
    assert unit == "mm"
    by_way = {tuple(row[:2]): row[names.index("hand_at_contact")] for row in table["rows"]}
    assert by_way["nothing", "model"] <= by_way["subject", "model"]
    assert by_way["subject", "model"] <= by_way["subject", "nearest"]
    assert parts["model"].data["summary"]["choose_by"] == "hand"
    found = fitted(choose_by="hand")
    sample, missed = found.model.knots[1], []
    for place, clip in enumerate(found.clips):
        root, rotations = found.model.samples(found.model.attribute_space.coordinates(clip.attributes[None])[0])
        true = found.ruler.hand(found.sampled.root[place, sample], found.sampled.rotations[place, sample])
        missed.append(np.linalg.norm(found.ruler.hand(root[sample], rotations[sample]) - true))
    assert own_prediction(found).contact == pytest.approx(np.mean(missed))
    assert by_way["nothing", "model"] == pytest.approx(10 * np.mean(missed))
