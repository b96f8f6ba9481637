"""The points of C3D: words of a file to coordinates and residuals, and back. See docs/formats/c3d.md."""

from __future__ import annotations

from dataclasses import dataclass
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from mcml.formats.c3d.data import frames_at_a_time, read_rows
from mcml.formats.c3d.layout import Layout
from mcml.formats.c3d.parameters import Machine
from mcml.motion.skeleton import Array

_WORD: Final = 0x7FFFFFFF


@dataclass(frozen=True, slots=True)
class Points:
    """The points of a file, to be read block by block. scale: of integers, and of residuals; positive."""

    stream: BinaryIO
    layout: Layout
    machine: Machine
    scale: float

    @property
    def block(self) -> int:
        """How many frames to read at a time."""
        return frames_at_a_time(self.layout)

    def read(self, first: int, count: int) -> tuple[Array, Array]:
        """(coordinates (n, points, 3), residuals (n, points)) of n frames from `first` on, counted from 0.

        A residual of -1 is a sample that is missing. Values are in single precision, as the file's own are.
        """
        layout = self.layout
        rows = read_rows(self.stream, layout, first, count)
        count = len(rows)
        size = 4 if layout.real else 2
        data = np.ascontiguousarray(rows[:, : 4 * layout.points * size]).tobytes()
        scale = np.float32(self.scale)
        if layout.real:
            values = self.machine.floats(data).reshape(count, layout.points, 4)
            coordinates, words = values[..., :3], _whole(values[..., 3])
        else:
            integers = self.machine.integers(data).reshape(count, layout.points, 4)
            coordinates = (integers[..., :3].astype(np.float32) * scale).astype(np.float64)
            words = integers[..., 3].astype(np.int64)
        # The fourth word: a sign for a missing sample, a byte of cameras, a byte of residual.
        residuals = ((words & 0xFF).astype(np.float32) * scale).astype(np.float64)
        missing = (words < 0) | ~np.isfinite(coordinates).all(axis=2) | ~np.isfinite(residuals)
        return coordinates, np.where(missing, -1.0, residuals)


def _whole(words: Array) -> NDArray[np.int64]:
    """Return integers that are stored as floats; -1 for other numbers."""
    return np.where(np.isfinite(words), np.clip(np.nan_to_num(words), -_WORD, _WORD), -1.0).astype(np.int64)


def to_floats(coordinates: Array, residuals: Array, scale: float) -> bytes:
    """Frames as Intel floats.

    coordinates: (n, points, 3), finite where the sample exists. residuals: (n, points), -1 for a missing sample.
    """
    values = np.zeros((*residuals.shape, 4), dtype="<f4")
    there = residuals >= 0
    values[..., :3] = np.where(there[..., None], coordinates, 0.0)
    values[..., 3] = np.where(there, np.clip(np.round(residuals / scale), 0, 255), -1.0)
    return values.tobytes()
