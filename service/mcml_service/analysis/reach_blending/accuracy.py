"""How far made motions are from measured ones: degrees a joint, and the way of the hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.rotations import multiply, rotate
from mcml.motion.skeleton import Array
from mcml_service.analysis.reach_blending.motion_spaces import MotionSpace
from mcml_service.analysis.reach_blending.principal_components import Components
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
    """Means over clips and samples.

    joints: degrees, over all joints. phase_joint: degrees. hand: the clip's unit; contact: the same at the contact.
    """

    joints: float
    phase_joint: float
    hand: float
    contact: float
    clips: int


@dataclass(frozen=True)
class Ruler:
    """The compared quantities.

    chain: joints from the root to the hand. offsets: (J, 3) of the template's body. contact: the sample at t2.
    """

    phase_joint: int
    chain: tuple[int, ...]
    offsets: Array
    contact: int

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
    degrees = own = hand = contact = 0.0
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
        missed = np.linalg.norm(ruler.hand(root, rotations) - ruler.hand(true_root, true_rotations), axis=2)
        hand += float(missed.mean(axis=1).sum())
        contact += float(missed[:, ruler.contact].sum())
        count += int(chosen.sum())
    if not count:
        return Errors(float("nan"), float("nan"), float("nan"), float("nan"), 0)
    return Errors(degrees / count, own / count, hand / count, contact / count, count)


def hand_error_of(
    space: MotionSpace, components: Components, measured: Sampled, ruler: Ruler
) -> Callable[[Array], float]:
    """Return the mean distance of the hand at the contact from measured ones, as a function of coefficients (N, K).

    Rows with NaN do not count. Only the sample of the contact is decoded: many predictions are compared.
    """
    sample = slice(ruler.contact, ruler.contact + 1)
    true = ruler.hand(measured.root[:, sample], measured.rotations[:, sample])

    def error(coefficients: Array) -> float:
        total, count = 0.0, 0
        for start in range(0, len(coefficients), AT_ONCE):
            rows = coefficients[start : start + AT_ONCE]
            known = np.asarray(np.isfinite(rows).all(axis=1))
            vectors = components.mean + rows[known] @ components.basis
            missed = ruler.hand(*space.motions(vectors, sample)) - true[start : start + AT_ONCE][known]
            total += float(np.linalg.norm(missed, axis=2).sum())
            count += int(known.sum())
        return total / count if count else float("inf")

    return error
