"""Every rig on every other: limbs, hips and shoulders point as in the source."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mcml.language.joint_names import named
from mcml.motion.clip import FrameBlock
from mcml.motion.frames import joined
from mcml.motion.retargeting.bone_mapping import suggest_matches
from mcml.motion.retargeting.retarget import retarget
from mcml.motion.skeleton import Skeleton
from mcml.motion.units import Reading, reading_of
from tests.formats.readers.posing import read_clip
from tests.motion.test_retarget import taken
from tests.poses import chosen_frames

RIGS = [
    "bvh/bandai/dataset-1_walk_normal_001.bvh", "bvh/dance/131_01.bvh", "asfamc/cmu16/16_15.amc",
    "bvh/exporters/ah_throw1.bvh", "bvh/exporters/cmu_daz_walk.bvh", "bvh/exporters/mixamo_freebvh.bvh",
    "bvh/exporters/rokoko_jesse_dance.bvh", "bvh/exporters/mocapbank_crlf.bvh", "htr/xbot_jump_m_mixamo.com.htr",
]  # fmt: skip


FAR = {(RIGS[3], RIGS[4]), (RIGS[3], RIGS[2]), (RIGS[7], RIGS[0])}
"""Pairs that differ by up to 23 degrees: a trunk of one bone moved by its middle, and a chest whose rest pose shows no
shoulders beside collars that begin in one point."""


def rig_of(shared: Path, name: str) -> tuple[Skeleton, FrameBlock, Reading]:
    (path,) = [shared / name] if (shared / name).exists() else list(shared.rglob(Path(name).name))[:1]
    skeleton, block, reading = taken(path)
    return skeleton, chosen_frames(block, np.arange(min(len(block), 40))), reading


@pytest.mark.slow
@pytest.mark.parametrize("name", RIGS)
def test_each_rig_moves_as_the_others(shared: Path, name: str) -> None:
    target, shown, target_reading = rig_of(shared, name)
    for other in RIGS:
        if other == name:
            continue
        source, block, reading = rig_of(shared, other)
        made = retarget(
            source, block, target, suggest_matches(source, target), 1 / 60, reading=reading,
            target_reading=target_reading, target_block=shown,
        )  # fmt: skip
        limbs = [bone.mean for bone in made.report.bones if bone.leads]
        assert np.median(limbs) < 2.6, other
        far = 25.0 if (other, name) in FAR else 8.0
        assert all(line.mean < far for line in made.report.parts if line.what in ("hips", "shoulders")), (
            other,
            made.report.parts,
        )


def test_legs_below_the_spine(shared: Path) -> None:
    """Where the legs hang from the spine, and the rest pose of the motion is twisted there, hips turn all the same."""
    source, block, reading = rig_of(shared, RIGS[0])
    clip = read_clip("fbx", (shared / "fbx" / "arnaud_rig_7500.fbx").read_bytes())
    target, shown = named(clip.head.skeleton)[0], joined(clip.blocks())
    spine = target.joints[target.joints[target.names.index("left_up_leg")].parent]
    assert spine.name == "waist"
    made = retarget(
        source, block, target, suggest_matches(source, target), 1 / 30, reading=reading,
        target_reading=reading_of(clip.head), target_block=shown,
    )  # fmt: skip
    assert max(part.mean for part in made.report.parts) < 3.0
