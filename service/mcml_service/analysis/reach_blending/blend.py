"""A Gaussian radial basis with a polynomial, fitted through or near scattered examples, and its prediction of each
example from the others.

y(x) = sum_j e_j exp(-|x - x_j|^2 / s^2) + c0 + C x, with sum_j e_j = 0 and sum_j e_j x_j^T = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.skeleton import Array

WIDTHS = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
"""Of the mean distance to the nearest example."""
RIDGES = (0.0, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0)
SUSPECT, SINGULAR = 1e12, 1e14

Groups = Sequence[NDArray[np.intp]]


@dataclass(frozen=True)
class Blend:
    """centres: (n, d). s: width. lam: ridge. radial: (n, K), the e. polynomial: (m, K), the c. degree: 0 or 1."""

    centres: Array
    s: float
    lam: float
    radial: Array
    polynomial: Array
    degree: int

    def __call__(self, x: Array) -> Array:
        """Values (q, K) at x (q, d)."""
        values: Array = kernel(x, self.centres, self.s) @ self.radial + terms(x, self.degree) @ self.polynomial
        return values


def terms(x: Array, degree: int) -> Array:
    """The polynomial's terms (n, m): 1, and for degree 1 the coordinates."""
    return np.concatenate([np.ones((len(x), 1)), x], axis=1) if degree else np.ones((len(x), 1))


def square_distances(first: Array, second: Array) -> Array:
    """(n, m) of points (n, d) and (m, d)."""
    total = np.zeros((len(first), len(second)))
    for axis in range(first.shape[1]):
        total += (first[:, axis, None] - second[None, :, axis]) ** 2
    return total


def kernel(first: Array, second: Array, s: float) -> Array:
    """(n, m): exp(-|x - x'|^2 / s^2)."""
    values: Array = np.exp(-square_distances(first, second) / s**2)
    return values


def saddle(x: Array, s: float, lam: float, degree: int) -> Array:
    """[[A + lam I, P], [P^T, 0]] of centres (n, d)."""
    p = terms(x, degree)
    count, extra = p.shape
    matrix = np.zeros((count + extra, count + extra))
    matrix[:count, :count] = kernel(x, x, s)
    matrix[np.arange(count), np.arange(count)] += lam
    matrix[:count, count:] = p
    matrix[count:, :count] = p.T
    return matrix


def fit_blend(x: Array, y: Array, s: float, lam: float, degree: int = 1) -> Blend:
    """The blend of values (n, K) at centres (n, d), all columns by one factorisation."""
    right = np.concatenate([y, np.zeros((terms(x[:1], degree).shape[1], y.shape[1]))])
    solved = scipy.linalg.lu_solve(scipy.linalg.lu_factor(saddle(x, s, lam, degree)), right)
    return Blend(x, s, lam, solved[: len(x)], solved[len(x) :], degree)


@dataclass(frozen=True)
class Inverse:
    """The inverse of a saddle matrix.

    block: (n, n), its upper left. cardinal: (n, n + m), its first n rows: times [phi(x); P(x)] the weights of the
    examples at x. condition: of the saddle matrix in the 1-norm.
    """

    cardinal: Array
    condition: float

    @property
    def block(self) -> Array:
        return self.cardinal[:, : len(self.cardinal)]


def invert(x: Array, s: float, lam: float, degree: int) -> Inverse:
    """The inverse for centres (n, d); an infinite condition, and no numbers, if there is none."""
    matrix = saddle(x, s, lam, degree)
    try:
        # numpy's: scipy's warns of every ill-conditioned matrix, and the condition is checked anyway.
        inverse = np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        return Inverse(np.full((len(x), len(matrix)), np.nan), np.inf)
    condition = float(np.abs(matrix).sum(axis=0).max() * np.abs(inverse).sum(axis=0).max())
    return Inverse(np.asarray(inverse[: len(x)], dtype=np.float64), condition if np.isfinite(condition) else np.inf)


def nearest_distances(x: Array) -> Array:
    """(n,) distance of each point (n, d) to the nearest other one."""
    squares = square_distances(x, x)
    np.fill_diagonal(squares, np.inf)
    distances: Array = np.sqrt(squares.min(axis=1).astype(np.float64))
    return distances


