"""Curves of frame ranges: figures of their samples, values at 0 to 100 % of a range, and means of many ranges."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

POINTS: Final = 101
"""Values of a normalised curve: 0, 1, … 100 percent."""


@dataclass(frozen=True)
class Figures:
    """Figures of the known samples of a range, in their unit.

    sd: with n - 1 in the denominator, NaN for one sample. place: index of the first greatest sample. missing: number
    of unknown samples.
    """

    minimum: float
    maximum: float
    mean: float
    sd: float
    place: int
    missing: int

    @property
    def range(self) -> float:
        """From the least to the greatest sample."""
        return self.maximum - self.minimum


def summarise_samples(values: Array) -> Figures | None:
    """Summarise (n,) samples, NaN where unknown. None if no sample is known."""
    is_known = np.isfinite(values)
    known = values[is_known]
    if not len(known):
        return None
    place = int(np.flatnonzero(is_known)[np.argmax(known)])
    sd = float(known.std(ddof=1)) if len(known) > 1 else float("nan")
    missing = len(values) - len(known)
    return Figures(float(known.min()), float(known.max()), float(known.mean()), sd, place, missing)


def normalise_range(values: Array, begin: float, end: float) -> Array:
    """Return (101,) values at even steps from `begin` to `end`, by linear interpolation.

    values: (n,) of frames. begin, end: places among these from 0; they may be between frames. A value next to an
    unknown sample is NaN: gaps are not bridged.

    >>> normalise_range(np.array([0.0, 10.0, 20.0]), 0, 2)[[0, 25, 100]].tolist()
    [0.0, 5.0, 20.0]
    """
    places = np.linspace(begin, end, POINTS)
    low = np.clip(np.floor(places).astype(np.intp), 0, len(values) - 1)
    high = np.minimum(low + 1, len(values) - 1)
    share = places - low
    between = values[low] + share * (values[high] - values[low])
    curve: Array = np.where(share == 0.0, values[low], between)
    return curve


@dataclass(eq=False)
class CurveSums:
    """The running mean and spread of curves, one point at a time; unknown values do not count.

    Source: B. P. Welford, "Note on a method for calculating corrected sums of squares and products" (1962).
    """

    count: NDArray[np.int64] = field(default_factory=lambda: np.zeros(POINTS, np.int64))
    _mean: Array = field(default_factory=lambda: np.zeros(POINTS))
    _squares: Array = field(default_factory=lambda: np.zeros(POINTS))

    def add(self, curve: Array) -> None:
        """Count a curve (101,)."""
        is_known = np.isfinite(curve)
        self.count += is_known
        step = np.where(is_known, curve - self._mean, 0.0)
        self._mean += step / np.maximum(self.count, 1)
        self._squares += step * np.where(is_known, curve - self._mean, 0.0)

    @property
    def mean(self) -> Array:
        """(101,) mean, NaN where no value is known."""
        return np.where(self.count > 0, self._mean, np.nan)

    @property
    def sd(self) -> Array:
        """(101,) standard deviation (n - 1), NaN where fewer than two values are known."""
        return np.where(self.count > 1, np.sqrt(self._squares / np.maximum(self.count - 1, 1)), np.nan)
