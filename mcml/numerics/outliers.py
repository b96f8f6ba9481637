"""Outliers by median and median absolute deviation.

Source: B. Iglewicz and D. C. Hoaglin, "How to Detect and Handle Outliers" (1993), the modified z-score.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

THRESHOLD: Final = 3.5
"""Modified z-scores beyond it are outliers."""
FEWEST: Final = 4
"""Values with scores: fewer have no spread to compare with."""
_NORMAL: Final = 1.4826
"""Standard deviations of a normal distribution in its median absolute deviation (1 / 0.6745)."""
_NORMAL_OF_MEAN: Final = 1.2533
"""The same in its mean absolute deviation, where more than half of the values are equal."""
_ROUNDING: Final = 1e-9
"""Of the greatest value: smaller deviations are rounding."""


def score_outliers(values: Array) -> Array:
    """Return the modified z-score of each of (n,) values: its distance from the median in robust standard deviations.

    NaN for unknown values, and for all of fewer than four known ones; 0 if all are equal.
    """
    scores = np.full(len(values), np.nan)
    is_known = np.isfinite(values)
    known = values[is_known]
    if len(known) < FEWEST:
        return scores
    off = known - np.median(known)
    off[np.abs(off) <= _ROUNDING * np.abs(known).max()] = 0.0
    spread = _NORMAL * np.median(np.abs(off)) or _NORMAL_OF_MEAN * np.abs(off).mean()
    scores[is_known] = off / spread if spread else 0.0
    return scores
