"""What the index says poses and motions are apart at least, against what they are: of bodies that lack joints, frames
without a pose, and several frame rates."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcml.motion.bodies.pose_index import COMPONENTS, WIDTH, Singles, balls_of, pose_index
from mcml.motion.bodies.poses import FEWEST, JOINTS, motion_distances, pose_distances
from mcml.motion.skeleton import Array

RATES = (1 / 30, 1 / 60, 1 / 120, None)
ALMOST = 1e-6
MOST_LACKING = len(JOINTS) - FEWEST + 2


def poses_of(random: np.random.Generator, frames: int, lacking: int, holes: float, *, odd: bool = False) -> Singles:
    """Someone who moves on smoothly through a few dimensions of all that joints can do."""
    few = random.normal(size=(5, WIDTH)) * random.uniform(0.1, 1.0)
    steps = np.cumsum(random.normal(size=(frames, 5)) * random.uniform(0.01, 0.4), axis=0)
    poses = (random.normal(size=WIDTH) * 0.2 + np.sin(steps) @ few).reshape(-1, len(JOINTS), 3)
    poses[:, random.permutation(len(JOINTS))[:lacking]] = np.nan
    poses[random.random(frames) < holes] = np.nan
    if odd:
        poses[random.random(frames) < 0.2, random.integers(len(JOINTS))] = np.nan
    return poses.reshape(-1, WIDTH).astype(np.float32)


def as_poses(vectors: Singles) -> Array:
    return vectors.astype(np.float64).reshape(-1, len(JOINTS), 3)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_nothing_is_nearer_than_the_index_says(seed: int) -> None:
    random = np.random.default_rng(seed)
    documents = [
        (
            poses_of(
                random,
                int(random.choice((0, 1, 2, 7, 40))),
                int(random.choice((0, 0, 2, MOST_LACKING))),
                float(random.choice((0.0, 0.0, 0.2))),
                odd=bool(random.random() < 0.2),
            ),
            RATES[int(random.integers(len(RATES)))],
        )
        for _ in range(8)
    ]
    index = pose_index([balls_of(*one) for one in documents])
    asked = as_poses(poses_of(random, 12, int(random.choice((0, 0, 3, MOST_LACKING))), 0.0))
    own = [as_poses(one) for one, _ in documents if len(one)]
    if own and random.random() < 0.5:
        # Something that is there, so that the nearest is at no distance.
        asked = own[0][:12]
    of_pose = index.near_pose(asked[0])
    rate = RATES[int(random.integers(3))] or 1.0
    at_rate = np.array([seconds == rate for _, seconds in documents])
    of_motion = index.near_motion(asked, rate, at_rate)

    for place, (vectors, _) in enumerate(documents):
        poses = as_poses(vectors)
        frames = np.arange(len(poses))
        segments = index.segments(np.full(len(poses), place), frames)
        assert len(np.unique(segments)) == index.ends[place] - index.starts[place]
        _bounded(pose_distances(poses, asked[:1])[:, 0], of_pose[segments])
        exact = motion_distances(poses, asked) if at_rate[place] else np.full(len(poses), np.nan)
        _bounded(exact, of_motion[segments])


def _bounded(exact: Array, least: Singles) -> None:
    known = ~np.isnan(exact)
    assert (least[known] <= exact[known] + ALMOST).all()


def test_bounds_leave_out_most_of_what_is_far() -> None:
    """A bound of nothing would be right, too, and no index."""
    random = np.random.default_rng(3)
    documents = [(poses_of(random, 200, 0, 0.0), 1 / 60) for _ in range(30)]
    index = pose_index([balls_of(*one) for one in documents])
    asked = as_poses(documents[7][0])
    exact = np.concatenate([pose_distances(as_poses(vectors), asked[50:51])[:, 0] for vectors, _ in documents])
    least = index.near_pose(asked[50])
    assert (least <= np.sort(exact)[20]).sum() < len(least) / 10
    of_motion = index.near_motion(asked[40:100], 1 / 60, np.ones(30, bool))
    best = np.minimum.reduceat(of_motion, index.starts)
    assert (best == 0).sum() < 15


def test_joints_that_are_not_asked_may_be_anywhere() -> None:
    random = np.random.default_rng(4)
    vectors = poses_of(random, 80, 0, 0.0)
    index = pose_index([balls_of(vectors, 1 / 30)])
    asked = as_poses(vectors)[20]
    asked[5:9] = np.nan
    least = index.near_pose(asked)
    exact = pose_distances(as_poses(vectors), asked[None])[:, 0]
    _bounded(exact, least[index.segments(np.zeros(80, np.int64), np.arange(80))])
    assert least.max() > 0.1
    asked[5 : 5 + MOST_LACKING] = np.nan
    assert np.isinf(index.near_pose(asked)).all()


@pytest.mark.parametrize("documents", [[], [(np.empty((0, WIDTH), np.float32), None)]])
def test_an_index_of_nothing_finds_nothing(documents: list[tuple[Singles, float | None]]) -> None:
    index = pose_index([balls_of(*one) for one in documents])
    pose = np.zeros((len(JOINTS), 3))
    assert index.points.shape == (0, COMPONENTS + 2)
    assert len(index.near_pose(pose)) == len(index.near_motion(pose[None], 1 / 30, np.ones(len(documents), bool))) == 0
