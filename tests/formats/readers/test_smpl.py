"""Poses of SMPL, SMPL-H and SMPL-X, against SciPy's rotations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mcml.errors import FormatError, LimitError, McmlError
from mcml.formats import READERS, find_format
from mcml.formats.format import Limits
from mcml.formats.smpl.skeleton import body_of
from mcml.motion.skeleton import Array
from mcml.testing import check_block, frames
from tests.formats.readers.posing import npz, places_of, read_clip, reads_or_refuses, spoil
from tests.fuzz import examples


def expected_places(poses: Array, trans: Array) -> Array:
    """(frames, J, 3) by matrices, in the order of the body's joints."""
    body = body_of(poses.shape[1] // 3)
    turns = poses.reshape(len(poses), -1, 3)
    places, axes = [], []
    for parent, offset, place in zip(body.parents, body.offsets, body.places, strict=True):
        local = Rotation.from_rotvec(turns[:, place])
        if parent < 0:
            places.append(trans + np.array(offset))
            axes.append(local)
        else:
            places.append(places[parent] + axes[parent].apply(np.array(offset)))
            axes.append(axes[parent] * local)
    return np.stack(places, axis=1)


@given(st.sampled_from([22, 24, 52, 55]), st.integers(0, 2**32 - 1), st.sampled_from(["<f4", "<f8"]))
@examples(20)
def test_joints_stand_where_the_axis_angles_put_them(joints: int, seed: int, kind: str) -> None:
    chance = np.random.default_rng(seed)
    poses = np.cumsum(chance.normal(0, 0.4, (7, 3 * joints)), axis=0).astype(kind)
    trans = chance.normal(0, 2, (7, 3)).astype(kind)
    clip = read_clip("smpl", npz(poses=poses, trans=trans, mocap_framerate=60.0))
    assert np.abs(places_of(clip) - expected_places(poses.astype(float), trans.astype(float))).max() < 1e-9
    assert clip.head.fields["global_axis_of_gravity"] == "Z"
    assert any(notice.kind == "guess" and "general adult" in notice.what for notice in clip.notices)


def test_pieces_are_joined_and_facts_are_properties() -> None:
    chance = np.random.default_rng(1)
    poses, trans = chance.normal(0, 1, (4, 165)), chance.normal(0, 1, (4, 3))
    whole = npz(poses=poses, trans=trans, mocap_frame_rate=120.0)
    parts = npz(
        root_orient=poses[:, :3], pose_body=poses[:, 3:66], pose_jaw=poses[:, 66:69], pose_eye=poses[:, 69:75],
        pose_hand=poses[:, 75:], trans=trans, mocap_frame_rate=120.0, gender=b"female", betas=np.arange(10) / 8,
    )  # fmt: skip
    clip = read_clip("smpl", parts)
    assert frames(clip) == frames(read_clip("smpl", whole))
    assert clip.head.properties[0] == ("gender", "female", "")
    assert clip.head.properties[1][1].startswith("0 0.125 0.25")


def test_the_rate_is_the_files_or_must_be_said() -> None:
    poses, trans = np.zeros((3, 72)), np.zeros((3, 3))
    with pytest.raises(FormatError, match="no frame rate"):
        read_clip("smpl", npz(poses=poses, trans=trans))
    said = read_clip("smpl", npz(poses=poses, trans=trans), rate=30)
    assert said.head.fields["dataframe_rate"] == "30"
    assert "global_axis_of_gravity" not in said.head.fields


def test_a_pose_that_is_not_finite_is_missing() -> None:
    poses, trans = np.zeros((5, 156)), np.zeros((5, 3))
    poses[3, 7] = np.nan
    clip = read_clip("smpl", npz(poses=poses, trans=trans, mocap_framerate=60))
    block = next(iter(clip.blocks()))
    check_block(block)
    assert block.shape_of is not None
    gone = [joint for joint, bits in block.shapes[block.shape_of[3]] if not bits]
    assert [clip.head.skeleton.joints[joint].source_name for joint in gone] == ["right_hip"]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (npz(joints=np.zeros((3, 3))), "no array 'poses'"),
        (npz(poses=np.zeros((3, 72)), trans=np.zeros((4, 3)), fps=30), "3 poses and 4 places"),
        (npz(poses=np.zeros((3, 70)), trans=np.zeros((3, 3)), fps=30), "have 23 joints"),
        (npz(poses=np.array([{}, []], object), trans=np.zeros((2, 3)), fps=30), "pickled data, which is not opened"),
        (npz(poses=np.zeros((0, 72)), trans=np.zeros((0, 3)), fps=30), "has no frames"),
        (npz(poses=np.zeros(72), trans=np.zeros((1, 3)), fps=30), "no matrix"),
        (npz(poses=np.full((3, 72), np.nan), trans=np.zeros((3, 3)), fps=30), "not finite"),
    ],
)
def test_what_is_no_motion_is_refused(data: bytes, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        frames(read_clip("smpl", data, rate=30))


def test_nothing_is_unpickled_and_sizes_are_checked_first() -> None:
    class Trap:
        def __reduce__(self) -> tuple[object, ...]:
            return pytest.fail, ("it was unpickled",)

    with pytest.raises(FormatError):
        read_clip("smpl", npz(poses=np.array([Trap()], object), trans=np.zeros((1, 3)), fps=30))
    with pytest.raises(LimitError):
        read_clip("smpl", npz(poses=np.zeros((99, 72)), trans=np.zeros((99, 3)), fps=30), limits=Limits(frames=10))


def test_any_byte_may_be_wrong() -> None:
    data = npz(poses=np.zeros((3, 72)), trans=np.zeros((3, 3)), fps=30)
    assert find_format("a.zip", data[:4096]) == (READERS["smpl"], "npz")
    chance = np.random.default_rng(5)
    for _ in range(150):
        reads_or_refuses("smpl", spoil(data, chance))
    for end in range(0, len(data), 41):
        with pytest.raises(McmlError):
            frames(read_clip("smpl", data[:end]))
