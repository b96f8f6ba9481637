"""MT1 read again, as a browser reads it: by the words of `mcml.motion.pictures.thumbnails` alone."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Picture:
    """bones: (B, 4) two places, side, depth. loop, scrub: (poses, points, 2), x to the right and y down, in heights."""

    face: bool
    markers: bool
    bones: NDArray[np.int64]
    loop: NDArray[np.float64]
    scrub: NDArray[np.float64]
    ground: NDArray[np.uint8]
    seconds: float
    aspect: float
    step: float


def read(content: bytes) -> Picture:
    magic, flags, points, bones, loop, scrub, seconds, aspect, step = struct.unpack("<3s5B3f", content[:20])
    assert magic == b"MT1"
    sizes = [bones * 3, loop * points * 2, scrub * points * 2, loop + scrub]
    ends = np.cumsum([20, *sizes])
    assert ends[-1] == len(content) <= 4096
    parts = [np.frombuffer(content[a:b], np.uint8) for a, b in pairwise(ends)]
    lines = parts[0].reshape(bones, 3).astype(np.int64)
    scale = np.array([aspect, 1.0]) / 255
    return Picture(
        bool(flags & 1),
        bool(flags & 2),
        np.column_stack([lines[:, :2], lines[:, 2] % 4, lines[:, 2] // 4]),
        parts[1].reshape(loop, points, 2) * scale,
        parts[2].reshape(scrub, points, 2) * scale,
        parts[3],
        seconds,
        aspect,
        step,
    )
