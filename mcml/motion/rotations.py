"""Rotations as Euler angles, unit quaternions and matrices, on (..., k) arrays.

Quaternions are x, y, z, w; angles are radians; vectors are columns, axes right-handed. An order such as "ZXY" with
angles (p, q, r) means the product Rz(p) Rx(q) Ry(r): rotations about local axes, left to right. Orders may name
fewer than three axes; the empty order is no rotation.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from mcml.motion.skeleton import Array

IDENTITY: Final = np.array([0.0, 0.0, 0.0, 1.0])
GIMBAL: Final = 1e-11
"""Cosine of the middle angle below which the outer two axes are treated as equal: the error is smaller than this."""

_AXIS = {"X": 0, "Y": 1, "Z": 2}


def multiply(first: Array, second: Array) -> Array:
    """The product of rotations: `second` is applied first. (..., 4) each, broadcast."""
    # Of short arrays, `moveaxis` takes longer than the product.
    x1, y1, z1, w1 = first[..., 0], first[..., 1], first[..., 2], first[..., 3]
    x2, y2, z2, w2 = second[..., 0], second[..., 1], second[..., 2], second[..., 3]
    product = np.empty(np.broadcast_shapes(first.shape, second.shape))
    product[..., 0] = w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2
    product[..., 1] = w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2
    product[..., 2] = w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2
    product[..., 3] = w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2
    return product


def inverse(rotation: Array) -> Array:
    """The opposite rotation of a unit quaternion (..., 4)."""
    opposite: Array = rotation * np.array([-1.0, -1.0, -1.0, 1.0])
    return opposite


def rotate(rotation: Array, vector: Array) -> Array:
    """Rotate vectors (..., 3) by unit quaternions (..., 4), broadcast."""
    x, y, z, w = rotation[..., 0], rotation[..., 1], rotation[..., 2], rotation[..., 3]
    a, b, c = vector[..., 0], vector[..., 1], vector[..., 2]
    # v + 2 w (u x v) + 2 u x (u x v)
    p, q, r = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    turned = np.empty((*np.broadcast_shapes(rotation.shape[:-1], vector.shape[:-1]), 3))
    turned[..., 0] = a + w * p + y * r - z * q
    turned[..., 1] = b + w * q + z * p - x * r
    turned[..., 2] = c + w * r + x * q - y * p
    return turned


def from_euler(angles: Array, order: str) -> Array:
    """Quaternions (..., 4) of angles (..., len(order)), radians."""
    if not order:
        return np.broadcast_to(IDENTITY, (*angles.shape[:-1], 4)).copy()
    half = np.moveaxis(angles, -1, 0) / 2
    sines, cosines = np.sin(half), np.cos(half)
    rotation = np.zeros((*angles.shape[:-1], 4))
    for column, letter in enumerate(order.upper()):
        sine, cosine, axis = sines[column], cosines[column], _AXIS[letter]
        if not column:
            rotation[..., axis], rotation[..., 3] = sine, cosine
            continue
        # The product with a rotation about one axis, whose other two components are zero.
        along, after, before = rotation[..., axis], rotation[..., (axis + 1) % 3], rotation[..., (axis + 2) % 3]
        turn = rotation[..., 3]
        done = along * cosine + turn * sine, after * cosine + before * sine, before * cosine - after * sine
        rotation[..., 3] = turn * cosine - along * sine
        for place, values in enumerate(done):
            rotation[..., (axis + place) % 3] = values
    return rotation


def from_fixed_euler(angles: Array, order: str) -> Array:
    """Quaternions of rotations about fixed axes, the first listed applied first: the reversed product."""
    return from_euler(angles[..., ::-1], order[::-1])


def to_matrix(rotation: Array) -> Array:
    """Matrices (..., 3, 3) of unit quaternions (..., 4)."""
    x, y, z, w = np.moveaxis(rotation, -1, 0)
    matrix = np.empty((*rotation.shape[:-1], 3, 3))
    matrix[..., 0, 0] = 1 - 2 * (y * y + z * z)
    matrix[..., 1, 1] = 1 - 2 * (x * x + z * z)
    matrix[..., 2, 2] = 1 - 2 * (x * x + y * y)
    matrix[..., 0, 1], matrix[..., 1, 0] = 2 * (x * y - z * w), 2 * (x * y + z * w)
    matrix[..., 0, 2], matrix[..., 2, 0] = 2 * (x * z + y * w), 2 * (x * z - y * w)
    matrix[..., 1, 2], matrix[..., 2, 1] = 2 * (y * z - x * w), 2 * (y * z + x * w)
    return matrix


def from_matrix(matrix: Array) -> Array:
    """Unit quaternions (..., 4) of rotation matrices (..., 3, 3), by the largest component. Shepperd (1978)."""
    m = matrix
    trace = m[..., 0, 0] + m[..., 1, 1] + m[..., 2, 2]
    squares = np.stack([*(2 * m[..., axis, axis] - trace for axis in range(3)), trace], axis=-1)
    largest = np.argmax(squares, axis=-1)
    candidates = np.empty((4, *matrix.shape[:-2], 4))
    for axis in range(3):
        second, third = (axis + 1) % 3, (axis + 2) % 3
        candidates[axis, ..., axis] = 1 + squares[..., axis]
        candidates[axis, ..., second] = m[..., second, axis] + m[..., axis, second]
        candidates[axis, ..., third] = m[..., third, axis] + m[..., axis, third]
        candidates[axis, ..., 3] = m[..., third, second] - m[..., second, third]
        candidates[3, ..., axis] = m[..., third, second] - m[..., second, third]
    candidates[3, ..., 3] = 1 + trace
    chosen = np.take_along_axis(candidates, largest[None, ..., None], axis=0)[0]
    unit: Array = chosen / np.linalg.norm(chosen, axis=-1, keepdims=True)
    return unit


def shortest_arc(start: Array, end: Array) -> Array:
    """The smallest rotation (4,) that takes the direction `start` to `end`, (3,) each, neither zero."""
    a, b = start / np.linalg.norm(start), end / np.linalg.norm(end)
    w = 1.0 + float(a @ b)
    if w < 1e-12:
        # Opposite: half a turn about any axis across.
        axis = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))])
        return np.array([*(axis / np.linalg.norm(axis)), 0.0])
    rotation = np.array([*np.cross(a, b), w])
    unit: Array = rotation / np.linalg.norm(rotation)
    return unit


def slerp(start: Array, end: Array, t: Array) -> Array:
    """Rotations between two others, along the shorter arc. Shoemake (1985).

    start, end: (..., 4) unit quaternions. t: (...,), 0 at start, 1 at end. Returns (..., 4).

    >>> slerp(IDENTITY, np.array([1.0, 0.0, 0.0, 0.0]), np.array(0.5)).round(3).tolist()
    [0.707, 0.0, 0.0, 0.707]
    """
    cosine = np.sum(start * end, axis=-1)
    end = np.where(cosine[..., None] < 0, -end, end)
    angle = np.arccos(np.clip(np.abs(cosine), 0.0, 1.0))
    sine = np.sin(angle)
    near = sine < 1e-9
    divisor = np.where(near, 1.0, sine)
    before = np.where(near, 1.0 - t, np.sin((1.0 - t) * angle) / divisor)
    after = np.where(near, t, np.sin(t * angle) / divisor)
    between = before[..., None] * start + after[..., None] * end
    unit: Array = between / np.linalg.norm(between, axis=-1, keepdims=True)
    return unit


def to_euler(rotation: Array, order: str, previous: Array | None = None) -> Array:
    """Angles (n, 3) in radians of unit quaternions (n, 4), continuous over the n frames.

    order: three different letters. previous: angles (3,) of the frame before the first, which they continue.
    Of the two triples that mean the same rotation, and whole turns, the nearest to the frame before is taken; the
    first frame without `previous` has its middle angle within a quarter turn. If the middle angle is a quarter turn the
    last angle does not change (0 at first), so only the first one moves. Formulas: docs/conventions.md.
    """
    if not len(rotation):
        return np.empty((0, 3))
    i, j, k = (_AXIS[letter] for letter in order.upper())
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    matrix = to_matrix(rotation)
    cosine = np.hypot(matrix[:, i, i], matrix[:, i, j])
    middle = np.arctan2(sign * matrix[:, i, k], cosine)
    last = np.arctan2(-sign * matrix[:, i, j], matrix[:, i, i])
    locked = cosine < GIMBAL
    flipped_before = False
    start = np.zeros(3)
    if previous is not None:
        flipped_before = bool(np.cos(previous[1]) < 0)
        start = _flipped(previous) if flipped_before else previous
    if locked.any():
        source = np.where(locked, 0, np.arange(1, len(last) + 1))
        last = np.concatenate([[start[2]], last])[np.maximum.accumulate(source)]
    # With the last angle known, the first follows from the rotation of the two outer axes.
    sine_last, cosine_last = sign * np.sin(last), np.cos(last)
    first = np.arctan2(
        sign * (sine_last * matrix[:, k, i] + cosine_last * matrix[:, k, j]),
        sine_last * matrix[:, j, i] + cosine_last * matrix[:, j, j],
    )
    angles = np.stack([first, middle, last], axis=-1)
    return _continued(angles, locked, start, flipped_before, previous)


def _flipped(angles: Array) -> Array:
    """The other triple of the same rotation."""
    flipped: Array = angles * np.array([1.0, -1.0, 1.0]) + np.pi
    return flipped


def _continued(
    angles: Array,
    locked: np.ndarray[tuple[int, ...], np.dtype[np.bool_]],
    start: Array,
    flipped: bool,
    previous: Array | None,
) -> Array:
    """Choose triples and add whole turns so that each is nearest to the previous one.

    Whether to change between a triple and its flipped twin depends only on the two rotations, not on which of the two
    came before (flipping both leaves every difference as it is, up to sign): so the choices are a running parity.
    """
    before = np.vstack([start, angles[:-1]])
    stay = np.abs(_wrapped(angles - before)).sum(axis=1)
    change = np.abs(_wrapped(_flipped(angles) - before)).sum(axis=1)
    changes = (change < stay) & ~locked
    if previous is None:
        changes[0] = False
    flips = (np.cumsum(changes) + flipped) % 2 == 1
    chosen = np.where(flips[:, None], _flipped(angles), angles)
    if previous is None:
        chosen[0] = _wrapped(chosen[0])
        return np.unwrap(chosen, axis=0)
    unwrapped: Array = np.unwrap(np.vstack([previous, chosen]), axis=0)[1:]
    return unwrapped


def _wrapped(angle: Array) -> Array:
    """Angles within half a turn of zero."""
    wrapped: Array = angle - 2 * np.pi * np.round(angle / (2 * np.pi))
    return wrapped
