"""Force plates: a known force at a known point, as each type of plate would measure it, comes back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcml.laboratory.force_plates import LEAST_FORCE, Plate, PlateForces, plate_forces

CORNERS = np.array([[0.5, 0.3, 0.02], [0.5, -0.3, 0.02], [-0.5, -0.3, 0.02], [-0.5, 0.3, 0.02]])
"""x of the plate is y of the laboratory, y is x, z is down."""
AXES = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
CENTRE = np.array([0.0, 0.0, 0.02])
ORIGIN = np.array([0.21, 0.35, -0.05])
TO_SURFACE = np.array([0.01, -0.02, -0.04])
"""From the origin of moments to the surface, plates of types 2 and 4."""
FORCES = st.tuples(st.floats(-300, 300), st.floats(-300, 300), st.floats(30, 3000))
POINTS = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.3, 0.3))
FREE = st.floats(-50, 50)


def plate_of(kind: int, **facts: object) -> Plate:
    count = 8 if kind == 3 else 6
    origin = ORIGIN if kind == 3 else TO_SURFACE
    calibration = np.linalg.inv(CROSS_TALK) if kind == 4 else None
    plate = Plate(kind, CORNERS, origin, tuple(range(count)), (1.0,) * count, calibration)
    return replace(plate, **facts)  # type: ignore[arg-type]


CROSS_TALK = np.eye(6) * [0.01, 0.02, 0.03, 0.04, 0.05, 0.06] + 0.0005 * np.arange(36).reshape(6, 6) / 36
"""Volts of a newton and a newton metre, with cross-talk."""


def measure(kind: int, force: np.ndarray, point: np.ndarray, free: float) -> np.ndarray:
    """(channels,) of a plate under a reaction force at a point with a free moment about up: all in the laboratory.

    Written from forces at four sensors and levers about points, without the formulas of the reader.
    """
    own, lever = AXES.T @ force, AXES.T @ (point - CENTRE)
    twist = np.array([0.0, 0.0, -free])
    if kind == 1:
        return np.array([*own, lever[0], lever[1], -free])
    if kind == 3:
        return eight(own, lever, -free)
    # A lever from the origin of moments, which is under the surface.
    about = np.cross(TO_SURFACE + lever, own) + twist
    channels = np.concatenate([own, about])
    return CROSS_TALK @ channels if kind == 4 else channels


def eight(force: np.ndarray, lever: np.ndarray, free: float) -> np.ndarray:
    """Solve for the forces of four sensors at (a, b), (-a, b), (-a, -b), (a, -b), below the surface by |z|."""
    a, b, depth = np.abs(ORIGIN)
    at = np.array([[a, b, 0], [-a, b, 0], [-a, -b, 0], [a, -b, 0]])
    # Seen from the sensors, the surface is at -depth along z, which points down.
    moment = np.cross(lever + np.array([0, 0, -depth]), force) + np.array([0, 0, free])
    columns = []
    for sensors, axis in [([0, 1], 0), ([2, 3], 0), ([0, 3], 1), ([1, 2], 1), *(([one], 2) for one in range(4))]:
        push = np.eye(3)[axis]
        columns.append(np.concatenate([push, np.mean([np.cross(at[one], push) for one in sensors], axis=0)]))
    channels, *_ = np.linalg.lstsq(np.array(columns).T, np.concatenate([force, moment]), rcond=None)
    return channels


@pytest.mark.parametrize("kind", [1, 2, 3, 4])
@given(force=FORCES, place=POINTS, free=FREE)
def test_a_known_force_comes_back(kind: int, force: tuple[float, ...], place: tuple[float, ...], free: float) -> None:
    pushed, point = np.array(force), np.array([*place, 0.02])
    found = plate_forces(plate_of(kind), measure(kind, pushed, point, free)[None])
    assert not found.problems
    assert not found.is_turned
    assert np.allclose(found.force[0], pushed, rtol=1e-9, atol=1e-9)
    assert np.allclose(found.centre_of_pressure[0], point, atol=1e-9)
    assert found.free_moment[0] == pytest.approx(free, abs=1e-8)
    assert found.vertical.tolist() == [0, 0, 1]


def turn(degrees: float, axis: int) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.roll(np.array([[1, 0, 0], [0, c, -s], [0, s, c]]), axis, (0, 1))


@given(force=FORCES, place=POINTS, free=FREE, spin=st.floats(-180, 180), tilt=st.floats(-30, 30))
def test_plates_stand_anywhere(
    force: tuple[float, ...], place: tuple[float, ...], free: float, spin: float, tilt: float
) -> None:
    rotation, shift = turn(spin, 2) @ turn(tilt, 0), np.array([3.0, -2.0, 0.5])
    plate = plate_of(2, corners=CORNERS @ rotation.T + shift)
    pushed, point = np.array(force), np.array([*place, 0.02])
    found = plate_forces(plate, measure(2, pushed, point, free)[None])
    assert np.allclose(found.force[0], rotation @ pushed, atol=1e-8)
    assert np.allclose(found.centre_of_pressure[0], rotation @ point + shift, atol=1e-8)
    assert found.free_moment[0] == pytest.approx(free, abs=1e-8)


def test_up_may_be_y() -> None:
    swap = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])
    pushed, point = np.array([20.0, -30, 800]), np.array([0.1, 0.2, 0.02])
    found = plate_forces(plate_of(2, corners=CORNERS @ swap.T), measure(2, pushed, point, 4.0)[None])
    assert found.vertical.tolist() == [0, 1, 0]
    assert np.allclose(found.force[0], swap @ pushed)
    assert np.allclose(found.centre_of_pressure[0], swap @ point)
    assert found.free_moment[0] == pytest.approx(4.0)


def test_corners_may_be_skew_and_in_the_other_order() -> None:
    measured = CORNERS + np.random.default_rng(1).normal(0, 0.004, (4, 3))
    axes = plate_of(2, corners=measured).axes
    assert np.allclose(axes.T @ axes, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1)
    # Where z of the plate is up, up is still the positive side.
    upside_down = plate_of(2, corners=CORNERS[[1, 0, 3, 2]])
    assert upside_down.axes[:, 2].tolist() == upside_down.vertical.tolist() == [0, 0, 1]
    assert not plate_forces(upside_down, np.array([[0, 0, 700.0, 0, 0, 0]])).is_turned
    assert plate_forces(upside_down, np.array([[0, 0, -700.0, 0, 0, 0]])).is_turned


@pytest.mark.parametrize("kind", [2, 4])
def test_origins_have_either_sign(kind: int) -> None:
    samples = measure(kind, np.array([80.0, -40, 700]), np.array([0.2, 0.1, 0.02]), 3.0)[None]
    one, other = (plate_forces(plate_of(kind, origin=sign * TO_SURFACE), samples) for sign in (1, -1))
    assert np.array_equal(one.centre_of_pressure, other.centre_of_pressure)


@pytest.mark.parametrize("kind", [2, 3, 4])
def test_the_force_on_the_ground_is_turned(kind: int) -> None:
    points = np.array([[0.2, 0.1, 0.02], [0.1, -0.1, 0.02], [0.0, 0.0, 0.02]])
    pushed = np.array([[80.0, -40, 700], [10, 20, 300], [1, 1, -25]])
    rows = [measure(kind, force, point, 3.0) for force, point in zip(pushed, points, strict=True)]
    right, turned = plate_forces(plate_of(kind), np.array(rows)), plate_forces(plate_of(kind), -np.array(rows))
    assert (right.is_turned, turned.is_turned) == (False, True)
    same(right, turned)
    assert np.allclose(right.force, pushed)
    # A foot does not pull the ground up.
    assert np.isnan(right.centre_of_pressure[2]).all()


def same(one: PlateForces, other: PlateForces) -> None:
    assert np.allclose(one.force, other.force, atol=1e-9)
    assert np.allclose(one.centre_of_pressure, other.centre_of_pressure, atol=1e-9, equal_nan=True)
    assert np.allclose(one.free_moment, other.free_moment, atol=1e-9, equal_nan=True)


def test_small_forces_have_no_centre_of_pressure() -> None:
    """Channels of single precision: a force of 0.1 N would have its centre kilometres away."""
    pushed = [LEAST_FORCE + 0.01, LEAST_FORCE - 0.01, 0.0]
    rows = [measure(2, np.array([0.0, 0.0, up]), np.array([0.1, 0.1, 0.02]), 1.0) for up in pushed]
    found = plate_forces(plate_of(2), np.array(rows))
    assert np.isnan(found.free_moment).tolist() == [False, True, True]
    assert np.isnan(found.centre_of_pressure).all(axis=1).tolist() == [False, True, True]
    assert np.allclose(found.force[:, 2], pushed)


def test_samples_without_a_number_stay_without() -> None:
    rows = np.array([measure(2, np.array([0.0, 0.0, up]), CENTRE, 0.0) for up in (500.0, 600.0)])
    rows[1, 3] = np.nan
    found = plate_forces(plate_of(2), rows)
    assert np.isfinite(found.centre_of_pressure[0]).all()
    assert np.isnan(found.centre_of_pressure[1, 0])
    assert not found.is_turned
    nothing = plate_forces(plate_of(2), np.full((3, 6), np.nan), 1000.0)
    assert np.isnan(nothing.force).all()
    assert np.isnan(nothing.offset)
    assert plate_forces(plate_of(2), np.zeros((0, 6)), 1000.0).force.shape == (0, 3)


def test_units_of_channels() -> None:
    samples = measure(2, np.array([80.0, -40, 700]), np.array([0.2, 0.1, 0.02]), 3.0)[None]
    millimetres = plate_of(2, factors=(1.0, 1.0, 1.0, 0.001, 0.001, 0.001))
    same(plate_forces(plate_of(2), samples), plate_forces(millimetres, samples * [1, 1, 1, 1000, 1000, 1000]))


@given(
    offset=st.floats(-19, 19),
    noise=st.floats(0, 1),
    sign=st.sampled_from([1.0, -1.0]),
    rate=st.sampled_from([60.0, 500.0]),
)
def test_offsets_are_told_and_not_applied(offset: float, noise: float, sign: float, rate: float) -> None:
    assume(abs(abs(offset) - 5.0) > 0.5)
    upward = np.concatenate([np.zeros(round(0.4 * rate)), 800 * np.sin(np.linspace(0, np.pi, round(0.6 * rate)))])
    upward += offset + noise * np.cos(np.arange(len(upward)) * 2.0)
    rows = sign * upward[:, None] * measure(2, np.array([0.0, 0.0, 1.0]), CENTRE, 0.0)
    found = plate_forces(plate_of(2), rows, rate)
    assert np.allclose(found.force[:, 2], upward)
    if abs(offset) < 5:
        assert np.isnan(found.offset)
    else:
        assert found.offset == pytest.approx(offset, abs=0.3)


def test_a_person_who_stands_is_no_offset() -> None:
    rows = np.array([measure(2, np.array([0.0, 0.0, 700.0]), CENTRE, 0.0)] * 1000)
    assert np.isnan(plate_forces(plate_of(2), rows, 1000.0).offset)


@pytest.mark.parametrize(
    ("plate", "problem"),
    [
        (plate_of(2, type=6), "force plate type 6 is not read"),
        (plate_of(2, corners=np.zeros((4, 3))), "its corners enclose no area"),
        (plate_of(2, corners=np.full((4, 3), np.nan)), "its corners are unknown"),
        (plate_of(2, corners=np.linspace(0, 1, 12).reshape(4, 3)), "its corners enclose no area"),
        (plate_of(2, channels=(0, 1)), "it has 2 channels, type 2 needs 6"),
        (plate_of(3, origin=np.array([np.nan, 0, 0])), "its origin is unknown"),
        (plate_of(4, calibration=None), "type 4 needs a calibration matrix, and it has none"),
        (plate_of(2, reasons=("its channels 9 are absent",), channels=()), "its channels 9 are absent"),
    ],
)
def test_plates_with_problems_have_no_numbers(plate: Plate, problem: str) -> None:
    found = plate_forces(plate, np.zeros((5, len(plate.channels))), 1000.0)
    assert found.problems == plate.problems == (problem,)
    assert found.force.shape == found.centre_of_pressure.shape == (5, 3)
    assert found.free_moment.shape == (5,)
    assert np.isnan(found.force).all()
    assert np.isnan(found.free_moment).all()
