"""How far made motions are from measured ones: degrees a joint, and the way of the hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.rotations import multiply, rotate
from mcml.motion.skeleton import Array
from mcml_service.analysis.reach_blending.motion_spaces import MotionSpace
from mcml_service.analysis.reach_blending.quaternion_tracks import angle_between

AT_ONCE = 64
"""Clips decoded together: bounds the memory."""


@dataclass(frozen=True)
class Sampled:
    """Measured clips at the samples: root (N, F0, 3), rotations (N, F0, J, 4)."""

    root: Array
    rotations: Array


@dataclass(frozen=True)
class Errors:
    """Means over clips and samples. joints: degrees, over all joints. phase_joint: degrees. hand: the clip's unit."""

    joints: float
    phase_joint: float
    hand: float
    clips: int


@dataclass(frozen=True)
class Ruler:
    """The compared quantities. chain: joints from the root to the hand. offsets: (J, 3) of the template's body."""

    phase_joint: int
    chain: tuple[int, ...]
    offsets: Array

    def hand(self, root: Array, rotations: Array) -> Array:
        """Where the hand is, (..., 3), of roots (..., 3) and rotations (..., J, 4)."""
        place, turn = root, rotations[..., self.chain[0], :]
        for joint in self.chain[1:]:
            place = place + rotate(turn, self.offsets[joint])
            turn = multiply(turn, rotations[..., joint, :])
        return place


def errors_of(
    space: MotionSpace, vectors: Callable[[slice], Array], measured: Sampled, ruler: Ruler, rows: NDArray[np.bool_]
) -> Errors:
    """Errors of motions in a space against measured ones.

    vectors: the motion vectors (n, D) of a slice of the clips, computed on use. rows: (N,) mask of used clips.
    """
    degrees = own = hand = 0.0
    count = 0
    for start in range(0, len(measured.root), AT_ONCE):
        part = slice(start, start + AT_ONCE)
        chosen = rows[part]
        if not chosen.any():
            continue
        root, rotations = space.motions(vectors(part)[chosen])
        true_root, true_rotations = measured.root[part][chosen], measured.rotations[part][chosen]
        angles = angle_between(rotations, true_rotations)
        degrees += float(angles.mean(axis=(1, 2)).sum())
        own += float(angles[:, :, ruler.phase_joint].mean(axis=1).sum())
        missed = ruler.hand(root, rotations) - ruler.hand(true_root, true_rotations)
        hand += float(np.linalg.norm(missed, axis=2).mean(axis=1).sum())
        count += int(chosen.sum())
    if not count:
        return Errors(float("nan"), float("nan"), float("nan"), 0)
    return Errors(degrees / count, own / count, hand / count, count)
