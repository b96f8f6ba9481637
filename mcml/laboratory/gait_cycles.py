"""Gait cycles: curves of any quantity from strike to strike, on one scale from 0 to 100 percent, and their mean.

Source: D. A. Winter, "The Biomechanics and Motor Control of Human Gait" (1991), chapter 1: time normalisation to the
stride, ensemble averages with standard deviations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml.numerics.runs import find_true

POINTS: Final = 101
"""Values of a cycle: 0, 1, … 100 percent."""
_MARGIN = 3
"""Frames on either side of a cycle that shape the spline at its ends, where they are measured."""


@dataclass(frozen=True, eq=False)
class Cycles:
    """Curves of strides. curves: (strides, 101). intervals: (first, last) seconds of each. gaps: number of strides that
    are left out, because a sample of theirs is missing."""

    curves: Array
    intervals: tuple[tuple[float, float], ...]
    gaps: int


@dataclass(frozen=True, eq=False)
class MeanCycle:
    """mean, sd: (101,) over strides, n - 1 in the denominator of the sd; NaN without enough strides. n: strides."""

    mean: Array
    sd: Array
    n: int


def normalise_cycles(values: Array, rate: float, intervals: Sequence[tuple[float, float]]) -> Cycles:
    """Resample a quantity within intervals of time by cubic splines.

    values: (n,) of each frame, NaN where not measured. rate: frames a second. intervals: (first, last) seconds from the
    first frame. Intervals with a gap, or outside of the frames, are left out whole and counted.
    """
    runs = find_true(np.asarray(np.isfinite(values)))
    curves: list[Array] = []
    kept: list[tuple[float, float]] = []
    for begin, end in intervals:
        low, high = int(np.floor(begin * rate + 1e-9)), int(np.ceil(end * rate - 1e-9))
        run = int(np.searchsorted(runs[:, 0], low, side="right")) - 1
        if run < 0 or high >= runs[run, 1] or high - low < 2:
            continue
        frames = np.arange(max(runs[run, 0], low - _MARGIN), min(runs[run, 1], high + 1 + _MARGIN))
        spline = scipy.interpolate.CubicSpline(frames, values[frames])
        curves.append(spline(np.linspace(begin, end, POINTS) * rate))
        kept.append((begin, end))
    stacked = np.stack(curves) if curves else np.empty((0, POINTS))
    return Cycles(stacked, tuple(kept), len(intervals) - len(kept))


def mean_cycle(curves: Array, is_kept: NDArray[np.bool_] | None = None) -> MeanCycle:
    """Return the mean and standard deviation of cycles (strides, 101). is_kept: (strides,) which of them count."""
    some = curves if is_kept is None else curves[is_kept]
    unknown = np.full(POINTS, np.nan)
    mean = some.mean(axis=0) if len(some) else unknown
    sd = some.std(axis=0, ddof=1) if len(some) > 1 else unknown
    return MeanCycle(mean, sd, len(some))
