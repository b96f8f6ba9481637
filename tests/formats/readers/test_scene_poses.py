"""Scenes with any transforms become clips whose joints stand where the scene has them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mcml.errors import FormatError, LimitError
from mcml.formats.format import Limits
from mcml.formats.scenes.local_poses import find_rotations
from mcml.formats.scenes.make_clip import make_clip
from mcml.formats.scenes.scene import Rig, Scene, Take
from mcml.motion.clip import ClipStream, SourcePart
from mcml.motion.nodes import choose_joints, parents_among, sort_by_tree
from mcml.motion.skeleton import Array
from mcml.testing import check_block
from tests.formats.readers.posing import places_of, rotations_of
from tests.fuzz import examples

UPS = ["Y", "-Z", "-X", "Z"]
HALF_TURNS = {"-Z": "x", "-X": "z"}
PART = SourcePart("fbx", "a.fbx")


def scene_of(poses: Array, parents: list[int], rest: Array | None = None, up: str = "Y") -> Scene:
    names = tuple(f"j{number}" for number in range(len(parents)))
    rig = Rig(names, np.array(parents, np.intp), poses[0] if rest is None else rest)
    return Scene((Take("t", rig, len(poses), 30.0, lambda first, end: poses[first:end]),), "cm", up)


def clip_from(poses: Array, parents: list[int], up: str = "Y") -> ClipStream:
    scene = scene_of(poses, parents, up=up)
    return make_clip(scene, scene.takes[0], "fbx", PART, Limits())


def random_poses(seed: int, frames: int, parents: list[int], *, scaled: bool, mirrored: bool) -> Array:
    """(frames, J, 3, 4) of chains of random local transforms."""
    chance = np.random.default_rng(seed)
    joints = len(parents)
    poses = np.zeros((frames, joints, 3, 4))
    rest = Rotation.random(joints, random_state=seed)
    for joint, parent in enumerate(parents):
        path = np.cumsum(chance.normal(0, 0.3, (frames, 3)), axis=0)
        linear = (rest[joint] * Rotation.from_rotvec(path)).as_matrix()
        if scaled:
            linear = linear * chance.uniform(0.2, 5, (frames, 1, 3))
        if mirrored and joint == 1:
            linear = linear * np.array([-1.0, 1.0, 1.0])
        place = chance.normal(0, 10, 3) + chance.normal(0, 1, (frames, 3)) * (joint % 2 == 0)
        if parent >= 0:
            above = poses[:, parent]
            place = (above[:, :, :3] @ place[..., None])[..., 0] + above[:, :, 3]
            linear = above[:, :, :3] @ linear
        poses[:, joint, :, :3], poses[:, joint, :, 3] = linear, place
    return poses


@given(st.integers(0, 2**32 - 1), st.integers(1, 8), st.booleans(), st.booleans(), st.sampled_from(UPS))
@examples(40)
def test_joints_stand_where_the_scene_has_them(seed: int, joints: int, scaled: bool, mirrored: bool, up: str) -> None:
    chance = np.random.default_rng(seed)
    parents = [-1] + [int(chance.integers(-1 if joint > 4 else 0, joint)) for joint in range(1, joints)]
    order = sort_by_tree(parents, 99)
    place = {joint: index for index, joint in enumerate(order)}
    parents = [place.get(parents[joint], -1) for joint in order]
    poses = random_poses(seed, 9, parents, scaled=scaled, mirrored=mirrored)
    clip = clip_from(poses, parents, up)
    turn = Rotation.from_euler(HALF_TURNS[up], 180, degrees=True) if up in HALF_TURNS else None
    expected = poses[..., 3] if turn is None else poses[..., 3] @ turn.as_matrix().T
    size = float(np.ptp(poses[0, :, :, 3], axis=0).max()) or 1.0
    assert np.abs(places_of(clip) - expected).max() < 3e-6 * max(size, np.abs(expected).max())
    if not scaled and not mirrored and turn is None:
        wanted = Rotation.from_matrix(poses[..., :3].reshape(-1, 3, 3))
        at_rest = Rotation.from_matrix(np.tile(poses[0, :, :, :3], (len(poses), 1, 1)))
        found = Rotation.from_quat(rotations_of(clip).reshape(-1, 4))
        assert (found * (wanted * at_rest.inv()).inv()).magnitude().max() < 1e-9


def test_scales_are_told_and_rotations_are_the_orthogonal_part() -> None:
    poses = random_poses(3, 5, [-1, 0, 1], scaled=True, mirrored=False)
    rotations, scales = find_rotations(poses[..., :3], np.broadcast_to(np.eye(3), (3, 3, 3)))
    for linear, rotation in zip(poses[..., :3].reshape(-1, 3, 3), rotations.reshape(-1, 3, 3), strict=True):
        left, _, right = np.linalg.svd(linear)
        assert np.allclose(rotation, left @ right, atol=1e-12)
    assert np.allclose(scales, np.linalg.norm(poses[..., :3], axis=-2))
    clip = clip_from(poses, [-1, 0, 1])
    assert any("the scale of" in notice.what for notice in clip.notices)


def test_a_flat_joint_keeps_the_rotation_of_the_frame_before() -> None:
    poses = random_poses(5, 4, [-1, 0], scaled=False, mirrored=False)
    before = poses[1, 1, :, :3].copy()
    poses[2, 1, :, :3] = 0
    rotations, _ = find_rotations(poses[..., :3], np.broadcast_to(np.eye(3), (2, 3, 3)))
    assert np.allclose(rotations[2, 1], before)


def test_what_is_not_finite_is_missing_and_more_than_half_is_refused() -> None:
    poses = random_poses(7, 6, [-1, 0, 1], scaled=False, mirrored=False)
    poses[2, 1, 0, 3] = np.nan
    poses[3, 2, 1, 1] = np.inf
    clip = clip_from(poses, [-1, 0, 1])
    blocks = list(clip.blocks())
    for block in blocks:
        check_block(block)
    missing = set()
    for block in blocks:
        for row, number in enumerate(block.ids):
            shape = block.shapes[0 if block.shape_of is None else block.shape_of[row]]
            missing |= {(int(number), joint) for joint, bits in shape if not bits}
    assert missing == {(3, 1), (3, 2), (4, 2)}
    poses[1:] = np.nan
    clip = clip_from(poses, [-1, 0, 1])
    with pytest.raises(FormatError, match="are missing or not finite"):
        list(clip.blocks())


def test_takes_of_one_rig_share_their_skeleton() -> None:
    moving = random_poses(9, 5, [-1, 0, 1], scaled=False, mirrored=False)
    rig = Rig(("a", "b", "c"), np.array([-1, 0, 1], np.intp), moving[0])
    still = np.repeat(moving[:1], 3, axis=0)
    takes = tuple(
        Take(name, rig, len(poses), 24.0, lambda first, end, poses=poses: poses[first:end])
        for name, poses in (("moving", moving), ("still", still))
    )
    scene = Scene(takes, "m", "Y")
    first, second = (make_clip(scene, take, "glb", PART, Limits()) for take in takes)
    assert first.head.skeleton == second.head.skeleton
    assert len(first.head.skeleton.joints[2].channels) == 6


def test_nodes_are_sorted_chosen_and_bounded() -> None:
    assert sort_by_tree([-1, 2, 0, 0], 9) == [0, 2, 1, 3]
    with pytest.raises(FormatError, match="its own ancestors"):
        sort_by_tree([1, 0, -1], 9)
    with pytest.raises(LimitError, match="nested more than 3 deep"):
        sort_by_tree([-1, 0, 1, 2], 3)
    parents = [-1, 0, 1, 2, 3, 0]
    assert choose_joints(parents, {1, 4}) == [1, 2, 3, 4]
    assert parents_among([1, 4], parents) == [-1, 0]
