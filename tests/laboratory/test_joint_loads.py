"""Moments and powers of legs whose mechanics are known."""

from __future__ import annotations

import numpy as np
import pytest

from mcml.laboratory.gait_model.dynamics import Ground, derive, joint_loads, spin_of
from mcml.laboratory.gait_model.lower_body import Leg
from mcml.motion.skeleton import Array
from tests.laboratory.gait_bodies import turn

UP = np.array([0.0, 0.0, 1.0])
MASS, RATE, FRAMES, GRAVITY = 60.0, 200.0, 400, 9.81
SHARES = {"Ankle": (0.0145, 0.5), "Knee": (0.0465, 0.433), "Hip": (0.1, 0.433)}


def standing_leg(count: int = FRAMES) -> tuple[Leg, Array]:
    """(leg, toe) upright, in millimetres, with the foot forward along x."""
    frame = np.repeat(np.eye(3)[None], count, axis=0)
    hip, knee, ankle, toe = (np.tile(place, (count, 1)) for place in
                             ([0.0, 0, 880], [0.0, 0, 480], [0.0, 0, 80], [150.0, 0, 20]))  # fmt: skip
    return Leg(hip, knee, ankle, frame, frame, frame, frame), toe


def ground(force: Array, centre: Array, moment: Array, count: int = FRAMES) -> Ground:
    return Ground(*(np.tile(value, (count, 1)) for value in (force, centre, moment)))


@pytest.mark.parametrize("side", ["L", "R"])
def test_a_leg_that_stands_holds_what_is_on_it(side: str) -> None:
    """Statics: the moment at a joint balances the ground and the weights of the segments below it."""
    leg, toe = standing_leg()
    force, centre, free = np.array([15.0, -20.0, 600.0]), np.array([0.09, 0.02, 0.0]), np.array([0.0, 0.0, 3.0])
    loads = joint_loads(side, leg, leg.thigh, toe, ground(force, centre, free), MASS, RATE, UP)
    below = []
    k = 1 if side == "L" else -1
    for joint, (begin, end) in {"Ankle": (leg.ankle, toe), "Knee": (leg.knee, leg.ankle),
                                "Hip": (leg.hip, leg.knee)}.items():  # fmt: skip
        share, along = SHARES[joint]
        begin, end = begin[0] / 1000, end[0] / 1000
        below.append((share * MASS, begin + along * (end - begin)))
        outer = np.cross(centre - begin, force) + free
        outer += sum(np.cross(place - begin, -mass * GRAVITY * UP) for mass, place in below)
        x, y, z = -outer * 1000 / MASS
        expected = [-y if joint == "Knee" else y, k * x, k * z]
        np.testing.assert_allclose(loads[joint].moment, np.tile(expected, (FRAMES, 1)), atol=1e-6)
        np.testing.assert_allclose(loads[joint].power, 0.0, atol=1e-9)
    # The ground is in front of the ankle: the calf holds it, which is positive.
    assert loads["Ankle"].moment[0, 0] > 500


def test_a_foot_in_the_air_swings_as_a_pendulum() -> None:
    """Of a foot without load that turns about a resting ankle: its moment is I a - weight, its power that times w."""
    leg, toe = standing_leg()
    seconds = np.arange(FRAMES) / RATE
    theta = 0.4 * np.sin(2 * np.pi * 1.5 * seconds)
    size = 0.15
    way = np.stack([np.cos(theta), np.zeros(FRAMES), -np.sin(theta)], axis=1)
    foot = np.stack([turn("y", degrees) for degrees in np.degrees(theta)])
    toe = leg.ankle + 1000 * size * way
    swing = Leg(leg.hip, leg.knee, leg.ankle, leg.thigh, leg.torsioned, leg.shank, foot)
    none = ground(np.zeros(3), np.zeros(3), np.zeros(3))
    load = joint_loads("L", swing, leg.thigh, toe, none, MASS, RATE, UP)["Ankle"]
    speed = np.gradient(theta, seconds)
    own = 0.0145 * MASS
    inertia = own * ((0.69 * size) ** 2 + (0.5 * size) ** 2)
    moment = inertia * np.gradient(speed, seconds) - own * GRAVITY * 0.5 * size * np.cos(theta)
    inner = slice(40, -40)
    np.testing.assert_allclose(load.moment[inner, 0], moment[inner] * 1000 / MASS, atol=0.2)
    np.testing.assert_allclose(load.power[inner], (moment * speed)[inner] / MASS, atol=2e-3)


def test_loads_are_unknown_where_the_ground_is() -> None:
    leg, toe = standing_leg()
    under = ground(np.array([0.0, 0.0, 600.0]), np.zeros(3), np.zeros(3))
    under.force[100:150] = np.nan
    for load in joint_loads("L", leg, leg.thigh, toe, under, MASS, RATE, UP).values():
        assert np.flatnonzero(np.isnan(load.power)).tolist() == list(range(100, 150))


def test_changes_of_short_and_gappy_motions() -> None:
    assert np.isnan(derive(np.zeros((1, 3)), RATE)).all()
    assert np.isnan(spin_of(np.eye(3)[None], RATE)).all()
    turning = np.stack([turn("z", degrees) for degrees in np.arange(100.0)])
    turning[50] = np.nan
    spin = spin_of(turning, RATE)
    assert np.isnan(spin[49:52]).all()
    np.testing.assert_allclose(spin[:40, 2], np.radians(RATE), rtol=1e-3)


@pytest.mark.parametrize("axis", "xyz")
def test_the_spin_of_a_frame_is_about_its_axis(axis: str) -> None:
    frames = np.stack([turn(axis, 90.0 * at / RATE) for at in range(FRAMES)])
    expected = np.zeros(3)
    expected["xyz".index(axis)] = np.pi / 2
    np.testing.assert_allclose(spin_of(frames, RATE)[20:-20], np.tile(expected, (FRAMES - 40, 1)), atol=1e-3)
    assert np.isnan(spin_of(frames[:1], RATE)).all()


def test_power_is_of_the_spins_of_both_segments() -> None:
    """Of a leg that turns as one about the ankle, the knee has a moment and no power; the ankle has both."""
    leg, toe = standing_leg()
    degrees = 8 * np.sin(2 * np.pi * np.arange(FRAMES) / RATE)
    turns = np.stack([turn("y", value) for value in degrees])
    still = np.repeat(np.eye(3)[None], FRAMES, axis=0)
    swung = {
        name: leg.ankle + (turns @ (getattr(leg, name) - leg.ankle)[:, :, None])[:, :, 0] for name in ("hip", "knee")
    }
    moving = Leg(swung["hip"], swung["knee"], leg.ankle, turns, turns, turns, still)
    force = np.array([0.0, 0.0, 600.0]), np.array([0.05, 0.0, 0.0]), np.zeros(3)
    loads = joint_loads("L", moving, turns, toe, ground(*force), MASS, RATE, UP)
    inner = slice(60, -60)
    assert np.abs(loads["Knee"].moment[inner]).max() > 50
    np.testing.assert_allclose(loads["Knee"].power[inner], 0.0, atol=1e-9)
    np.testing.assert_allclose(loads["Hip"].power[inner], 0.0, atol=1e-9)
    assert np.abs(loads["Ankle"].power[inner]).max() > 0.1
