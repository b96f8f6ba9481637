"""Paths on the ground, and the next goals of a body that follows one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcml.motion.matching.library import AHEAD
from mcml.motion.matching.tracks import RATE
from mcml.motion.skeleton import Array

_LOOK = 2.0
"""Metres of the path ahead in which the nearest place is looked for: a path may cross itself."""
_SPACING = 0.02
"""Metres between the places of a path that are compared."""
_CORNER = 0.25
"""Metres over which corners are rounded: a body cannot turn at once."""


@dataclass(frozen=True)
class Path:
    """places: (n, 2) evenly spaced, in metres. directions: (n,) radians of its course. ways: (n,) metres so far."""

    places: Array
    directions: Array
    ways: Array

    @staticmethod
    def through(points: Array) -> Path:
        """The path along lines between points (k, 2), with rounded corners. ValueError where it has no length."""
        lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
        kept = np.concatenate([[True], lengths > 0])
        points, lengths = points[kept], lengths[lengths > 0]
        if not len(lengths):
            raise ValueError("a path needs two places")
        ways = np.concatenate([[0.0], np.cumsum(lengths)])
        even = np.linspace(0.0, ways[-1], max(2, round(ways[-1] / _SPACING) + 1))
        places = np.stack([np.interp(even, ways, column) for column in points.T], axis=1)
        places = _rounded(places, round(_CORNER / _SPACING))
        steps = np.diff(places, axis=0)
        ways = np.concatenate([[0.0], np.cumsum(np.linalg.norm(steps, axis=1))])
        courses = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
        return Path(places, np.append(courses, courses[-1]), ways)

    @property
    def length(self) -> float:
        return float(self.ways[-1])

    def at(self, way: Array) -> tuple[Array, Array]:
        """Places (k, 2) and directions (k,) after ways (k,) in metres; those of its ends beyond them."""
        places = np.stack([np.interp(way, self.ways, column) for column in self.places.T], axis=1)
        return places, np.interp(way, self.ways, self.directions)

    def progress(self, place: Array, way: float) -> tuple[float, float]:
        """The way to the place of the path nearest to a place (2,), not before `way`, and the distance to it."""
        first, end = np.searchsorted(self.ways, [way, way + _LOOK])
        first = min(int(first), len(self.ways) - 1)
        apart = np.linalg.norm(self.places[first : int(end) + 1] - place, axis=1)
        nearest = int(np.argmin(apart))
        return max(way, float(self.ways[first + nearest])), float(apart[nearest])


@dataclass(frozen=True)
class Wish:
    """The goals of a body at `AHEAD`: places (3, 2) in metres, directions (3,) in radians, on the ground."""

    places: Array
    directions: Array


def wish_along(path: Path, way: float, speed: float, facing: float) -> Wish:
    """Go on along a path from a way, at a speed in metres a second, facing so many radians from its course."""
    places, directions = path.at(way + speed * np.array(AHEAD))
    return Wish(places, directions + facing)


def _rounded(places: Array, window: int) -> Array:
    """Means over windows around each place, smaller ones near the ends, which stay."""
    if window < 1 or len(places) < 3:
        return places
    sums = np.concatenate([np.zeros((1, 2)), np.cumsum(places, axis=0)])
    index = np.arange(len(places))
    half = np.minimum(np.minimum(index, len(places) - 1 - index), window)
    means: Array = (sums[index + half + 1] - sums[index - half]) / (2 * half + 1)[:, None]
    return means


def steps_for(path: Path, speed: float, slack: float) -> int:
    """Rows in which a path must be walked, so many times those that its speed asks for, and ten seconds."""
    return int((slack * path.length / speed + 10.0) * RATE)
