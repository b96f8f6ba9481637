"""How alike frames are, where motions meet: places and movements of joints in the body's own frame.

As in "Motion graphs" (Kovar, Gleicher and Pighin, 2002, section 3), of joints instead of points of a skin.
"""

from __future__ import annotations

import numpy as np

from mcml.motion.anatomy.axes import BODY
from mcml.motion.edits.splicing import Poses
from mcml.motion.hub import walked
from mcml.motion.rotation_vectors import from_vector, twist
from mcml.motion.rotations import inverse, rotate
from mcml.motion.skeleton import Array, Skeleton

_VELOCITY = 0.1
"""Seconds: a velocity counts for the way in this time."""
_FEWEST = 10
"""Joints of a body from which on the others of its skeleton do not count."""


def joint_features(skeleton: Skeleton, poses: Poses, carrier: int, up: Array, frame_time: float) -> Array:
    """(n, 6 J) places and velocities of joints, between which distances are; missing ones count as 0.

    carrier: the joint whose place on the ground and whose facing do not count. up: (3,) unit vector. frame_time:
    seconds. Joints of the body count, so that fingers and helpers of a rig do not; all joints of one whose body is
    unknown.
    """
    places, world = walked(skeleton, poses.translations, poses.rotations)
    root = places[:, carrier]
    ground = root - np.outer(root @ up, up)
    back = inverse(from_vector(twist(world[:, carrier], up)[:, None] * up))
    body = [index for index, name in enumerate(skeleton.names) if name in BODY and "finger" not in name]
    if len(body) >= _FEWEST:
        places = places[:, body]
    velocities = np.gradient(places, axis=0) / frame_time if len(places) > 1 else np.zeros_like(places)
    own = [rotate(back[:, None], values) for values in (places - ground[:, None], velocities * _VELOCITY)]
    features: Array = np.nan_to_num(np.concatenate(own, axis=2)).reshape(len(places), -1)
    return features
