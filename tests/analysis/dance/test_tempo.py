"""The tempo of a motion: the same at every frame rate, of partners together, and doubtful where it is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mcml.motion.skeleton import Array
from mcml_schemas.analyses.dance import BeatsParameters
from mcml_service.analysis.dance import tempo as tempi
from mcml_service.analysis.dance.analyses import BEATS
from mcml_service.analysis.dance.figure import figure_of
from mcml_service.analysis.dance.sources import Search, channels_of, read_clip
from mcml_service.analysis.dance.tempo import RATE, TEMPI, Tempo, periodicity, tempo_of
from mcml_service.analysis.interface import Motion, silent
from tests.analysis.dance.motions import generated, read_file, resampled


def tempo(*motions: Motion) -> Tempo:
    found = tempo_of([channels_of(replace(motion, up="Y")) for motion in motions])
    assert found is not None
    return found


def bpm(*motions: Motion) -> float:
    return tempo(*motions).peaks[0].bpm


def beats(*motions: Motion, **parameters: Any) -> tuple[list[dict[str, Any]], list[list[Any]]]:
    """Rows of the clips by column, and warnings."""
    parts = BEATS.run(motions, BeatsParameters.model_validate(parameters), silent)
    columns = [column["name"] for column in parts["clips"].data["columns"]]
    rows = [dict(zip(columns, row, strict=True)) for row in parts["clips"].data["rows"]]
    return rows, parts["warnings"].data["rows"]


def test_a_real_dance_has_one_tempo_at_every_frame_rate(shared: Path) -> None:
    """Nominally 132. By the beats that are found it was 126.6, 112.6 and 126.2 at 24, 30 and 60."""
    motion = read_file(shared / "bvh/dance/Gangnam-Style.bvh")
    found = [bpm(motion), *(bpm(resampled(motion, fps)) for fps in (24.0, 30.0, 40.0, 90.0, 120.0))]
    assert np.ptp(found) < 0.05
    assert found[0] == pytest.approx(130.8, rel=0.005)
    assert tempo(motion).clear
    row = beats(resampled(motion, 30.0))[0][0]
    assert row["bpm"] == pytest.approx(found[0], rel=1e-3)
    assert row["tempo_clear"]


@pytest.mark.parametrize(
    ("path", "clear"),
    [
        ("bvh/exporters/rokoko_jesse_dance.bvh", True),
        ("bvh/dance/B_test.bvh", False),
        ("asfamc/dance/lambada.amc", False),
        ("asfamc/dance/charleston2.amc", False),
    ],
)
def test_real_clips_agree_with_themselves(shared: Path, path: str, clear: bool) -> None:
    motion = read_file(shared / path)
    whole = tempo(motion)
    for fps in (24.0, 30.0):
        assert bpm(resampled(motion, fps)) == pytest.approx(whole.peaks[0].bpm, rel=0.01)
    assert whole.clear == clear
    assert ("tempo-unclear" in [row[1] for row in beats(motion)[1]]) == (not clear)


@pytest.mark.parametrize(
    "path", ["asfamc/cmu_misc/07_05-walk.amc", "bvh/bandai/dataset-1_bow_tired_001.bvh", "asfamc/dance/lambada.amc"]
)
@pytest.mark.parametrize("fps", [None, 25.0])
def test_other_motion_is_told_no_tempo_with_confidence(shared: Path, path: str, fps: float | None) -> None:
    """Walks and bows of some seconds are as regular as dances, and whole bars as regular as beats."""
    motion = read_file(shared / path)
    found = tempo(motion if fps is None else resampled(motion, fps))
    assert not found.clear
    assert found.warnings()


def test_a_weak_periodicity_of_minutes_is_ambiguous() -> None:
    """Chance alone makes one tempo stand out in minutes of motion that keep no time."""
    rng = np.random.default_rng(3)
    told = [
        tempo_of([np.stack([np.convolve(rng.normal(size=9000), np.hanning(30), "same") for _ in range(3)])])
        for _ in range(12)
    ]
    assert not any(found is not None and found.clear for found in told)
    weak = of_channels(channel((104.0, 150.0), noise=1.2, seed=2))
    assert weak.peaks[0].strength < 0.15
    assert not weak.clear
    assert of_channels(channel((104.0, 150.0))).clear


def test_partners_are_read_together(shared: Path) -> None:
    pair = [replace(read_file(shared / f"bvh/dance/{name}_scaled.bvh"), document=name) for name in ("60_10", "61_10")]
    alone = beats(*pair)[0]
    assert alone[0]["bpm"] != alone[1]["bpm"]
    together, warnings = beats(*pair, shared_music=True)
    assert together[0]["bpm"] == together[1]["bpm"] == pytest.approx(93.6, rel=0.01)
    assert [row[1] for row in warnings] == ["tempo-unclear"]
    assert warnings[0][0].startswith("All clips: ")


@pytest.mark.parametrize("style", ["groove", "hit", "step", "accent", "preparation", "wave"])
@pytest.mark.parametrize(("true", "fps"), [(80, 120.0), (110, 30.0), (145, 60.0)])
def test_generated_dances_have_their_tempo(style: Any, true: float, fps: float) -> None:
    motion, _ = generated(style, tempo=true, fps=fps, seed=31)
    assert bpm(motion) == pytest.approx(true, rel=0.01)


def test_blocks_are_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    motion, _ = generated("step", fps=100.0, bars=6)
    whole = channels_of(motion)
    monkeypatch.setattr(tempi, "_BLOCK", 200)
    assert np.allclose(channels_of(motion), whole, atol=1e-9)


def test_a_pose_of_calibration_is_left_out() -> None:
    motion, _ = generated("groove", fps=40.0, bars=4)
    posed = motion.translations.copy()
    posed[:3, 0] += np.array([900.0, 0.0, 400.0])
    assert bpm(replace(motion, translations=posed)) == pytest.approx(bpm(motion), rel=0.01)
    assert channels_of(replace(motion, translations=posed)).shape[1] == channels_of(motion).shape[1] - 5


def test_what_is_known_replaces_it() -> None:
    motion, truth = generated("groove", tempo=100)
    rows, warnings = beats(motion, source_bpm=50.0)
    assert (rows[0]["bpm"], rows[0]["tempo_clear"], warnings) == (50.0, None, [])
    by_beats = beats(motion, tempo="paper")[0][0]
    assert by_beats["tempo_clear"] is None
    assert by_beats["bpm"] == pytest.approx(100, rel=0.01)
    own = read_clip(motion, Search(own_beats=tuple(truth.beats[::2])))
    assert own.period == pytest.approx(1.2, rel=0.01)


def channel(*parts: tuple[float, float], noise: float = 0.0, seed: int = 0) -> Array:
    """Channels (3, n) of pulses at tempi (beats a minute, seconds), one after the other."""
    rng = np.random.default_rng(seed)
    pulses = []
    for tempo_there, seconds in parts:
        time = np.arange(int(seconds * RATE)) / RATE
        pulses.append(np.exp(8 * (np.cos(2 * np.pi * tempo_there / 60 * time) - 1)))
    wave = np.concatenate(pulses)
    wave -= wave.mean()
    return np.stack([wave + noise * rng.normal(size=len(wave)) for _ in range(3)])


def of_channels(*clips: Array) -> Tempo:
    found = tempo_of(clips)
    assert found is not None
    return found


def codes(found: Tempo) -> list[str]:
    return [code for code, _ in found.warnings()]


def test_periodicity_is_comb_times_coherence() -> None:
    """Against sums that are written out, at some tempi whose beats are whole samples."""
    window = channel((100, 8), noise=0.5)
    found = periodicity(window)
    count = window.shape[1]
    hann = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(count) / (count - 1))
    for lag in (20, 36, 45, 60, 90):
        wanted = 0.0
        for series, weight in zip(window, (0.25, 0.5, 0.25), strict=True):
            at = [
                sum(series[i] * series[i + k * lag] for i in range(count - k * lag)) / (series**2).sum()
                * min(count / (count - k * lag), 4)
                if k * lag < count else 0.0
                for k in (1, 2, 3, 4)
            ]  # fmt: skip
            comb = max(0.0, (at[0] + at[1] + at[2] / 2 + at[3]) / 3.5)
            turned = (hann * series * np.exp(-2j * np.pi * np.arange(count) / lag)).sum()
            wanted += weight * comb * np.sqrt(2 * abs(turned) ** 2 / (((hann * series) ** 2).sum() * (hann**2).sum()))
        assert np.interp(60 * RATE / lag, TEMPI, found) == pytest.approx(wanted, rel=0.02, abs=2e-4)


@pytest.mark.parametrize("true", [45.0, 72.0, 90.0, 128.0, 150.0])
def test_pulses_have_their_tempo(true: float) -> None:
    found = of_channels(channel((true, 30), noise=0.3))
    assert any(peak.bpm == pytest.approx(true, rel=0.01) for peak in found.peaks[:2])
    assert found.steady == 1.0


def test_noise_is_not_clear() -> None:
    for seed in range(4):
        found = of_channels(channel((100, 30), noise=50.0, seed=seed))
        assert "tempo-unclear" in codes(found)
        assert "source_bpm" in dict(found.warnings())["tempo-unclear"]


def test_a_change_of_tempo_is_told() -> None:
    steady, changed = of_channels(channel((100, 80))), of_channels(channel((90, 40), (125, 40)))
    assert steady.steady == 1.0
    assert steady.clear
    assert changed.steady < 0.6
    assert "tempo-changes" in codes(changed)


def test_an_octave_that_is_as_likely_is_told() -> None:
    found = of_channels(channel((70, 40)) + 0.5 * channel((140, 40)))
    assert found.octave >= 0.5
    assert "tempo-octave" in codes(found)
    assert found.clear


def test_clips_together_are_clearer_than_each() -> None:
    parts = [channel((104, 7), noise=2.5, seed=seed) for seed in range(6)]
    together = of_channels(*parts)
    assert together.peaks[0].bpm == pytest.approx(104, rel=0.02)
    assert together.seconds == pytest.approx(42)
    assert together.rival < max(of_channels(part).rival for part in parts)


def test_nothing_in_time_has_no_tempo() -> None:
    assert tempo_of([np.zeros((3, 600))]) is None
    assert tempo_of([channel((100, 0.5))]) is None
    assert tempo_of([]) is None
    motion, _ = generated("groove", bars=2)
    figure = replace(figure_of(motion.skeleton, motion.translations), used=np.empty(0, dtype=np.intp))
    assert tempo_of([tempi.body_channels(figure, motion.translations, motion.rotations, motion.fps)]) is None
