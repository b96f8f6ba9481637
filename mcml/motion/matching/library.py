"""Frames of many clips as one library in which the best continuation is found.

A feature of a frame says where the body was led and how it stood: the way of the root ahead and where it faces then,
places and velocities of the feet, velocity of the hips, all seen from the root (Clavet, "Motion matching and the road
to next-gen animation", GDC 2016; Holden et al., "Learned motion matching", 2020, section 3).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.frames import Rows
from mcml.motion.hub_writer import Flags
from mcml.motion.matching.tracks import RATE, Track
from mcml.motion.skeleton import Array

AHEAD = (1 / 3, 2 / 3, 1.0)
"""Seconds at which the way is looked at."""
ROWS_AHEAD = tuple(round(seconds * RATE) for seconds in AHEAD)
TAIL = 10
"""Rows at the end of a clip to which no cut leads: a transition needs some frames."""
NEAREST = 64
"""Rows among which one that is not avoided is looked for."""
GROUPS = {
    "places ahead": (slice(0, 6), 0.6),
    "directions ahead": (slice(6, 12), 0.6),
    "left foot": (slice(12, 15), 0.75),
    "right foot": (slice(15, 18), 0.75),
    "velocity of the left foot": (slice(18, 21), 0.75),
    "velocity of the right foot": (slice(21, 24), 0.75),
    "velocity of the hips": (slice(24, 27), 1.0),
}
"""Columns of features that are scaled together, and their weights."""
WIDTH = 27
WAY = slice(0, 12)
"""The columns that a goal sets; the others are those of the frame before."""


@dataclass(frozen=True)
class MatchingLibrary:
    """Rows of all clips, one clip after the other.

    features: (n, 27) float32, divided by the scales: three places ahead, three directions ahead, places of the two
    ankles, their velocities, velocity of the hips. starts: (clips + 1,) the first row of each clip. targets: (n,)
    whether a cut may lead to a row. scales: (27,) by which features in metres and seconds are multiplied.
    """

    tracks: tuple[Track, ...]
    features: NDArray[np.float32]
    starts: Rows
    targets: Flags
    scales: Array

    @staticmethod
    def of(tracks: Sequence[Track]) -> MatchingLibrary:
        """The library of tracks; at least one, with a row to which a cut may lead (ValueError)."""
        raw = np.concatenate([features_of(track) for track in tracks])
        known = np.concatenate([track.known for track in tracks])
        targets = known & np.concatenate([_not_at_end(len(track)) for track in tracks])
        if not targets.any():
            raise ValueError("no clip is long enough")
        scales = np.ones(WIDTH)
        for columns, weight in GROUPS.values():
            spread = float(raw[targets][:, columns].std(axis=0).mean())
            scales[columns] = weight / spread if spread > 1e-6 else weight
        features = np.where(known[:, None], raw * scales, np.nan).astype(np.float32)
        starts = np.cumsum([0, *(len(track) for track in tracks)])
        return MatchingLibrary(tuple(tracks), features, starts, targets, scales)

    def __len__(self) -> int:
        return len(self.features)

    @cached_property
    def place(self) -> Array:
        """(n, 2) of the root."""
        return np.concatenate([track.place for track in self.tracks])

    @cached_property
    def facing(self) -> Array:
        """(n,) radians."""
        return np.concatenate([track.facing for track in self.tracks])

    @cached_property
    def usual_speed(self) -> float:
        """Metres a second: the median over rows that travel, of all rows where none does."""
        speeds = np.concatenate([_speeds(track) for track in self.tracks])[self.targets]
        moving = speeds[speeds > _MOVES]
        return float(np.median(moving if len(moving) else speeds))

    def clip_of(self, row: int) -> int:
        """The clip that has a row."""
        return int(np.searchsorted(self.starts, row, side="right")) - 1

    def nearest(self, query: Array, avoided: Collection[int] = ()) -> tuple[int, float]:
        """The row nearest to a query (27,) in scaled features among those to which a cut may lead, and its distance.

        avoided: rows that are taken only if all of the nearest ones are avoided.
        """
        distances, indices = self._tree.query(query, k=min(NEAREST, len(self._rows)) if avoided else 1)
        rows = self._rows[np.atleast_1d(indices)].tolist()
        best = next((place for place, row in enumerate(rows) if row not in avoided), 0)
        return rows[best], float(np.atleast_1d(distances)[best])

    def nearest_way(self, way: Array) -> int:
        """The row whose way ahead (12,), scaled, is nearest: where nothing comes before."""
        apart = np.linalg.norm(self.features[self._rows][:, WAY] - way, axis=1)
        return int(self._rows[np.argmin(apart)])

    @cached_property
    def _rows(self) -> Rows:
        return np.flatnonzero(self.targets)

    @cached_property
    def _tree(self) -> scipy.spatial.KDTree:
        return scipy.spatial.KDTree(self.features[self._rows])


_MOVES = 0.2
"""Metres a second from which a body travels."""


def features_of(track: Track) -> Array:
    """(n, 27) features in metres and metres a second. Beyond its end a track goes on straight at its last velocity."""
    rows = np.arange(len(track))
    last = len(track) - 1
    velocity = _velocity(track.place)
    pieces: list[Array] = []
    for ahead in ROWS_AHEAD:
        reached = np.minimum(rows + ahead, last)
        beyond = (rows + ahead - reached)[:, None] / RATE
        pieces.append(_seen(track.place[reached] + beyond * velocity[last] - track.place, track.facing))
    for ahead in ROWS_AHEAD:
        turned = track.facing[np.minimum(rows + ahead, last)] - track.facing
        pieces.append(np.stack([np.cos(turned), np.sin(turned)], axis=1))
    root = np.concatenate([track.place, np.zeros((len(track), 1))], axis=1)
    pieces += [_seen(track.feet[:, side] - root, track.facing) for side in (0, 1)]
    pieces += [_seen(_velocity(track.feet[:, side]), track.facing) for side in (0, 1)]
    pieces.append(_seen(_velocity(track.hips), track.facing))
    return np.concatenate(pieces, axis=1)


def way_of(places: Array, directions: Array, scales: Array) -> Array:
    """(12,) scaled features of three places (3, 2) ahead, metres from the root as it faces, and directions (3,) in
    radians from where it faces."""
    flat = np.concatenate([places.ravel(), np.stack([np.cos(directions), np.sin(directions)], axis=1).ravel()])
    way: Array = flat * scales[WAY]
    return way


def turn(points: Array, angle: Array | float) -> Array:
    """Points (..., 2) turned by an angle in radians, of each or of all."""
    cosine, sine = np.cos(angle), np.sin(angle)
    turned: Array = np.stack(
        [cosine * points[..., 0] - sine * points[..., 1], sine * points[..., 0] + cosine * points[..., 1]], axis=-1
    )
    return turned


def _seen(vectors: Array, facing: Array) -> Array:
    """Vectors (n, 2 or 3) from where a body faces; heights stay."""
    return np.concatenate([turn(vectors[:, :2], -facing), vectors[:, 2:]], axis=1)


def _velocity(places: Array) -> Array:
    speeds: Array = np.gradient(places, axis=0) * RATE
    return speeds


def _speeds(track: Track) -> Array:
    speeds: Array = np.linalg.norm(_velocity(track.place), axis=1)
    return speeds


def _not_at_end(rows: int) -> Flags:
    flags = np.ones(rows, dtype=bool)
    flags[max(rows - TAIL, 0) :] = False
    return flags
