"""Where two walks meet in the same phase of a step: frames at a seam that are left out, so that feet need not shuffle.

Poses are compared over all pairs of frames near the seam (`joint_features`).
"""

from __future__ import annotations

import numpy as np
import scipy

from mcml.motion.edits.pose_likeness import joint_features
from mcml.motion.edits.splicing import Poses
from mcml.motion.feet.seams import Stance
from mcml.motion.hub_writer import Flags
from mcml.motion.skeleton import Array, Skeleton

WINDOW = 1.2
"""Seconds on each side of a seam that may be left out: a slow cycle of two steps."""
_AS_GOOD = 0.05
"""Of the range of distances: pairs of frames up to so much worse than the best are as good, fewer frames decide."""


def walks(stance: Stance) -> bool:
    """Whether both feet of two legs are set down or lifted in these frames."""
    stands: Flags = np.any(stance.stands, axis=2)
    if stands.shape[1] != 2 or len(stands) < 2:
        return False
    return bool((stands[1:] != stands[:-1]).any(axis=0).all())


def find_meeting(
    skeleton: Skeleton, before: Poses, after: Poses, carrier: int, up: Array, frame_time: float
) -> tuple[int, int]:
    """Return the frame of one motion and the frame of another, from 0, whose poses and velocities are most alike.

    before: (n) the last frames of a motion. after: (m) the first frames of the other. carrier: the joint whose place on
    the ground and whose facing do not count. up: (3,) unit vector. frame_time: seconds. Of pairs that are as good, the
    one that leaves out the fewest frames between the end of the one and the beginning of the other.
    """
    one, two = (joint_features(skeleton, poses, carrier, up, frame_time) for poses in (before, after))
    distances = scipy.spatial.distance.cdist(one, two)
    least = distances.min()
    good = distances <= least + _AS_GOOD * (distances.max() - least)
    left_out = np.add.outer(len(before) - 1 - np.arange(len(before)), np.arange(len(after)))
    costs = np.where(good, left_out + distances / (distances.max() or 1.0), np.inf)
    row, column = np.unravel_index(np.argmin(costs), costs.shape)
    return int(row), int(column)
