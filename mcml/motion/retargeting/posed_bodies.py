"""A skeleton standing in a pose, to be compared with another one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcml.motion.hub import Rest, walked
from mcml.motion.skeleton import Array, Skeleton

SHORT = 1e-3
"""Relative to the longest bone: anything shorter has no direction."""


@dataclass(frozen=True)
class PosedBody:
    """A skeleton in a pose to compare. positions: (J, 3), turned: (J, 4) in the world, local: (J, 4)."""

    skeleton: Skeleton
    rest: Rest
    positions: Array
    turned: Array
    local: Array

    @classmethod
    def of(cls, skeleton: Skeleton, rest: Rest, pose: Array | None) -> PosedBody:
        local = np.tile(np.array([0.0, 0.0, 0.0, 1.0]), (len(skeleton), 1)) if pose is None else pose
        positions, turned = walked(skeleton, rest.offsets[None], local[None])
        return cls(skeleton, rest, positions[0], turned[0], local)

    @property
    def short(self) -> float:
        below = [index for index, joint in enumerate(self.skeleton.joints) if joint.parent >= 0]
        return SHORT * float(np.linalg.norm(self.rest.offsets[below], axis=1).max(initial=0.0))


def upright_axes(side: Array, high: Array) -> Array | None:
    """Axes (3, 3) as columns: to the side, up (perpendicular to it), and perpendicular to both."""
    left = side / np.linalg.norm(side)
    upward = high - (high @ left) * left
    length = float(np.linalg.norm(upward))
    if length < 0.1 * float(np.linalg.norm(high)):
        return None
    upward = upward / length
    return np.stack([left, upward, np.cross(left, upward)], axis=1)
