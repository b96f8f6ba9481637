"""Vectors of many frames, (n, 3) each: few operations, as clips are short and many."""

from __future__ import annotations

import numpy as np

from mcml.motion.skeleton import Array


def dot(one: Array, other: Array) -> Array:
    """(n,) products of vectors (n, 3)."""
    product: Array = one[:, 0] * other[:, 0] + one[:, 1] * other[:, 1] + one[:, 2] * other[:, 2]
    return product


def length(vectors: Array) -> Array:
    """(n,) lengths of vectors (n, 3)."""
    lengths: Array = np.sqrt(dot(vectors, vectors))
    return lengths


def cross(one: Array, other: Array) -> Array:
    """Return the cross product (n, 3) of vectors (n, 3); for short arrays `np.cross` takes three times as long."""
    (a, b, c), (x, y, z) = one.T, other.T
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=1)


def divided(vectors: Array, lengths: Array, least: Array) -> Array:
    """Vectors (n, 3) over lengths (n,); NaN where these are not above the least (n,)."""
    result: Array = vectors / np.where(lengths > least, lengths, np.nan)[:, None]
    return result


def unit(vectors: Array) -> Array:
    """Unit vectors (n, 3); NaN for those without length."""
    lengths = length(vectors)
    return divided(vectors, lengths, np.zeros(len(vectors)))


def angle_between(one: Array, other: Array) -> Array:
    """(n,) degrees from 0 to 180 between vectors (n, 3); NaN where one has no length."""
    degrees: Array = np.degrees(np.arctan2(length(cross(one, other)), dot(one, other)))
    # Without length both are 0, whose angle looks like that of vectors along each other.
    suspects = np.flatnonzero((degrees == 0) | (degrees == 180))
    if len(suspects):
        without = (one[suspects] == 0).all(axis=1) | (other[suspects] == 0).all(axis=1)
        degrees[suspects[without]] = np.nan
    return degrees
