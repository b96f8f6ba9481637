"""Clips of any length read at the same number of instants, their phases matched; and the way back for playback.

Knots are sample numbers (c1, c2, end); a clip has end + 1 samples, from 0.
"""

from __future__ import annotations

import numpy as np

from mcml.motion.rotations import slerp
from mcml.motion.skeleton import Array

Knots = tuple[int, int, int]

PAPER_KNOTS: Knots = (5, 28, 49)
"""6, 29 and 50 counted from 1."""


def mean_knots(times: Array) -> Knots:
    """Rounded means of phase times (N, 3), made to differ by at least one sample."""
    c1, c2, end = (round(float(mean)) for mean in np.mean(times, axis=0))
    c1 = max(c1, 1)
    c2 = max(c2, c1 + 1)
    return c1, c2, max(end, c2 + 1)


def instants(knots: Knots, times: Array | tuple[float, float, float]) -> Array:
    """When to read a clip for each sample, (end + 1,), in the unit of its phase times (t1, t2, end)."""
    read: Array = np.interp(np.arange(knots[2] + 1), [0, *knots], [0.0, *times])
    return read


def positions(knots: Knots, times: Array | tuple[float, float, float], time: Array, *, legacy: bool = False) -> Array:
    """Which sample to show at each time (...,): the inverse of `instants`, continuous.

    legacy: the printed map, whose second and third pieces begin one sample late: samples c1 and c1 + 1 share an
    instant, and c2 and c2 + 1, so that playback leaps over one at both.
    """
    t1, t2, end = (float(value) for value in times)
    if not legacy:
        shown: Array = np.interp(time, [0.0, t1, t2, end], [0, *knots])
        return shown
    c1, c2, last = knots
    pieces = [
        np.interp(time, [0.0, t1], [0, c1]),
        np.interp(time, [t1, t2], [c1 + 1, c2]),
        np.interp(time, [t2, end], [c2 + 1, last]),
    ]
    return np.choose(np.searchsorted([t1, t2], time, side="left"), pieces)


def read_rotations(rotations: Array, at: Array) -> Array:
    """Rotations (n, J, 4) of a track (F, J, 4) at fractional frames (n,), on the arcs between frames."""
    before, share = _between(len(rotations), at)
    after = np.minimum(before + 1, len(rotations) - 1)
    return slerp(rotations[before], rotations[after], np.broadcast_to(share[:, None], (len(at), rotations.shape[1])))


def read_values(values: Array, at: Array) -> Array:
    """Values (n, C) of a track (F, C) at fractional frames (n,), on the lines between frames."""
    before, share = _between(len(values), at)
    after = np.minimum(before + 1, len(values) - 1)
    read: Array = values[before] + share[:, None] * (values[after] - values[before])
    return read


def _between(count: int, at: Array) -> tuple[np.ndarray[tuple[int], np.dtype[np.intp]], Array]:
    inside = np.clip(at, 0.0, count - 1.0)
    before = np.minimum(inside.astype(np.intp), count - 1)
    return before, inside - before
