"""Skeletons from markers: rigid bodies are followed exactly, gaps stay gaps, every person has an own skeleton."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mcml
from mcml.errors import ConversionError, LimitError
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.resizing import turn_up
from mcml.motion.frames import joined
from mcml.motion.kinematics import Walker, unseen
from mcml.motion.rotations import inverse, multiply
from mcml.motion.skeleton import Array
from mcml.motion.solving import marker_skeleton as solving
from mcml.motion.solving.marker_skeleton import SolvedPerson, solve_people, with_skeleton
from tests.motion.bodies.made import clip_of, person
from tests.motion.solving.trials import SIDES, markers_on, pair, trial, with_gaps

LEG = ("up_leg", "low_leg", "foot")


def solved(clip: ClipStream) -> SolvedPerson:
    (one,) = solve_people(clip.head, joined(clip.blocks()))
    return one


def world(clip: ClipStream) -> tuple[Array, Array]:
    return Walker(clip.head.skeleton).poses(joined(clip.blocks()))


def poses(one: SolvedPerson) -> tuple[dict[str, Array], dict[str, Array]]:
    places, turns = world(one.clip())
    names = one.head.skeleton.names
    return ({name: places[:, n] for n, name in enumerate(names)}, {name: turns[:, n] for n, name in enumerate(names)})


def turned_since_start(turns: Array) -> Array:
    return multiply(turns, inverse(np.broadcast_to(turns[0], turns.shape)))


@settings(deadline=None, max_examples=12)
@given(st.integers(0, 10**6), st.sampled_from("XYZ"))
def test_rigid_legs_are_followed_exactly(seed: int, up: str) -> None:
    body = clip_of(person(seed, 30))
    one = solved(trial(markers_on(body), up))
    at, turns = poses(one)
    stated = body.with_head(replace(body.head, fields=body.head.fields | {"global_axis_of_gravity": "Y"}))
    own = world(stated if up == "Y" else turn_up(stated, "Y", up))
    names = list(body.head.skeleton.names)
    for side in ("left", "right"):
        for part in LEG:
            joint = f"{side}_{part}"
            np.testing.assert_allclose(at[joint], own[0][:, names.index(joint)], atol=2e-3)
            generated = turned_since_start(own[1][:, names.index(joint)])
            found = turned_since_start(turns[joint])
            cosine = np.abs((generated * found).sum(axis=1))
            assert cosine.min() > np.cos(np.radians(0.05)), (joint, np.degrees(2 * np.arccos(cosine.min())))
    assert {miss.joint: miss for miss in one.misses}["right_foot"].most < 2e-3
    assert all(miss.unknown == 0 for miss in one.misses)


@settings(deadline=None, max_examples=12)
@given(st.integers(0, 10**6), st.sampled_from("XYZ"))
def test_bones_point_as_the_centres_do_and_keep_their_length(seed: int, up: str) -> None:
    clip = trial(markers_on(clip_of(person(seed, 25))), up)
    at, _ = poses(solved(clip))
    marker = {joint.source_name: place for place, joint in enumerate(clip.head.skeleton.joints)}
    values = world(clip)[0]
    for letter, side, _ in SIDES:
        for upper, lower, ends in (("up_arm", "low_arm", "SE"), ("low_arm", "hand", "EW"), ("low_leg", "foot", "KA")):
            bone = at[f"{side}_{lower}"] - at[f"{side}_{upper}"]
            start, end = (values[:, marker[f"{letter}{short}JC"]] for short in ends)
            line = (end - start) / np.linalg.norm(end - start, axis=1, keepdims=True)
            lengths = np.linalg.norm(bone, axis=1)
            np.testing.assert_allclose(lengths, lengths[0], rtol=1e-9)
            np.testing.assert_allclose(bone / lengths[:, None], line, atol=1e-6)


@pytest.mark.parametrize("up", ["X", "Y", "Z"])
def test_the_rest_pose_stands_with_arms_to_the_sides(up: str) -> None:
    one = solved(trial(markers_on(clip_of(person(5, 40))), up))
    names = one.head.skeleton.names
    offsets = np.array([[float(number) for number in joint.offset or ()] for joint in one.head.skeleton.joints])
    at = offsets.copy()
    for index, joint in enumerate(one.head.skeleton.joints):
        if joint.parent >= 0:
            at[index] += at[joint.parent]
    axis = "XYZ".index(up)
    place = dict(zip(names, at, strict=True))
    assert place["Head"][axis] > place["Root"][axis] > place["left_low_leg"][axis] > place["left_foot"][axis]
    left = place["left_hand"] - place["right_hand"]
    front = np.roll(np.eye(3)[axis], 1)
    assert left @ np.cross(np.eye(3)[axis], front) > 0.95 * np.linalg.norm(left)
    assert (place["left_toes"] - place["left_foot"]) @ front > 0


@settings(deadline=None, max_examples=12)
@given(st.integers(0, 10**6), st.data())
def test_gaps_stay_gaps_and_harm_only_what_hangs_from_them(seed: int, data: st.DataObject) -> None:
    markers = markers_on(clip_of(person(seed, 20)))
    lost = data.draw(st.sampled_from(["LKNE", "RASI", "LHJC", "RWJC", "C7", "LTOE", "RANK"]))
    gap = data.draw(st.integers(0, 19)), data.draw(st.integers(0, 19))
    rows = slice(min(gap), max(gap) + 1)
    holed = {name: place.copy() for name, place in markers.items()}
    holed[lost][rows] = np.nan
    one = solved(with_gaps(trial(holed)))
    missing = unseen(one.head.skeleton, one.block)
    inside = np.zeros(20, dtype=bool)
    inside[rows] = True
    names = one.head.skeleton.names
    # Whose position depends on the marker. Joints at the ends of limbs have rotations that may be lost as well.
    for name, column in zip(names, missing.T, strict=True):
        assert not column[~inside].any(), name
        if lost == "RASI":
            assert column[inside].all(), name
    hit = {name for name, column in zip(names, missing.T, strict=True) if column[inside].any()}
    spared = {
        "LKNE": "right_toes", "LHJC": "right_toes", "RWJC": "left_toes", "C7": "left_toes", "LTOE": "right_toes",
        "RANK": "left_toes", "RASI": "",
    }[lost]  # fmt: skip
    assert hit or lost == "LTOE"
    assert spared not in hit
    if not inside.all():
        told = [notice.what for notice in one.notices if notice.kind == "warning"]
        assert bool(told) == bool({miss.joint for miss in one.misses if miss.unknown})


def test_every_person_has_a_skeleton_of_their_own() -> None:
    alone = [markers_on(clip_of(person(seed, 12))) for seed in (1, 2)]
    clip = trial(pair() | {"ball": alone[0]["LASI"] + 100.0})
    head = replace(clip.head, properties=(("gait Anna LKneeWidth", "100", "mm"), ("gait Bea LKneeWidth", "90", "mm")))
    people = solve_people(head, joined(clip.blocks()))
    assert [one.person for one in people] == ["Anna", "Bea"]
    for one, some in zip(people, alone, strict=True):
        own = solved(trial(some))
        assert one.head.skeleton.names == own.head.skeleton.names
        np.testing.assert_allclose(one.block.values, own.block.values, atol=1e-9)
    assert ("gait LKneeWidth", "90", "mm") in people[1].head.properties
    with pytest.raises(ConversionError, match="several people: Anna, Bea"):
        with_skeleton(clip)


def test_markers_without_a_pelvis_are_refused() -> None:
    markers = {name: place for name, place in markers_on(clip_of(person(1, 5))).items() if name[1:] != "HJC"}
    for left_out in ("ASI", "PSI"):
        markers = {name: place for name, place in markers.items() if name[1:] != left_out}
    with pytest.raises(ConversionError, match="no pelvis with both hips"):
        solved(trial(markers))


def test_a_pelvis_that_is_never_seen_is_refused() -> None:
    markers = markers_on(clip_of(person(1, 5)))
    markers = {name: place * np.nan if name[1:] == "HJC" else place for name, place in markers.items()}
    with pytest.raises(ConversionError, match="no pelvis with both hips"):
        solved(with_gaps(trial(markers)))


def test_long_trials_are_refused_before_they_are_worked_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solving, "MOST_POINTS", 100)
    with pytest.raises(LimitError, match="frames"):
        solved(trial(markers_on(clip_of(person(1, 12)))))


def test_clips_with_a_skeleton_stay() -> None:
    clip = clip_of(person(1, 5))
    assert with_skeleton(clip) is clip


def test_the_floor_of_the_trial_stays() -> None:
    markers = {name: place + np.array([0.0, 50.0, 0.0]) for name, place in markers_on(clip_of(person(4, 30))).items()}
    one = solved(trial(markers))
    (floor,) = [value for name, value, _ in one.head.properties if name == "calibration floor"]
    assert float(floor) > 5.0
    assert any("floor of the trial" in notice.what for notice in one.notices)


REAL = ("lab/hc030a05.c3d", "lab/s4_am_gait04.c3d", "lab/mh0222_bp06.c3d", "lab/walking5.c3d")
ANGLES = {"left-knee-flexion": 0.3, "right-hip-flexion": 0.5, "left-ankle-dorsiflexion": 1.5}


@pytest.mark.parametrize("name", REAL)
def test_real_trials_keep_their_angles(name: str, shared: Path) -> None:
    """Angles of the skeleton are those of the markers, whose bones change their lengths."""
    motion = mcml.read(shared / name)
    (made,) = motion.skeletons()
    assert made.bones[0] == "Root"
    for angle, most in ANGLES.items():
        one, two = motion.angle(angle), made.angle(angle)
        both = np.isfinite(one) & np.isfinite(two)
        assert np.count_nonzero(both) > 0.2 * len(one)
        assert np.sqrt(np.mean((one[both] - two[both]) ** 2)) < most, angle
