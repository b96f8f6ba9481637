"""What is promised on generated clips: beats found, and kept by a new dance."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from mcml_schemas.analyses.dance import BeatsParameters, DanceParameters
from mcml_service.analysis.dance.analyses import BEATS, DANCE
from mcml_service.analysis.dance.metrics import nearest
from mcml_service.analysis.dance.motion_beats import minima
from mcml_service.analysis.interface import Motion, Part, Parts, silent
from mcml_service.demo.dance_clips import Style, Truth
from tests.analysis.dance.motions import BEAT_STYLES, generated
from tests.builders import assign

RATES, TEMPI = (30.0, 60.0, 120.0), (84.0, 112.0, 140.0)


def records(part: Part) -> list[dict[str, Any]]:
    names = [column["name"] for column in part.data["columns"]]
    return [dict(zip(names, row, strict=True)) for row in part.data["rows"]]


def value_of(parts: Parts, metric: str) -> float:
    return dict(parts["metrics"].data["rows"])[metric]


def hits(found: np.ndarray, true: np.ndarray, within: float) -> int:
    """Found beats that meet a true one, each true one once."""
    met: set[int] = set()
    for beat in found:
        closest = int(np.abs(true - beat).argmin())
        if abs(true[closest] - beat) <= within + 1e-9:
            met.add(closest)
    return len(met)


@pytest.mark.parametrize("style", BEAT_STYLES)
@pytest.mark.parametrize("fps", RATES)
@pytest.mark.parametrize("tempo", TEMPI)
def test_beats_are_found(style: Style, fps: float, tempo: float) -> None:
    """Precision and recall of 0.95 within a frame or a sixtieth of a second; the period within one per cent."""
    for seed in (1, 2):
        motion, truth = generated(style, fps=fps, tempo=tempo, bars=10, seed=seed, dancer=seed)
        parts = BEATS.run([motion], BeatsParameters(), silent)
        found = np.array([row["seconds"] for row in records(parts["beats"])])
        met = hits(found, truth.beats, max(1 / fps, 1 / 60))
        assert met >= 0.95 * len(found)
        assert met >= 0.95 * len(truth.beats)
        clip = records(parts["clips"])[0]
        assert abs(clip["period"] / truth.period - 1) < 0.01
        assert clip["bars"] == 10
        starts = np.array([row["b0"] - 1 for row in records(parts["bars"])]) / fps
        assert np.abs(starts - truth.bars[:, 0]).max() < 0.05


def test_a_wave_has_a_period_but_no_beats_where_they_are_counted() -> None:
    """The limit that the thesis names; if this fails, say in the docs that it is gone."""
    motion, truth = generated("wave", bars=10)
    parts = BEATS.run([motion], BeatsParameters(), silent)
    found = np.array([row["seconds"] for row in records(parts["beats"])])
    assert hits(found, truth.beats, 1 / 60) < 0.5 * len(truth.beats)
    assert abs(records(parts["clips"])[0]["period"] / truth.period - 1) < 0.01


def test_a_preparation_adds_beats_but_loses_none() -> None:
    motion, truth = generated("preparation", bars=10)
    parts = BEATS.run([motion], BeatsParameters(), silent)
    found = np.array([row["seconds"] for row in records(parts["beats"])])
    met = hits(found, truth.beats, 1 / 60)
    assert met >= 0.95 * len(truth.beats)
    assert len(found) <= len(truth.beats) + 4


@cache
def pair(style: Style, fps: float) -> tuple[tuple[Motion, Truth], tuple[Motion, Truth]]:
    first = generated(style, "1", fps=fps, bars=12, seed=1)
    return first, generated(style, "2", fps=fps, bars=12, seed=2, tempo=126.0)


def danced(style: Style, fps: float, **parameters: Any) -> Parts:
    motions = [motion for motion, _ in pair(style, fps)]
    return DANCE.run(motions, DanceParameters.model_validate({"bars": 24, **parameters}), silent)


@pytest.mark.parametrize("style", BEAT_STYLES)
@pytest.mark.parametrize(("fps", "bpm"), [(30.0, 90.0), (60.0, 120.0), (120.0, 140.0)])
def test_a_new_dance_keeps_the_beat(style: Style, fps: float, bpm: float) -> None:
    parts = danced(style, fps, bpm=bpm)
    clip, grid = parts["clip"].clip, parts["speed"].arrays["grid"]
    assert clip is not None
    assert len(clip.rotations) == int(24 * 240 / bpm * fps + 0.5)
    found = parts["speed"].arrays["beats"]
    inner = np.concatenate([grid[1::4], grid[2::4]])
    assert (nearest(inner, found) <= 1 / fps + 1e-6).mean() >= 0.95
    jumps = np.array([row["position"] - 1 for row in records(parts["transitions"])])
    assert len(jumps) >= 3
    assert nearest(grid[4 * jumps - 1], found).max() <= 0.12
    lows = minima(parts["speed"].arrays["speed"]) / fps
    assert nearest(grid[4 * jumps], lows).max() <= 0.12


@pytest.mark.parametrize("style", BEAT_STYLES)
def test_holding_has_no_more_beats_inside_transitions_than_the_classic_blend(style: Style) -> None:
    parts = danced(style, 60.0, bpm=120.0, strategy="random", seed=5)
    assert len(parts["transitions"].data["rows"]) >= 5
    assert value_of(parts, "beats_in_transitions") <= value_of(parts, "classic_beats_in_transitions")


@pytest.mark.parametrize("blend", ["hold", "classic"])
def test_root_and_joints_are_continuous(blend: str) -> None:
    """No faster than the source at the rate it is played, and the poles of a transition in the time it has."""
    for style in BEAT_STYLES:
        parts = danced(style, 60.0, bpm=120.0, blend=blend, strategy="random", seed=2)
        rate = value_of(parts, "greatest_rate")
        bound = 1.1 * value_of(parts, "source_greatest_rotation_speed") * rate
        assert value_of(parts, "greatest_rotation_speed") <= bound
        assert value_of(parts, "greatest_body_speed") <= 1.2 * value_of(parts, "source_greatest_body_speed") * rate


def test_a_cut_is_not_continuous() -> None:
    """What the test above would miss if it could not fail."""
    parts = danced("step", 60.0, bpm=120.0, blend="none", strategy="random", seed=2, cloud_at="first beat")
    bound = 1.1 * value_of(parts, "source_greatest_rotation_speed") * value_of(parts, "greatest_rate")
    assert value_of(parts, "greatest_rotation_speed") > bound


@pytest.mark.slow
def test_ten_minutes_do_not_drift() -> None:
    parts = danced("groove", 30.0, bpm=113.0, bars=280)
    clip, grid, found = parts["clip"].clip, parts["speed"].arrays["grid"], parts["speed"].arrays["beats"]
    assert clip is not None
    assert grid[-1] == pytest.approx(280 * 240 / 113)
    assert len(clip.rotations) == int(280 * 240 / 113 * 30 + 0.5)
    assert (nearest(grid[-201:-1], found) <= 2 / 30).mean() > 0.95


@pytest.mark.parametrize(("pulse", "bpm"), [("2", 200.0), ("1/2", 60.0)])
def test_a_pulse_lets_the_dance_go_at_half_or_double_the_music(pulse: str, bpm: float) -> None:
    chosen = danced("groove", 60.0, bpm=bpm, bars=8)
    assert chosen["clip"].clip is not None
    assert ("pulse", pulse, "") in chosen["clip"].clip.properties
    asked = danced("groove", 60.0, bpm=bpm, bars=8, pulse=pulse)
    assert np.array_equal(chosen["clip"].clip.rotations, asked["clip"].clip.rotations)  # type: ignore[union-attr]


def test_the_uniform_warp_of_the_thesis_misses_inner_beats() -> None:
    def misses(warp: str) -> float:
        parts = danced("groove", 120.0, bpm=120.0, warp=warp)
        grid = parts["speed"].arrays["grid"]
        return float(nearest(np.concatenate([grid[1::4], grid[2::4]]), parts["speed"].arrays["beats"]).mean())

    assert misses("beats") < 0.3 * misses("uniform")


def test_planted_feet_are_locked() -> None:
    """Feet slide less, most of all in transitions; head and arms keep their rotations, and beats stay."""
    clips = [_by_name(generated("groove", f"{seed}", bars=8, seed=seed, tempo=112.0)[0]) for seed in (1, 2)]
    loose, locked = (
        DANCE.run(clips, DanceParameters(bpm=118, bars=16, stage=2.0, lock_feet=lock), silent) for lock in (False, True)
    )
    for where, part in (("in_transitions", 0.6), ("outside", 1.0)):
        assert value_of(locked, f"foot_skate_{where}") < part * value_of(loose, f"foot_skate_{where}")
    assert value_of(locked, "beat_align_music") > value_of(loose, "beat_align_music") - 0.02
    assert value_of(locked, "greatest_rotation_speed") < 1.2 * value_of(loose, "greatest_rotation_speed")
    before, after = loose["clip"].clip, locked["clip"].clip
    assert before is not None
    assert after is not None
    names = list(before.skeleton.names)
    upper = [names.index(name) for name in ("neck1", "left_up_arm", "right_low_arm")]
    assert np.array_equal(before.rotations[:, upper], after.rotations[:, upper])


def test_bodies_whose_legs_have_no_names_of_mcml_keep_their_feet() -> None:
    clips = [generated("step", "1", bars=8, seed=1, tempo=112.0)[0]]
    made = [
        DANCE.run(clips, DanceParameters(bpm=118, bars=4, lock_feet=lock), silent)["clip"].clip
        for lock in (False, True)
    ]
    assert made[0] is not None
    assert made[1] is not None
    assert np.array_equal(made[0].rotations, made[1].rotations)


def _by_name(motion: Motion) -> Motion:
    """The motion with MCML's names of joints, as in the store."""
    return replace(motion, skeleton=assign(motion.skeleton))
