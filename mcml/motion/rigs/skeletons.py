"""Recognise rigs of clips; results are cached for all clips that share a skeleton."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mcml.motion.clip import ClipStream, FrameBlock
from mcml.motion.hub import rest_of
from mcml.motion.kinematics import Walker
from mcml.motion.rigs.recognise import Recognition, recognise
from mcml.motion.rigs.tree import Tree
from mcml.motion.skeleton import Array, Convention, Skeleton
from mcml.motion.units import reading_of

MOST_JOINTS = 300
"""Of a skeleton that is kept for clips to come: sixty-four such take some ten megabytes, of any size they might not."""
_POSES = 9
"""Number of poses of a clip, if its rest pose is not enough."""
_MOST_FRAMES = 100_000
"""Of a clip among which poses are taken: enough for a quarter of an hour at 120 a second."""


def rig_of(skeleton: Skeleton) -> Tree:
    """The source's own names of a skeleton, with its tree and its rest pose."""
    rest = rest_of(skeleton)
    places = rest.offsets.copy()
    with np.errstate(over="ignore", invalid="ignore"):
        for index, joint in enumerate(skeleton.joints):
            if joint.parent >= 0:
                places[index] += places[joint.parent]
    if not np.isfinite(places).all() or (places.size and np.abs(places).max() > _FARTHEST):
        places = np.zeros_like(places)
    tips = tuple((joint, places[joint] + vector) for joint, vector in rest.tips if np.abs(vector).max() < _FARTHEST)
    # A blend shape named after a part of the face is not that part.
    names = ["" if joint.convention is Convention.BLEND_SHAPE else joint.own_name for joint in skeleton.joints]
    return Tree(names, [joint.parent for joint in skeleton.joints], places, tips)


_FARTHEST = 1e100
"""From the origin, in any unit: squares of more are no numbers."""


def recognise_skeleton(skeleton: Skeleton) -> Recognition:
    """Recognise the joints of a skeleton by their names, their tree and their rest pose."""
    return (_kept if len(skeleton) <= MOST_JOINTS else _made)(skeleton)


def recognise_clip(clip: ClipStream) -> Recognition:
    """Recognise the joints of a clip, also by poses of the motion if the rest pose is not a standing body.

    Frames are read only then, and once for the clips that share a skeleton: all get the names of the first.
    """
    skeleton = clip.head.skeleton
    known = recognise_skeleton(skeleton)
    if not known.asks_for_frames:
        return known
    kept = _by_poses(skeleton) if len(skeleton) <= MOST_JOINTS else []
    if not kept:
        kept.append(recognise(rig_of(skeleton), _some_poses(clip)))
    return kept[0]


def _made(skeleton: Skeleton) -> Recognition:
    return recognise(rig_of(skeleton))


_kept = lru_cache(maxsize=64)(_made)


@lru_cache(maxsize=64)
def _by_poses(skeleton: Skeleton) -> list[Recognition]:
    """Where the recognition by poses of a skeleton is kept, once it is made."""
    return []


def _some_poses(clip: ClipStream) -> Sequence[Array]:
    """Places of joints, (J, 3), in frames that are spread over a clip; fewer than twice _POSES."""
    walker = Walker(clip.head.skeleton, reading_of(clip.head))
    poses: list[Array] = []
    step, first = 1, 0
    with np.errstate(over="ignore", invalid="ignore"):
        for block in clip.blocks():
            rows = np.arange(-first % step, len(block), step)
            poses += list(walker.poses(_rows_of(block, rows))[0])
            first += len(block)
            while len(poses) >= 2 * _POSES:
                poses, step = poses[::2], step * 2
            if first >= _MOST_FRAMES:
                break
    return [places for places in poses if np.isfinite(places).all() and np.abs(places).max(initial=0) < _FARTHEST]


def _rows_of(block: FrameBlock, rows: NDArray[np.intp]) -> FrameBlock:
    ids = np.arange(len(rows))
    shape_of = None if block.shape_of is None else block.shape_of[rows]
    return replace(block, values=block.values[rows], shape_of=shape_of, ids=ids, motion_names=None)
