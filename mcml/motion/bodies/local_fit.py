"""How fast numbers change: the slope and the bend of a parabola through a frame's neighbours (Savitzky, Golay 1964).

Differences of two frames measure noise: at 120 frames a second they found 2.88 m/s, and 1.79 at 30, for one hand whose
parabola moves at 1.80 and 1.79.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array

Flags = NDArray[np.bool_]

WINDOW = 0.05
"""Seconds before and after."""
LEAST, MOST = 2, 500
"""Frames before and after, at least and at most."""
_AT_ONCE = 1 << 18
"""Places of neighbours that are looked at together."""


def reach(frame_time: float | None) -> int:
    """Frames before and after that count: none further away than WINDOW, but LEAST at least, and MOST at most.

    >>> reach(1 / 120), reach(0.0083333), reach(1 / 30)
    (6, 6, 2)
    """
    if frame_time is None:
        return LEAST
    # Files round their frame times; a hundredth of a frame is nothing.
    return min(MOST, max(LEAST, int(min(WINDOW / frame_time, MOST) + 0.01)))


def slopes(values: Array, frame_time: float) -> Array:
    """First derivatives (n, k) of values (n, k), per second, of the parabola that fits best in least squares.

    Rows that are not completely finite are ignored, and their slope is NaN. At the ends of the clip, and next to gaps,
    the parabola fits the available rows of the window; two rows give a line, one gives NaN.
    """
    count, far = len(values), reach(frame_time)
    seen: Flags = np.logical_and.reduce(np.isfinite(values), axis=1)
    found = np.full(values.shape, np.nan)
    inner = slice(far, max(far, count - far))
    if inner.stop > far:
        # Over a whole window the slope is that of a line, as its squares weigh the same on both sides.
        total = np.zeros_like(values[inner])
        for step in range(1, far + 1):
            total += step * (values[far + step : inner.stop + step] - values[far - step : inner.stop - step])
        found[inner] = total / (2 * sum(step * step for step in range(1, far + 1)))
    edge = min(far, max(0, count - far))
    if edge:
        found[:edge] = _slopes_at_the_start(values, far)[:edge]
        found[count - edge :] = -_slopes_at_the_start(values[::-1], far)[:edge][::-1]
    rows = np.flatnonzero(seen & ~_has_all_neighbours(seen, far))
    piece = max(1, _AT_ONCE // (2 * far + 1))
    for start in range(0, len(rows), piece):
        chosen = rows[start : start + piece]
        found[chosen] = _slopes_of_what_there_is(values, seen, chosen, far)
    found[~seen] = np.nan
    return found / frame_time


def _slopes_at_the_start(values: Array, far: int) -> Array:
    """(far, k) of the first rows; invalid where a row of their windows is missing."""
    first = np.zeros((2 * far, values.shape[1]))
    part = values[: 2 * far]
    moved = part - np.where(np.isfinite(part[0]), part[0], 0.0)
    first[: len(part)] = np.where(np.isfinite(moved), moved, 0.0)
    found: Array = _weights_at_the_start(far) @ first
    return found


@cache
def _weights_at_the_start(far: int) -> Array:
    """(far, 2 far) of the first rows, for the slopes in each of the first rows before which too few are."""
    weights = np.zeros((far, 2 * far))
    for row in range(far):
        steps = np.arange(-row, far + 1, dtype=np.float64)
        weights[row, : row + far + 1] = np.linalg.pinv(np.stack([np.ones_like(steps), steps, steps**2], axis=1))[1]
    return weights


def bends(values: Array, frame_time: float) -> Array:
    """Second derivatives (n, k) of values (n, k), per second squared, of the same parabola.

    Known only where the whole window is: at its ends a parabola bends with the noise. NaN elsewhere.
    """
    count, far = len(values), reach(frame_time)
    found = np.full(values.shape, np.nan)
    inner = slice(far, max(far, count - far))
    if inner.stop > far:
        squares = sum(step**2 for step in range(-far, far + 1))
        fourths = sum(step**4 for step in range(-far, far + 1))
        mean = squares / (2 * far + 1)
        total = np.zeros_like(values[inner])
        for step in range(1, far + 1):
            both = values[far + step : inner.stop + step] + values[far - step : inner.stop - step]
            total += (step * step - mean) * (both - 2 * values[inner])
        found[inner] = 2 * total / (fourths - squares * mean)
    return found / frame_time**2


def _has_all_neighbours(seen: Flags, far: int) -> Flags:
    """Return (n,) whether every row within the distance `far` is present, and the clip does not end on both sides."""
    count = len(seen)
    places = np.arange(count)
    open_ended = (places >= far) | (places < count - far)
    if seen.all():
        return open_ended
    counts = np.concatenate([[0], np.cumsum(seen)])
    low, high = np.maximum(places - far, 0), np.minimum(places + far + 1, count)
    whole: Flags = open_ended & (counts[high] - counts[low] == high - low)
    return whole


def _slopes_of_what_there_is(values: Array, seen: Flags, rows: NDArray[np.intp], far: int) -> Array:
    """(m, k) by Cramer's rule from the normal equations of a parabola, or of a line through two; of some rows (m,)."""
    steps = np.arange(-far, far + 1)
    places = rows[:, None] + steps
    inside = (places >= 0) & (places < len(values))
    places = np.clip(places, 0, len(values) - 1)
    there = inside & seen[places]
    # From the row's own value: sums of neighbours lose no digits.
    differences = np.where(there[..., None], values[places] - values[rows][:, None], 0.0)
    powers = steps[None, :].astype(np.float64) ** np.arange(5)[:, None]
    s0, s1, s2, s3, s4 = ((there * power).sum(axis=1)[:, None] for power in powers)
    t0, t1, t2 = ((differences * power[None, :, None]).sum(axis=1) for power in powers[:3])
    determinant = s0 * (s2 * s4 - s3 * s3) - s1 * (s1 * s4 - s2 * s3) + s2 * (s1 * s3 - s2 * s2)
    slope = s0 * (t1 * s4 - s3 * t2) - t0 * (s1 * s4 - s3 * s2) + s2 * (s1 * t2 - t1 * s2)
    line = (s0 * t1 - s1 * t0) / np.where(s0 == 2, s0 * s2 - s1 * s1, np.nan)
    found: Array = np.where(s0 > 2, slope / np.where(s0 > 2, determinant, 1.0), line)
    return found


def rate(values: Array, frame_time: float | None) -> Array:
    """(n,) change per second of any numbers (n,) of frames; NaN where unknown."""
    if frame_time is None:
        return np.full(len(values), np.nan)
    changes: Array = slopes(values[:, None], frame_time)[:, 0]
    return changes
