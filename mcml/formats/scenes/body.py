"""The visible body of a scene: a mesh that joints carry.

A simple one has a slim octahedron along each bone, and a small one at each joint or marker that belongs to no bone;
each turns with one joint. A person can have the figure of `mcml.motion.characters` instead.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mcml.formats.scenes.stage import Stage
from mcml.motion.anatomy.axes import stance_of
from mcml.motion.characters.figure import make_character
from mcml.motion.characters.measures import check_joints
from mcml.motion.hub import rest_of
from mcml.motion.pictures.figures import axis_of
from mcml.motion.rotations import IDENTITY
from mcml.motion.skeleton import Array
from mcml.motion.units import reading_of

_SHORT = 1e-6
"""Relative to the size of a body: anything shorter is not a bone."""
_WAIST, _WIDTH = 0.15, 0.08
"""Where along a bone it is thickest, and half of how thick, in its lengths."""
_POINT = 0.012
"""Half of how wide a joint without bone is, in sizes of the body."""
_FACES = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 1), (5, 2, 1), (5, 3, 2), (5, 4, 3), (5, 1, 4)])
"""Outwards, counterclockwise, of start, four corners around, and end."""
_POSES = 200
"""Frames among which a pose in which the body stands is looked for."""


@dataclass(frozen=True, eq=False)
class Body:
    """points: (V, 3) in the source's unit and axes. faces: (T, 3). joints, weights: (V, k) of the joints that carry
    each. normals: (V, 3), None for flat faces. places: (J, 3), turns: (J, 4) from rest, of the joints in the pose of
    the points. colours: (V, 3) of sRGB, None for one colour."""

    points: Array
    faces: NDArray[np.int64]
    joints: NDArray[np.int64]
    weights: Array
    normals: Array | None
    places: Array
    turns: Array
    colours: NDArray[np.uint8] | None = None


def body_of(stage: Stage) -> Body:
    """The body of a clip: its character, the figure if it was asked for, else the simple one. Raises ConversionError
    for a figure of clips that are not of a person."""
    if not isinstance(stage.character, bool):
        made = stage.character
        return Body(
            made.points, made.faces, made.joints, made.weights, made.normals, made.places, made.turns, made.colours
        )  # fmt: skip
    return _figure(stage) if stage.character else _bones(stage)


def _figure(stage: Stage) -> Body:
    skeleton = stage.skeleton
    check_joints(skeleton)
    rest = replace(rest_of(skeleton, reading_of(stage.clip.head)), offsets=stage.rest)
    translations, rotations = [stage.rest], [np.tile(IDENTITY, (len(skeleton), 1))]
    step, at = max(1, stage.frames // _POSES), 0
    for moved, turned in stage.blocks():
        chosen = slice(-at % step, None, step)
        translations += list(moved[chosen])
        rotations += list(turned[chosen])
        at += len(moved)
    stance = stance_of(skeleton, rest, np.array(translations), np.array(rotations), axis_of(stage.up or "Y"))
    made = make_character(skeleton, rest, stance)
    return Body(made.points, made.faces, made.joints, made.weights, made.normals, made.places, made.turns)


def _bones(stage: Stage) -> Body:
    """Octahedra, in the rest pose."""
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
        np.repeat(np.array(carriers, dtype=np.int64), 6)[:, None],
        np.ones((6 * count, 1)),
        None,
        places,
        np.tile(IDENTITY, (len(places), 1)),
    )


def _bone(vector: Array, waist: float = _WAIST, width: float = _WIDTH) -> Array:
    """(6, 3) corners of an octahedron from the origin along a vector."""
    across = np.cross(vector, np.eye(3)[int(np.argmin(np.abs(vector)))])
    across *= np.linalg.norm(vector) / np.linalg.norm(across)
    other = np.cross(vector, across) / np.linalg.norm(vector)
    around = np.stack([across, other, -across, -other])
    return np.vstack([np.zeros(3), waist * vector + width * around, vector])
