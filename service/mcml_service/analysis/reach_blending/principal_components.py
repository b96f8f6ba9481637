"""Principal components: centre, thin singular value decomposition, a sign that does not depend on the library."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from mcml.motion.skeleton import Array


@dataclass(frozen=True)
class Components:
    """mean: (D,). basis: (K, D) orthonormal rows. coefficients: (n, K). variances: (r,) all that exist, descending."""

    mean: Array
    basis: Array
    coefficients: Array
    variances: Array

    def cumulative(self) -> Array:
        """(r,) share of the variance that the first 1, 2, … components hold."""
        total = float(self.variances.sum())
        return np.cumsum(self.variances) / total if total > 0 else np.ones(len(self.variances))


def principal_components(
    data: Array, count: int, variance: float | None = None, *, fix_signs: bool = True, in_place: bool = False
) -> Components:
    """Return the first components of rows (n, D).

    count: maximum number. variance: instead, as many as explain this share. At most min(n - 1, D) exist. Variances are
    S^2 / n. The largest entry of each component is positive; without fix_signs it has the sign from the library.
    in_place: the rows may be overwritten, which saves a copy.
    """
    mean = data.mean(axis=0)
    centred = np.subtract(data, mean, out=data if in_place else None)
    # Transposed, rows in C order are columns in Fortran's, which LAPACK takes without a copy.
    right, sizes, left = scipy.linalg.svd(centred.T, full_matrices=False, overwrite_a=True, check_finite=False)
    right, left = right.T, left.T
    existing = max(min(len(data) - 1, data.shape[1]), 0)
    variances = sizes[:existing] ** 2 / len(data)
    kept = min(count, existing)
    if variance is not None:
        shares = np.cumsum(variances) / max(float(variances.sum()), np.finfo(float).tiny)
        kept = min(int(np.searchsorted(shares, variance - 1e-12)) + 1, existing)
    signs = signs_of(right[:kept]) if fix_signs else np.ones(kept)
    return Components(mean, right[:kept] * signs[:, None], left[:, :kept] * (sizes[:kept] * signs), variances)


def signs_of(rows: Array) -> Array:
    """(k,) the sign that makes the entry of largest magnitude of each row (k, D) positive."""
    largest = np.argmax(np.abs(rows), axis=1)
    return np.where(np.take_along_axis(rows, largest[:, None], axis=1)[:, 0] < 0, -1.0, 1.0)
