"""Colours as bytes of sRGB and as linear light (IEC 61966-2-1), and those of pictures where Pillow is installed."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array

MOST_PIXELS = 1 << 27
"""Of all pictures of a file that are read."""


def to_srgb(linear: Array) -> NDArray[np.uint8]:
    """Bytes of sRGB of linear light between 0 and 1, of any shape."""
    light = np.clip(np.nan_to_num(linear), 0.0, 1.0)
    curve = np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.power(light, 1 / 2.4) - 0.055)
    return np.asarray(np.round(255 * curve), np.uint8)


def to_linear(srgb: NDArray[np.uint8]) -> Array:
    """Linear light between 0 and 1 of bytes of sRGB, of any shape."""
    curve = srgb / 255.0
    return np.asarray(np.where(curve <= 0.04045, curve / 12.92, np.power((curve + 0.055) / 1.055, 2.4)))


class Pictures:
    """Reads the pictures of one file, of `MOST_PIXELS` together. left_out: why others were not read."""

    def __init__(self) -> None:
        self.left_out: set[str] = set()
        self._room = MOST_PIXELS

    def read(self, data: bytes) -> NDArray[np.uint8] | None:
        """Return a PNG or JPEG as (height, width, 3) of sRGB; None, with the reason, where it is not read."""
        try:
            from PIL import Image
        except ImportError:
            self.left_out.add("Pillow is not installed")
            return None
        try:
            with Image.open(io.BytesIO(data), formats=("PNG", "JPEG")) as picture:
                if picture.width * picture.height > self._room:
                    self.left_out.add("they are too large")
                    return None
                self._room -= picture.width * picture.height
                return np.asarray(picture.convert("RGB"), np.uint8)
        except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
            self.left_out.add("they are damaged")
            return None


def sample_picture(picture: NDArray[np.uint8], at: Array) -> Array:
    """Return the linear colours (V, 3) of a picture at places (V, 2), from its upper left corner to the right and down
    in shares of its size; beyond its edges it is repeated.
    """
    height, width = picture.shape[:2]
    share = np.nan_to_num(at - np.floor(at))
    rows = np.minimum((share[:, 1] * height).astype(np.intp), height - 1)
    columns = np.minimum((share[:, 0] * width).astype(np.intp), width - 1)
    return to_linear(picture[rows, columns])
