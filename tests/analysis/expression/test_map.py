"""Maps, against whole eigenproblems and scikit-learn; thresholds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse.csgraph import connected_components
from sklearn.manifold import Isomap

from service.analysis.expression_space import threshold
from service.analysis.expression_space.planar_map import (
    Scaling,
    agreement,
    agreement_between,
    classical_scaling,
)
from service.analysis.expression_space.threshold import Tried, candidates, choose, sampled_geodesics, try_threshold
from service.motion.skeleton import Array
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


def test_a_curve_of_thresholds() -> None:
    found = space()
    taus = [tried.tau for tried in found.tried]
    assert taus == sorted(taus)
    assert found.connecting is not None
    assert found.tried[0].tau >= found.connecting
    assert all(tried.components == 1 and tried.giant == 1.0 for tried in found.tried if tried.tau >= found.connecting)
    assert all(tried.stretch >= 1 - 1e-9 for tried in found.tried)
    best = max(tried.r for tried in found.tried)
    assert found.tau == min(tried.tau for tried in found.tried if tried.r >= best - 0.01)


def test_the_curve_is_that_of_the_whole_graph() -> None:
    """On few frames nothing is thinned: r is Pearson's over all geodesics."""
    apart = np.asarray(geodesics()[::8, ::8])

    def parts(tau: float) -> np.ndarray:
        return connected_components(apart <= tau, directed=False)[1].astype(np.intp)

    tried = try_threshold(apart, 150.0, parts)
    giant = np.flatnonzero(parts(150.0) == np.bincount(parts(150.0)).argmax())
    whole_graph = threshold.floyd(np.where(apart <= 150.0, apart, np.inf))[np.ix_(giant, giant)]
    coordinates, _ = whole(whole_graph, 2)
    assert tried.r == pytest.approx(agreement(whole_graph, coordinates).r, abs=1e-3)
    assert tried.components == parts(150.0).max() + 1


def test_thinning_hardly_lengthens_geodesics() -> None:
    points = np.random.default_rng(3).normal(size=(900, 3)) * (100, 40, 20)
    apart = apart_of(points)
    frames = np.arange(900)
    sample = frames[::9]
    exact = threshold.floyd(np.where(apart <= 60, apart, np.inf))[np.ix_(sample, sample)]
    found = sampled_geodesics(apart, 60.0, frames, sample)
    assert (found >= exact - 1e-9).all()
    assert found.mean() < 1.01 * exact.mean()


def _tried(tau: float, r: float, components: int = 1) -> Tried:
    return Tried(tau, r, 0.1, components, 1.0, 10.0, 1.0)


def test_rules_of_the_threshold() -> None:
    curve = [_tried(10, 0.985, 2), _tried(20, 0.975), _tried(40, 0.985), _tried(80, 0.991), _tried(160, 0.990)]
    assert choose(curve, "smallest", 100) == (40, None)
    assert choose(curve, "best", 100) == (80, None)
    assert choose(curve, "published", 100) == (pytest.approx(230), None)
    tau, why = choose([_tried(10, float("nan"))], "smallest", 50)
    assert tau == pytest.approx(115)
    assert why is not None


def test_thresholds_go_from_the_connecting_one_to_the_longest() -> None:
    taus = candidates(10.0, 1000.0, 12, [230.0])
    assert len(taus) == 13
    assert taus[0] == pytest.approx(10.0)
    assert taus[0] >= 10.0
    assert taus[-1] == pytest.approx(1000.0)
