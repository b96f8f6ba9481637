"""Where joints are: forward kinematics of clips of every convention (formats.md 1.4, 2.3, 4.2).

Lengths are in the clip's own unit. Rotations are those from the rest pose in world axes, so that they mean the same in
every convention: the identity is the rest pose. A missing sample keeps its last value.
"""

from __future__ import annotations

import numpy as np

from service.motion.clip import FrameBlock
from service.motion.hub import HubReader, rest_of, walked
from service.motion.rotations import rotate
from service.motion.skeleton import Array, Skeleton
from service.motion.units import DEGREES, Reading


class Walker:
    """Forward kinematics over consecutive blocks of one clip; carries held values from block to block."""

    def __init__(self, skeleton: Skeleton, reading: Reading = DEGREES) -> None:
        self._skeleton = skeleton
        self._hub = HubReader(skeleton, reading)

    @property
    def tip_joints(self) -> tuple[int, ...]:
        """The joint of each tip that `tips` gives."""
        return tuple(joint for joint, _ in self._hub.rest.tips)

    def poses(self, block: FrameBlock) -> tuple[Array, Array]:
        """Positions (n, J, 3) and rotations (n, J, 4) in the world."""
        hub = self._hub.read(block)
        return walked(self._skeleton, hub.translations, hub.rotations)

    def tips(self, block: FrameBlock) -> Array:
        """Positions (n, T, 3) of the ends of chains: BVH end sites, tips of ASF and HTR bones without child."""
        hub = self._hub.read(block)
        positions, rotations = walked(self._skeleton, hub.translations, hub.rotations)
        tips = self._hub.rest.tips
        result = np.empty((len(block), len(tips), 3))
        for place, (joint, vector) in enumerate(tips):
            along = vector * hub.scales[:, joint, None]
            result[:, place] = positions[:, joint] + rotate(rotations[:, joint], along)
        return result


def global_positions(skeleton: Skeleton, block: FrameBlock, reading: Reading = DEGREES) -> Array:
    """Positions (n, J, 3) of the joints of a block, in the world. Use `Walker` for several blocks of a clip."""
    return Walker(skeleton, reading).poses(block)[0]


def global_rotations(skeleton: Skeleton, block: FrameBlock, reading: Reading = DEGREES) -> Array:
    """Rotations (n, J, 4) of the joints of a block from the rest pose, x y z w, in the world."""
    return Walker(skeleton, reading).poses(block)[1]


def tip_positions(skeleton: Skeleton, block: FrameBlock, reading: Reading = DEGREES) -> Array:
    """Positions (n, T, 3) of the ends of chains of a block; see `Walker.tips`."""
    return Walker(skeleton, reading).tips(block)


def rest_positions(skeleton: Skeleton, reading: Reading = DEGREES) -> Array:
    """Positions (J + T, 3) of the rest pose: joints, then tips."""
    rest = rest_of(skeleton, reading)
    positions = rest.offsets.copy()
    for index, joint in enumerate(skeleton.joints):
        if joint.parent >= 0:
            positions[index] += positions[joint.parent]
    tips = [positions[joint] + vector for joint, vector in rest.tips]
    return np.vstack([positions, *tips]) if tips else positions


def rest_height(skeleton: Skeleton, up: str | None = None, reading: Reading = DEGREES) -> float:
    """Vertical extent of the rest pose in the clip's own unit.

    up: "X", "Y" or "Z". Without it the Y axis counts, as most files stand on it, unless the pose lies across it:
    then the largest extent does.
    """
    positions = rest_positions(skeleton, reading)
    if not len(positions):
        return 0.0
    extent = np.ptp(positions, axis=0)
    if up is not None and up.upper() in ("X", "Y", "Z"):
        return float(extent["XYZ".index(up.upper())])
    return float(extent[1] if extent[1] >= 0.5 * extent.max() else extent.max())
