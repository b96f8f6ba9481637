"""The threshold: sets whose true distances are known, the curve, the rules, against obvious twins."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial.distance import cdist

from mcml.motion.skeleton import Array
from mcml_service.analysis.expression_space import space as spaces
from mcml_service.analysis.expression_space import trials as trials_of
from mcml_service.analysis.expression_space.frame_graph import hub_graph, threshold_graph
from mcml_service.analysis.expression_space.geodesics import all_pairs, from_sources
from mcml_service.analysis.expression_space.levels import farthest_order
from mcml_service.analysis.expression_space.options import options_of
from mcml_service.analysis.expression_space.planar_map import agreement, classical_scaling
from mcml_service.analysis.expression_space.space import build
from mcml_service.analysis.expression_space.threshold import STEPS, Chosen, choose
from mcml_service.analysis.expression_space.trials import Trials, Tried, sample_geodesics
from tests.analysis.expression.face_motions import motions, space

FRAMES = 500


def along(corners: list[tuple[float, float]], count: int) -> Array:
    """Points at equal steps along a line through corners."""
    places = np.array(corners)
    gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
    at = np.linspace(0, gone[-1], count)
    return np.stack([np.interp(at, gone, column) for column in places.T], axis=1)


def rows(width: float, height: float, count: int) -> Array:
    """A path back and forth over a rectangle, as one take may cover its movements: slowly, each way beside the last."""
    ends = [(width * ((row + end) % 2), height * row / (count - 1)) for row in range(count) for end in (0, 1)]
    return along(ends, FRAMES)


def circle() -> tuple[Array, Array]:
    """Three rounds, each a little farther out; true distances along the circle."""
    angle = np.linspace(0, 6 * np.pi, FRAMES)
    apart = np.abs(angle[:, None] - angle) % (2 * np.pi)
    radius = 95 + 15 * angle / angle[-1]
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    return points, 100 * np.minimum(apart, 2 * np.pi - apart)


def sheet() -> tuple[Array, Array]:
    points = rows(100, 80, 9)
    return points, cdist(points, points)


def roll() -> tuple[Array, Array]:
    """A sheet rolled up, with room between its layers; true distances on the sheet."""
    turn = np.linspace(4, 14, 5000)
    length = 5 * (turn * np.sqrt(1 + turn**2) + np.arcsinh(turn))
    length -= length[0]
    flat = rows(length[-1], 80, 5)
    at = np.interp(flat[:, 0], length, turn)
    return np.stack([10 * at * np.cos(at), flat[:, 1], 10 * at * np.sin(at)], axis=1), cdist(flat, flat)


def searched(points: Array) -> tuple[Trials, list[Tried], Chosen]:
    trials = Trials(cdist(points, points))
    tried = [trials.try_threshold(tau) for tau in trials.steps(STEPS)]
    return trials, tried, choose(trials, tried, "unbroken", 10)


def r_of(apart: Array, true: Array) -> float:
    pairs = np.triu_indices(len(true), 1)
    return float(np.corrcoef(apart[pairs], true[pairs])[0, 1])


@pytest.mark.slow
@pytest.mark.parametrize("shape", [circle, sheet, roll])
def test_a_single_take_is_no_time_line(shape: Callable[[], tuple[Array, Array]]) -> None:
    """The smallest connecting threshold makes one: its own map fits perfectly, and that of the truth not at all."""
    points, true = shape()
    trials, tried, chosen = searched(points)
    maps = []
    for tau in (tried[0].tau, chosen.tau):
        paths = all_pairs(threshold_graph(trials.apart, tau).matrix)
        maps.append(classical_scaling(paths, 2).coordinates)
    line, found = (cdist(each, each) for each in maps)
    assert tried[0].r > 0.99
    assert tried[0].broken > 0.1
    assert r_of(line, true) < 0.65
    assert r_of(found, true) > 0.97
    assert chosen.tau < 0.25 * trials.far
    assert chosen.warnings == ()


def test_a_large_space_keeps_the_shape_too() -> None:
    points, true = roll()
    hubs = farthest_order(points, 200)
    radius = float(cdist(points, points[hubs]).min(axis=1).max())
    trials = Trials(cdist(points[hubs], points[hubs]), 2 * radius)
    tried = [trials.try_threshold(tau) for tau in trials.steps(STEPS)]
    tau = choose(trials, tried, "unbroken", 10).tau
    assert tau >= trials.low >= 2 * radius
    graph = hub_graph(points, hubs, tau, np.zeros(FRAMES, np.int32), np.arange(FRAMES, dtype=np.int32))
    paths = from_sources(graph.matrix, None)
    assert r_of(paths, true) > 0.97


def test_a_large_space_says_how_its_threshold_was_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spaces, "HUBS", 100)
    found = build(motions(), options_of(scale="landmark", landmarks=60))
    assert len(found.tried) == STEPS + 1
    assert found.tau in [pytest.approx(factor * each.tau) for each in found.tried for factor in (1.0, 1.3)]
    assert found.tau >= found.connecting
    assert build(motions(), options_of(scale="landmark", landmarks=60, tau_mm=80.0)).tau == 80


def test_a_curve_of_thresholds() -> None:
    found = space()
    taus = [tried.tau for tried in found.tried]
    assert taus == sorted(taus)
    assert len(taus) == STEPS + 1
    assert found.tried[0].tau >= found.connecting
    connected = [tried for tried in found.tried if tried.tau >= found.connecting]
    assert all(tried.components == 1 and tried.giant == 1.0 for tried in connected)
    assert all(tried.stretch >= 1 - 1e-9 for tried in found.tried)
    broken = [tried.broken for tried in found.tried]
    assert broken == sorted(broken, reverse=True)
    assert broken[-1] == 0


def test_the_curve_is_that_of_the_whole_graph(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trials_of, "COVER", 1e12)
    apart = np.asarray(space().geodesics, dtype=float)[::8, ::8]
    trials = Trials(apart)
    tau = 1.1 * trials.low
    paths = dijkstra(csr_array(np.where(apart <= tau, apart, 0.0)))
    tried, chosen = trials.try_threshold(tau), trials.spread
    assert np.allclose(trials.geodesics(tau, chosen), paths[np.ix_(chosen, chosen)])
    among = paths[np.ix_(chosen, chosen)]
    assert tried.r == pytest.approx(agreement(among, classical_scaling(among, 2).coordinates).r)
    assert tried.components == 1
    shares = []
    for rho in (0.05, 0.10, 0.15):
        reach = rho * np.percentile(apart[np.triu_indices(len(apart), 1)], 95)
        near = [(i, j) for i in chosen for j in chosen if i < j and apart[i, j] <= reach]
        if len(near) >= 30:
            shares.append(np.mean([paths[pair] > 2 * reach for pair in near]))
    assert shares
    assert tried.broken == pytest.approx(max(shares), abs=1e-12)


def test_spread_frames_leave_none_far() -> None:
    points = np.random.default_rng(2).normal(size=(700, 2)) * (100, 30)
    trials = Trials(cdist(points, points))
    assert len(trials.spread) <= 450
    assert trials.apart[trials.spread].min(axis=0).max() <= 0.02 * trials.far
    many = np.random.default_rng(2).normal(size=(700, 20))
    assert len(Trials(cdist(many, many)).spread) == 450


def test_parts_that_stay_apart_are_counted() -> None:
    points = np.random.default_rng(4).normal(size=(60, 2))
    points[40:] += 50
    apart = cdist(points, points)
    apart[:40, 40:] = apart[40:, :40] = np.inf
    trials = Trials(apart)
    assert np.isfinite(trials.low)
    tried = trials.try_threshold(trials.longest)
    assert (tried.components, tried.broken) == (2, 0.0)
    assert tried.giant == pytest.approx(40 / 60)


def test_thinning_hardly_lengthens_geodesics() -> None:
    points = np.random.default_rng(3).normal(size=(600, 3)) * (100, 40, 20)
    apart = cdist(points, points)
    frames = np.arange(600)
    sample = frames[::9]
    exact = dijkstra(csr_array(np.where(apart <= 120, apart, 0.0)), indices=sample)[:, sample]
    found = sample_geodesics(apart, 120.0, frames, sample)
    assert (found >= exact - 1e-9).all()
    assert found.mean() < 1.01 * exact.mean()


def tried_at(tau: float, r: float = 0.9, broken: float = 0.0) -> Tried:
    return Tried(tau, broken, r, 0.1, 1, 1.0, 10.0, 1.0)


class Jumps(Trials):
    """Trials whose jumps are given, by the smaller threshold."""

    given: dict[float, float]

    def jump(self, tau: float, larger: float) -> float:
        return self.given.get(round(tau, 6), 0.0)


def jumps(given: dict[float, float]) -> Jumps:
    points = np.linspace(0, 1000, 41)[:, None]
    found = Jumps(cdist(points, points), 10.0)
    object.__setattr__(found, "given", given)
    return found


def test_rules_of_the_threshold() -> None:
    curve = [tried_at(30, 0.95, 0.3), tried_at(40, 0.985, 0.004), tried_at(80, 0.991)]
    plain = jumps({})
    assert choose(plain, curve, "published", 100) == Chosen(pytest.approx(230))
    assert choose(plain, curve, "best", 100) == Chosen(80)
    assert choose(plain, curve, "unbroken", 100) == Chosen(pytest.approx(52))
    undefined = choose(plain, [tried_at(10, float("nan"))], "best", 50)
    assert undefined.tau == pytest.approx(115)
    assert [code for code, _ in undefined.warnings] == ["tau-undefined"]


@pytest.mark.parametrize(
    ("given", "tau", "codes"),
    [({40.0: 0.2}, 40, ["near-gap"]), ({52.0: 0.2}, 52, ["near-gap"]), ({40.0: 0.1, 52.0: 0.1}, 52, [])],
)
def test_a_short_cut_just_above_is_not_taken_and_told(given: dict[float, float], tau: float, codes: list[str]) -> None:
    curve = [tried_at(30, broken=0.006), tried_at(40, broken=0.005)]
    chosen = choose(jumps(given), curve, "unbroken", 100)
    assert chosen.tau == pytest.approx(tau)
    assert [code for code, _ in chosen.warnings] == codes


def test_a_space_of_few_frames_is_called_sparse() -> None:
    curve = [tried_at(300, broken=0.1), tried_at(900)]
    chosen = choose(jumps({}), curve, "unbroken", 100)
    assert chosen.tau == 1000
    assert [code for code, _ in chosen.warnings] == ["sparse-space"]


def test_thresholds_go_from_the_connecting_one_to_the_longest() -> None:
    points = np.array([0.0, 10, 20, 1000])[:, None]
    trials = Trials(cdist(points, points))
    taus = trials.steps(12, 990.0)
    assert len(taus) == 13
    assert 990 in taus
    assert taus[0] >= 980
    assert taus[0] == pytest.approx(980)
    assert taus[-1] == pytest.approx(1000)
