"""Where the joints of a block are, and blocks of chosen frames, for tests that look at a motion from outside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mcml.motion.clip import FrameBlock
from mcml.motion.kinematics import Walker, rest_positions
from mcml.motion.skeleton import Array, Skeleton
from mcml.motion.units import DEGREES, Reading


def global_positions(skeleton: Skeleton, block: FrameBlock, reading: Reading = DEGREES) -> Array:
    """Positions (n, J, 3) of the joints in the world."""
    return Walker(skeleton, reading).poses(block)[0]


def global_rotations(skeleton: Skeleton, block: FrameBlock, reading: Reading = DEGREES) -> Array:
    """Rotations (n, J, 4) of the joints from the rest pose, x y z w, in the world."""
    return Walker(skeleton, reading).poses(block)[1]


def rest_height(skeleton: Skeleton, reading: Reading = DEGREES) -> float:
    """Extent of the rest pose along Y, as most files stand on it, unless the pose lies across: then the largest one."""
    extent = np.ptp(rest_positions(skeleton, reading), axis=0)
    return float(extent[1] if extent[1] >= 0.5 * extent.max() else extent.max())


def chosen_frames(block: FrameBlock, rows: NDArray[np.intp] | Sequence[int]) -> FrameBlock:
    """Frames of a block by their places (n,), in that order, repeated where asked, numbered from 1."""
    return replace(
        block,
        values=block.values[rows],
        shape_of=None if block.shape_of is None else block.shape_of[rows],
        motion_names=None if block.motion_names is None else [block.motion_names[int(row)] for row in rows],
        ids=np.arange(1, len(rows) + 1, dtype=np.int64),
    )
