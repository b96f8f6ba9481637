"""The generator keeps its law (docs/analyses/dance.md)."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mcml_service.demo import dance_clips
from mcml_service.demo.dance_clips import Style, dance_clip
from tests.analysis.dance.motions import BEAT_STYLES, STYLES, motion_of


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize(("fps", "tempo"), [(30.0, 84.0), (120.0, 140.0)])
def test_beats_stand_where_the_law_says(style: Style, fps: float, tempo: float) -> None:
    made = dance_clip(style, fps=fps, tempo=tempo, bars=5)
    period, before = 60 / tempo, 2.0 if style == "preparation" else 0.0
    even = before + period * (np.arange(20) + 0.5)
    assert np.abs(made.truth.beats - even).max() <= 0.012 + 1e-12
    assert (made.truth.bars.ravel() == made.truth.beats).all()
    assert made.truth.period == period
    assert made.clip.frames == round((2 * before + 20 * period) * fps)
    assert float(made.clip.head.frame_time or 0) == pytest.approx(1 / fps, abs=1e-9)


@pytest.mark.parametrize("style", STYLES)
def test_a_frame_rate_only_samples_the_dance(style: Style) -> None:
    fast, slow = (motion_of(dance_clip(style, fps=fps, bars=3, seed=5).clip) for fps in (120.0, 30.0))
    count = min(len(slow), len(fast) // 4)
    turned = Rotation.from_quat(fast.rotations[: 4 * count : 4].reshape(-1, 4)).inv() * Rotation.from_quat(
        slow.rotations[:count].reshape(-1, 4)
    )
    assert turned.magnitude().max() < 1e-5
    assert np.abs(fast.translations[: 4 * count : 4] - slow.translations[:count]).max() < 1e-3


@pytest.mark.parametrize("style", BEAT_STYLES)
def test_the_body_is_slow_on_beats_and_fast_between(style: Style) -> None:
    made = dance_clip(style, fps=240.0, bars=6, seed=2)
    positions, _ = motion_of(made.clip).walk()
    speed = np.linalg.norm(np.gradient(positions, axis=0), axis=-1).mean(axis=1)
    at = np.round(made.truth.beats * 240).astype(int)
    between = np.round((made.truth.beats[:-1] + made.truth.beats[1:]) * 120).astype(int)
    assert speed[at].max() < 0.35 * speed[between].min()


def test_a_wave_is_never_at_rest() -> None:
    positions, _ = motion_of(dance_clip("wave", bars=6).clip).walk()
    speed = np.linalg.norm(np.gradient(positions, axis=0), axis=-1).mean(axis=1)
    assert speed.min() > 0.7 * speed.mean()


def test_feet_stand_unless_the_dancer_travels() -> None:
    made = motion_of(dance_clip("groove", bars=4).clip)
    feet = [index for index, name in enumerate(made.skeleton.names) if name.endswith("Foot")]
    assert np.ptp(made.walk()[0][:, feet], axis=0).max() < 0.1
    travelling = motion_of(dance_clip("step", bars=4).clip)
    assert np.ptp(travelling.walk()[0][:, feet], axis=0).max() > 10


def test_tempo_rate_and_length_change_no_other_choice() -> None:
    short, long = (dance_clip("step", bars=bars, tempo=tempo, seed=3).truth for bars, tempo in ((3, 90.0), (6, 130.0)))
    assert (short.figures == long.figures[:3]).all()
    assert np.allclose(
        short.beats - short.period * (np.arange(12) + 0.5), long.beats[:12] - long.period * (np.arange(12) + 0.5)
    )


def test_figures_begin_where_others_end_and_poses_are_apart() -> None:
    figures = dance_clips._vocabulary(4)
    homes = {tuple(figure[3]) for figure in figures}
    assert len(homes) == 2
    steps = (figures[:, 1:] - figures[:, :-1]) / dance_clips._SPAN
    assert np.sqrt((steps**2).mean(axis=-1)).min() >= 1 / 3


def test_seeds_and_dancers_differ_and_repeat() -> None:
    clips = {
        (seed, dancer): motion_of(dance_clip("hit", bars=2, seed=seed, dancer=dancer).clip).rotations
        for seed in (0, 1)
        for dancer in (0, 1)
    }
    again = motion_of(dance_clip("hit", bars=2, seed=1, dancer=1).clip).rotations
    assert np.array_equal(again, clips[1, 1])
    assert len({array.tobytes() for array in clips.values()}) == 4
