"""A motion played faster or slower, by one factor or by a curve of factors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcml.errors import ConversionError
from mcml.motion.skeleton import Array

_FINE = 16
"""Steps a frame, and `_FEWEST` in all, in which the time of a curve of factors is added up."""
_FEWEST = 1024
_MOST_FRAMES = 10_000_000
_NEARLY = 1e-5
"""Relative change of the speed under which a series is exact."""


def speed_places(frames: int, factors: Sequence[float], *, follows: bool) -> Array:
    """Return the places (m,), from 0, in a range of frames at which its frames are at another speed.

    frames: of the range. factors: of the speed, at even distances over the range and linear between them; one holds
    everywhere. follows: whether a frame follows the range, which then comes one frame after the last place; else the
    last place is the last frame. The factors bend by less than half a frame in all, for a whole number of frames.
    Raises ConversionError for factors that are not positive.

    >>> speed_places(5, [2.0], follows=False).tolist(), speed_places(4, [0.5], follows=True).tolist()
    ([0.0, 2.0, 4.0], [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5])
    """
    speeds = np.asarray(factors, dtype=np.float64)
    if not (speeds.size and np.isfinite(speeds).all() and (speeds > 0).all()):
        raise ConversionError("A factor of speed is not positive.", remedy="Give factors such as 0.5 or 2.")
    length = float(frames if follows else frames - 1)
    if speeds.size == 1:
        seconds = length / float(speeds[0])
    else:
        given = np.linspace(0.0, length, speeds.size)
        grid = np.union1d(np.linspace(0.0, length, max(_FEWEST, round(length) * _FINE) + 1), given)
        passed = np.concatenate([[0.0], np.cumsum(np.diff(grid) * _mean_paces(np.interp(grid, given, speeds)))])
        seconds = float(passed[-1])
    if seconds > _MOST_FRAMES:
        raise ConversionError(
            f"{frames:,} frames would become {seconds:,.0f}.", remedy="Choose a shorter range, or a larger factor."
        )
    steps = max(1, round(seconds))
    wanted = np.arange(steps if follows else steps + 1, dtype=np.float64)
    if length == 0.0:
        return np.zeros(1)
    if speeds.size == 1:
        return wanted * length / steps
    places: Array = np.interp(wanted * seconds / steps, passed, grid)
    return places


def _mean_paces(speeds: Array) -> Array:
    """(k - 1,) the means of 1 / speed between speeds (k,), each linear from one to the next: of 1 / x, its integral."""
    first, last = speeds[:-1], speeds[1:]
    ratio = (last - first) / first
    near = np.abs(ratio) < _NEARLY
    # log1p(x) / x is 1 - x / 2 + x² / 3 for a small x.
    safe = np.where(near, 1.0, ratio)
    paces: Array = np.where(near, 1 - ratio / 2 + ratio**2 / 3, np.log1p(safe) / safe) / first
    return paces
