"""Colours as bytes of sRGB and as linear light (IEC 61966-2-1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array


def to_srgb(linear: Array) -> NDArray[np.uint8]:
    """Bytes of sRGB of linear light between 0 and 1, of any shape."""
    light = np.clip(np.nan_to_num(linear), 0.0, 1.0)
    curve = np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.power(light, 1 / 2.4) - 0.055)
    return np.asarray(np.round(255 * curve), np.uint8)


def to_linear(srgb: NDArray[np.uint8]) -> Array:
    """Linear light between 0 and 1 of bytes of sRGB, of any shape."""
    curve = srgb / 255.0
    return np.asarray(np.where(curve <= 0.04045, curve / 12.92, np.power((curve + 0.055) / 1.055, 2.4)))
