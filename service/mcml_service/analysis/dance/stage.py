"""A stage: how far a dance leaves it, and turns of the dancer that keep the dance on it.

Points of the floor are complex numbers x + i z, metres; the middle of the stage is 0. A turn of theta about Y
multiplies a step by exp(-i theta), as in `blend.place_roots`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.rotations import multiply
from mcml.motion.skeleton import Array

Points = NDArray[np.complex128]
Indices = NDArray[np.intp]
INSIDE = 0.95
"""Part of the stage that turns aim for, so that its edge is kept."""
POINTS_A_BAR = 24
"""Points of a bar at which turns are fitted."""
ROUNDS = 400
NEAR = 0.5
"""Metres between the roots of two dancers below which they touch."""
CLEAR = 0.8
"""Metres between roots that a path aims for, so that its motion keeps `NEAR`."""
_ASIDE = (0.0, 0.5, -0.5)
"""Turns, in the most of them, added to those to begin with: on a straight way out both sides are alike."""
_STILL = 1e-3
"""Cost of turning by the most, in square metres, against that of distance outside."""


@dataclass(frozen=True)
class Stage:
    """A circle (radius) or a rectangle (width along X, depth along Z) about 0, metres."""

    radius: float | None = None
    width: float = 0.0
    depth: float = 0.0

    def beyond(self, points: Points, part: float = 1.0) -> Points:
        """Vectors from the nearest point of the stage, or of a part of its size, to each point; 0 inside."""
        if self.radius is not None:
            distances = np.abs(points)
            outside = np.maximum(distances - part * self.radius, 0.0)
            circle: Points = points * (outside / np.where(distances > 0, distances, 1.0))
            return circle
        across, along = part * self.width / 2, part * self.depth / 2
        excess: Points = (points.real - np.clip(points.real, -across, across)) + 1j * (
            points.imag - np.clip(points.imag, -along, along)
        )
        return excess

    def outside(self, points: Points) -> Array:
        """Distances of points from the stage; 0 inside."""
        distances: Array = np.abs(self.beyond(points))
        return distances

    @property
    def text(self) -> str:
        """Its size in words."""
        if self.radius is not None:
            return f"a circle of {self.radius:g} m radius"
        return f"a rectangle of {self.width:g} m by {self.depth:g} m"


@dataclass(frozen=True)
class Shares:
    """bars: (F,) bar of each frame. shares: (F,) of the turn of this bar that is done, from 0 to 1, even at both."""

    bars: Indices
    shares: Array


def ease(part: Array) -> Array:
    """Smooth steps from 0 to 1, level at both ends.

    >>> ease(np.array([0.0, 0.5, 1.0])).tolist()
    [0.0, 0.5, 1.0]
    """
    eased: Array = part * part * (3 - 2 * part)
    return eased


def find_shares(grid: Array, frames: int, fps: float) -> Shares:
    """Return bar and share of each frame. grid: (4 M + 1,) motion beats; a bar plays from the beat before its first."""
    time = np.arange(frames) / fps
    edges = np.concatenate([grid[:1], grid[3:-1:4][: len(grid) // 4 - 1], grid[-1:]])
    bars = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, len(edges) - 2)
    part = np.clip((time - edges[bars]) / (edges[bars + 1] - edges[bars]), 0.0, 1.0)
    return Shares(bars, ease(part))


def spread_turns(turns: Array, shares: Shares) -> Array:
    """(F,) the turn at each frame: whole turns of earlier bars and the share of this one's. turns: (M,), radians."""
    before = np.concatenate([[0.0], np.cumsum(turns)[:-1]])
    angles: Array = before[shares.bars] + turns[shares.bars] * shares.shares
    return angles


def bend(track: Points, angles: Array) -> Points:
    """The track of a dancer with turns by angles (F,) more, radians: each step from the middle of its turn. (F,)."""
    middle = (angles[1:] + angles[:-1]) / 2
    bent: Points = track[0] + np.concatenate([[0.0], np.cumsum(np.exp(-1j * middle) * np.diff(track))])
    return bent


