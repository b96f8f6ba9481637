"""How far a request is from the examples: hull, neighbours, gaps, weights."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.skeleton import Array

TOUCHING = 1e-7


def nearest_in_hull(points: Array, x: Array) -> Array:
    """The point (d,) of the convex hull of points (n, d) that is nearest to x (d,).

    With Z the points seen from x: least squares of [Z; 1 ... 1] l = [0; 1] under l >= 0, over the sum of l. Along a ray
    l = t u with sum u = 1 the least value is |Z u|^2 / (1 + |Z u|^2), which grows with |Z u|. Lawson and Hanson
    (1974), least distance programming. x is in the hull where this point is x, the same as feasibility of
    x = sum l_j x_j, l >= 0, sum l = 1.
    """
    seen = (points - x).T
    size = float(np.abs(seen).max(initial=0.0)) or 1.0
    weights, _ = scipy.optimize.nnls(np.vstack([seen / size, np.ones(len(points))]), np.append(np.zeros(len(x)), 1.0))
    nearest: Array = points.T @ (weights / weights.sum())
    return nearest


def most_influential(weights: Array, count: int = 10) -> NDArray[np.intp]:
    """The places of the weights (n,) that are largest in magnitude, largest first; of equals the first."""
    return np.argsort(-np.abs(weights), kind="stable")[:count]