def groups_of(labels: Sequence[object]) -> Groups:
    """Rows with equal labels, groups in the order of their first row."""
    places: dict[object, list[int]] = {}
    for row, label in enumerate(labels):
        places.setdefault(label, []).append(row)
    return [np.array(rows, dtype=np.intp) for rows in places.values()]


def leavable(x: Array, degree: int, groups: Groups) -> Groups:
    """The groups without which the polynomial of the others is still determined."""
    q, r = np.linalg.qr(terms(x, degree))
    if np.abs(np.diag(r)).min() < 1e-10 * np.abs(np.diag(r)).max():
        return []
    # I - Q_S Q_S^T is singular exactly where leaving S out loses a column.
    return [rows for rows in groups if np.linalg.norm(q[rows], 2) ** 2 < 1 - 1e-9]


def leave_out(inverse: Inverse, y: Array, groups: Groups) -> Array:
    """Return the prediction of each group by a blend of the others, (n, K); NaN for rows without a group.

    y_S - f_(-S)(x_S) = (B_SS)^-1 e_S, with B the block of the inverse saddle matrix and e = B y: no fit is repeated.
    """
    block = inverse.block
    radial = block @ y
    predicted = np.full(y.shape, np.nan)
    for rows in groups:
        missed: Array
        if len(rows) == 1:
            missed = radial[rows] / block[rows, rows][:, None]
        else:
            missed = np.linalg.solve(block[np.ix_(rows, rows)], radial[rows]).astype(np.float64)
        predicted[rows] = y[rows] - missed
    return predicted


def linear_left_out(x: Array, y: Array, degree: int, groups: Groups) -> Array:
    """Return the prediction of each group by the polynomial alone, fitted to the others by least squares, (n, K)."""
    q, _ = np.linalg.qr(terms(x, degree))
    residual = y - q @ (q.T @ y)
    predicted = np.full(y.shape, np.nan)
    for rows in groups:
        hat = q[rows] @ q[rows].T
        predicted[rows] = y[rows] - np.linalg.solve(np.eye(len(rows)) - hat, residual[rows])
    return predicted


def nearest_left_out(x: Array, y: Array, groups: Groups) -> Array:
    """The values of the nearest example that is not in the group, (n, K); the first one of equally near ones."""
    squares = square_distances(x, x)
    predicted = np.full(y.shape, np.nan)
    for rows in groups:
        others = np.setdiff1d(np.arange(len(x)), rows)
        if len(others):
            predicted[rows] = y[others[np.argmin(squares[np.ix_(rows, others)], axis=1)]]
    return predicted


@dataclass(frozen=True)
class Choice:
    """s, lam with the least error of those tried. tried: (s, lam, condition, error); the error infinite if skipped."""

    s: float
    lam: float
    error: float
    tried: tuple[tuple[float, float, float, float], ...]


def choose(
    x: Array,
    values: Sequence[Array],
    errors: Sequence[Callable[[Array], float]],
    widths: Sequence[float],
    ridges: Sequence[float],
    degree: int,
    groups: Groups,
) -> list[Choice | None]:
    """For each of several sets of values (n, K) the width and ridge that predict left-out groups best.

    errors: of predictions (n, K), NaN rows included. widths, ridges: to try, in this order; the first of equals wins.
    Ill-conditioned ones (above 1e14) are skipped; None where all are.
    """
    tried: list[list[tuple[float, float, float, float]]] = [[] for _ in values]
    for s in widths:
        for lam in ridges:
            inverse = invert(x, s, lam, degree)
            for table, y, error in zip(tried, values, errors, strict=True):
                usable = inverse.condition <= SINGULAR
                residual = error(leave_out(inverse, y, groups)) if usable else np.inf
                table.append((s, lam, inverse.condition, residual))
    chosen: list[Choice | None] = []
    for table in tried:
        best = min(table, key=lambda row: row[3])
        chosen.append(Choice(best[0], best[1], best[3], tuple(table)) if np.isfinite(best[3]) else None)
    return chosen
