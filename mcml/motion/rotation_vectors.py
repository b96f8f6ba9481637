"""Rotations as vectors along their axes, as long as their angles: where rotations are added, weighted, measured."""

from __future__ import annotations

import numpy as np

from mcml.motion.rotations import inverse, multiply
from mcml.motion.skeleton import Array

_SMALL = 1e-8


def to_vector(rotation: Array) -> Array:
    """Axis times angle (..., 3), radians up to half a turn, of unit quaternions (..., 4): the logarithm.

    >>> to_vector(np.array([0.6, 0.0, 0.0, 0.8])).round(3).tolist()
    [1.287, 0.0, 0.0]
    """
    shorter = np.where(rotation[..., 3:] < 0, -rotation, rotation)
    length = np.linalg.norm(shorter[..., :3], axis=-1)
    near = length < _SMALL
    factor = np.where(near, 2.0, 2 * np.arctan2(length, shorter[..., 3]) / np.where(near, 1.0, length))
    vector: Array = shorter[..., :3] * factor[..., None]
    return vector


def from_vector(vector: Array) -> Array:
    """Unit quaternions (..., 4) of vectors (..., 3) along the axis, as long as the angle in radians.

    >>> from_vector(np.array([0.0, 0.0, np.pi / 2])).round(3).tolist()
    [0.0, 0.0, 0.707, 0.707]
    """
    angle = np.linalg.norm(vector, axis=-1)
    near = angle < _SMALL
    factor = np.where(near, 0.5, np.sin(angle / 2) / np.where(near, 1.0, angle))
    rotation = np.concatenate([vector * factor[..., None], np.cos(angle / 2)[..., None]], axis=-1)
    unit: Array = rotation / np.linalg.norm(rotation, axis=-1, keepdims=True)
    return unit


def angle_between(first: Array, second: Array) -> Array:
    """Angles (...,) in radians between rotations (..., 4), exact for small ones too."""
    between = multiply(inverse(first), second)
    angle: Array = 2 * np.arctan2(np.linalg.norm(between[..., :3], axis=-1), np.abs(between[..., 3]))
    return angle


def twist(rotation: Array, axis: Array) -> Array:
    """Angles (...,) in radians about a unit axis (3,) of the turn about it that is nearest to a rotation (..., 4)."""
    angle: Array = 2 * np.arctan2(rotation[..., :3] @ axis, rotation[..., 3])
    wrapped: Array = angle - 2 * np.pi * np.round(angle / (2 * np.pi))
    return wrapped


def shortest_arcs(start: Array, end: Array) -> Array:
    """The smallest rotations (n, 4) that take directions (n, 3) to others; none where they are opposite or nothing."""
    lengths = np.linalg.norm(start, axis=1) * np.linalg.norm(end, axis=1)
    safe = np.where(lengths > 0, lengths, 1.0)[:, None]
    cosine = (start * end).sum(axis=1, keepdims=True) / safe
    rotation = np.concatenate([np.cross(start, end) / safe, 1.0 + cosine], axis=1)
    rotation[(rotation[:, 3] < 1e-9) | (lengths == 0)] = [0.0, 0.0, 0.0, 1.0]
    unit: Array = rotation / np.linalg.norm(rotation, axis=1, keepdims=True)
    return unit
