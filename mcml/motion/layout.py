"""Frames in one layout of columns, with missing samples held.

Kinematics and most files need a number for every channel of every frame. Where a frame has none, the joint keeps its
last value; before the first one it rests: its base value.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcml.motion.clip import ClipStream, FrameBlock
from mcml.motion.skeleton import CHANNEL_INDEX, Array, Convention, Skeleton, numbers, once_a_skeleton

_SCALE = CHANNEL_INDEX["SF"]


class Held:
    """Blocks to arrays of one layout; keeps the last frame from block to block.

    columns: (joint, channel) of each column wanted. missing: how many samples had to be held so far.
    """

    def __init__(self, skeleton: Skeleton, columns: Sequence[tuple[int, int]] | None = None) -> None:
        self.columns = skeleton.columns() if columns is None else tuple(columns)
        self.missing = 0
        self._last = _rest_values(skeleton, self.columns)

    def values(self, block: FrameBlock) -> Array:
        """(n, D) finite values in the layout."""
        if block.columns == self.columns:
            values = block.values
        else:
            place = {column: index for index, column in enumerate(block.columns)}
            values = np.full((len(block), len(self.columns)), np.nan)
            pairs = [(here, place[column]) for here, column in enumerate(self.columns) if column in place]
            if pairs:
                here, there = zip(*pairs, strict=True)
                values[:, list(here)] = block.values[:, list(there)]
        if not values.size:
            return values
        gaps = np.isnan(values)
        if gaps.any():
            values = self._filled(values, gaps)
        self._last = values[-1].copy()
        return values

    def _filled(self, values: Array, gaps: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> Array:
        self.missing += int(gaps.sum())
        with_last = np.vstack([self._last, values])
        rows = np.arange(len(with_last))[:, None]
        source = np.where(np.isnan(with_last), 0, rows)
        np.maximum.accumulate(source, axis=0, out=source)
        filled: Array = np.take_along_axis(with_last, source, axis=0)[1:]
        return filled


@once_a_skeleton
def _rest_values(skeleton: Skeleton, columns: tuple[tuple[int, int], ...]) -> Array:
    """(D,) of each column before its first sample."""
    return np.array([_at_rest(skeleton, joint, channel) for joint, channel in columns])


def _at_rest(skeleton: Skeleton, joint: int, channel: int) -> float:
    """The value of a channel before its first sample."""
    if channel == _SCALE:
        return 1.0
    item = skeleton.joints[joint]
    if item.convention is Convention.LISTED and item.translation != "relative" and channel < 3:
        return float(numbers(item.offset)[channel])
    return 0.0


def count_frames(clip: ClipStream) -> int:
    """The number of frames, by reading them where the clip does not know it."""
    return sum(len(block) for block in clip.blocks()) if clip.frames is None else clip.frames
