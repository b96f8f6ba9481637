"""Arms of two bones whose hand is to be at a goal.

An arm is part of a chain (see `chains`): places in it of the shoulder and of the elbow; the end is the hand.
"""

from __future__ import annotations

import numpy as np

from mcml.motion.feet.two_bones import hinge_of, two_bones
from mcml.motion.rotations import inverse, multiply, rotate
from mcml.motion.skeleton import Array
from mcml.motion.solving.chains import solve_chain, walk_chain
from mcml.motion.solving.joint_ranges import JointRanges

_ROUNDS = 12
"""Of least squares, enough to undo what the ranges forbid."""


def bend_arm(
    start: Array,
    rotations: Array,
    offsets: Array,
    goals: Array,
    arm: tuple[int, int],
    ranges: JointRanges,
    allowed: Array,
    hinge: Array | None = None,
) -> Array:
    """Bend the arm of chains so that their end is at the goals (n, 3), or as near as ranges allow.

    The elbow bends in the plane in which it is bent, then the whole arm swings, so that its swivel stays. Where ranges
    forbid this, `turn_arm` goes on. start, rotations, offsets: of the chains. allowed: (n, C, 4), see
    `JointRanges.limit`. hinge: (3,) unit axis of the elbow in the frame of the shoulder, about which a straight arm
    bends. Return local rotations (n, C, 4).
    """
    shoulder, elbow = arm
    places, turned = walk_chain(start, rotations, offsets)
    axes = None if hinge is None else rotate(turned[:, shoulder], hinge)
    swing, bend = two_bones(places[:, shoulder], places[:, elbow], places[:, -1], goals, axes)
    bent = rotations.copy()
    bent[:, shoulder] = multiply(inverse(turned[:, shoulder - 1]), multiply(swing, turned[:, shoulder]))
    # Joints between shoulder and elbow, if any, stay as they are.
    above = multiply(swing, turned[:, elbow - 1])
    bent[:, elbow] = multiply(inverse(above), multiply(swing, multiply(bend, turned[:, elbow])))
    return turn_arm(start, bent, offsets, goals, arm, ranges, allowed)


def turn_arm(
    start: Array,
    rotations: Array,
    offsets: Array,
    goals: Array,
    arm: tuple[int, int],
    ranges: JointRanges,
    allowed: Array,
) -> Array:
    """Turn shoulder and elbow by damped least squares until the end is at the goals (n, 3), or as near as ranges allow.

    Small changes of the goals are small changes of the arm. A straight arm does not bend. Arguments as in `bend_arm`.
    """
    joints = list(arm)
    shares = np.zeros(rotations.shape[1])
    shares[joints] = 1.0
    limited = rotations.copy()
    limited[:, joints] = ranges.of(joints).limit(rotations[:, joints], allowed[:, joints])
    return solve_chain(start, limited, offsets, goals, shares, arm_length(offsets, arm), ranges, allowed, _ROUNDS)


def find_hinge(rotations: Array, offsets: Array, arm: tuple[int, int]) -> Array | None:
    """Find the axis (3,) of the elbow in the frame of the shoulder, over frames (n, C, 4); None if it never bends."""
    shoulder, elbow = arm
    places, turned = walk_chain(np.zeros((len(rotations), 3)), rotations, offsets)
    back = inverse(turned[:, shoulder])
    upper, lower = places[:, elbow] - places[:, shoulder], places[:, -1] - places[:, elbow]
    return hinge_of(rotate(back, upper), rotate(back, lower))


def arm_length(offsets: Array, arm: tuple[int, int]) -> float:
    """Return the length of a stretched arm: of the bones from the shoulder to the end of a chain's offsets (C, 3)."""
    return float(np.linalg.norm(offsets[arm[0] + 1 :], axis=1).sum())
