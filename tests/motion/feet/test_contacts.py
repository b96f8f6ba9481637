"""When feet stand, and legs that reach."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mcml.motion.feet.contacts import contact_flags, hysteresis, sliding
from mcml.motion.feet.two_bones import two_bones
from mcml.numerics.runs import find_true

UP = np.array([0.0, 1.0, 0.0])


@given(seed=st.integers(0, 100_000))
def test_contacts_of_a_made_walk(seed: int) -> None:
    """Stands, swings, stands: known to the frame, but for the frames in which it is only just lifted."""
    rng = np.random.default_rng(seed)
    leg = rng.uniform(0.1, 100)
    spans, places, at = [], [], np.zeros(3)
    for _ in range(4):
        stand, swing = int(rng.integers(15, 40)), int(rng.integers(20, 40))
        spans.append((len(places), len(places) + stand - 1))
        places += [at + rng.normal(0, 1e-5, 3) * leg for _ in range(stand)]
        part = (np.arange(1, swing) / swing)[:, None]
        places += list(at + leg * (part * [0.7, 0, 0] + 0.2 * np.sin(np.pi * part) * [0, 1, 0]))
        at = at + leg * np.array([0.7, 0, 0])
    flags = contact_flags(np.array(places), 1 / 60, leg, UP)
    found = [(first, end - 1) for first, end in find_true(flags).tolist()]
    assert len(found) == 4
    for (first, last), (start, end) in zip(found, spans, strict=True):
        assert abs(first - start) <= 2
        assert abs(last - end) <= 2


def test_a_foot_that_never_rests_has_no_contact() -> None:
    places = np.arange(100)[:, None] * np.array([0.1, 0.0, 0.0])
    assert not contact_flags(places, 1 / 30, 1.0, UP).any()
    assert not contact_flags(places[:1], 1 / 30, 1.0, UP).any()
    assert not contact_flags(places, 1 / 30, 0.0, UP).any()


@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=40))
def test_hysteresis_is_that_of_a_switch(flags: list[tuple[bool, bool]]) -> None:
    begins = np.array([one and other for one, other in flags])
    stays = np.array([other for _, other in flags])
    found = hysteresis(begins, stays)
    for first, end in find_true(found):
        assert begins[first:end].any()
        assert stays[first:end].all()
        assert first == 0 or not stays[first - 1]
        assert end == len(flags) or not stays[end]
    assert (found | ~begins).all()


def test_sliding_is_along_the_ground() -> None:
    places = np.array([[0.0, 0, 0], [3, 5, 4], [3, 9, 4], [9, 9, 9]])
    assert sliding(places, [(0, 2)], UP) == pytest.approx(5.0)
    assert sliding(places, [], UP) == 0.0


@given(seed=st.integers(0, 100_000))
def test_a_leg_reaches_what_it_can(seed: int) -> None:
    rng = np.random.default_rng(seed)
    hip, knee, ankle = rng.normal(size=(3, 8, 3))
    a, b = np.linalg.norm(knee - hip, axis=1), np.linalg.norm(ankle - knee, axis=1)
    goal = hip + rng.normal(size=(8, 3)) * 1.2
    turn, bend = two_bones(hip, knee, ankle, goal)
    new_knee = hip + Rotation.from_quat(turn).apply(knee - hip)
    new_ankle = new_knee + (Rotation.from_quat(turn) * Rotation.from_quat(bend)).apply(ankle - knee)
    assert np.allclose(np.linalg.norm(new_knee - hip, axis=1), a)
    assert np.allclose(np.linalg.norm(new_ankle - new_knee, axis=1), b)
    distance = np.linalg.norm(goal - hip, axis=1)
    fits = (distance < 0.999 * (a + b)) & (distance > np.abs(a - b) + 1e-6)
    assert np.abs(new_ankle - goal)[fits].max(initial=0.0) < 1e-7
    # What is out of reach is pointed at.
    line = (goal - hip) / distance[:, None]
    arrived = new_ankle - hip
    assert np.allclose(arrived / np.linalg.norm(arrived, axis=1, keepdims=True), line, atol=1e-6)
    # The knee stays in its plane and on its side.
    plane = np.cross(Rotation.from_quat(turn).apply(knee - hip), (Rotation.from_quat(turn)).apply(ankle - knee))
    bent = np.cross(new_knee - hip, new_ankle - new_knee)
    assert ((plane * bent).sum(axis=1) > -1e-9).all()


def test_a_leg_that_is_there_stays() -> None:
    rng = np.random.default_rng(3)
    hip, knee, ankle = rng.normal(size=(3, 5, 3))
    turn, bend = two_bones(hip, knee, ankle, ankle)
    assert np.abs(turn[:, :3]).max() < 1e-12
    assert np.abs(bend[:, :3]).max() < 1e-12


def test_a_straight_leg_bends_as_it_did() -> None:
    hip = np.zeros((2, 3))
    knee = np.array([[0.0, -1, 0.0], [0, -1, 0]])
    ankle = np.array([[0.0, -2, 0], [0.0, -1.9, -0.3]])
    goal = np.array([[0.0, -1.5, 0], [0.0, -1.5, 0]])
    turn, bend = two_bones(hip, knee, ankle, goal)
    knees = Rotation.from_quat(turn).apply(knee)
    assert (knees[:, 2] > 0.3).all()
    assert np.abs(bend[:, 0]).min() > 0.1
    # Straight in all frames: some plane.
    turn, bend = two_bones(hip[:1], knee[:1], ankle[:1], goal[:1])
    arrived = Rotation.from_quat(turn).apply(knee[:1] + Rotation.from_quat(bend).apply(ankle[:1] - knee[:1]))
    assert arrived[0] == pytest.approx(goal[0], abs=1e-9)
