"""Correction of a made motion, after which its hand arrives at a target.

The pose of the contact is solved first: the arm moves the hand as far as it can, then the spine helps, then the pelvis.
The correction then grows smoothly from the start of the reach to the contact, stays as long as hands of the examples
stay, and fades until the end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from mcml.motion.rotation_vectors import from_vector, to_vector
from mcml.motion.rotations import inverse, multiply, rotate
from mcml.motion.skeleton import Array
from mcml.motion.solving.arms import arm_length, bend_arm, turn_arm
from mcml.motion.solving.chains import DAMPING, LONGEST_STEP, find_turns, solve_chain, turn_chain, walk_chain
from mcml_service.analysis.reach_blending.model import Reaching

SHORTEST_FADE = 0.3
"""Seconds in which a correction grows or fades at least."""
CALM = 15.0
"""Metres per second squared: the most that a correction adds to the acceleration of the hand, where time allows."""
TOLERANCE = 1e-4
"""Of the arm's length: nearer than this is arrived."""
ROUNDS = 100
TOGETHER = 10
"""Rounds of least squares between moves of the pelvis."""
STUCK = 1e-4
"""Of the arm's length: a round that brings the hand no nearer than this is the last."""
PELVIS = 0.25
"""Of the arm's length: the pelvis moves no farther."""


@dataclass(frozen=True)
class Share:
    """How far parts of the body moved at the contact, in the clip's unit.

    arm: the hand in the axes of the trunk. spine: the shoulder in the axes of the pelvis. pelvis: itself.
    """

    arm: float
    spine: float
    pelvis: float


@dataclass(frozen=True)
class Solution:
    """A pose at the contact.

    turns: (C, 3) rotation vectors that follow the blend's own rotations. pelvis: (3,). place: (3,) of the hand. missed:
    its distance from the target.
    """

    turns: Array
    pelvis: Array
    place: Array
    missed: float
    share: Share


def spread_solution(
    reaching: Reaching,
    root: Array,
    rotations: Array,
    solution: Solution,
    frames: tuple[int, int],
    fps: float,
    seconds: float = SHORTEST_FADE,
) -> tuple[Array, Array]:
    """Spread the pose of the contact over a motion; return roots (F, 3) and rotations (F, C, 4) of the chain.

    root, rotations: of the motion. frames: start of the reach, contact. seconds: in which the correction grows or fades
    at least. Each joint turns by its own share: on a straight line the hand could pass the shoulder, where an arm has
    to turn over within a few frames.
    """
    first, contact = frames
    weights = find_weights(len(root), first, contact, reaching.hold, fps, seconds)
    moved = root + weights[:, None] * solution.pelvis
    return moved, multiply(rotations, from_vector(weights[:, None, None] * solution.turns))


def solve_contact(
    reaching: Reaching, offsets: Array, root: Array, rotations: Array, target: Array, pelvis: float = PELVIS
) -> Solution:
    """Find the pose of the contact, with the least help of spine and pelvis that lets the arm reach the target (3,).

    root: (3,), rotations: (C, 4), offsets: (C, 3) of the chain. pelvis: how far it may move, in arm lengths. There are
    two ways to turn the arm. The one that comes nearer is used; if both arrive, the one with smaller moves of spine and
    pelvis.
    """
    length = arm_length(offsets, (reaching.shoulder, reaching.elbow))
    bend = partial(bend_arm, hinge=reaching.hinge)

    def solve(turn: Callable[..., Array]) -> tuple[tuple[float, float], Solution]:
        solution = _Contact(
            reaching, offsets, root[None], rotations[None], target[None], turn, length, pelvis * length
        ).solve()
        costs = np.array([solution.missed, solution.share.spine + solution.share.pelvis])
        missed, rest = np.where(costs > TOLERANCE * length, costs, 0.0).tolist()
        return (missed, rest), solution

    cost, solution = solve(bend)
    if cost > (0.0, 0.0):
        other_cost, other = solve(turn_arm)
        solution = other if other_cost < cost else solution
    return solution


@dataclass(frozen=True)
class _Pose:
    """trunk: (1, C, 4) with the arm of the blend. bent: with the arm at the target. pelvis, missed: (1, 3)."""

    trunk: Array
    pelvis: Array
    bent: Array
    missed: Array

    @property
    def distance(self) -> float:
        return float(np.linalg.norm(self.missed))


