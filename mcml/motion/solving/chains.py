"""Chains of joints whose end is to be at a goal: damped least squares (Buss, "Introduction to inverse kinematics with
Jacobian transpose, pseudoinverse and damped least squares methods", 2004).

A chain has C joints in n frames, from one that is given in the world to the end, which is the last joint: places of
the first (n, 3), local rotations (n, C, 4), offsets (C, 3) of each joint in its parent (the first is not used), or
(C, n, 3) if they differ by frame.
"""

from __future__ import annotations

import numpy as np

from mcml.motion.rotation_vectors import from_vector
from mcml.motion.rotations import IDENTITY, inverse, multiply, rotate
from mcml.motion.skeleton import Array
from mcml.motion.solving.joint_ranges import JointRanges

DAMPING = 0.05
"""Lambda, in lengths of the limb."""
ARRIVED = 1e-9
"""Lengths of the limb: an end so near to its goal is there."""
LONGEST_STEP = 0.25
"""Of the way to the goal in a round, in lengths of the limb: the least squares are of small rotations."""


def walk_chain(start: Array, rotations: Array, offsets: Array) -> tuple[Array, Array]:
    """Return places (n, C, 3) and world rotations (n, C, 4) of the joints of a chain that starts at (n, 3)."""
    places, turned = np.empty((*rotations.shape[:2], 3)), np.empty(rotations.shape)
    places[:, 0], turned[:, 0] = start, rotations[:, 0]
    for joint in range(1, rotations.shape[1]):
        places[:, joint] = places[:, joint - 1] + rotate(turned[:, joint - 1], offsets[joint])
        turned[:, joint] = multiply(turned[:, joint - 1], rotations[:, joint])
    return places, turned


def find_turns(places: Array, missed: Array, shares: Array, damping: float) -> Array:
    """Find small rotations (n, C, 3) in the world, as vectors, that move the end of chains by a missed way (n, 3).

    places: (n, C, 3). shares: (C,) how easily each joint turns, 0 for not at all. With r the way from a joint to the
    end, its block of the Jacobian is -[r]x, so that J J^T is the sum of share (|r|^2 I - r r^T), and the rotations are
    share r x (J J^T + damping^2 I)^-1 missed.
    """
    ways = places[:, -1:] - places
    squares = (ways**2).sum(axis=2) @ shares
    gram = squares[:, None, None] * np.eye(3) - np.einsum("c,nci,ncj->nij", shares, ways, ways)
    pull = np.linalg.solve(gram + damping**2 * np.eye(3), missed[..., None])[..., 0]
    turns: Array = shares[:, None] * np.cross(ways, pull[:, None])
    return turns


def turn_chain(rotations: Array, turned: Array, turns: Array) -> Array:
    """Turn joints by vectors (n, C, 3) in the world; return new local rotations. turned: see `walk_chain`."""
    above = np.concatenate([np.broadcast_to(IDENTITY, turned[:, :1].shape), turned[:, :-1]], axis=1)
    changed = multiply(inverse(above), multiply(from_vector(turns), multiply(above, rotations)))
    moved = (turns != 0).any(axis=2, keepdims=True)
    return np.where(moved, changed, rotations)


def solve_chain(
    start: Array,
    rotations: Array,
    offsets: Array,
    goals: Array,
    shares: Array,
    length: float,
    ranges: JointRanges | None = None,
    allowed: Array | None = None,
    rounds: int = 30,
) -> Array:
    """Turn the joints of chains until their ends are at the goals (n, 3), or as near as ranges allow.

    shares: (C,) how easily each joint turns, 0 for not at all. length: of the limb, for damping and steps. ranges: of
    the C joints; allowed: see `JointRanges.limit`. Return local rotations (n, C, 4), whose ends are never farther from
    the goals than before.
    """
    free = (shares > 0)[:, None]
    nearest, least = rotations, np.full(len(rotations), np.inf)
    for turn in range(rounds + 1):
        places, turned = walk_chain(start, rotations, offsets)
        missed = goals - places[:, -1]
        distance = np.linalg.norm(missed, axis=1)
        nearer = distance < least
        nearest = np.where(nearer[:, None, None], rotations, nearest)
        least = np.minimum(least, distance)
        if turn == rounds or float(distance.max(initial=0.0)) < ARRIVED * length:
            break
        step = missed * np.minimum(1.0, LONGEST_STEP * length / np.maximum(distance, 1e-300))[:, None]
        rotations = turn_chain(rotations, turned, find_turns(places, step, shares, DAMPING * length))
        if ranges is not None:
            rotations = np.where(free, ranges.limit(rotations, allowed), rotations)
    return nearest
