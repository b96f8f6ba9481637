"""Dances that stay on a stage: its edge, turns spread over bars, the motion after them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.motion.hub import walked
from mcml.motion.sides import sagittal
from mcml_schemas.analyses.dance import DanceParameters
from mcml_service.analysis.dance import stage as stages
from mcml_service.analysis.dance.analyses import DANCE
from mcml_service.analysis.dance.beam import Costs, Floor, beam_path
from mcml_service.analysis.dance.motion_graph import Edges
from mcml_service.analysis.dance.path import successors
from mcml_service.analysis.dance.stage import Stage
from mcml_service.analysis.dance.time_warp import even_grid
from mcml_service.analysis.interface import AnalysisError, Parts, silent
from tests import fuzz
from tests.analysis.dance.motions import generated, moved

CIRCLE, RECTANGLE = Stage(2.0), Stage(None, 4.0, 2.0)
TRAVELLERS = [replace(generated("step", f"{seed}", bars=10, seed=seed, tempo=112.0)[0], metres=0.01) for seed in (3, 4)]
points = st.complex_numbers(max_magnitude=20, allow_nan=False)


def make_dance(**parameters: Any) -> tuple[Parts, np.ndarray]:
    """The parts of a dance, and the way of its root, metres."""
    parts = DANCE.run(TRAVELLERS, DanceParameters.model_validate({"bpm": 112, "bars": 48, **parameters}), silent)
    clip = parts["clip"].clip
    assert clip is not None
    root = clip.translations[:, 0]
    return parts, (root[:, 0] + 1j * root[:, 2]) * 0.01


def value_of(parts: Parts, metric: str) -> float:
    return dict(parts["metrics"].data["rows"])[metric]


@given(point=points, stage=st.sampled_from([CIRCLE, RECTANGLE]))
def test_the_way_back_to_the_stage_is_the_shortest(point: complex, stage: Stage) -> None:
    here = np.array([point])
    edge = here - stage.beyond(here)
    assert stage.outside(edge)[0] == pytest.approx(0, abs=1e-9)
    inside = abs(point) <= 2 if stage is CIRCLE else abs(point.real) <= 2 and abs(point.imag) <= 1
    assert (stage.outside(here)[0] == 0) == inside or stage.outside(here)[0] < 1e-9
    corners = np.array([2 + 1j, 2 - 1j, -2 + 1j, -2 - 1j]) if stage is RECTANGLE else 2 * np.exp(1j * np.arange(9))
    assert (stage.outside(here)[0] <= np.abs(corners - point) + 1e-9).all()


@given(bars=st.integers(1, 9), seed=st.integers(0, 99))
def test_turns_are_spread_over_their_bars_and_stay(bars: int, seed: int) -> None:
    grid, fps = even_grid(120, bars), 60.0
    turns = np.random.default_rng(seed).uniform(-0.17, 0.17, bars)
    shares = stages.find_shares(grid, int(grid[-1] * fps), fps)
    angles = stages.spread_turns(turns, shares)
    assert angles[0] == 0
    assert abs(angles[-1] - turns.sum()) < 0.01
    assert np.abs(np.diff(angles)).max() <= 1.6 * np.abs(turns).max() / (1.5 * fps) + 1e-9
    for bar in range(1, bars):
        assert angles[int((grid[4 * bar - 1]) * fps)] == pytest.approx(turns[:bar].sum(), abs=1e-6)


@given(seed=st.integers(0, 999))
def test_bending_keeps_the_length_of_steps(seed: int) -> None:
    rng = np.random.default_rng(seed)
    track = np.cumsum(rng.normal(size=50) + 1j * rng.normal(size=50))
    bent = stages.bend(track, np.cumsum(rng.normal(size=50)))
    assert np.allclose(np.abs(np.diff(bent)), np.abs(np.diff(track)))
    assert np.allclose(stages.bend(track, np.zeros(50)), track)


@given(step=st.floats(0.05, 0.25), bars=st.integers(20, 60))
def test_a_walk_straight_on_becomes_a_circle_on_the_stage(step: float, bars: int) -> None:
    """At 10 degrees a bar, a walker of `step` metres a bar needs a radius of 5.7 steps."""
    grid, fps = even_grid(120, bars), 30.0
    frames = int(grid[-1] * fps)
    track = np.linspace(0, step * bars, frames) + 0j
    shares, most = stages.find_shares(grid, frames, fps), np.radians(10)
    turns = stages.fit_turns(track, shares, Stage(3.0), np.zeros(bars), most)
    assert np.abs(turns).max() <= most + 1e-12
    assert Stage(3.0).outside(stages.bend(track, stages.spread_turns(turns, shares))).max() == 0
    assert not stages.fit_turns(track, shares, Stage(step * bars + 1), np.zeros(bars), most).any()


@given(seed=st.integers(0, 999))
def test_turns_never_lead_further_out(seed: int) -> None:
    rng = np.random.default_rng(seed)
    grid = even_grid(100, 12)
    frames = int(grid[-1] * 20)
    track = np.cumsum(rng.normal(size=frames) + 1j * rng.normal(size=frames)) * 0.1
    track -= track[0]
    shares, first = stages.find_shares(grid, frames, 20.0), rng.uniform(-0.1, 0.1, 12)
    turns = stages.fit_turns(track, shares, CIRCLE, first, 0.17)
    before, after = (CIRCLE.outside(stages.bend(track, stages.spread_turns(t, shares))).max() for t in (first, turns))
    assert after <= before


def test_the_beam_turns_back_at_the_edge() -> None:
    """Two bars, a metre forwards and a metre backwards, which may follow each other: one alone leaves the stage."""
    pairs = np.array([(a, b) for a in range(4) for b in range(4) if a != b], dtype=np.intp)
    first, second = pairs.T
    edges = Edges(first, second, np.full(12, 0.1), np.zeros(12, dtype=bool), np.zeros((12, 3)))
    tracks = np.outer([1.0, 1.0, -1.0, -1.0], np.linspace(0, 1, 13)).astype(complex)
    shifts = tracks[first, -1] - tracks[second, 0]
    ways, reach = successors(4, edges, 0.1), np.ones((40, 4), dtype=bool)
    ones, zeros = np.ones(12, dtype=complex), np.zeros(4, dtype=complex)
    floor = Floor(CIRCLE, 0.0, tracks, 0, ones, shifts, zeros, ones[:4])
    free, kept = (beam_path(ways, reach, Costs(0.0), ground).path for ground in (None, floor))
    assert np.abs(np.cumsum(tracks[free, -1])).max() > 2
    assert np.abs(np.cumsum(tracks[kept, -1])).max() <= 2


@pytest.mark.parametrize("stage", [1.2, {"width": 3.0, "depth": 1.6}])
def test_a_dance_stays_on_its_stage(stage: Any) -> None:
    free, left = make_dance()
    assert value_of(free, "farthest_from_centre") == pytest.approx(np.abs(left - left[0]).max(), rel=1e-6)
    assert value_of(free, "outside_stage") is None
    parts, way = make_dance(stage=stage)
    assert way[0] == pytest.approx(0)
    area = Stage(stage) if isinstance(stage, float) else Stage(None, stage["width"], stage["depth"])
    assert area.outside(way).max() == pytest.approx(value_of(parts, "outside_stage"), abs=1e-9)
    assert area.outside(way).max() < 0.05
    assert area.outside(left - left[0]).max() > 0.5


def test_a_stage_that_is_left_is_told() -> None:
    parts, way = make_dance(stage=0.3)
    assert value_of(parts, "outside_stage") == pytest.approx(np.abs(way).max() - 0.3)
    assert any("leaves the stage, a circle of 0.3 m radius" in row[0] for row in parts["warnings"].data["rows"])


def test_turns_change_no_pose_and_no_height() -> None:
    parts, _ = make_dance(stage=1.2, stage_turn=10)
    clip = parts["clip"].clip
    assert clip is not None
    straight = DanceParameters.model_validate({"bpm": 112, "bars": 48, "stage": 1.2, "stage_turn": 0})
    other = DANCE.run(TRAVELLERS, straight, silent)["clip"].clip
    assert other is not None
    assert np.allclose(np.linalg.norm(clip.rotations, axis=-1), 1)
    steps = np.abs(np.diff(clip.translations[:, 0, 1]))
    assert steps.max() <= 1.05 * np.abs(np.diff(other.translations[:, 0, 1])).max()


@fuzz.examples(4)
@given(heading=st.floats(-3, 3))
def test_the_dancer_faces_as_asked(heading: float) -> None:
    clips = [moved(motion, heading, np.zeros(3)) for motion in TRAVELLERS]
    for facing in (0.0, 90.0):
        parameters = DanceParameters.model_validate({"bpm": 112, "bars": 4, "facing": facing, "stage": 4})
        clip = DANCE.run(clips, parameters, silent)["clip"].clip
        assert clip is not None
        positions, _ = walked(clip.skeleton, clip.translations[:1], clip.rotations[:1])
        up = np.array([0.0, 1.0, 0.0])
        ahead = np.cross(sagittal(clip.skeleton, positions[0], up).normal, up)
        assert np.degrees(np.arctan2(ahead[0], ahead[2])) == pytest.approx(facing, abs=2)


def test_seeds_give_other_paths_of_the_same_variety() -> None:
    paths = []
    for options in ({}, {"seed": 7}, {"seed": 7}, {"seed": 8}, {"seed": 8, "novelty": 0}, {"novelty": 0}):
        parts, _ = make_dance(dry_run=False, **options)
        paths.append([row[1] for row in parts["path"].data["rows"]])
    assert paths[1] == paths[2]
    assert len({tuple(path) for path in (paths[0], paths[1], paths[3])}) == 3
    assert paths[4] == paths[5]
    assert len(set(paths[1])) >= len(set(paths[0])) - 1


def test_a_dance_ends_with_the_bar_asked_for() -> None:
    parts = DANCE.run(TRAVELLERS, DanceParameters(bpm=112, bars=8, start=2, end=5), silent)
    names = [column["name"] for column in parts["path"].data["columns"]]
    bars = [row[names.index("node")] for row in parts["path"].data["rows"]]
    assert (bars[0], bars[-1]) == (2, 5)
    with pytest.raises(AnalysisError, match="position"):
        DANCE.run(TRAVELLERS, DanceParameters(bpm=112, bars=8, end=999), silent)
