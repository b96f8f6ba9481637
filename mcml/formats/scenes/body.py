"""A simple body around the joints of a clip, so that it is seen: a slim octahedron along each bone, a small one at each
joint or marker that belongs to no bone. Each turns with one joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.formats.scenes.stage import Stage
from mcml.motion.skeleton import Array

_SHORT = 1e-6
"""Relative to the size of a body: anything shorter is not a bone."""
_WAIST, _WIDTH = 0.15, 0.08
"""Where along a bone it is thickest, and half of how thick, in its lengths."""
_POINT = 0.012
"""Half of how wide a joint without bone is, in sizes of the body."""
_FACES = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 1), (5, 2, 1), (5, 3, 2), (5, 4, 3), (5, 1, 4)])
"""Outwards, counterclockwise, of start, four corners around, and end."""


@dataclass(frozen=True, eq=False)
class Body:
    """points: (V, 3) in the rest pose, in the source's unit and axes. faces: (T, 3). joints: (V,) that carries each."""

    points: Array
    faces: NDArray[np.int64]
    joints: NDArray[np.int64]


def body_of(stage: Stage) -> Body:
    """The body of a clip in its rest pose."""
    places = stage.rest_places()
    bones = [(joint.parent, stage.rest[index], index) for index, joint in enumerate(stage.skeleton.joints)]
    ends = [(parent, vector, index) for parent, vector, index in bones if parent >= 0]
    ends += [(joint, vector, joint) for joint, vector in stage.tips]
    points: list[Array] = []
    carriers: list[int] = []
    held: set[int] = set()
    for carrier, vector, end in ends:
        if np.linalg.norm(vector) > _SHORT * stage.size:
            points.append(places[carrier] + _bone(vector))
            carriers.append(carrier)
            held |= {carrier, end}
    radius = _POINT * stage.size
    for index in range(len(stage.skeleton)):
        if index not in held:
            points.append(places[index] + _bone(np.array([0.0, 2 * radius, 0.0]), 0.5, 0.5) - (0, radius, 0))
            carriers.append(index)
    count = len(points)
    return Body(
        np.concatenate(points) if count else np.empty((0, 3)),
        (_FACES[None] + 6 * np.arange(count)[:, None, None]).reshape(-1, 3),
        np.repeat(np.array(carriers, dtype=np.int64), 6),
    )


def _bone(vector: Array, waist: float = _WAIST, width: float = _WIDTH) -> Array:
    """(6, 3) corners of an octahedron from the origin along a vector."""
    across = np.cross(vector, np.eye(3)[int(np.argmin(np.abs(vector)))])
    across *= np.linalg.norm(vector) / np.linalg.norm(across)
    other = np.cross(vector, across) / np.linalg.norm(vector)
    around = np.stack([across, other, -across, -other])
    return np.vstack([np.zeros(3), waist * vector + width * around, vector])
