"""Numbers near the largest double: results computed from them may overflow, and are refused."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.clip import ClipStream, FrameBlock, full_shape


def within_doubles(clip: ClipStream) -> ClipStream:
    """The clip; ConversionError, once its frames are read, for the first number that is beyond the largest double."""

    def blocks() -> Iterator[FrameBlock]:
        position = 1
        for block in clip.blocks():
            check_numbers(block, clip.head.skeleton.names, position)
            position += len(block)
            yield block

    return replace(clip, blocks=blocks)


def check_numbers(block: FrameBlock, names: Sequence[str] | Mapping[int, str], position: int) -> None:
    """ConversionError for a number that is beyond the largest double. position: of the block's first frame, from 1."""
    # Without missing samples, NaN is the difference of two such numbers.
    whole = block.shape_of is None and block.shapes[:1] == (full_shape(block.columns),)
    beyond = ~np.isfinite(block.values) if whole else np.isinf(block.values)
    if beyond.any():
        row, column = np.argwhere(beyond)[0].tolist()
        raise ConversionError(
            f"Frame {position + row}, {names[block.columns[column][0]]}: the number would be beyond the largest one.",
            remedy="Check the numbers it is made from: they are near 1e308.",
        )
