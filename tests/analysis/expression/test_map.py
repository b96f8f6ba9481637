"""Maps, against whole eigenproblems and scikit-learn."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.manifold import Isomap, trustworthiness

from mcml.motion.skeleton import Array
from mcml_service.analysis.expression_space.planar_map import (
    Scaling,
    agreement,
    agreement_between,
    classical_scaling,
    neighbourhoods,
)
from tests.analysis.expression.face_motions import space


def apart_of(points: Array) -> Array:
    found: Array = np.linalg.norm(points[:, None] - points[None], axis=2)
    return found


def whole(apart: Array, dimensions: int) -> tuple[Array, Array]:
    """Classical scaling by the book."""
    n = len(apart)
    j = np.eye(n) - 1 / n
    values, vectors = np.linalg.eigh(-0.5 * j @ apart**2 @ j)
    values, vectors = values[::-1][:dimensions], vectors[:, ::-1][:, :dimensions]
    vectors = vectors * np.sign(vectors[np.abs(vectors).argmax(axis=0), np.arange(dimensions)])
    return vectors * np.sqrt(values), values


def geodesics() -> Array:
    found: Array = np.asarray(space().geodesics, dtype=float)
    return found


def test_points_of_a_plane_are_found_again() -> None:
    points = np.random.default_rng(0).normal(size=(120, 2)) * (50, 10)
    found = classical_scaling(apart_of(points), 4)
    assert np.allclose(apart_of(found.coordinates), apart_of(points), atol=1e-8)
    assert np.allclose(found.coordinates[:, 2:], 0)
    assert (found.eigenvalues[2:] == 0).all()


@pytest.mark.parametrize("count", [20, 300])
def test_lanczos_is_the_whole_eigenproblem(count: int) -> None:
    apart = geodesics()[:count, :count]
    found = classical_scaling(apart, 10)
    coordinates, values = whole(apart, 10)
    assert np.allclose(found.eigenvalues, values, rtol=1e-9)
    assert np.allclose(found.coordinates, coordinates, atol=1e-6 * np.abs(coordinates).max())


def test_the_map_is_scikit_learns() -> None:
    apart = geodesics()
    neighbours = Isomap(n_neighbors=len(apart) - 1, n_components=2, metric="precomputed", eigen_solver="dense")
    wanted = neighbours.fit_transform(apart)
    found = classical_scaling(apart, 2).coordinates
    sign = np.sign((wanted * found).sum(axis=0))
    assert np.allclose(found, wanted * sign, atol=1e-6 * np.abs(found).max())


def test_agreement_is_pearsons_r_and_stress() -> None:
    apart = geodesics()
    for dimensions in (2, 3, 5, 10):
        coordinates = space().coordinates[:, :dimensions]
        i, j = np.triu_indices(len(apart), 1)
        g, d = apart[i, j], np.linalg.norm(coordinates[i] - coordinates[j], axis=1)
        found = agreement(apart, coordinates)
        assert found.r == pytest.approx(np.corrcoef(g, d)[0, 1], abs=1e-9)
        assert found.stress == pytest.approx(np.sqrt(((g - d) ** 2).sum() / (g**2).sum()), rel=1e-9)
    between = agreement_between(apart[:5], coordinates[:5], coordinates)
    d = np.linalg.norm(coordinates[:5, None] - coordinates[None], axis=2)
    assert between.r == pytest.approx(np.corrcoef(apart[:5].ravel(), d.ravel())[0, 1], abs=1e-9)


def test_r_is_undefined_for_equal_distances() -> None:
    apart = 1.0 - np.eye(30)
    assert np.isnan(agreement(apart, np.zeros((30, 2))).r)


def test_landmarks_are_placed_where_they_are() -> None:
    apart = geodesics()[::5, ::5]
    scaling = classical_scaling(apart, 6)
    assert np.allclose(scaling.place(apart**2), scaling.coordinates, atol=1e-6)


def test_points_of_a_plane_are_placed_by_landmarks() -> None:
    points = np.random.default_rng(1).normal(size=(80, 2)) * (50, 20)
    scaling: Scaling = classical_scaling(apart_of(points[:15]), 2)
    placed = scaling.place(np.linalg.norm(points[:, None] - points[None, :15], axis=2) ** 2)
    assert np.allclose(apart_of(placed), apart_of(points), atol=1e-7)


def test_the_negative_share_is_that_of_the_spectrum() -> None:
    rng = np.random.default_rng(2)
    apart = rng.uniform(1, 2, (40, 40))
    apart = np.triu(apart, 1) + np.triu(apart, 1).T
    j = np.eye(40) - 1 / 40
    values = np.linalg.eigvalsh(-0.5 * j @ apart**2 @ j)
    assert classical_scaling(apart, 2).negative == pytest.approx(-values[values < 0].sum() / np.abs(values).sum())


def test_neighbourhoods_are_scikit_learns_trustworthiness() -> None:
    rng = np.random.default_rng(3)
    points = rng.normal(size=(90, 4)) * (30, 20, 15, 10)
    shown = points[:, :2]
    found = neighbourhoods(apart_of(points), shown)
    assert found[0] == pytest.approx(trustworthiness(points, shown, n_neighbors=10))
    assert found[1] == pytest.approx(trustworthiness(shown, points, n_neighbors=10))
    assert neighbourhoods(apart_of(points), points) == (1.0, 1.0)
