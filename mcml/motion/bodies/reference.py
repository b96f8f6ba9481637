"""The reference pose of a skeleton: the start of angles from rotations, the same for every clip of it.

If a body could stand in the rest pose, that is the reference. Rigs with all bones along one axis at rest, or without
offsets, use the most upright frame of the first clip of the skeleton. It is stored as a pose, so that a clip that is
cut, reversed or composed keeps its angles.
"""

from __future__ import annotations

import numpy as np

from mcml.motion.anatomy.axes import STANDS, Stance, stance_in, uprightness
from mcml.motion.clip import Reference, ReferencePose
from mcml.motion.kinematics import Walker, rest_positions
from mcml.motion.pictures.figures import axis_of
from mcml.motion.rotations import IDENTITY
from mcml.motion.skeleton import Array, Skeleton, once_a_skeleton
from mcml.motion.units import DEGREES, Reading

DECIMALS = 6
"""Of the numbers of a pose that is kept."""


def stance_of(reference: Reference, skeleton: Skeleton, reading: Reading = DEGREES) -> Stance | None:
    """Return the anatomical axes of a reference; None if the pose of its frame is unknown.

    Raises ConversionError if left and right are unknown in it.
    """
    up = axis_of(reference.up)
    if reference.pose is not None:
        return stance_in(skeleton, np.array(reference.pose.positions), np.array(reference.pose.rotations), up)
    if reference.frame is not None:
        return None
    turned = np.tile(IDENTITY, (len(skeleton), 1))
    return stance_in(skeleton, rest_positions(skeleton, reading)[: len(skeleton)], turned, up)


@once_a_skeleton
def could_stand(skeleton: Skeleton, reading: Reading, up: str) -> bool:
    """Tell whether a body could stand in the rest pose."""
    rest = rest_positions(skeleton, reading)[None, : len(skeleton)]
    return bool(uprightness(skeleton, rest, axis_of(up))[0] > STANDS)


def pose_in(skeleton: Skeleton, reading: Reading, values: Array) -> ReferencePose:
    """The pose of one frame. values: (D,) of the skeleton's columns, without gaps."""
    positions, rotations = Walker(skeleton, reading).poses_at(values[None])
    places, turns = (np.round(each[0], DECIMALS).tolist() for each in (positions, rotations))
    return ReferencePose(tuple(map(tuple, places)), tuple(map(tuple, turns)))
