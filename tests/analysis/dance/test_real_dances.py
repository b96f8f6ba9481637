"""Real dance clips, whose beats nobody has annotated: they agree with themselves at another frame rate."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from mcml_schemas.analyses.dance import BeatsParameters, DanceParameters
from mcml_service.analysis.dance.analyses import BEATS, DANCE
from mcml_service.analysis.dance.metrics import nearest
from mcml_service.analysis.interface import Motion, silent
from tests.analysis.dance.motions import read_file, resampled

CLIPS = (
    "bvh/dance/60_10_scaled.bvh",
    "bvh/dance/61_10_scaled.bvh",
    "bvh/dance/Gangnam-Style.bvh",
    "bvh/dance/B_test.bvh",
    "bvh/exporters/rokoko_jesse_dance.bvh",
    "asfamc/dance/lambada.amc",
)


def seconds_of(motion: Motion, **parameters: Any) -> np.ndarray:
    parts = BEATS.run([motion], BeatsParameters.model_validate(parameters), silent)
    return np.array([row[3] for row in parts["beats"].data["rows"]])


def agreement(motion: Motion, fps: float) -> float:
    """The share of beats that stay within a frame of the slower rate."""
    one, other = (seconds_of(clip, beats_from="detected") for clip in (motion, resampled(motion, fps)))
    within = 1 / min(fps, motion.fps)
    met = min((nearest(one, other) <= within).sum(), (nearest(other, one) <= within).sum())
    return float(met / max(len(one), len(other)))


def test_clips_agree_with_themselves_at_another_frame_rate(shared: Path) -> None:
    """Beats at the edge of a condition come and go: B_test, slow and full of small rests, loses seven of 27 at 30."""
    found = {path: [agreement(read_file(shared / path), fps) for fps in (30.0, 50.0, 100.0)] for path in CLIPS}
    assert min(min(shares) for shares in found.values()) >= 0.7
    assert np.mean([min(shares) for shares in found.values()]) >= 0.9
    assert sum(min(shares) == 1.0 for shares in found.values()) >= 3


def test_the_same_take_in_another_unit_has_the_same_beats(shared: Path) -> None:
    one, other = (
        seconds_of(read_file(shared / f"bvh/dance/{name}131_01.bvh"), beats_from="detected") for name in ("", "scaled_")
    )
    assert len(one) == len(other)
    assert np.abs(one - other).max() < 0.02


def test_a_dance_of_real_bars(shared: Path) -> None:
    motion = read_file(shared / "bvh/dance/Gangnam-Style.bvh")
    parts = DANCE.run([motion], DanceParameters(bpm=128, bars=8, stride=1, k3=1.5), silent)
    clip = parts["clip"].clip
    assert clip is not None
    assert len(clip.rotations) == int(8 * 240 / 128 * motion.fps + 0.5)
    assert np.isfinite(clip.translations).all()
    assert np.abs(np.linalg.norm(clip.rotations, axis=-1) - 1).max() < 1e-9
