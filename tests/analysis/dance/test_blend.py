"""Weights, placement on the floor, blends of rotations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mcml.motion.rotations import from_euler, rotate
from mcml_service.analysis.dance import blend

transforms = st.tuples(st.floats(-3, 3), st.floats(-5, 5), st.floats(-5, 5)).map(np.array)


def test_the_weight_falls_from_one_to_zero_and_is_level_at_both_ends() -> None:
    part = np.linspace(0, 1, 1001)
    alpha = blend.weight(part)
    assert (alpha[0], alpha[-1]) == (1, 0)
    assert (np.diff(alpha) < 0).all()
    assert abs(alpha[1] - 1) < 1e-5
    assert abs(alpha[-2]) < 1e-5


def test_kovars_formula_is_the_same_curve() -> None:
    k = 20
    p = np.arange(-1, k)
    kovar = 2 * ((p + 1) / k) ** 3 - 3 * ((p + 1) / k) ** 2 + 1
    assert np.allclose(kovar, blend.weight(np.arange(k + 1) / k))


@given(outer=transforms, inner=transforms, seed=st.integers(0, 999))
def test_joined_transforms_are_one_after_the_other(outer: np.ndarray, inner: np.ndarray, seed: int) -> None:
    rng = np.random.default_rng(seed)
    point, turn = rng.normal(0, 1, (1, 1, 3)), from_euler(rng.normal(0, 1, (1, 1, 3)), "XYZ")
    step = blend.place_roots(inner[None], point, turn)
    expected = blend.place_roots(outer[None], *step)
    found = blend.place_roots(blend.join_transforms(outer, inner)[None], point, turn)
    assert np.allclose(found[0], expected[0])
    assert np.allclose(abs((found[1] * expected[1]).sum()), 1)


@given(transform=transforms, seed=st.integers(0, 999))
def test_a_placed_root_carries_its_body_along(transform: np.ndarray, seed: int) -> None:
    """A point of the body moves as the formula of the alignment says, whatever the root's rotation."""
    rng = np.random.default_rng(seed)
    place, bone = rng.normal(0, 1, (1, 1, 3)), rng.normal(0, 1, (1, 1, 3))
    turn = from_euler(rng.normal(0, 1, (1, 1, 3)), "XYZ")
    moved, turned = blend.place_roots(transform[None], place, turn)
    x, y, z = (place + rotate(turn, bone))[0, 0]
    theta, x0, z0 = transform
    expected = [x * np.cos(theta) + z * np.sin(theta) + x0, y, -x * np.sin(theta) + z * np.cos(theta) + z0]
    assert np.allclose((moved + rotate(turned, bone))[0, 0], expected)


@given(heading=st.floats(-3, 3), other=st.floats(-3, 3), seed=st.integers(0, 999))
def test_facing_turns_heading_and_place_of_the_second_root_to_the_first(
    heading: float, other: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    lean = from_euler(np.array([0.3, -0.2]), "XZ")
    turns = [(Rotation.from_euler("y", angle) * Rotation.from_quat(lean)).as_quat() for angle in (heading, other)]
    places = rng.normal(0, 1, (2, 3))
    transform = blend.facing(turns[0], places[0], turns[1], places[1])
    moved, turned = blend.place_roots(transform[None], places[1][None, None], turns[1][None, None])
    assert np.allclose(moved[0, 0, [0, 2]], places[0][[0, 2]])
    assert moved[0, 0, 1] == places[1][1]
    assert abs((turned[0, 0] * turns[0]).sum()) == pytest.approx(1)


@given(seed=st.integers(0, 9999), t=st.floats(0, 1))
def test_the_arc_turns_evenly_from_one_to_the_other(seed: int, t: float) -> None:
    rng = np.random.default_rng(seed)
    start, end = rng.normal(0, 1, (2, 4))
    start, end = start / np.linalg.norm(start), end / np.linalg.norm(end)
    found = blend.arc(start, end, np.array(t))
    angle = np.arccos(np.clip(start @ end, -1, 1))
    assert np.linalg.norm(found) == pytest.approx(1)
    assert found @ start == pytest.approx(np.cos(t * angle), abs=1e-6)
    assert found @ end == pytest.approx(np.cos((1 - t) * angle), abs=1e-6)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_arc_between_the_same_rotations_stands_still(sign: float) -> None:
    q = np.array([0.5, -0.5, 0.5, 0.5])
    for t in (0.0, 0.3, 0.5, 1.0):
        assert abs(blend.arc(q, sign * q, np.array(t)) @ q) == pytest.approx(1)


def test_tracks_are_continuous_whatever_signs_they_come_with() -> None:
    smooth = from_euler(np.linspace(0, 9, 50)[:, None], "X")[:, None]
    signs = np.random.default_rng(1).choice([-1.0, 1.0], 50)
    found = blend.continuous(smooth * signs[:, None, None])
    assert (np.sum(found[1:] * found[:-1], axis=-1) > 0).all()


def test_a_blend_does_not_flip_where_two_tracks_pass_half_a_turn() -> None:
    """The shortest arc frame by frame jumps there: seen 168 degrees in one frame."""
    frames = 60
    first = np.tile(from_euler(np.array([0.0]), "Y"), (frames, 1, 1))
    angles = np.radians(np.linspace(120, 230, frames))
    second = from_euler(angles[:, None], "Y")[:, None]
    signs = np.where(np.sum(first * second, axis=-1) < 0, -1.0, 1.0)[..., None]
    part = np.linspace(0, 1, frames + 2)[1:-1]
    found = Rotation.from_quat(blend.blend_rotations(first, second, blend.weight(part))[:, 0])
    steps = np.degrees((found[1:] * found[:-1].inv()).magnitude())
    assert steps.max() < 8
    shortest = Rotation.from_quat(blend.arc(first, second * signs, 1 - blend.weight(part)[:, None])[:, 0])
    assert np.degrees((shortest[1:] * shortest[:-1].inv()).magnitude()).max() > 90


@pytest.mark.parametrize("spin", [200.0, 330.0, 400.0])
def test_a_spin_is_blended_without_a_jolt(spin: float) -> None:
    """They meet, then one spins on: taken the other way around, the arc would have no direction where they meet."""
    part = np.linspace(0, 1, 102)[1:-1]
    tilt = from_euler(np.array([0.02, 0.01]), "XZ")
    first = from_euler(np.radians(spin * np.minimum(part * 3, 1))[:, None], "Y")[:, None]
    second = np.tile(tilt, (100, 1, 1))
    found = Rotation.from_quat(blend.blend_rotations(first, second, blend.weight(part))[:, 0])
    steps = np.degrees((found[1:] * found[:-1].inv()).magnitude())
    assert steps.max() < 16


@given(seed=st.integers(0, 999))
def test_a_blend_begins_with_the_first_and_ends_with_the_second(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, second = from_euler(np.cumsum(rng.normal(0, 0.1, (2, 20, 3, 3)), axis=1), "ZXY")
    alpha = np.ones(20)
    alpha[-1] = 0.0
    found = blend.blend_rotations(first, second, alpha)
    assert np.allclose(np.abs(np.sum(found[:-1] * first[:-1], axis=-1)), 1)
    assert np.allclose(np.abs(np.sum(found[-1] * second[-1], axis=-1)), 1)
    even, signs = np.linspace(1, 0, 20), rng.choice([-1.0, 1.0], (20, 3, 1))
    same, other = blend.blend_rotations(first, second, even), blend.blend_rotations(-first, second * signs, even)
    assert np.allclose(np.abs(np.sum(other * same, axis=-1)), 1)