@dataclass(frozen=True)
class _Contact:
    """The frame of the contact: root (1, 3), own rotations (1, C, 4), goal (1, 3).

    turn: how the arm is turned. length: of the arm. farthest: that the pelvis may move.
    """

    reaching: Reaching
    offsets: Array
    root: Array
    own: Array
    goal: Array
    turn: Callable[..., Array]
    length: float
    farthest: float

    def solve(self) -> Solution:
        pose = self._improve(self._pose(self.own, np.zeros((1, 3))), self._turn_spine)
        pose = self._improve(pose, self._move_pelvis)
        pose = self._improve(pose, self._turn_all)
        turns = to_vector(multiply(inverse(self.own[0]), pose.bent[0]))
        share = measure_share(self.offsets, self.own, pose.bent, pose.pelvis, self.reaching.shoulder)
        return Solution(turns, pose.pelvis[0], (self.goal - pose.missed)[0], pose.distance, share)

    def _improve(self, pose: _Pose, step: Callable[[_Pose], _Pose]) -> _Pose:
        """Repeat a step until the hand arrives, or comes no nearer."""
        for _ in range(ROUNDS):
            if pose.distance < TOLERANCE * self.length:
                break
            new = step(pose)
            if pose.distance - new.distance < STUCK * self.length:
                break
            pose = new
        return pose

    def _pose(self, trunk: Array, pelvis: Array) -> _Pose:
        arm = self.reaching.shoulder, self.reaching.elbow
        start = self.root + pelvis
        bent = self.turn(start, trunk, self.offsets, self.goal, arm, self.reaching.ranges, self.own)
        return _Pose(trunk, pelvis, bent, self.goal - walk_chain(start, bent, self.offsets)[0][:, -1])

    def _turn_spine(self, pose: _Pose) -> _Pose:
        joints = list(range(1, self.reaching.shoulder))
        shares = np.zeros(self.own.shape[1])
        shares[joints] = 1.0
        places, _ = walk_chain(self.root + pose.pelvis, pose.bent, self.offsets)
        _, turned = walk_chain(self.root + pose.pelvis, pose.trunk, self.offsets)
        step = pose.missed * min(1.0, LONGEST_STEP * self.length / pose.distance)
        trunk = turn_chain(pose.trunk, turned, find_turns(places, step, shares, DAMPING * self.length))
        trunk[:, joints] = self.reaching.ranges.of(joints).limit(trunk[:, joints], self.own[:, joints])
        return self._pose(trunk, pose.pelvis)

    def _move_pelvis(self, pose: _Pose) -> _Pose:
        return self._pose(pose.trunk, self._pelvis(pose))

    def _turn_all(self, pose: _Pose) -> _Pose:
        """Turn arm and spine and move the pelvis together."""
        shares = np.zeros(self.own.shape[1])
        shares[[*range(1, self.reaching.shoulder), self.reaching.shoulder, self.reaching.elbow]] = 1.0
        start = self.root + self._pelvis(pose)
        bent = solve_chain(
            start, pose.bent, self.offsets, self.goal, shares, self.length, self.reaching.ranges, self.own, TOGETHER
        )
        missed = self.goal - walk_chain(start, bent, self.offsets)[0][:, -1]
        return _Pose(pose.trunk, start - self.root, bent, missed)

    def _pelvis(self, pose: _Pose) -> Array:
        """Return a place of the pelvis (1, 3) that is nearer by the miss of the hand, as far as it may go."""
        pelvis = pose.pelvis + pose.missed
        distance = float(np.linalg.norm(pelvis))
        return np.asarray(pelvis * (self.farthest / distance if distance > self.farthest else 1.0))


def measure_share(offsets: Array, own: Array, bent: Array, pelvis: Array, shoulder: int) -> Share:
    """Measure moves between chains (1, C, 4) of the blend and of the contact. offsets: (C, 3). pelvis: its move."""
    origin = np.zeros((1, 3))
    (old, old_turns), (new, new_turns) = walk_chain(origin, own, offsets), walk_chain(origin, bent, offsets)
    hands = [
        rotate(inverse(turned[0, shoulder - 1]), places[0, -1] - places[0, shoulder])
        for places, turned in ((old, old_turns), (new, new_turns))
    ]
    return Share(
        arm=float(np.linalg.norm(hands[1] - hands[0])),
        spine=float(np.linalg.norm(new[0, shoulder] - old[0, shoulder])),
        pelvis=float(np.linalg.norm(pelvis)),
    )


def find_fade(distance: float) -> float:
    """Return in how many seconds a correction of the hand by metres grows or fades at least.

    A smoothstep over T seconds has accelerations of up to 6 distance / T^2.
    """
    return float(max(SHORTEST_FADE, np.sqrt(6.0 * distance / CALM)))


def find_weights(
    frames: int, first: int, contact: int, hold: float, fps: float, seconds: float = SHORTEST_FADE
) -> Array:
    """Return how much of the correction each frame has, (F,): 0 to 1 until the contact, and back to 0 at the end.

    first: frame in which the reach begins. hold: share of the time after the contact without change. A correction
    that would have to grow or fade in fewer seconds begins earlier, or stays until the end.
    """
    least = seconds * fps
    start = max(min(float(first), contact - least), 0.0)
    times = np.arange(frames, dtype=float)
    weights = smoothstep((times - start) / max(contact - start, 1.0))
    last = frames - 1
    leave = min(contact + hold * (last - contact), last - least)
    if leave > contact:
        weights = np.where(times > leave, 1.0 - smoothstep((times - leave) / (last - leave)), weights)
    elif last - contact >= least:
        weights = np.where(times > contact, 1.0 - smoothstep((times - contact) / (last - contact)), weights)
    weights[contact] = 1.0
    return weights


def smoothstep(part: Array) -> Array:
    """Return 3 x^2 - 2 x^3 of x within 0 and 1; 0 below, 1 above.

    >>> smoothstep(np.array([-1.0, 0.5, 2.0])).tolist()
    [0.0, 0.5, 1.0]
    """
    inside = np.clip(part, 0.0, 1.0)
    step: Array = inside * inside * (3.0 - 2.0 * inside)
    return step
