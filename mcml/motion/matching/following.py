"""A body follows a path by frames of a library: which ones, and where on the ground each of them is placed."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mcml.motion.matching.library import WAY, MatchingLibrary, turn, way_of
from mcml.motion.matching.paths import Path, Wish, steps_for, wish_along
from mcml.motion.skeleton import Array

SEARCH_EVERY = 6
"""Rows between searches: 0.2 s."""
SHORTEST = 9
"""Rows of a run before a cut: as long as a transition of 0.3 s."""
MEMORY = 30
"""Rows that were played last, to which no cut leads: a body must not repeat half a step."""
SAME = 6
"""Rows: a frame that near to the present one in its clip is no other."""
BETTER = 0.95
"""Of the distance of going on: a cut leads only to rows that are nearer than this."""
_SLACK = 3.0
"""Of the time that the speed asks for: a body that has not come to the end by then ends there."""
_ARRIVED = 0.1
"""Metres before the end of a path at which it is reached."""
_NEAR, _STANDS, _STILL = 0.75, 0.1, 0.15
"""A body within metres of the end that moves slower (m/s), and is to move slower (m between looks), has come."""


@dataclass(frozen=True)
class Run:
    """Rows first to last of a clip (from 0 in it, both included) that are played at a turn (radians) and a shift (2,).

    A place p of the clip on the ground is at turn(p) + shift.
    """

    clip: int
    first: int
    last: int
    angle: float
    shift: Array


@dataclass(frozen=True)
class Followed:
    """runs: in order. places: (n, 2) of the root, at the rate of tracks. distances: (n,) metres to the path.

    way: metres of the path that were covered; complete: whether its end was reached.
    """

    runs: tuple[Run, ...]
    places: Array
    distances: Array
    way: float
    complete: bool


def follow(
    library: MatchingLibrary,
    path: Path,
    *,
    speed: float,
    facing: float = 0.0,
    steering: float = np.radians(10.0),
    most_runs: int = 1000,
    check: Callable[[], None] = lambda: None,
) -> Followed:
    """Follow a path from its start.

    speed: metres a second. facing: radians from the course of the path. steering: radians by which the body is turned
    towards its goal at each cut, at most. check: called often; it may raise. It ends at the end of the path, in three
    times the time that the speed asks for, or at `most_runs`.
    """
    start, direction = path.at(np.zeros(1))
    body = _Body(library, start[0], float(direction[0]) + facing, steering)
    body.begin(wish_along(path, 0.0, speed, facing))
    way, places, distances = 0.0, [], []
    complete = False
    for step in range(steps_for(path, speed, _SLACK)):
        way, distance = path.progress(body.place, way)
        places.append(body.place)
        distances.append(distance)
        complete = way >= path.length - _ARRIVED or (path.length - way < _NEAR and body.speed < _STANDS)
        if complete or len(body.runs) >= most_runs:
            break
        if step % SEARCH_EVERY == 0 or body.at_end:
            check()
            body.choose(wish_along(path, way, speed, facing))
        body.advance()
    return Followed(tuple(body.finish()), np.array(places), np.array(distances), way, complete)


class _Body:
    """A body on the ground that plays rows of a library."""

    def __init__(self, library: MatchingLibrary, place: Array, facing: float, steering: float) -> None:
        self._library, self._steering = library, steering
        self.place, self.facing = place, facing
        self.row, self._since = -1, 0
        self._played: deque[int] = deque(maxlen=MEMORY)
        self.runs: list[tuple[int, int, float, Array]] = []
        """(first row, last row, angle, shift) of runs that ended."""
        self._angle, self._shift, self._first = 0.0, np.zeros(2), 0

    @property
    def at_end(self) -> bool:
        """Whether the clip has no further row."""
        return self.row + 1 >= int(self._library.starts[self._library.clip_of(self.row) + 1])

    @property
    def speed(self) -> float:
        """Metres a second of the root."""
        features = self._library.features[self.row] / self._library.scales
        return float(np.linalg.norm(features[24:26]))

    def begin(self, wish: Wish) -> None:
        self._cut(self._library.nearest_way(self._way(wish)), wish)
        self._first = self.row
        self._played.append(self.row)

    def choose(self, wish: Wish) -> None:
        """Go on, or cut to the row that continues better."""
        library, forced = self._library, self.at_end
        if not forced and self._since < SHORTEST:
            return
        present = library.features[self.row].astype(np.float64)
        way = self._way(wish)
        query = np.where(np.isnan(present), 0.0, present)
        query[WAY] = way
        row, distance = library.nearest(query, self._played)
        if not forced:
            going_on = float(np.linalg.norm(present - query)) if not np.isnan(present).any() else np.inf
            same = library.clip_of(row) == library.clip_of(self.row) and abs(row - self.row) <= SAME
            if same or not distance < BETTER * going_on:
                return
        self._cut(row, wish)

    def advance(self) -> None:
        self.row += 1
        self._since += 1
        self._played.append(self.row)
        self._stand()

    def finish(self) -> list[Run]:
        self._close()
        found = []
        for first, last, angle, shift in self.runs:
            clip = self._library.clip_of(first)
            start = int(self._library.starts[clip])
            found.append(Run(clip, first - start, last - start, angle, shift))
        return found

    def _way(self, wish: Wish) -> Array:
        places = turn(wish.places - self.place, -self.facing)
        return way_of(places, wish.directions - self.facing, self._library.scales)

    def _cut(self, row: int, wish: Wish) -> None:
        if self.row >= 0:
            self._close()
        # The row itself stands for the moment of the cut, which was shown already: the next one is the first.
        library = self._library
        ahead = (library.features[row, :6] / library.scales[:6]).reshape(3, 2).astype(np.float64)
        wanted = turn(wish.places - self.place, -self.facing)
        # The turn about the body that brings the places ahead nearest to the wanted ones, and the directions.
        cosines = library.features[row, 6:12].reshape(3, 2).astype(np.float64) / library.scales[6:12].reshape(3, 2)
        directions = np.stack([np.cos(wish.directions - self.facing), np.sin(wish.directions - self.facing)], axis=1)
        one, two = np.concatenate([ahead, cosines]), np.concatenate([wanted, directions])
        off = np.arctan2((one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]).sum(), (one * two).sum())
        self.facing += float(np.clip(off, -self._steering, self._steering))
        self._angle = self.facing - float(library.facing[row])
        self._shift = self.place - turn(library.place[row], self._angle)
        self.row, self._first, self._since = row, row + 1, 0

    def _close(self) -> None:
        self.runs.append((self._first, self.row, self._angle, self._shift))

    def _stand(self) -> None:
        self.facing = self._angle + float(self._library.facing[self.row])
        self.place = turn(self._library.place[self.row], self._angle) + self._shift
