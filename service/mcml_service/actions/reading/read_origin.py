"""The origin of a document's positions: a point near its motion, so that 32-bit floats are precise enough.

It belongs to a revision, not to the requested frames: the position of the first bone in frame 1. For labelled points it
is the first in the document's order that is visible in frame 1; (0, 0, 0) if none is, and without frames.
"""

from __future__ import annotations

import numpy as np

from mcml.motion.clip import FrameBlock
from mcml.motion.kinematics import Walker, unseen
from mcml.motion.skeleton import Array, Convention, Skeleton
from mcml.motion.units import reading_of
from mcml_service.clips.read_clip import StoredClip, read_clip
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction


def origin_of(tx: Transaction, source: StoredClip) -> Array:
    """(3,) in the document's unit. source: any frames of the document."""
    skeleton = source.clip.head.skeleton
    if not source.stored.frames or not len(skeleton):
        return np.zeros(3)
    root = skeleton.joints[0]
    if root.convention is Convention.MARKER:
        return origin_in(first_pose(tx, source.stored)[1])
    # Where the first bone is depends on its own channels alone.
    bones = tx.heads.bone_names(source.stored.key)
    number = next(bone for bone, name in bones.items() if name == root.name)
    columns = [(number, channel) for joint, channel in skeleton.columns() if joint == 0]
    (block,) = tx.tracks.blocks(source.stored.key, 1, 1, columns=columns, bones=[number])
    own = tuple((0, channel) for _, channel in block.columns)
    alone = FrameBlock(block.values, own, ((),), block.ids)
    origin: Array = Walker(Skeleton((root,)), reading_of(source.clip.head)).poses(alone)[0][0, 0]
    return origin


def first_pose(tx: Transaction, stored: StoredDocument | Listed) -> tuple[StoredClip, Array]:
    """Frame 1 of a document that has frames, and (J, 3) where its joints are in it; NaN where a point was not seen."""
    source = read_clip(tx, stored, first=1, last=1, labelled=False)
    skeleton = source.clip.head.skeleton
    (block,) = source.clip.blocks()
    positions = Walker(skeleton, reading_of(source.clip.head)).poses(block)[0][0]
    if any(joint.convention is Convention.MARKER for joint in skeleton.joints):
        positions[unseen(skeleton, block)[0]] = np.nan
    return source, positions


def origin_in(positions: Array) -> Array:
    """(3,) the origin, of the pose in frame 1."""
    seen = positions[np.isfinite(positions).all(axis=1)]
    return seen[0] if len(seen) else np.zeros(3)
