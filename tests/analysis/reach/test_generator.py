"""The generated clips obey the law in docs/analyses/reach.md."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

from mcml_service.demo import reach_clips as source
from mcml_service.demo.reach_clips import BELT, reach_clips
from tests.analysis.reach.reach_motions import generated
from tests.builders import assign


def test_the_set_has_the_papers_shape() -> None:
    motions, clips = generated(few=False)
    assert len(clips) == 185
    assert sum(20 <= clip.age <= 29 for clip in clips) == 98
    assert sum(60 <= clip.age <= 79 for clip in clips) == 87
    assert len({clip.subject for clip in clips}) == 41
    assert all(60 <= len(motion) <= 90 for motion in motions)
    assert all(len(motion.skeleton) == 23 for motion in motions)
    assert all(motion.fps == pytest.approx(30, rel=1e-5) for motion in motions)
    for motion, clip in zip(motions, clips, strict=True):
        assert motion.properties["age"] == (str(clip.age), "year")
        assert motion.properties["height"] == (f"{clip.height:.1f}", "cm")
        assert motion.properties["hbp"] == (str(clip.hbp), "mm")
        assert motion.properties["subject"] == (clip.subject, "")
        assert 150 <= clip.hbp <= 420
        assert 0 < clip.times[0] < clip.times[1] < clip.times[2] == len(motion) - 1


def test_the_arm_has_its_mcml_name() -> None:
    names = {joint.source_name: joint.name for joint in assign(source.skeleton(170)).joints}
    assert names["Bip01 R UpperArm"] == "right_up_arm"
    assert names["Bip01 R Hand"] == "right_hand"


def test_the_wrist_is_at_the_belt_when_the_reach_ends() -> None:
    motions, clips = generated(few=False)
    hand = motions[0].skeleton.names.index("right_hand")
    away = [
        np.linalg.norm(motion.walk()[0][round(clip.times[1]), hand] - BELT)
        for motion, clip in zip(motions, clips, strict=True)
    ]
    # The belt's point varies by 0.8 cm an axis, and the trunk still follows.
    assert np.median(away) < 3


def test_the_arm_stands_still_at_the_true_times() -> None:
    motions, clips = generated(few=True, noise=False, fps=120)
    joint = motions[0].skeleton.names.index("right_up_arm")
    for motion, clip in zip(motions, clips, strict=True):
        turns = motion.rotations[:, joint]
        speed = 2 * np.arccos(np.minimum(np.abs(np.sum(turns[1:] * turns[:-1], axis=1)), 1)) * motion.fps
        for time in clip.times[:2]:
            # Sway of the sum of two periods remains.
            assert speed[round(time)] < 0.06 * speed.max()


def test_a_seed_is_a_set_and_rates_only_sample_it() -> None:
    first, again, other = (reach_clips(seed, young=(2,), old=(2,)) for seed in (1, 1, 2))
    values = [[next(iter(clip.clip.blocks())).values for clip in made] for made in (first, again, other)]
    assert all(np.array_equal(a, b) for a, b in zip(values[0], values[1], strict=True))
    assert not np.array_equal(values[0][0][:10], values[2][0][:10])
    slow, fast = (reach_clips(1, fps=fps, young=(2,), old=(2,), noise=False) for fps in (30, 60))
    for a, b in zip(slow, fast, strict=True):
        low, high = next(iter(a.clip.blocks())).values, next(iter(b.clip.blocks())).values[::2]
        assert np.abs((low - high + 180) % 360 - 180).max() < 2e-4


def test_the_generator_knows_nothing_of_the_analysis() -> None:
    tree = ast.parse(Path(source.__file__).read_text(encoding="utf-8"))
    imported = [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    assert not [name for name in imported if name.startswith("mcml_service.analysis")]
