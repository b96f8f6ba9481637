"""The blend against SciPy's, and closed forms against refits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import RBFInterpolator
from scipy.optimize import linprog

from mcml_service.analysis.reach_blending.blend import (
    choose,
    fit_blend,
    groups_of,
    invert,
    leavable,
    leave_out,
    linear_left_out,
    nearest_distances,
    nearest_left_out,
    terms,
)
from mcml_service.analysis.reach_blending.model import cardinal_of
from mcml_service.analysis.reach_blending.trust import TOUCHING, most_influential, nearest_in_hull

seeds = st.integers(0, 10_000)


def scattered(seed: int, count: int = 30, dimensions: int = 3) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(count, dimensions))
    return x, np.stack([np.sin(x[:, 0]) + x[:, 1] ** 2, x.sum(axis=1), rng.normal(size=count)], axis=1)


@given(seeds, st.sampled_from([0.5, 1.0, 3.0]), st.sampled_from([0.0, 1e-2, 1.0]), st.sampled_from([0, 1]))
def test_blends_are_scipys(seed: int, s: float, lam: float, degree: int) -> None:
    x, y = scattered(seed)
    ours = fit_blend(x, y, s, lam, degree)
    theirs = RBFInterpolator(x, y, kernel="gaussian", epsilon=1 / s, smoothing=lam, degree=degree)
    at = np.random.default_rng(seed + 1).normal(size=(20, 3))
    condition = invert(x, s, lam, degree).condition
    assert np.abs(ours(at) - theirs(at)).max() < 1e-12 * condition + 1e-9


@given(seeds, st.sampled_from([0, 1]))
def test_radial_weights_are_orthogonal_to_the_polynomial(seed: int, degree: int) -> None:
    x, y = scattered(seed)
    blend = fit_blend(x, y, 1.0, 0.1, degree)
    assert np.abs(terms(x, degree).T @ blend.radial).max() < 1e-10


@given(seeds)
def test_without_ridge_examples_are_met(seed: int) -> None:
    x, y = scattered(seed)
    assert np.abs(fit_blend(x, y, 0.8, 0.0, 1)(x) - y).max() < 1e-7


@given(seeds, st.sampled_from([0.0, 0.1]), st.sampled_from([0, 1]))
def test_left_out_predictions_are_those_of_refits(seed: int, lam: float, degree: int) -> None:
    x, y = scattered(seed)
    groups = groups_of((np.arange(30) * 7 % 9).tolist())
    found = leave_out(invert(x, 0.9, lam, degree), y, groups)
    linear, nearest = linear_left_out(x, y, degree, groups), nearest_left_out(x, y, groups)
    for rows in groups:
        others = np.setdiff1d(np.arange(30), rows)
        refit = fit_blend(x[others], y[others], 0.9, lam, degree)
        assert np.abs(found[rows] - refit(x[rows])).max() < 1e-6
        solved = np.linalg.lstsq(terms(x[others], degree), y[others], rcond=None)[0]
        assert np.abs(linear[rows] - terms(x[rows], degree) @ solved).max() < 1e-8
        for row in rows:
            closest = min(others, key=lambda other: float(np.linalg.norm(x[other] - x[row])))
            assert np.array_equal(nearest[row], y[closest])


def test_groups_that_carry_the_polynomial_cannot_be_left_out() -> None:
    x = np.array([[0.0], [0.0], [0.0], [1.0]])
    kept = leavable(x, 1, [np.array([row]) for row in range(4)])
    assert [rows.tolist() for rows in kept] == [[0], [1], [2]]
    assert leavable(np.zeros((4, 1)), 1, [np.array([0])]) == []
    assert len(leavable(x, 0, [np.array([3])])) == 1


@given(seeds)
def test_weights_sum_to_one_and_give_the_blend(seed: int) -> None:
    x, y = scattered(seed)
    blend = fit_blend(x, y, 1.2, 0.05, 1)
    at = np.random.default_rng(seed).normal(size=3)
    row = np.concatenate([np.exp(-np.sum((x - at) ** 2, axis=1) / 1.2**2), [1.0], at])
    weights = cardinal_of(blend) @ row
    assert weights.sum() == pytest.approx(1.0)
    assert np.allclose(weights @ y, blend(at[None])[0])


def test_equal_examples_have_no_inverse() -> None:
    x, _ = scattered(1)
    x[4] = x[9]
    assert invert(x, 1.0, 0.0, 1).condition > 1e14
    assert invert(x, 1.0, 1e-3, 1).condition < 1e6


def test_the_best_width_and_ridge_are_chosen_and_singular_ones_skipped() -> None:
    x, y = scattered(2)
    x[4] = x[9]
    alone = [np.array([row]) for row in range(len(x))]

    def error(predicted: np.ndarray) -> float:
        return float(np.mean((predicted - y) ** 2))

    chosen = choose(x, [y], [error], [0.5, 2.0], [0.0, 0.1, 1.0], 1, alone)[0]
    assert chosen is not None
    assert len(chosen.tried) == 6
    for s, lam, condition, found in chosen.tried:
        assert np.isinf(found) == (lam == 0.0) == (condition > 1e14)
        if lam:
            refits = np.empty_like(y)
            for row in range(len(x)):
                others = np.arange(len(x)) != row
                refits[row] = fit_blend(x[others], y[others], s, lam, 1)(x[row : row + 1])[0]
            assert found == pytest.approx(error(refits), rel=1e-6)
    assert chosen.error == min(row[3] for row in chosen.tried)
    assert choose(x, [y], [error], [0.5, 2.0], [0.0], 1, alone) == [None]


def in_hull(points: np.ndarray, x: np.ndarray) -> bool:
    size = float(np.ptp(points, axis=0).max()) or 1.0
    return bool(np.linalg.norm(nearest_in_hull(points, x) - x) <= TOUCHING * size)


def feasible(points: np.ndarray, x: np.ndarray) -> bool:
    equations = np.vstack([points.T, np.ones(len(points))])
    return bool(linprog(np.zeros(len(points)), A_eq=equations, b_eq=[*x, 1.0]).status == 0)


@given(seeds, st.integers(1, 4), st.floats(0, 2))
def test_hulls_are_those_of_linear_programs(seed: int, dimensions: int, reach: float) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(25, dimensions))
    x = rng.normal(size=dimensions) * reach
    assert in_hull(points, x) == feasible(points, x)
    nearest = nearest_in_hull(points, x)
    assert feasible(points, nearest * (1 - 1e-9) + points.mean(axis=0) * 1e-9)
    # A point of a convex set is the nearest one where no other lies on its near side.
    assert ((points - nearest) @ (x - nearest)).max() < 1e-7


def test_corners_belong_to_the_hull_and_points_beyond_do_not() -> None:
    points = np.random.default_rng(0).normal(size=(40, 3))
    corner = points[np.argmax(points[:, 0])]
    assert in_hull(points, corner)
    assert not in_hull(points, corner + np.array([1e-4, 0, 0]))
    assert in_hull(np.zeros((3, 2)), np.zeros(2))


def test_influence_is_by_magnitude() -> None:
    assert most_influential(np.array([0.1, -0.5, 0.3, -0.3]), 3).tolist() == [1, 2, 3]


def test_nearest_distances_leave_out_oneself() -> None:
    assert nearest_distances(np.array([[0.0], [1.0], [3.0]])).tolist() == [1.0, 1.0, 2.0]