def bend_motion(
    translations: Array, rotations: Array, roots: Indices, angles: Array, start: complex
) -> tuple[Array, Array]:
    """The motion turned about the first root by angles (F,), which starts at a point of the floor in the clip's unit.

    translations: (F, J, 3), rotations: (F, J, 4), Y up. Heights stay.
    """
    moved, turned = translations.copy(), rotations.copy()
    track = translations[:, roots[0], 0] + 1j * translations[:, roots[0], 2]
    bent = bend(track, angles) - track[0] + start
    spin = np.exp(-1j * angles)
    turn = np.zeros((len(angles), 4))
    turn[:, 1], turn[:, 3] = np.sin(angles / 2), np.cos(angles / 2)
    for root in roots.tolist():
        away = translations[:, root, 0] + 1j * translations[:, root, 2] - track
        place = bent + spin * away
        moved[:, root, 0], moved[:, root, 2] = place.real, place.imag
        turned[:, root] = multiply(turn, rotations[:, root])
    return moved, turned


def crowd(points: Points, others: Points, clear: float = CLEAR) -> Points:
    """Vectors to points from the nearest places that are `clear` metres away from others; 0 if they are further."""
    between = points - others
    distances = np.abs(between)
    ahead = np.where(distances > 0, between / np.where(distances > 0, distances, 1.0), 1.0)
    pushed: Points = ahead * np.minimum(distances - clear, 0.0)
    return pushed


def fit_turns(
    track: Points, shares: Shares, stage: Stage, first: Array, most: float, others: Points | None = None
) -> Array:
    """Turns (M,) of each bar that keep a track (F,) on a stage and away from others (N, F), as far as possible.

    first: (M,) turns to begin with. most: radians a bar. The sum of squared distances outside is least (L-BFGS-B; its
    gradient by one pass forwards and one backwards). O(rounds * bars).
    """
    company = np.zeros((0, len(track)), dtype=np.complex128) if others is None else others

    def miss(turns: Array) -> float:
        way = bend(track, spread_turns(turns, shares))
        near = np.abs(crowd(way, company, (NEAR + CLEAR) / 2)).max(initial=0.0)
        return max(float(stage.outside(way).max()), float(near))

    if most <= 0 or not miss(first):
        return first
    step = max(1, len(track) // (POINTS_A_BAR * len(first)))
    chosen = np.unique(np.append(np.arange(0, len(track), step), len(track) - 1))
    thin, own = track[chosen], Shares(shares.bars[chosen], shares.shares[chosen])
    steps, beside = np.diff(thin), company[:, chosen]
    count = len(first)

    def cost(turns: Array) -> tuple[float, Array]:
        angles = spread_turns(turns, own)
        way = np.exp(-0.5j * (angles[1:] + angles[:-1])) * steps
        places = thin[0] + np.concatenate([[0.0], np.cumsum(way)])
        misses = np.concatenate([stage.beyond(places, INSIDE)[None], crowd(places, beside)])
        rest = np.cumsum(misses.sum(axis=0)[:0:-1])[::-1]
        # Of the cost by the middle of each step's turn; half of it belongs to the angle at either end.
        slopes = 2 * (np.conj(rest) * (-1j * way)).real / len(thin)
        at = np.concatenate([slopes, [0.0]]) / 2 + np.concatenate([[0.0], slopes]) / 2
        whole = np.bincount(own.bars, at, count)
        later = np.cumsum(whole[::-1])[::-1] - whole
        gradient = later + np.bincount(own.bars, at * own.shares, count) + 2 * _STILL * turns / (count * most**2)
        value = float((np.abs(misses) ** 2).sum() / len(thin) + _STILL * (turns**2).sum() / (count * most**2))
        return value, gradient

    tried = [first]
    for aside in _ASIDE:
        fit = scipy.optimize.minimize(
            cost,
            np.clip(first + aside * most, -most, most),
            jac=True,
            method="L-BFGS-B",
            bounds=[(-most, most)] * count,
            options={"maxiter": ROUNDS},
        )
        tried.append(np.clip(fit.x, -most, most))
    return tried[int(np.argmin(np.round([miss(turns) for turns in tried], 9)))]
