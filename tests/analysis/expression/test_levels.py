"""Fuzzy c-means against scikit-fuzzy and the obvious way; levels of detail."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import skfuzzy
from hypothesis import given
from hypothesis import strategies as st

from mcml.motion.skeleton import Array
from mcml_service.analysis.expression_space.fuzzy_means import fuzzy_means, top_memberships
from mcml_service.analysis.expression_space.levels import farthest_order, level_sizes, make_levels
from mcml_service.analysis.expression_space.options import options_of
from tests.analysis.expression.face_motions import space


def points(seed: int = 0, count: int = 150, dimensions: int = 2) -> Array:
    rng = np.random.default_rng(seed)
    return rng.normal(size=(count, dimensions)) * 5 + rng.integers(0, 4, (count, 1)) * 20


def memberships_of(x: np.ndarray, v: np.ndarray, fuzziness: float = 2.0) -> np.ndarray:
    """(n, c): of each point in all clusters."""
    which, share = top_memberships(x, v, fuzziness, most=len(v))
    found = np.zeros((len(x), len(v)))
    np.put_along_axis(found, which, share, axis=1)
    return found


def naive_memberships(x: Array, v: Array, m: float) -> Array:
    u = np.zeros((len(x), len(v)))
    for i, point in enumerate(x):
        d = np.linalg.norm(v - point, axis=1)
        if (d == 0).any():
            u[i, d == 0] = 1 / (d == 0).sum()
        else:
            u[i] = [1 / sum((d[j] / d[k]) ** (2 / (m - 1)) for k in range(len(v))) for j in range(len(v))]
    return u


@pytest.mark.parametrize("fuzziness", [2.0, 1.6, 3.0])
@pytest.mark.parametrize("dimensions", [2, 10])
def test_it_is_scikit_fuzzys_from_the_same_start(fuzziness: float, dimensions: int) -> None:
    x = points(1, dimensions=dimensions)
    start = np.random.default_rng(3).random((7, len(x)))
    start /= start.sum(axis=0)
    for iterations in (1, 2, 5, 30):
        centres, _, _, _, objective, _, _ = skfuzzy.cmeans(x.T, 7, fuzziness, 0.0, iterations, init=start)
        found = fuzzy_means(x, memberships=start, fuzziness=fuzziness, iterations=iterations, tolerance=0.0)
        assert np.allclose(found.centres, centres, rtol=1e-6, atol=1e-6)
        assert np.allclose(found.objective, objective, rtol=1e-7)


@given(st.integers(0, 2**31), st.integers(2, 12), st.sampled_from([2, 5]))
def test_the_objective_never_rises(seed: int, clusters: int, dimensions: int) -> None:
    x = points(seed, 80, dimensions)
    found = fuzzy_means(x, x[:clusters], iterations=40, tolerance=0.0)
    assert (np.diff(found.objective) <= 1e-9 * found.objective[0]).all()


def test_memberships_are_those_of_the_formula() -> None:
    x = points(2, 40, 3)
    v = np.concatenate([x[:2], x[2:5] + 0.7])
    for fuzziness in (2.0, 1.5, 2.7):
        found = memberships_of(x, v, fuzziness)
        assert np.allclose(found, naive_memberships(x, v, fuzziness), atol=1e-9)
        assert np.allclose(found.sum(axis=1), 1)


def test_a_point_on_two_centres_belongs_to_both() -> None:
    x = points(3, 20)
    found = memberships_of(x, np.concatenate([x[:1], x[:1], x[5:6]]))
    assert found[0].tolist() == [0.5, 0.5, 0.0]
    assert np.isfinite(fuzzy_means(x, np.concatenate([x[:1], x[:1]])).centres).all()


def test_equal_points_and_as_many_centres_as_points_give_numbers() -> None:
    same = np.ones((30, 2))
    assert np.allclose(fuzzy_means(same, same[:4]).centres, 1)
    x = points(4, 12)
    assert np.allclose(np.sort(fuzzy_means(x, x).centres, axis=0), np.sort(x, axis=0), atol=1e-6)


def test_top_memberships_are_the_greatest() -> None:
    x, v = points(5, 60), points(6, 9)
    which, share = top_memberships(x, v)
    whole = naive_memberships(x, v, 2.0)
    assert np.array_equal(which, np.argsort(-whole, axis=1, kind="stable")[:, :3])
    assert np.allclose(share, np.sort(whole, axis=1)[:, ::-1][:, :3])


def test_sizes_double_until_every_frame_is_shown() -> None:
    assert level_sizes(2400, 11) == [11, 22, 44, 88, 176, 352, 704, 1408, 2400]
    assert level_sizes(11, 11) == [11]
    assert level_sizes(12, 11) == [11, 12]


@given(st.integers(0, 2**31))
def test_the_farthest_order_is_the_obvious_one(seed: int) -> None:
    x = points(seed, 40)
    chosen = [int(((x - x.mean(axis=0)) ** 2).sum(axis=1).argmin())]
    while len(chosen) < 15:
        apart = np.array([min(((x[i] - x[j]) ** 2).sum() for j in chosen) for i in range(40)])
        chosen.append(int(apart.argmax()))
    assert farthest_order(x, 15).tolist() == chosen


def test_equal_frames_are_all_different_candidates() -> None:
    x = np.repeat(points(1, 5), 4, axis=0)
    assert sorted(farthest_order(x, 20).tolist()) == list(range(20))


@pytest.mark.parametrize("method", ["robust", "paper"])
def test_every_level_shows_different_frames(method: str) -> None:
    found = space(method)
    count = len(found.coordinates)
    assert [len(level.candidates) for level in found.levels] == level_sizes(count, 11)
    for level in found.levels:
        assert len(set(level.candidates.tolist())) == len(level.candidates)
        assert 0.9 * level.wanted <= level.unique <= level.wanted
        assert (np.diff(level.objective) <= 1e-9 * np.abs(level.objective[:-1])).all()
        apart = np.linalg.norm(
            found.coordinates[:, None, : found.options.cluster_dimensions]
            - found.coordinates[None, level.candidates, : found.options.cluster_dimensions],
            axis=2,
        )
        assert level.coverage == pytest.approx(apart.min(axis=1).max(), abs=1e-6)
        assert np.allclose(apart[np.arange(count), level.nearest], apart.min(axis=1), atol=1e-6)


def test_candidates_are_the_frames_nearest_to_the_centres() -> None:
    found = space()
    x = found.coordinates[:, :10]
    for level in found.levels[:3]:
        near = [int(((x - centre) ** 2).sum(axis=1).argmin()) for centre in level.centres]
        assert level.candidates[: level.unique].tolist() == list(dict.fromkeys(near))
        assert level.candidates[level.stands].tolist() == near


def test_farthest_points_nest_and_cluster_centres_need_not() -> None:
    x = space().coordinates[:, :10]
    levels = list(make_levels(x, options_of(grouping="fps"), level_sizes(len(x), 11)))
    for coarse, fine in pairwise(levels):
        assert set(coarse.candidates.tolist()) <= set(fine.candidates.tolist())
        assert fine.coverage <= coarse.coverage
    # So that the test above can fail.
    fuzzy = space().levels
    assert any(
        not set(coarse.candidates.tolist()) <= set(fine.candidates.tolist()) for coarse, fine in pairwise(fuzzy[:-1])
    )
