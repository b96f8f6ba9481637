"""Nearest points of many."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.skeleton import Array


def nearest(points: Array, asked: Array, count: int = 1) -> tuple[Array, NDArray[np.intp]]:
    """Distances and numbers, (q, count), of the points nearest to the given ones. points: (n, p). asked: (q, p)."""
    apart, which = scipy.spatial.cKDTree(points).query(asked, k=[*range(1, min(count, len(points)) + 1)])
    return np.asarray(apart, dtype=float), np.asarray(which, dtype=np.intp)
