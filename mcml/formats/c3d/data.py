"""Find the data of a C3D file and read its frames as bytes: points, then analog samples, frame by frame."""

from __future__ import annotations

import io
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from mcml.errors import Notice
from mcml.formats.c3d.layout import Layout, find_layout
from mcml.formats.c3d.parameters import Statements

_BLOCK_BYTES: Final = 8 << 20
_BLOCK_FRAMES: Final = 4096
_PIECE: Final = 1 << 20


def find_data(stream: BinaryIO, said: Statements, notices: list[Notice], *, analog_alone: bool = False) -> Layout:
    """Find the layout of the data. Raises FormatError as `find_layout`.

    analog_alone: accept files that have analog channels and no points.
    """
    size = stream.seek(0, io.SEEK_END)
    return find_layout(said, size, lambda first, behind: _is_zero(stream, first, behind), notices, analog_alone)


def first_frame(said: Statements, frames: int) -> int:
    """Return the number of the first frame: the one of TRIAL, which has more bits, if its count of frames is right."""
    start, end = said.long("TRIAL:ACTUAL_START_FIELD"), said.long("TRIAL:ACTUAL_END_FIELD")
    agrees = start is not None and end is not None and end - start + 1 == frames
    return int(start) if agrees and start is not None else int(said.words[3])


def frames_at_a_time(layout: Layout) -> int:
    """Return how many frames to read at a time, so that memory stays bounded."""
    return max(1, min(_BLOCK_FRAMES, _BLOCK_BYTES // layout.frame_bytes))


def read_rows(stream: BinaryIO, layout: Layout, first: int, count: int) -> NDArray[np.uint8]:
    """Read (n, bytes of a frame) of n frames from `first` on, counted from 0; fewer at the end of the data."""
    count = max(0, min(count, layout.frames - first))
    stream.seek(layout.start + first * layout.frame_bytes)
    return np.frombuffer(stream.read(count * layout.frame_bytes), np.uint8).reshape(count, layout.frame_bytes)


def _is_zero(stream: BinaryIO, first: int, behind: int) -> bool:
    stream.seek(first)
    return not any(any(stream.read(min(_PIECE, behind - place))) for place in range(first, behind, _PIECE))
