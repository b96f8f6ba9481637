"""Inverse kinematics on arrays: ranges of joints, chains, arms."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mcml.motion.rotation_vectors import from_vector, to_vector
from mcml.motion.rotations import IDENTITY, inverse, multiply
from mcml.motion.skeleton import Array
from mcml.motion.solving.arms import arm_length, bend_arm, find_hinge, turn_arm
from mcml.motion.solving.chains import DAMPING, find_turns, solve_chain, walk_chain
from mcml.motion.solving.joint_ranges import HINGE, WIDENING, JointRanges, learn_ranges

SEEDS = st.integers(0, 2**32 - 1)
FRAMES, JOINTS = 5, 6
ARM = (3, 4)


def chain(seed: int, most: float = 0.6) -> tuple[Array, Array, Array]:
    """A random chain: start (n, 3), local rotations (n, C, 4) of up to `most` radians an axis, offsets (C, 3)."""
    rng = np.random.default_rng(seed)
    rotations = from_vector(rng.uniform(-most, most, (FRAMES, JOINTS, 3)))
    rotations[:, 4] = multiply(from_vector(np.array([1.0, 0.0, 0.0])), rotations[:, 4])
    offsets = rng.uniform(-0.05, 0.05, (JOINTS, 3)) + np.array([0.0, 0.3, 0.0])
    return rng.normal(size=(FRAMES, 3)), rotations, offsets


def free() -> JointRanges:
    wide = np.full((JOINTS, 3), np.pi)
    return JointRanges(np.tile(IDENTITY, (JOINTS, 1)), np.tile(np.eye(3), (JOINTS, 1, 1)), -wide, wide)


def ends(start: Array, rotations: Array, offsets: Array) -> Array:
    return walk_chain(start, rotations, offsets)[0][:, -1]


@given(SEEDS)
def test_turns_are_damped_least_squares_of_the_jacobian(seed: int) -> None:
    start, rotations, offsets = chain(seed)
    places, _ = walk_chain(start, rotations, offsets)
    rng = np.random.default_rng(seed)
    missed, shares = rng.normal(size=(FRAMES, 3)), rng.uniform(0, 1, JOINTS)
    turns = find_turns(places, missed, shares, 0.3)
    for frame in range(FRAMES):
        blocks = [
            np.cross(np.eye(3), places[frame, -1] - places[frame, joint]) * np.sqrt(share)
            for joint, share in enumerate(shares)
        ]
        jacobian = np.concatenate(blocks).T
        least = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 0.09 * np.eye(3), missed[frame])
        expected = np.sqrt(shares)[:, None] * least.reshape(JOINTS, 3)
        assert np.allclose(turns[frame], expected, atol=1e-9)


@given(SEEDS)
def test_a_chain_comes_to_goals_that_it_was_at(seed: int) -> None:
    start, rotations, offsets = chain(seed)
    _, others, _ = chain(seed + 1)
    goals = ends(start, multiply(rotations, from_vector(0.5 * to_vector(others))), offsets)
    solved = solve_chain(start, rotations, offsets, goals, np.ones(JOINTS), 1.0, rounds=200)
    assert np.linalg.norm(ends(start, solved, offsets) - goals, axis=1).max() < 1e-4


@given(SEEDS, st.floats(0.0, 5.0))
def test_a_chain_never_ends_farther_from_its_goal_than_before(seed: int, away: float) -> None:
    start, rotations, offsets = chain(seed)
    rng = np.random.default_rng(seed)
    before = ends(start, rotations, offsets)
    goals = before + away * rng.normal(size=(FRAMES, 3))
    ranges = learn_ranges(rotations, np.tile(IDENTITY, (JOINTS, 1)))
    shares = np.array([0.0, 1.0, 0.5, 1.0, 1.0, 0.0])
    solved = solve_chain(start, rotations, offsets, goals, shares, 1.0, ranges, rotations)
    after = ends(start, solved, offsets)
    assert np.all(np.linalg.norm(after - goals, axis=1) <= np.linalg.norm(before - goals, axis=1) + 1e-12)
    assert np.array_equal(solved[:, shares == 0], rotations[:, shares == 0])
    turns = ranges.coordinates(solved)
    own = ranges.coordinates(rotations)
    assert np.all(turns >= np.minimum(ranges.low, own) - 1e-9)
    assert np.all(turns <= np.maximum(ranges.high, own) + 1e-9)


@given(SEEDS)
def test_chains_at_their_goals_stay_to_the_bit(seed: int) -> None:
    start, rotations, offsets = chain(seed)
    goals = ends(start, rotations, offsets)
    solved = solve_chain(start, rotations, offsets, goals, np.ones(JOINTS), 1.0, free(), rotations)
    assert np.array_equal(solved, rotations)


@given(SEEDS, st.floats(0.2, 0.95))
def test_an_arm_reaches_every_place_within_its_length(seed: int, part: float) -> None:
    start, rotations, offsets = chain(seed)
    places, _ = walk_chain(start, rotations, offsets)
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=(FRAMES, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    bones = np.linalg.norm(places[:, 4] - places[:, 3], axis=1), np.linalg.norm(places[:, 5] - places[:, 4], axis=1)
    nearest, farthest = np.abs(bones[0] - bones[1]), bones[0] + bones[1]
    distance = nearest + part * (farthest - nearest)
    goals = places[:, 3] + direction * distance[:, None]
    bent = bend_arm(start, rotations, offsets, goals, ARM, free(), rotations)
    assert np.linalg.norm(ends(start, bent, offsets) - goals, axis=1).max() < 1e-6
    others = [0, 1, 2, 5]
    assert np.array_equal(bent[:, others], rotations[:, others])


def test_a_straight_arm_bends_about_the_hinge_of_its_elbow() -> None:
    axis = np.array([1.0, 0.0, 0.0])
    offsets = np.array([[0.0, 0.0, 0.0], [0.0, 0.3, 0.0], [0.0, 0.0, 0.3], [0.0, 0.0, 0.3]])
    angles = np.linspace(-0.05, -1.5, 40)
    measured = np.tile(IDENTITY, (40, 4, 1))
    measured[:, 2] = from_vector(angles[:, None] * axis)
    hinge = find_hinge(measured, offsets, (1, 2))
    assert hinge is not None
    assert np.allclose(hinge, -axis)
    straight = np.tile(IDENTITY, (1, 4, 1))
    ranges = learn_ranges(measured, np.tile(IDENTITY, (4, 1)))
    free_shoulder = np.array([[0.0], [3.0], [0.0], [0.0]])
    wide = JointRanges(ranges.reference, ranges.axes, ranges.low - free_shoulder, ranges.high + free_shoulder)
    goal = np.array([[0.0, 0.3, 0.45]])
    bent = bend_arm(np.zeros((1, 3)), straight, offsets, goal, (1, 2), wide, straight, hinge)
    assert np.linalg.norm(ends(np.zeros((1, 3)), bent, offsets) - goal) < 1e-6
    turn = to_vector(bent[:, 2])[0]
    assert turn[0] < -1.0
    assert np.abs(turn[1:]).max() < 1e-6
    assert find_hinge(straight, offsets, (1, 2)) is None


def test_an_arm_out_of_reach_is_stretched_towards_its_goal() -> None:
    start, rotations, offsets = chain(3)
    places, _ = walk_chain(start, rotations, offsets)
    goals = places[:, 3] + np.array([0.0, 0.0, 10.0])
    bent = bend_arm(start, rotations, offsets, goals, ARM, free(), rotations)
    hands = ends(start, bent, offsets) - places[:, 3]
    lengths = np.linalg.norm(hands, axis=1)
    assert np.all(lengths > 0.99 * arm_length(offsets, ARM))
    assert np.all(hands[:, 2] / lengths > 0.99)


@given(SEEDS)
def test_small_changes_of_goals_are_small_changes_of_the_arm(seed: int) -> None:
    start, rotations, offsets = chain(seed)
    goals = ends(start, rotations, offsets)
    ranges = learn_ranges(rotations, np.tile(IDENTITY, (JOINTS, 1)))
    moved = turn_arm(start, rotations, offsets, goals + 1e-5, ARM, ranges, rotations)
    assert np.abs(moved - rotations).max() < 0.01


@given(SEEDS)
def test_measured_rotations_are_in_their_ranges_and_limits_are_kept(seed: int) -> None:
    rng = np.random.default_rng(seed)
    measured = from_vector(rng.normal(scale=0.3, size=(400, 2, 3)))
    reference = np.tile(IDENTITY, (2, 1))
    ranges = learn_ranges(measured, reference)
    inside = np.isclose(ranges.limit(measured), measured).all(axis=2)
    assert inside.mean() >= 0.94
    wild = from_vector(rng.uniform(-1.7, 1.7, (100, 2, 3)))
    limited = ranges.limit(wild)
    turns = ranges.coordinates(limited)
    assert np.all((turns >= ranges.low - 1e-9) & (turns <= ranges.high + 1e-9))
    assert np.allclose(ranges.limit(limited), limited)
    assert np.array_equal(ranges.limit(wild, wild), wild)


@given(SEEDS)
def test_a_hinge_stays_a_hinge(seed: int) -> None:
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    reference = from_vector(axis * 0.7)[None]
    angles = np.linspace(0.1, 1.5, 60)
    ranges = learn_ranges(from_vector(angles[:, None] * axis)[:, None], reference)
    limited = ranges.limit(from_vector(rng.uniform(-1, 1, (50, 1, 3))))
    across = np.cross(to_vector(limited[:, 0]), axis)
    assert np.abs(across).max() < 1e-6
    widths = np.sort((ranges.high - ranges.low)[0])
    assert widths[1] < HINGE
    assert widths[2] > 1.3 + 2 * WIDENING


def test_the_damping_is_in_lengths_of_the_limb() -> None:
    start, rotations, offsets = chain(1)
    goals = ends(start, rotations, offsets) + 0.05
    solved = solve_chain(start, rotations, offsets, goals, np.ones(JOINTS), 1.0, rounds=1)
    large = solve_chain(100 * start, rotations, 100 * offsets, 100 * goals, np.ones(JOINTS), 100.0, rounds=1)
    assert np.allclose(solved, large)
    assert 0 < DAMPING < 1
    assert np.abs(multiply(inverse(solved), rotations)[..., :3]).max() > 1e-3
