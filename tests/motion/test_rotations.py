"""Rotations against SciPy's."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from mcml.motion.rotations import (
    IDENTITY,
    from_euler,
    from_fixed_euler,
    from_matrix,
    inverse,
    multiply,
    rotate,
    shortest_arc,
    slerp,
    to_euler,
    to_matrix,
)

ORDERS = ["".join(letters) for letters in itertools.permutations("XYZ")]
SHORT_ORDERS = ["".join(letters) for count in (1, 2) for letters in itertools.permutations("XYZ", count)]
angle = st.one_of(
    st.floats(-10, 10),
    st.sampled_from([0.0, np.pi / 2, -np.pi / 2, np.pi, -np.pi, 3 * np.pi / 2]),
    st.builds(lambda side, gap: side * (np.pi / 2 - gap), st.sampled_from([-1, 1]), st.floats(-1e-6, 1e-6)),
)
triples = st.lists(st.tuples(angle, angle, angle), min_size=1, max_size=8).map(np.array)


@pytest.mark.parametrize("order", ORDERS + SHORT_ORDERS)
def test_euler_angles_mean_what_scipy_means(order: str) -> None:
    angles = np.random.default_rng(1).uniform(-7, 7, (200, len(order)))
    listed = Rotation.from_euler(order, angles).as_matrix()
    fixed = Rotation.from_euler(order.lower(), angles).as_matrix()
    assert np.abs(to_matrix(from_euler(angles, order)) - listed).max() < 1e-14
    assert np.abs(to_matrix(from_fixed_euler(angles, order)) - fixed).max() < 1e-14


@pytest.mark.parametrize("order", [*ORDERS, "ZXZ"])
def test_euler_angles_are_the_product_of_their_rotations(order: str) -> None:
    angles = np.random.default_rng(2).uniform(-7, 7, (50, 3))
    product = np.tile(IDENTITY, (50, 1))
    for column, letter in enumerate(order):
        step = np.zeros((50, 4))
        step[:, "XYZ".index(letter)], step[:, 3] = np.sin(angles[:, column] / 2), np.cos(angles[:, column] / 2)
        product = multiply(product, step)
    assert np.array_equal(from_euler(angles, order), product)


def test_no_axis_is_no_rotation() -> None:
    assert np.array_equal(from_euler(np.empty((3, 0)), ""), np.tile(IDENTITY, (3, 1)))


@pytest.mark.parametrize("order", ORDERS)
@given(angles=triples)
def test_decomposition_gives_the_rotation_back(order: str, angles: np.ndarray) -> None:
    rotations = from_euler(angles, order)
    found = to_euler(rotations, order)
    assert np.abs(to_matrix(from_euler(found, order)) - to_matrix(rotations)).max() < 1e-10


@pytest.mark.parametrize("order", ORDERS)
@given(seed=st.integers(0, 10_000), cut=st.integers(0, 40))
def test_frames_in_blocks_give_the_same_angles(order: str, seed: int, cut: int) -> None:
    angles = np.cumsum(np.random.default_rng(seed).normal(0, 0.5, (40, 3)), axis=0)
    angles[seed % 40, 1] = np.pi / 2
    rotations = from_euler(angles, order)
    whole = to_euler(rotations, order)
    first = to_euler(rotations[:cut], order)
    second = to_euler(rotations[cut:], order, first[-1] if len(first) else None)
    assert np.abs(np.vstack([first, second]) - whole).max() < 1e-9


@pytest.mark.parametrize("order", ORDERS)
def test_smooth_motion_gives_smooth_angles(order: str) -> None:
    """The middle angle passes a quarter turn and whole turns go by; no angle jumps."""
    time = np.linspace(0, 20, 5000)
    angles = np.stack([3 * np.sin(time), 2.5 * np.sin(1.3 * time), time], axis=-1)
    found = to_euler(from_euler(angles, order), order)
    assert np.abs((found - angles) - (found - angles)[0]).max() < 1e-9


@pytest.mark.parametrize("order", ORDERS)
def test_locked_frames_keep_the_last_angle(order: str) -> None:
    angles = np.array([[0.1, 1.4, 0.7], [0.2, np.pi / 2, 0.7], [0.3, np.pi / 2, 0.7], [0.3, 1.5, 0.7]])
    found = to_euler(from_euler(angles, order), order)
    assert np.abs(found - angles).max() < 1e-7
    alone = to_euler(from_euler(angles[1:2], order), order)
    assert alone[0, 2] == 0.0


def test_products_inverses_and_vectors() -> None:
    rng = np.random.default_rng(2)
    a, b = Rotation.random(500, rng=rng), Rotation.random(500, rng=rng)
    vectors = rng.normal(size=(500, 3))
    assert np.abs(to_matrix(multiply(a.as_quat(), b.as_quat())) - (a * b).as_matrix()).max() < 1e-14
    assert np.abs(rotate(a.as_quat(), vectors) - a.apply(vectors)).max() < 1e-14
    assert np.abs(to_matrix(inverse(a.as_quat())) - a.inv().as_matrix()).max() < 1e-14
    assert np.abs(to_matrix(from_matrix(a.as_matrix())) - a.as_matrix()).max() < 1e-14
    halves = Rotation.from_rotvec(np.pi * np.eye(3)).as_matrix()
    assert np.abs(to_matrix(from_matrix(halves)) - halves).max() < 1e-14


def require_same(found: np.ndarray, wanted: np.ndarray) -> None:
    """Both are the same unit quaternions, of either sign."""
    assert found.shape == wanted.shape
    assert np.allclose(np.abs((found * wanted).sum(axis=-1)), 1.0)
    assert np.allclose(np.linalg.norm(found, axis=-1), 1.0)


@pytest.mark.parametrize("shape", [(), (1,), (2, 3), (4, 1, 2)])
def test_rotations_come_in_arrays_of_any_shape(shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(5)
    count = int(np.prod(shape))
    a, b = Rotation.random(count, rng=rng), Rotation.random(count, rng=rng)
    first, second = a.as_quat().reshape(*shape, 4), b.as_quat().reshape(*shape, 4)
    matrices = a.as_matrix().reshape(*shape, 3, 3)
    vectors = rng.normal(size=(*shape, 3))
    assert np.allclose(to_matrix(first), matrices, atol=1e-14)
    require_same(from_matrix(matrices), first)
    require_same(multiply(first, second), (a * b).as_quat().reshape(*shape, 4))
    assert np.allclose(rotate(first, vectors), a.apply(vectors.reshape(-1, 3)).reshape(*shape, 3))
    assert np.allclose(multiply(first, inverse(first)), IDENTITY)


def test_shortest_arc_takes_one_direction_to_the_other() -> None:
    rng = np.random.default_rng(3)
    for start, end in [*rng.normal(size=(50, 2, 3)), (np.eye(3)[0], -np.eye(3)[0]), (np.eye(3)[1], np.eye(3)[1])]:
        turned = rotate(shortest_arc(start, end), start / np.linalg.norm(start))
        assert np.abs(turned - end / np.linalg.norm(end)).max() < 1e-12


def test_slerp_goes_the_shorter_way_at_even_speed() -> None:
    rng = np.random.default_rng(4)
    for _ in range(20):
        pair = Rotation.random(2, rng=rng)
        steps = np.linspace(0, 1, 7)
        expected = Slerp([0, 1], pair)(steps).as_matrix()
        start, end = pair.as_quat()
        assert np.abs(to_matrix(slerp(start, end, steps)) - expected).max() < 1e-12
        assert np.abs(to_matrix(slerp(start, -end, steps)) - expected).max() < 1e-12
    assert np.abs(slerp(IDENTITY, IDENTITY, np.array(0.5)) - IDENTITY).max() < 1e-15


def test_slerp_of_many_pairs_is_that_of_each_pair() -> None:
    random = np.random.default_rng(4)
    start, end = (Rotation.random(40, random_state=seed).as_quat() for seed in (1, 2))
    share = random.uniform(0, 1, 40)
    found = slerp(start, end, share)
    expected = [
        Slerp([0.0, 1.0], Rotation.from_quat([one, other]))(at).as_matrix()
        for one, other, at in zip(start, end, share, strict=True)
    ]
    np.testing.assert_allclose(to_matrix(found), expected, atol=1e-12)
    # Rotations that are the same, or nearly so, have no arc between them.
    np.testing.assert_allclose(slerp(start, -start, share), start, atol=1e-12)
    near = start + 1e-11 * end
    np.testing.assert_allclose(np.linalg.norm(slerp(start, near, share), axis=1), 1.0, atol=1e-12)


@pytest.mark.parametrize("start", [(0.0, 3.0, 0.0), (2.0, -1.0, 0.5), (0.0, 0.0, -4.0)])
def test_opposite_directions_are_half_a_turn_apart(start: tuple[float, float, float]) -> None:
    turn = shortest_arc(np.array(start), -2 * np.array(start))
    assert np.linalg.norm(turn) == pytest.approx(1.0)
    np.testing.assert_allclose(rotate(turn, np.array(start)), -np.array(start), atol=1e-12)
