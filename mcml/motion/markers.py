"""Labelled points: markers of optical systems, and the joints of a body taken as such."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from mcml.motion.clip import ClipStream, FrameBlock, full_shape
from mcml.motion.kinematics import Walker
from mcml.motion.skeleton import CHANNEL_INDEX, TRANSLATIONS, Array, Convention, Joint, Skeleton, unique_names
from mcml.motion.units import reading_of

UNNAMED = "unnamed"
"""The name of points without a label."""
_KEPT_FIELDS = ("filename", "skeleton_name", "dataframe_rate", "calibration_unit", "global_axis_of_gravity")


def marker_skeleton(labels: Sequence[str], *, residual: bool = False, names: Sequence[str] | None = None) -> Skeleton:
    """Points without hierarchy, in the order of their labels; repeated names get `#2`, `#3` … at their end.

    residual: they have the channel of that name too, how well each sample was measured. names: if not the labels.
    """
    channels = (*TRANSLATIONS, "residual") if residual else TRANSLATIONS
    names = unique_names([name or UNNAMED for name in names or labels])
    return Skeleton(
        tuple(
            Joint(
                name=name,
                parent=-1,
                source_name=label,
                convention=Convention.MARKER,
                channels=channels,
                translation="absolute",
            )
            for name, label in zip(names, labels, strict=True)
        )
    )


def read_marker_positions(clip: ClipStream, joints: Sequence[int]) -> Array:
    """(frames, k, 3) positions of markers in all frames, in the unit of the clip; NaN where a sample is missing.

    joints: indices of the markers in its skeleton.
    """
    columns = {column: place for place, column in enumerate(clip.head.skeleton.columns())}
    wanted = [columns[joint, CHANNEL_INDEX[channel]] for joint in joints for channel in TRANSLATIONS]
    positions = [np.empty((0, len(joints), 3))]
    for block in clip.blocks():
        positions.append(_in_order(block, clip.head.skeleton.columns())[:, wanted].reshape(len(block), -1, 3))
    return np.concatenate(positions)


def _in_order(block: FrameBlock, columns: tuple[tuple[int, int], ...]) -> Array:
    """(n, D) values of these columns, NaN for those that a block lacks."""
    if block.columns == columns:
        return block.values
    places = {column: place for place, column in enumerate(block.columns)}
    values = np.full((len(block), len(columns)), np.nan)
    for here, column in enumerate(columns):
        if column in places:
            values[:, here] = block.values[:, places[column]]
    return values


def as_markers(clip: ClipStream) -> ClipStream:
    """The joints of a body as points in the world, by forward kinematics; ends of chains are left out."""
    source = clip
    skeleton = marker_skeleton(source.head.skeleton.names)
    skeleton = Skeleton(
        tuple(
            replace(point, source_name=joint.source_name, mapped=joint.mapped)
            for point, joint in zip(skeleton.joints, source.head.skeleton.joints, strict=True)
        )
    )
    columns = skeleton.columns()
    shapes = (full_shape(columns),)
    fields = {name: source.head.fields[name] for name in _KEPT_FIELDS if name in source.head.fields}
    head = replace(source.head, skeleton=skeleton, fields=fields, number_style="shortest", sources=())

    def blocks() -> Iterator[FrameBlock]:
        walker = Walker(source.head.skeleton, reading_of(source.head))
        for block in source.blocks():
            positions = walker.poses(block)[0]
            values = np.ascontiguousarray(positions.reshape(len(block), -1))
            yield FrameBlock(values, columns, shapes, block.ids, None, block.motion_names)

    return ClipStream(head, blocks, source.frames, source.notices)
