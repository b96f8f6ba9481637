"""Where joints are: forward kinematics of clips of every convention (docs/conventions.md).

Lengths are in the clip's own unit. Rotations are those from the rest pose in world axes, so that they mean the same in
every convention: the identity is the rest pose. A missing sample keeps its last value.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcml.motion.clip import FrameBlock
from mcml.motion.hub import HubReader, rest_of, walked
from mcml.motion.rotations import rotate
from mcml.motion.skeleton import CHANNEL_INDEX, Array, Skeleton
from mcml.motion.units import DEGREES, Reading

RESIDUAL = CHANNEL_INDEX["residual"]
"""The last channel, and the only one that moves nothing."""


class Walker:
    """Forward kinematics over consecutive blocks of one clip; carries held values from block to block."""

    def __init__(self, skeleton: Skeleton, reading: Reading = DEGREES) -> None:
        self._skeleton = skeleton
        self._hub = HubReader(skeleton, reading)

    def poses(self, block: FrameBlock) -> tuple[Array, Array]:
        """Positions (n, J, 3) and rotations (n, J, 4) in the world."""
        hub = self._hub.read(block)
        return walked(self._skeleton, hub.translations, hub.rotations)

    def poses_at(self, values: Array) -> tuple[Array, Array]:
        """The same of frames without gaps: (n, D) in the skeleton's columns."""
        hub = self._hub.of_values(values)
        return walked(self._skeleton, hub.translations, hub.rotations)

    def poses_with_tips(self, block: FrameBlock) -> tuple[Array, Array, Array]:
        """As `poses`, and positions (n, T, 3) of the ends of chains: BVH end sites, tips of ASF and HTR bones without
        child."""
        hub = self._hub.read(block)
        positions, rotations = walked(self._skeleton, hub.translations, hub.rotations)
        tips = np.empty((len(block), len(self._hub.rest.tips), 3))
        for place, (joint, vector) in enumerate(self._hub.rest.tips):
            along = vector * hub.scales[:, joint, None]
            tips[:, place] = positions[:, joint] + rotate(rotations[:, joint], along)
        return positions, rotations, tips

    def tips(self, block: FrameBlock) -> Array:
        """Positions (n, T, 3) of the ends of chains."""
        return self.poses_with_tips(block)[2]


def rest_positions(skeleton: Skeleton, reading: Reading = DEGREES) -> Array:
    """Positions (J + T, 3) of the rest pose: joints, then tips."""
    rest = rest_of(skeleton, reading)
    positions = rest.offsets.copy()
    for index, joint in enumerate(skeleton.joints):
        if joint.parent >= 0:
            positions[index] += positions[joint.parent]
    tips = [positions[joint] + vector for joint, vector in rest.tips]
    return np.vstack([positions, *tips]) if tips else positions


def unseen(skeleton: Skeleton, block: FrameBlock) -> NDArray[np.bool_]:
    """Return (n, J) where a sample that a joint's position depends on is missing: one of its own channels, or of a
    joint above.
    """
    place = {column: index for index, column in enumerate(block.columns)}
    missing = np.isnan(block.values)
    result = np.zeros((len(block), len(skeleton)), dtype=bool)
    for index, channel in skeleton.columns():
        if channel < RESIDUAL:
            result[:, index] |= missing[:, place[index, channel]] if (index, channel) in place else True
    for index, joint in enumerate(skeleton.joints):
        if joint.parent >= 0:
            result[:, index] |= result[:, joint.parent]
    return result
