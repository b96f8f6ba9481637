"""Paths: walks over the graph, refinement, playback."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from mcml.errors import SizeError
from mcml_service.analysis.expression_space.navigation import (
    Ground,
    accept_keys,
    link_keys,
    offers_near,
    offers_on_the_way,
    shortest_walk,
    walk_over,
    with_picks,
)
from mcml_service.analysis.expression_space.playback import MOST_SAMPLES, markers_of, sample
from mcml_service.analysis.interface import AnalysisError
from tests.analysis.expression.face_motions import space


@cache
def ground(method: str = "robust", stored: bool = True) -> Ground:
    found = space(method)
    count = found.graph.frames
    return Ground(
        found.graph,
        found.coordinates[:, :2],
        [level.candidates for level in found.levels],
        [None if len(level.candidates) == count else own for level, own in zip(found.levels, found.links, strict=True)],
        found.geodesics if stored else None,
    )


def farthest_keys(method: str = "robust", count: int = 4) -> list[int]:
    """Candidates of level 0 that can all be reached from each other, far apart."""
    candidates = ground(method).candidates[0].tolist()
    keys = [candidates[0]]
    while len(keys) < count:
        row = ground(method).row(keys[-1])
        keys.append(max((c for c in candidates if c not in keys), key=lambda c: row[c]))
    return keys


def edges() -> set[tuple[int, int]]:
    graph = space().graph
    return set(zip(graph.first.tolist(), graph.second.tolist(), strict=True))


@pytest.mark.parametrize("stored", [True, False])
def test_walks_go_over_edges_and_are_as_short_as_geodesics(stored: bool) -> None:
    here, known = ground(stored=stored), edges()
    rng = np.random.default_rng(0)
    for a, b in rng.integers(0, here.graph.frames, (60, 2)).tolist():
        if a == b:
            continue
        frames = shortest_walk(here, a, b)
        assert frames[0] == a
        assert frames[-1] == b
        assert len(set(frames)) == len(frames)
        assert all((min(pair), max(pair)) in known for pair in pairwise(frames))
        length = sum(here.edge(*pair) or np.nan for pair in pairwise(frames))
        assert length == pytest.approx(here.between(a, b), rel=1e-5)


def test_keys_that_are_not_linked_are_refused_with_a_way() -> None:
    here = ground()
    keys = farthest_keys(count=2)
    with pytest.raises(AnalysisError) as error:
        link_keys(here, 0, keys, auto_route=False)
    assert error.value.code == "not-linked"
    way = error.value.details["suggestion"]
    assert way[0] == keys[0]
    assert way[-1] == keys[-1]
    assert link_keys(here, 0, way, auto_route=False) == way
    assert link_keys(here, 0, keys, auto_route=True) == way


def test_keys_may_come_again_but_not_at_once() -> None:
    here = ground()
    a, b = link_keys(here, 0, farthest_keys(count=2), auto_route=True)[:2]
    assert link_keys(here, 0, [a, b, a], auto_route=False) == [a, b, a]
    walk = walk_over(here, [a, b, a])
    assert walk.length == pytest.approx(2 * here.between(a, b), rel=1e-5)
    assert walk.frames[walk.at].tolist() == [a, b, a]
    for keys, code in (([a, a], "repeated-key"), ([a], "too-few-keys"), ([a, _other(here)], "not-a-candidate")):
        with pytest.raises(AnalysisError) as error:
            link_keys(here, 0, keys, auto_route=True)
        assert error.value.code == code


def _other(here: Ground) -> int:
    return next(frame for frame in range(here.graph.frames) if frame not in here.candidates[0])


def test_what_links_do_not_reach_is_unreachable() -> None:
    here = ground("paper")
    labels = space("paper").links
    level = next(number for number, links in enumerate(labels) if links.components > 1)
    candidates = here.candidates[level]
    codes = set()
    for other in candidates[1:].tolist():
        try:
            link_keys(here, level, [int(candidates[0]), other], auto_route=True)
        except AnalysisError as error:
            codes.add(error.code)
    assert codes == {"unreachable"}


@pytest.mark.parametrize("stored", [True, False])
def test_refinement_keeps_the_keys_and_grows_by_a_tenth_at_most(stored: bool) -> None:
    here = ground(stored=stored)
    walk = walk_over(here, farthest_keys())
    first = walk
    for level in (2, 4, len(here.candidates) - 1):
        keys = accept_keys(here, walk, offers_on_the_way(here, walk, level), 0.1)
        finer = walk_over(here, keys)
        rest = iter(keys)
        # In their order; another part of the path may lead over a key once more.
        assert all(key in rest for key in walk.keys.tolist())
        assert finer.length <= 1.1 * walk.length * (1 + 1e-5)
        assert len(keys) > len(walk.keys)
        assert set(keys) - set(walk.keys.tolist()) <= set(here.candidates[level].tolist())
        walk = finer
    assert walk.length > first.length * 0.999


def test_offers_on_the_way_are_those_of_small_detour() -> None:
    here = ground()
    walk = walk_over(here, farthest_keys(count=3))
    found = {(offer.segment, offer.frame): offer.apart for offer in offers_on_the_way(here, walk, 3, 0.05)}
    wanted = {}
    for segment, (a, b) in enumerate(pairwise(walk.keys.tolist())):
        for frame in here.candidates[3].tolist():
            detour = here.between(a, frame) + here.between(frame, b) - here.between(a, b)
            if frame not in (a, b) and detour <= 0.05 * here.between(a, b):
                wanted[segment, frame] = detour
    assert found.keys() == wanted.keys()
    assert all(found[key] == pytest.approx(max(wanted[key], 0), abs=1e-3) for key in wanted)


def test_offers_of_the_paper_are_near_the_walk_on_the_map() -> None:
    here = ground("paper")
    walk = walk_over(here, farthest_keys("paper", 3))
    found = offers_near(here, walk, 3, 30.0)
    path = here.plane[walk.frames]
    wanted = {
        frame
        for frame in here.candidates[3].tolist()
        if frame not in walk.keys and np.linalg.norm(path - here.plane[frame], axis=1).min() <= 30.0
    }
    assert {offer.frame for offer in found} == wanted
    assert [offer.position for offer in found] == sorted(offer.position for offer in found)
    for offer in found:
        low, high = walk.position[walk.at[[offer.segment, offer.segment + 1]]]
        assert low - 1e-9 <= offer.position <= high + 1e-9


def test_picks_are_put_where_they_cost_least() -> None:
    here = ground()
    walk = walk_over(here, farthest_keys(count=3))
    offers = offers_on_the_way(here, walk, 3, 0.2)
    picks = [offers[0].frame, offers[-1].frame]
    keys = with_picks(here, walk, 3, picks[::-1])
    assert [key for key in keys if key not in picks] == walk.keys.tolist()
    assert keys.index(picks[0]) <= keys.index(picks[1])
    with pytest.raises(AnalysisError) as error:
        with_picks(here, walk, 0, [_other(here)])
    assert error.value.code == "not-a-candidate"


@pytest.mark.parametrize("loop", [False, True])
@pytest.mark.parametrize("smooth", [False, True])
def test_playback_is_continuous_and_ends_are_exact(loop: bool, smooth: bool) -> None:
    walk = walk_over(ground(), farthest_keys())
    positions = space().frames.positions
    samples = sample(walk, 300.0, 60.0, loop=loop)
    markers = markers_of(samples, positions, smooth=smooth)
    assert np.allclose(markers[0], positions[walk.keys[0]], atol=1e-12)
    middle = (len(markers) - 1) // 2 if loop else -1
    if not smooth or not loop:
        assert np.allclose(markers[middle], positions[walk.keys[-1]], atol=1e-12)
    assert np.allclose(markers[-1], positions[walk.keys[0 if loop else -1]], atol=1e-12)
    steps = np.abs(np.diff(samples.position))
    assert np.allclose(steps, samples.speed / 60, rtol=1e-9)
    assert samples.speed == pytest.approx(300, rel=0.02)
    # One step moves no marker farther than the edge it lies on does, in its share.
    moves = np.linalg.norm(np.diff(markers, axis=0), axis=2).max()
    hops = np.linalg.norm(np.diff(positions[walk.frames], axis=0), axis=2).max(axis=1) / np.diff(walk.position)
    assert moves <= 2 * hops.max() * steps.max() * 1.01


def test_samples_lie_on_edges_of_the_walk() -> None:
    walk = walk_over(ground(), farthest_keys())
    samples = sample(walk, 250.0, 48.0)
    known = set(pairwise(walk.frames.tolist()))
    place = {}
    for edge, pair in enumerate(pairwise(walk.frames.tolist())):
        place.setdefault(pair, []).append(edge)
    for a, b, alpha, position in zip(
        samples.first.tolist(), samples.second.tolist(), samples.alpha, samples.position, strict=True
    ):
        assert (a, b) in known
        assert any(
            abs(walk.position[edge] + alpha * (walk.position[edge + 1] - walk.position[edge]) - position) < 1e-9
            for edge in place[a, b]
        )


def test_a_duration_is_kept() -> None:
    walk = walk_over(ground(), farthest_keys(count=2))
    samples = sample(walk, 0.0, 30.0, duration=4.0)
    assert len(samples.alpha) == 121
    assert samples.speed == pytest.approx(walk.length / 4)


def test_no_sample_of_a_marker_in_one_frame_takes_the_others() -> None:
    walk = walk_over(ground(), farthest_keys(count=2))
    positions = space().frames.positions.copy()
    samples = sample(walk, 300.0)
    inner = int(np.flatnonzero((samples.alpha > 0.2) & (samples.alpha < 0.8))[0])
    positions[samples.first[inner], 3] = np.nan
    positions[[samples.first[inner], samples.second[inner]], 5] = np.nan
    markers = markers_of(samples, positions)
    assert np.allclose(markers[inner, 3], positions[samples.second[inner], 3])
    assert np.isnan(markers[inner, 5]).all()
    assert np.isfinite(markers[inner, 4]).all()
    smoothed = markers_of(samples, positions, smooth=True)
    assert np.array_equal(np.isnan(smoothed), np.isnan(markers))


def test_what_cannot_be_played() -> None:
    here = ground()
    walk = walk_over(here, farthest_keys(count=2))
    with pytest.raises(SizeError):
        sample(walk, 300.0, 60.0, duration=MOST_SAMPLES / 60)
    assert len(sample(walk, 300.0, 60.0, duration=(MOST_SAMPLES - 1) / 60).alpha) == MOST_SAMPLES
    with pytest.raises(AnalysisError) as error:
        sample(walk, 0.0)
    assert error.value.code == "no-speed"
    still = walk_over(here, [walk.keys[0], walk.keys[0]])
    with pytest.raises(AnalysisError) as error:
        sample(still, 300.0)
    assert error.value.code == "zero-length"
