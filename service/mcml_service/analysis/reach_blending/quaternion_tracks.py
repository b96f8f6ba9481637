"""Tracks of rotations made continuous and comparable, and their logarithms.

A quaternion and its opposite are one rotation; statistics and differences need the same choice along time and between
clips. Quaternions are x, y, z, w.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcml.motion.rotations import slerp
from mcml.motion.skeleton import Array
from mcml.numerics.runs import find_true
from mcml_service.analysis.interface import AnalysisError

SMALLEST_NORM = 1e-6
JUMP = 0.5
"""Product of neighbouring quaternions below which a joint turned more than 120 degrees in a frame."""
LONGEST_GAP = 5


def unit(rotations: Array) -> Array:
    """Quaternions (..., 4) made of unit length. Raises AnalysisError `zero-quaternion` below a length of 1e-6."""
    norms = np.linalg.norm(rotations, axis=-1, keepdims=True)
    if (norms < SMALLEST_NORM).any():
        raise AnalysisError(
            "zero-quaternion",
            "A quaternion has no length.",
            remedy="Mend the frames that have no rotation.",
        )
    unit: Array = rotations / norms
    return unit


def continuous(rotations: Array) -> Array:
    """The same rotations (F, ..., 4), each with the sign nearest to the frame before; the first one stays."""
    if len(rotations) < 2:
        return rotations.copy()
    products = np.sum(rotations[1:] * rotations[:-1], axis=-1)
    signs = np.cumprod(np.where(products < 0, -1.0, 1.0), axis=0)
    fixed = rotations.copy()
    fixed[1:] *= signs[..., None]
    return fixed


def jumps(rotations: Array) -> list[tuple[int, int]]:
    """(frame, joint) where a joint of (F, J, 4) turns by more than 120 degrees since the frame before."""
    products = np.abs(np.sum(rotations[1:] * rotations[:-1], axis=-1))
    return [(int(frame) + 1, int(joint)) for frame, joint in np.argwhere(products < JUMP)]


def second_moments(rotations: Array) -> Array:
    """(J, 4, 4) sums of q q^T over the frames of (F, J, 4); the sign of no quaternion matters."""
    moments: Array = np.einsum("fjc,fjd->jcd", rotations, rotations)
    return moments


def mean_rotations(moments: Array) -> Array:
    """Reference rotations (J, 4), w >= 0: dominant eigenvectors of second moments (J, 4, 4). Markley et al. (2007)."""
    _, vectors = np.linalg.eigh(moments)
    reference: Array = vectors[..., -1]
    first = np.argmax(np.abs(reference) > 1e-12, axis=-1)
    lead = np.take_along_axis(reference, first[..., None], axis=-1)[..., 0]
    deciding = np.where(np.abs(reference[..., 3]) > 1e-12, reference[..., 3], lead)
    signed: Array = reference * np.where(deciding < 0, -1.0, 1.0)[..., None]
    return signed


def align_tracks(rotations: Array, reference: Array) -> Array:
    """Return tracks (F, J, 4), negated for joints on the far side of the reference (J, 4)."""
    sides = np.einsum("fjc,jc->j", rotations, reference)
    turned: Array = rotations * np.where(sides < 0, -1.0, 1.0)[:, None]
    return turned


def log(rotations: Array) -> Array:
    """Rotation vectors (..., 3), radians, of length 0 to pi, of unit quaternions (..., 4).

    >>> log(np.array([1.0, 0.0, 0.0, 0.0])).round(4).tolist()
    [3.1416, 0.0, 0.0]
    """
    signed = np.where(rotations[..., 3:] < 0, -rotations, rotations)
    size = np.linalg.norm(signed[..., :3], axis=-1, keepdims=True)
    # 2 atan2(|u|, w) / |u| tends to 2 / w; acos(w) would lose half of the digits near w = 1.
    small = size < 1e-12
    factor = np.where(small, 2.0, 2.0 * np.arctan2(size, signed[..., 3:]) / np.where(small, 1.0, size))
    vectors: Array = signed[..., :3] * factor
    return vectors


def exp(vectors: Array) -> Array:
    """Unit quaternions (..., 4) of rotation vectors (..., 3), radians."""
    angle = np.sqrt(np.einsum("...c,...c->...", vectors, vectors))[..., None]
    rotations = np.empty((*vectors.shape[:-1], 4))
    rotations[..., :3] = vectors * (0.5 * np.sinc(angle / (2 * np.pi)))
    rotations[..., 3:] = np.cos(angle / 2)
    return rotations


def angle_between(first: Array, second: Array) -> Array:
    """Degrees (...,) from one rotation to another, (..., 4) each: 2 acos |q . q'|."""
    cosine = np.abs(np.einsum("...c,...c->...", first, second))
    degrees: Array = np.degrees(2.0 * np.arccos(np.minimum(cosine, 1.0)))
    return degrees


def fill_gaps(values: Array, missing: NDArray[np.bool_]) -> Array:
    """Tracks (F, J, C) with short gaps filled: C = 4 on the arc between the neighbours, else on the line.

    missing: (F, J). Raises AnalysisError `missing-samples` for gaps of more than 5 frames, or at either end.
    """
    filled = values.copy()
    for joint in np.flatnonzero(missing.any(axis=0)):
        for first, end in find_true(missing[:, joint]):
            if first == 0 or end == len(values) or end - first > LONGEST_GAP:
                raise AnalysisError(
                    "missing-samples",
                    f"Joint {int(joint) + 1} has no samples in frames {first + 1} to {end}.",
                    remedy=f"Only gaps of up to {LONGEST_GAP} frames inside a clip are filled: mend it.",
                )
            before, after = values[first - 1, joint], values[end, joint]
            share = np.arange(1, end - first + 1) / (end - first + 1)
            if values.shape[-1] == 4:
                filled[first:end, joint] = slerp(before[None], after[None], share)
            else:
                filled[first:end, joint] = before + share[:, None] * (after - before)
    return filled
