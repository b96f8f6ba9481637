"""A clip without its blend shapes, for formats that have no place for them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from mcml.errors import ConversionError, Notice
from mcml.motion.clip import ClipStream, FrameBlock, Shape
from mcml.motion.skeleton import Convention, Joint, Skeleton


def without_blend_shapes(clip: ClipStream) -> ClipStream:
    """The clip without its blend shapes, with a notice; the same clip where there are none.

    Joints below a shape move to the joint above it. Raises ConversionError where nothing else is left.
    """
    shapes = clip.head.skeleton.blend_shapes
    if not shapes:
        return clip
    if len(shapes) == len(clip.head.skeleton):
        raise ConversionError(
            "the document holds blend shapes alone, which have no skeleton", remedy="Export it as CSV, glTF or MCML."
        )
    notice = Notice("warning", f"{len(shapes)} blend shapes are left out: the format has no place for them")
    bare = joints_of(clip)
    return replace(bare, notices=[*clip.notices, notice])


def joints_of(clip: ClipStream) -> ClipStream:
    """The clip without its blend shapes, with the same list of notices. It may have no joints."""
    skeleton = clip.head.skeleton
    kept = [index for index, joint in enumerate(skeleton.joints) if joint.convention is not Convention.BLEND_SHAPE]
    place = {index: number for number, index in enumerate(kept)}
    head = replace(clip.head, skeleton=_keep_joints(skeleton, place))

    def blocks() -> Iterator[FrameBlock]:
        for block in clip.blocks():
            yield _keep_columns(block, place)

    return replace(clip, head=head, blocks=blocks)


def _keep_joints(skeleton: Skeleton, place: dict[int, int]) -> Skeleton:
    joints = tuple(replace(skeleton.joints[index], parent=_parent_of(skeleton.joints, index, place)) for index in place)
    return Skeleton(joints, tuple(place[index] for index in skeleton.declared if index in place))


def _parent_of(joints: Sequence[Joint], index: int, place: dict[int, int]) -> int:
    parent = joints[index].parent
    while parent >= 0 and parent not in place:
        parent = joints[parent].parent
    return place.get(parent, -1)


def _keep_columns(block: FrameBlock, place: dict[int, int]) -> FrameBlock:
    chosen = [number for number, (joint, _) in enumerate(block.columns) if joint in place]
    columns = tuple((place[joint], channel) for joint, channel in (block.columns[number] for number in chosen))
    shapes: list[Shape] = [
        tuple((place[joint], bits) for joint, bits in shape if joint in place) for shape in block.shapes
    ]
    different = tuple(dict.fromkeys(shapes))
    number_of = np.array([different.index(shape) for shape in shapes], dtype=np.intp)
    shape_of = None if block.shape_of is None or len(different) == 1 else number_of[block.shape_of]
    return replace(block, values=block.values[:, chosen], columns=columns, shapes=different, shape_of=shape_of)
