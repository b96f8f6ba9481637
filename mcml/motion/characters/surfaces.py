"""Closed surfaces of rings along a line of joints, and how much each vertex follows each joint.

Every part of the figure is such a surface: elliptic rings with a pole at either end. A vertex follows the bone that it
is at; around a joint it changes over from one bone to the next, smoothly. A ring in the middle of that change has its
centre in the joint, which both bones carry to the same place, so that no pose moves a part away from its joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.rotations import rotate, shortest_arc
from mcml.motion.skeleton import Array

MOST_JOINTS = 4
"""Joints that a vertex follows at most, as glTF and graphics cards have it."""


@dataclass(frozen=True, eq=False)
class Drive:
    """The joints along a line and where each takes over.

    joints: (k,) indices, the first one carries all before the second one's start. starts: (k,) places on the line.
    widths: (k,) lengths of the line over which each takes over from the one before it.
    """

    joints: tuple[int, ...]
    starts: Array
    widths: Array

    def weights(self, places: Array) -> Array:
        """(n, k) how much vertices at places (n,) on the line follow each joint; each row has the sum 1."""
        share = np.clip((places[:, None] - self.starts) / np.maximum(self.widths, 1e-12) + 0.5, 0.0, 1.0)
        share = share * share * (3 - 2 * share)
        share[:, 0] = 1.0
        # A joint does not take over more than the one before it has.
        share = np.minimum.accumulate(share, axis=1)
        after = np.concatenate([share[:, 1:], np.zeros((len(places), 1))], axis=1)
        return np.asarray(share - after)


@dataclass(frozen=True, eq=False)
class Surface:
    """points: (V, 3). faces: (T, 3), counterclockwise seen from outside. joints: (V, 4) indices. weights: (V, 4)."""

    points: Array
    faces: NDArray[np.int64]
    joints: NDArray[np.int64]
    weights: Array


@dataclass(frozen=True, eq=False)
class Rings:
    """centres: (R, 3). across, ahead: (R, 3) unit vectors of the two half-axes of each ring, whose cross product points
    along the line. widths, depths: (R,) the half-axes. places: (R,) on the line, by which rings follow joints.

    The first and the last ring are poles: points.
    """

    centres: Array
    across: Array
    ahead: Array
    widths: Array
    depths: Array
    places: Array


def make_surface(rings: Rings, drive: Drive, sides: int) -> Surface:
    """The closed surface of rings. sides: vertices of each ring."""
    angles = 2 * np.pi * np.arange(sides) / sides
    inner = slice(1, -1)
    around = (
        rings.centres[inner, None]
        + (rings.widths[inner, None] * np.cos(angles))[..., None] * rings.across[inner, None]
        + (rings.depths[inner, None] * np.sin(angles))[..., None] * rings.ahead[inner, None]
    )
    count = len(around)
    points = np.concatenate([around.reshape(-1, 3), rings.centres[[0, -1]]])
    places = np.concatenate([np.repeat(rings.places[inner], sides), rings.places[[0, -1]]])
    joints, weights = _largest(drive, drive.weights(places))
    return Surface(points, _faces(count, sides), joints, weights)


def _faces(rings: int, sides: int) -> NDArray[np.int64]:
    """Quads between rings as two triangles each, and fans to the poles, which are the last two points."""
    here = np.arange(sides)
    beside = (here + 1) % sides
    first, last = rings * sides, (rings - 1) * sides
    fans = [
        np.stack([np.full(sides, first), beside, here], axis=1),
        np.stack([np.full(sides, first + 1), last + here, last + beside], axis=1),
    ]
    strips = [
        np.concatenate([
            np.stack([low + here, low + beside, low + sides + beside], axis=1),
            np.stack([low + here, low + sides + beside, low + sides + here], axis=1),
        ])
        for low in range(0, last, sides)
    ]  # fmt: skip
    return np.concatenate([*strips, *fans]).astype(np.int64)


def _largest(drive: Drive, weights: Array) -> tuple[NDArray[np.int64], Array]:
    """The joints (n, 4) with the largest weights, and these (n, 4) with the sum 1; unused ones have the weight 0."""
    names = np.array(drive.joints, dtype=np.int64)
    if len(names) < MOST_JOINTS:
        short = MOST_JOINTS - len(names)
        names = np.concatenate([names, np.full(short, names[0])])
        weights = np.concatenate([weights, np.zeros((len(weights), short))], axis=1)
    order = np.argsort(-weights, axis=1, kind="stable")[:, :MOST_JOINTS]
    kept = np.take_along_axis(weights, order, axis=1)
    kept /= kept.sum(axis=1, keepdims=True)
    return np.where(kept > 0, names[order], names[order[:, :1]]), kept


def vertex_normals(points: Array, faces: NDArray[np.int64]) -> Array:
    """Return (V, 3) unit normals of vertices: the mean of the faces around each, weighted by their areas."""
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    across = np.cross(b - a, c - a)
    normals = np.zeros_like(points)
    for corner in range(3):
        np.add.at(normals, faces[:, corner], across)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(normals / np.where(length > 0, length, 1.0))


def join(surfaces: Sequence[Surface]) -> Surface:
    """One surface of several."""
    before = np.cumsum([0, *(len(each.points) for each in surfaces[:-1])])
    return Surface(
        np.concatenate([each.points for each in surfaces]),
        np.concatenate([each.faces + start for each, start in zip(surfaces, before, strict=True)]),
        np.concatenate([each.joints for each in surfaces]),
        np.concatenate([each.weights for each in surfaces]),
    )


@dataclass(frozen=True, eq=False)
class Line:
    """A line through joints. places: (n, 3), at least two. lengths: (n,) along it from the first one."""

    places: Array

    @property
    def lengths(self) -> Array:
        steps = np.linalg.norm(np.diff(self.places, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])

    def at(self, along: Array) -> Array:
        """(m, 3) the points at lengths (m,); beyond its ends it goes on straight."""
        lengths, directions = self.lengths, self._directions()
        inside = np.clip(along, 0.0, lengths[-1])
        points = np.stack([np.interp(inside, lengths, self.places[:, axis]) for axis in range(3)], axis=1)
        points += np.minimum(along, 0.0)[:, None] * directions[0]
        points += np.maximum(along - lengths[-1], 0.0)[:, None] * directions[-1]
        return np.asarray(points)

    def headings(self, along: Array, width: float) -> Array:
        """(m, 3) unit directions at lengths (m,), from one bone's to the next one's over a width around each joint."""
        lengths, directions = self.lengths, self._directions()
        drive = Drive(tuple(range(len(directions))), lengths[:-1], np.full(len(directions), width))
        weights = drive.weights(along)
        mixed = weights @ directions
        # Bones that lead back along themselves have no direction between them.
        folded = np.linalg.norm(mixed, axis=1) < 1e-3
        mixed[folded] = directions[np.argmax(weights[folded], axis=1)]
        return np.asarray(mixed / np.linalg.norm(mixed, axis=1, keepdims=True))

    def _directions(self) -> Array:
        """(n - 1, 3); of a bone without length that of the one before it, or of the first one that has any."""
        steps = np.diff(self.places, axis=0)
        found = np.linalg.norm(steps, axis=1) > 1e-9 * max(self.lengths[-1], 1e-12)
        source = np.maximum.accumulate(np.where(found, np.arange(len(steps)), -1))
        source = np.where(source < 0, int(np.argmax(found)), source)
        chosen = steps[source]
        return np.asarray(chosen / np.linalg.norm(chosen, axis=1, keepdims=True))


def axes_along(headings: Array, usual: Array, across: Array) -> tuple[Array, Array]:
    """The two half-axes (n, 3) each of rings along directions (n, 3).

    The half-axes of a limb in a usual pose, turned by the smallest rotation from it. usual: (3,) its direction,
    across: (3,) its first half-axis, which is across.
    """
    turns = np.stack([shortest_arc(usual, heading) for heading in headings])
    first = rotate(turns, across)
    return first, np.cross(headings, first)
