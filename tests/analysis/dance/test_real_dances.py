"""Real dance clips, whose beats nobody has annotated: they agree with themselves at another frame rate."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from schemas.analyses.dance import BeatsParameters, DanceParameters
from service.analysis.dance.analyses import BEATS, DANCE
from service.analysis.dance.metrics import nearest
from service.analysis.interface import Motion, silent
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


@pytest.mark.parametrize("path", CLIPS)
def test_a_clip_agrees_with_itself_at_another_frame_rate(shared: Path, path: str) -> None:
    """Beats are where they were, but for one or two at the edge of a condition."""
    motion = read_file(shared / path)
    own = seconds_of(motion, beats_from="detected")
    assert len(own) >= 7
    for fps in (30.0, 50.0, 100.0):
        other = seconds_of(resampled(motion, fps), beats_from="detected")
        within = 1 / min(fps, motion.fps) + 1e-9
        agreed = (nearest(own, other) <= within).sum(), (nearest(other, own) <= within).sum()
        assert min(agreed) >= 0.85 * max(len(own), len(other))


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
