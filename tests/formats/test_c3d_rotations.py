"""C3D: files of rotations alone are joints with a place and a rotation in the world."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mcml.errors import FormatError, LimitError, McmlError
from mcml.formats import FORMATS
from mcml.formats.format import Limits, ReadOptions
from mcml.motion.clip import ClipStream
from mcml.motion.frames import joined
from mcml.motion.kinematics import Walker
from mcml.motion.skeleton import Array
from mcml.motion.units import reading_of
from mcml.testing import read
from tests.c3d_writer import Value, c3d_bytes, number

INTEL = 84


def texts(*words: str) -> Value:
    longest = max(map(len, words))
    return -1, (longest, len(words)), "".join(word.ljust(longest) for word in words).encode()


def rotations(
    matrices: Array, reliability: Array, ratio: int = 1, labels: tuple[str, ...] = ("pelvis_4X4", "l_foot")
) -> bytes:
    """A file without points. matrices: (n, J, 4, 4). reliability: (n, J)."""
    frames, count = matrices.shape[:2]
    table = np.concatenate([matrices.swapaxes(-1, -2).reshape(frames, count, 16), reliability[..., None]], axis=2)
    data = b"".join(number(float(value), INTEL) for value in table.ravel())
    parameters: dict[str, Value | None] = {
        "POINT:LABELS": None,
        "ROTATION:USED": (2, (), struct.pack("<H", count)),
        "ROTATION:RATIO": (2, (), struct.pack("<H", ratio)),
        "ROTATION:LABELS": texts(*labels),
        "ROTATION:DATA_START": (2, (), struct.pack("<H", 4)),
    }
    content = c3d_bytes(np.zeros((frames // ratio, 0, 3)), labels=["x"], parameters=parameters, behind=b"")
    assert len(content) <= 3 * 512
    return content.ljust(3 * 512, b"\0") + data


def clip_of(data: bytes, **limits: int) -> ClipStream:
    return read(FORMATS["c3d"], {"c3d": data}, ReadOptions(limits=Limits(**limits)))


def moving(frames: int = 30, seed: int = 0) -> Array:
    chance = np.random.default_rng(seed)
    matrices = np.tile(np.eye(4), (frames, 2, 1, 1))
    turns = Rotation.from_rotvec(np.cumsum(chance.normal(0, 0.2, (frames, 2, 3)), axis=0).reshape(-1, 3))
    matrices[..., :3, :3] = turns.as_matrix().reshape(frames, 2, 3, 3)
    matrices[..., :3, 3] = chance.normal(0, 500, (frames, 2, 3))
    return matrices.astype(np.float32).astype(np.float64)


def poses_of(clip: ClipStream) -> tuple[Array, Array]:
    positions, turned = Walker(clip.head.skeleton, reading_of(clip.head)).poses(joined(clip.blocks()))
    return positions, Rotation.from_quat(turned.reshape(-1, 4)).as_matrix().reshape(*turned.shape[:2], 3, 3)


@pytest.mark.parametrize("seed", range(3))
def test_joints_have_the_places_and_rotations_of_the_matrices(seed: int) -> None:
    matrices = moving(30, seed)
    clip = clip_of(rotations(matrices, np.ones((30, 2))))
    assert clip.head.skeleton.names == ("pelvis", "l_foot")
    assert clip.head.skeleton.roots == (0, 1)
    assert (clip.frames, clip.head.fields["dataframe_rate"], clip.head.fields["calibration_unit"]) == (30, "100", "mm")
    positions, turns = poses_of(clip)
    np.testing.assert_allclose(positions, matrices[..., :3, 3], atol=1e-4)
    np.testing.assert_allclose(turns, matrices[..., :3, :3], atol=2e-6)


def test_a_negative_reliability_is_a_missing_sample() -> None:
    reliability = np.ones((6, 2))
    reliability[3, 1] = -1
    values = joined(clip_of(rotations(moving(6), reliability)).blocks())
    gone = {joint for (joint, _), value in zip(values.columns, values.values[3], strict=True) if np.isnan(value)}
    assert gone == {1}
    assert np.isnan(values.values).sum() == 6


def test_rotations_may_be_faster_than_points() -> None:
    clip = clip_of(rotations(moving(30), np.ones((30, 2)), ratio=3))
    assert (clip.frames, clip.head.fields["dataframe_rate"]) == (30, "300")


def test_what_is_cut_off_is_told() -> None:
    whole = rotations(moving(30), np.ones((30, 2)))
    clip = clip_of(whole[: -5 * 2 * 17 * 4])
    assert clip.frames == 25
    assert any("states 30 frames of rotations and has 25" in notice.what for notice in clip.notices)
    with pytest.raises(FormatError, match="states rotations and has none"):
        clip_of(whole[: 3 * 512])
    with pytest.raises(LimitError):
        clip_of(whole, joints=1)


@pytest.mark.parametrize("seed", range(2))
def test_damaged_files_are_read_or_refused(seed: int) -> None:
    whole, chance = bytearray(rotations(moving(4), np.ones((4, 2)))), np.random.default_rng(seed)
    for _ in range(60):
        data = bytearray(whole)
        for place in chance.integers(0, len(data), 3):
            data[place] = chance.integers(0, 256)
        try:
            for block in clip_of(bytes(data)).blocks():
                assert len(block.values)
        except McmlError:
            pass


def test_a_file_of_a_markerless_system(shared: Path) -> None:
    expected = json.loads((shared / "lab" / "expected.json").read_text())["rotation_theia.c3d"]["rotations"]
    clip = clip_of((shared / "lab" / "rotation_theia.c3d").read_bytes())
    assert [f"{name}_4X4" for name in clip.head.skeleton.names] == expected["labels"]
    positions, turns = poses_of(clip)
    assert len(positions) == expected["frames"]
    wanted = np.array(expected["frame_100_3"])
    np.testing.assert_allclose(positions[100, 3], wanted[:3, 3], atol=1e-4)
    np.testing.assert_allclose(turns[100, 3], wanted[:3, :3], atol=1e-5)
