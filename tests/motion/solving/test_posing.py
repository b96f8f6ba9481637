"""Handles of a body moved over frames: they are where they were sent, the rest stays or goes along."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import ConversionError
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.convert import convert
from mcml.motion.frames import eased, in_columns, joined
from mcml.motion.hub import HubReader, walked
from mcml.motion.markers import marker_skeleton
from mcml.motion.rotation_vectors import from_vector
from mcml.motion.rotations import multiply
from mcml.motion.skeleton import Array, Convention, Skeleton
from mcml.motion.solving.posing import HANDLES, Handle, HandleMove, Posed, handles_of, pose_frames
from mcml.motion.units import reading_of
from tests.builders import assign
from tests.formats.test_real_files import opened
from tests.motion.bodies.made import clip_of, named, person

FRAMES = 40
JOINTS: dict[Handle, str] = {"hips": "Root", "head": "Head"} | {each: each for each in HANDLES[2:]}  # type: ignore[dict-item]
REAL = ("bvh/bandai/dataset-1_walk_normal_001.bvh", "bvh/exporters/mixamo_freebvh.bvh")


class Before:
    """A clip, its joints in the world, and the same posed."""

    def __init__(self, clip: ClipStream) -> None:
        self.skeleton: Skeleton = assign(clip.head.skeleton)
        self.block, self.reading = joined(clip.blocks()), reading_of(clip.head)
        self.places, self.world = self.walk(self.block)

    def walk(self, block: object) -> tuple[Array, Array]:
        hub = HubReader(self.skeleton, self.reading).read(block)  # type: ignore[arg-type]
        return walked(self.skeleton, hub.translations, hub.rotations)

    def pose(self, moves: dict[Handle, HandleMove], strength: Array, **more: tuple[Handle, ...]) -> Posed:
        return pose_frames(self.skeleton, self.block, moves, strength, reading=self.reading, **more)

    def joint(self, handle: Handle) -> int:
        return self.skeleton.names.index(JOINTS[handle])

    @property
    def height(self) -> float:
        return float(np.ptp(self.places[0], axis=0).max())


def made(seed: int, form: Convention = Convention.LISTED) -> Before:
    clip = named(clip_of(person(seed, FRAMES)))
    return Before(clip if form == Convention.LISTED else convert(clip, form))


ways = st.tuples(*[st.floats(-0.04, 0.04) for _ in range(3)]).map(np.array)
turns = st.tuples(*[st.floats(-0.5, 0.5) for _ in range(3)]).map(np.array)


@given(
    seed=st.integers(0, 5),
    form=st.sampled_from([Convention.LISTED, Convention.FIXED, Convention.BASE]),
    moves=st.dictionaries(st.sampled_from(HANDLES), st.tuples(ways, turns), min_size=1),
    ease=st.integers(0, 12),
)
def test_handles_arrive_and_other_frames_keep_their_bits(
    seed: int, form: Convention, moves: dict[Handle, tuple[Array, Array]], ease: int
) -> None:
    clip = made(seed, form)
    strength = eased(FRAMES, 8, 30, ease)
    wanted = {handle: HandleMove(way * clip.height, turn) for handle, (way, turn) in moves.items()}
    posed = clip.pose(wanted, strength)
    places, world = clip.walk(posed.edited.block)
    columns = clip.skeleton.columns()
    before, after = (in_columns(block, columns) for block in (clip.block, posed.edited.block))
    assert np.array_equal(before[strength == 0], after[strength == 0])
    for handle, move in wanted.items():
        joint = clip.joint(handle)
        goals = clip.places[:, joint] + strength[:, None] * move.way
        away = np.linalg.norm(places[:, joint] - goals, axis=1).max()
        assert away == pytest.approx(posed.missed[handle], abs=1e-5 * clip.height)
        faces = multiply(from_vector(strength[:, None] * move.turn), clip.world[:, joint])
        assert np.abs(np.abs((world[:, joint] * faces).sum(axis=1)) - 1).max() < 1e-8
    # The hips arrive always, and the reports tell of limbs that are too short.
    assert posed.missed.get("hips", 0.0) < 1e-6 * clip.height


def test_feet_stay_while_hips_go_down() -> None:
    clip = made(3)
    posed = clip.pose({"hips": HandleMove(np.array([0.0, -0.06 * clip.height, 0.0]))}, eased(FRAMES, 0, FRAMES - 1))
    places, _ = clip.walk(posed.edited.block)
    feet = [clip.joint("left_foot"), clip.joint("right_foot")]
    np.testing.assert_allclose(places[:, feet], clip.places[:, feet], atol=1e-6 * clip.height)
    head = places[:, clip.joint("head")] - clip.places[:, clip.joint("head")]
    np.testing.assert_allclose(head, np.broadcast_to([0.0, -0.06 * clip.height, 0.0], head.shape), atol=1e-6)


def test_nothing_is_held_where_that_is_wanted() -> None:
    clip = made(3)
    way = np.array([0.1 * clip.height, 0.0, 0.0])
    posed = clip.pose({"hips": HandleMove(way)}, np.ones(FRAMES), hold=())
    np.testing.assert_allclose(clip.walk(posed.edited.block)[0], clip.places + way, atol=1e-6 * clip.height)


@pytest.mark.parametrize(("handle", "height"), [("left_hand", -0.03), ("head", 0.03)])
def test_what_is_held_stays_while_the_hips_move(handle: Handle, height: float) -> None:
    clip = made(3)
    moves: dict[Handle, HandleMove] = {"hips": HandleMove(np.array([0.0, height * clip.height, 0.0]))}
    places, _ = clip.walk(clip.pose(moves, np.ones(FRAMES), hold=(handle,)).edited.block)
    joint, other = clip.joint(handle), clip.joint("left_foot")
    np.testing.assert_allclose(places[:, joint], clip.places[:, joint], atol=1e-4 * clip.height)
    np.testing.assert_allclose(places[:, other, 1] - clip.places[:, other, 1], height * clip.height, atol=1e-6)


def test_a_goal_out_of_reach_is_told() -> None:
    clip = made(3)
    way = np.array([0.0, 2 * clip.height, 0.0])
    posed = clip.pose({"left_hand": HandleMove(way)}, np.ones(FRAMES))
    assert posed.missed["left_hand"] > clip.height
    # It is stretched towards the goal.
    places, _ = clip.walk(posed.edited.block)
    arm = [clip.skeleton.names.index(f"left_{part}") for part in ("up_arm", "low_arm", "hand")]
    lengths = np.linalg.norm(np.diff(places[:, arm], axis=1), axis=2).sum(axis=1)
    assert (np.linalg.norm(places[:, arm[2]] - places[:, arm[0]], axis=1) > 0.99 * lengths).all()


def test_missing_samples_stay_missing() -> None:
    clip = made(3)
    clip.block.values[5:8, 3:9] = np.nan
    posed = clip.pose({"left_hand": HandleMove(np.array([0.0, 1.0, 0.0]))}, np.ones(FRAMES))
    columns = clip.skeleton.columns()
    before, after = (np.isnan(in_columns(block, columns)) for block in (clip.block, posed.edited.block))
    assert np.array_equal(before, after)
    assert before.any()


def test_what_has_no_handles_is_refused() -> None:
    points = marker_skeleton(("a", "b"))
    assert handles_of(points) == ()
    clip = made(0)
    with pytest.raises(ConversionError, match="no handle left_hand"):
        pose_frames(points, clip.block, {"left_hand": HandleMove()}, np.ones(FRAMES))


@pytest.mark.parametrize("name", REAL)
def test_real_bodies(shared: Path, name: str) -> None:
    clip = Before(opened(shared / name))
    count = len(clip.block)
    assert handles_of(clip.skeleton) == HANDLES
    up = np.array([0.0, 0.02 * clip.height, 0.0])
    strength = eased(count, 10, min(count - 1, 90), 15)
    moves: dict[Handle, HandleMove] = {"left_hand": HandleMove(up), "right_foot": HandleMove(up)}
    moves["hips"] = HandleMove(-up)
    places, _ = clip.walk(clip.pose(moves, strength).edited.block)
    for handle, move in moves.items():
        goals = clip.places[:, clip.joint(handle)] + strength[:, None] * move.way
        away = np.linalg.norm(places[:, clip.joint(handle)] - goals, axis=1)
        assert away.max() < 2e-3 * clip.height, handle
    steps = np.abs(np.diff(places, axis=0)).max()
    assert steps < 1.5 * np.abs(np.diff(clip.places, axis=0)).max()
