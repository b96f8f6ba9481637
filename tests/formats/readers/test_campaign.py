"""Many damaged files of each format of scenes, with other seeds each time: read whole, or refused in words of ours."""

from __future__ import annotations

import numpy as np
import pytest

from tests.formats.readers.fbx_text import fbx_text
from tests.formats.readers.posing import npz, reads_or_refuses, spoil
from tests.formats.readers.test_arkit import table
from tests.formats.readers.test_gltf import TIMES, TURNS, gltf, model_of
from tests.formats.readers.test_mvnx import mvnx, poses
from tests.formats.readers.test_usd import ARM

SAMPLES = {
    "fbx": (fbx_text(("Walk", "Run")), 30),
    "usd": (ARM, 15),
    "glb": (gltf(*model_of([(1, "rotation", "LINEAR", TIMES, TURNS.as_quat())]), form="data"), 1000),
    "smpl": (npz(poses=np.zeros((3, 72)), trans=np.zeros((3, 3)), fps=30), 1000),
    "arkit": (table(12), 1000),
    "mvnx": (mvnx(*poses(2)), 1000),
}


@pytest.mark.fuzz(seeds=20)
@pytest.mark.parametrize("name", SAMPLES)
def test_damaged_files_are_read_or_refused(name: str, seed: int) -> None:
    data, count = SAMPLES[name]
    chance = np.random.default_rng(seed)
    for _ in range(count):
        changed = spoil(data, chance, int(chance.integers(1, 6)))
        reads_or_refuses(name, changed[: chance.integers(1, len(changed) + 1)] if chance.random() < 0.3 else changed)
