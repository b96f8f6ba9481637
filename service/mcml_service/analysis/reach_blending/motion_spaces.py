"""Motions as vectors, and back: three spaces in which clips are averaged and blended.

Each has `vectors` (clips to rows) and `motions` (rows to roots and rotations of the samples), both for many at once.
Quaternions are x, y, z, w.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from mcml.motion.rotations import inverse, multiply
from mcml.motion.skeleton import Array
from mcml_service.analysis.reach_blending.principal_components import principal_components, signs_of
from mcml_service.analysis.reach_blending.quaternion_tracks import exp, log
from mcml_service.analysis.reach_blending.time_normalisation import read_values

SignAlign = Literal["none", "max", "reference"]


@dataclass(frozen=True)
class Track:
    """A clip before time normalisation.

    root: (F, 3). rotations: (F, J, 4), continuous, on the reference's side. at: (F0,) frames of the samples.
    """

    root: Array
    rotations: Array
    at: Array


EVERY = slice(None)


class MotionSpace(Protocol):
    """Rows (N, D) of motion vectors to roots (N, F0, 3) and unit rotations (N, F0, J, 4), or of some samples only."""

    def motions(self, vectors: Array, samples: slice = EVERY) -> tuple[Array, Array]: ...


@dataclass(frozen=True)
class TangentSpace:
    """log(ref^-1 q) of every joint and the root over L, sample by sample: R^((3 + 3 J) F0).

    Decoded quaternions are normalised.

    reference: (J, 4). length: L, the longest bone, in the clip's unit.
    """

    reference: Array
    length: float

    def vectors(self, root: Array, rotations: Array) -> Array:
        """(N, (3 + 3 J) F0) of sampled roots (N, F0, 3) and rotations (N, F0, J, 4)."""
        count, samples, joints = rotations.shape[:3]
        rows = np.empty((count, samples, 3 + 3 * joints))
        rows[:, :, :3] = root / self.length
        opposite = inverse(self.reference)
        for row, clip in zip(rows, rotations, strict=True):
            row[:, 3:] = log(multiply(opposite, clip)).reshape(samples, -1)
        return rows.reshape(count, -1)

    def motions(self, vectors: Array, samples: slice = EVERY) -> tuple[Array, Array]:
        joints = len(self.reference)
        rows = vectors.reshape(len(vectors), -1, 3 + 3 * joints)[:, samples]
        tangents = rows[:, :, 3:].reshape(*rows.shape[:2], joints, 3)
        return rows[:, :, :3] * self.length, multiply(self.reference, exp(tangents))

    def farthest(self, vectors: Array) -> float:
        """The greatest angle, radians, between any rotation of the rows and the reference."""
        rows = vectors.reshape(-1, 1 + len(self.reference), 3)
        return float(np.sqrt((rows[:, 1:] ** 2).sum(axis=2).max(initial=0.0)))


@dataclass(frozen=True)
class EigenposeSpace:
    """The paper's: each clip's mean pose, its k eigenposes, their coefficients sample by sample: R^(P + P k + k F0).

    joints: J; a pose has P = 3 + 4 J numbers: the root, then a quaternion a joint. count: k.
    """

    joints: int
    count: int

    def vectors(self, tracks: Sequence[Track], sign_align: SignAlign) -> tuple[Array, Array]:
        """(N, D) rows, and (N, k) the share of each clip's variance that its first 1 … k eigenposes hold."""
        rows, shares = [], []
        reference: Array | None = None
        for track in tracks:
            pose = principal_components(poses(track.root, track.rotations), self.count, fix_signs=sign_align != "none")
            basis, coefficients = _pad(pose.basis, self.count), _pad(pose.coefficients.T, self.count).T
            if sign_align == "reference":
                reference = basis if reference is None else reference
                signs = np.where(np.sum(basis * reference, axis=1) < 0, -1.0, 1.0)
                basis, coefficients = basis * signs[:, None], coefficients * signs
            sampled = read_values(coefficients, track.at)
            rows.append(np.concatenate([pose.mean, basis.ravel(), sampled.ravel()]))
            cumulative = pose.cumulative()[: self.count]
            shares.append(np.concatenate([cumulative, np.ones(self.count - len(cumulative))]))
        return np.stack(rows), np.stack(shares)

    def motions(self, vectors: Array, samples: slice = EVERY) -> tuple[Array, Array]:
        size = 3 + 4 * self.joints
        mean, rest = vectors[:, :size], vectors[:, size:]
        basis = rest[:, : size * self.count].reshape(-1, self.count, size)
        coefficients = rest[:, size * self.count :].reshape(len(vectors), -1, self.count)[:, samples]
        return from_poses(mean[:, None] + coefficients @ basis)


@dataclass(frozen=True)
class GlobalPoseSpace:
    """One set of eigenposes for all clips, and coefficients sample by sample: R^(k F0).

    mean: (P,). basis: (k, P).
    """

    mean: Array
    basis: Array

    @classmethod
    def of(cls, tracks: Sequence[Track], count: int) -> tuple[GlobalPoseSpace, Array]:
        """The space of all frames of all tracks, and (k,) the share of the variance its components hold."""
        frames = sum(len(track.root) for track in tracks)
        mean = sum((poses(track.root, track.rotations).sum(axis=0) for track in tracks), np.zeros(())) / frames
        # P is small: the covariance is summed clip by clip, so that no more than one clip's poses are held.
        covariance = np.zeros((len(mean), len(mean)))
        for track in tracks:
            centred = poses(track.root, track.rotations) - mean
            covariance += centred.T @ centred
        values, axes = np.linalg.eigh(covariance / frames)
        basis = axes[:, ::-1].T[:count]
        shares = np.cumsum(values[::-1][:count]) / max(float(values.sum()), np.finfo(float).tiny)
        return cls(mean, basis * signs_of(basis)[:, None]), shares

    def vectors(self, tracks: Sequence[Track]) -> Array:
        """(N, k F0)."""
        return np.stack(
            [
                read_values((poses(track.root, track.rotations) - self.mean) @ self.basis.T, track.at).ravel()
                for track in tracks
            ]
        )

    def motions(self, vectors: Array, samples: slice = EVERY) -> tuple[Array, Array]:
        coefficients = vectors.reshape(len(vectors), -1, len(self.basis))[:, samples]
        return from_poses(self.mean + coefficients @ self.basis)


def poses(root: Array, rotations: Array) -> Array:
    """(F, 3 + 4 J): the root's position, then the quaternion of each joint."""
    return np.concatenate([root, rotations.reshape(len(rotations), -1)], axis=1)


def from_poses(rows: Array) -> tuple[Array, Array]:
    """Roots (..., 3) and rotations (..., J, 4), made of unit length, of poses (..., 3 + 4 J)."""
    rotations = rows[..., 3:].reshape(*rows.shape[:-1], -1, 4)
    norms = np.linalg.norm(rotations, axis=-1, keepdims=True)
    # A blend of opposite rotations has no direction; the identity is as good as any.
    lost = norms < 1e-12
    return rows[..., :3], np.where(lost, [0.0, 0.0, 0.0, 1.0], rotations / np.where(lost, 1.0, norms))


def _pad(rows: Array, count: int) -> Array:
    """(count, D): rows of zeros for components that a short clip does not have."""
    return np.vstack([rows, np.zeros((count - len(rows), rows.shape[1]))])
