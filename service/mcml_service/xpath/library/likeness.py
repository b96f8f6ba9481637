"""Distances of documents to a pose or a motion: of all their frames, or only of the nearest candidates."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mcml.motion.bodies.pose_index import WIDTH, PoseIndex, Singles
from mcml.motion.bodies.poses import JOINTS, NEEDS, at_rate, motion_starts, pose_features
from mcml.motion.skeleton import Array
from mcml_service.clips.bodies import Body
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.library.pose_columns import PoseColumns
from mcml_service.xpath.nodes.numbering import Floats, Ints

MOST_FRAMES = 1 << 18
"""Limit of frames whose poses are in memory at once."""
TOGETHER = 64
"""Number of nearest candidates that are compared exactly before the bounds are checked again."""


@dataclass(frozen=True, eq=False)
class Poses:
    """The poses of a document. vectors: (frames, WIDTH) in leg lengths, NaN where a joint is not known. seconds: a
    frame, None where unknown."""

    vectors: Singles
    seconds: float | None

    @property
    def nbytes(self) -> int:
        return self.vectors.nbytes + 100

    @classmethod
    def of(cls, body: Body) -> Poses:
        """The poses of a body."""
        vectors = pose_features(body.stretch(NEEDS)).astype(np.float32).reshape(-1, WIDTH)
        return cls(vectors, body.frame_time)


class _Kept(Protocol):
    def read(self, tx: Transaction, documents: Sequence[Listed]) -> list[Poses]: ...


class _Caches(Protocol):
    """The cache of poses."""

    @property
    def poses(self) -> _Kept: ...


@dataclass(frozen=True, eq=False)
class Asked:
    """The pose or motion that is compared with others.

    poses: (m, 20, 3) as `pose_features` gives them. moves: whether they are a motion, else one pose. seconds: a frame
    of the motion, None where unknown.
    """

    poses: Array
    moves: bool
    seconds: float | None = None

    def unlike(
        self, tx: Transaction, caches: _Caches, documents: Sequence[Listed], check: Callable[[], None]
    ) -> Iterator[Floats]:
        """Return the distance of each frame of documents, or of the frame range that ends there; NaN where unknown.

        check: called often.
        """
        first = 0
        while first < len(documents):
            last, frames = first + 1, documents[first].frames
            while last < len(documents) and frames + documents[last].frames <= MOST_FRAMES:
                frames += documents[last].frames
                last += 1
            yield from self._unlike(caches.poses.read(tx, documents[first:last]), check)
            first = last

    def _unlike(self, documents: Sequence[Poses], check: Callable[[], None]) -> list[Floats]:
        counts = np.array([len(poses.vectors) for poses in documents], np.int64)
        ends: Ints = np.cumsum(counts)
        vectors = np.concatenate([np.empty((0, WIDTH), np.float32), *(poses.vectors for poses in documents)])
        seconds = np.array([poses.seconds or np.nan for poses in documents], np.float64)
        columns = PoseColumns(vectors, (ends - counts)[counts > 0])
        return np.split(self.column(columns, seconds, counts, check), ends[:-1])

    def began(self, document: Poses, end: int) -> int:
        """Return the first frame of the range most similar to the motion that ends in a frame (from 0) of a
        document.
        """
        if not self.moves or document.seconds is None:
            return end
        motion = self._at(document.seconds)
        first = max(0, end + 1 - 2 * len(motion))
        features = document.vectors[first : end + 1].astype(np.float64).reshape(-1, len(JOINTS), 3)
        return first + int(motion_starts(features, motion)[-1])

    def column(self, columns: PoseColumns, seconds: Floats, frames: Ints, check: Callable[[], None]) -> Floats:
        """The same of documents one after the other. seconds: a frame of each. frames: of each."""
        if not self.moves:
            return columns.from_pose(self.poses[0], check)
        found = np.full(len(columns.vectors), np.nan)
        for rate in self._rates(seconds, frames):
            own = np.repeat(seconds == rate, frames)
            found[own] = columns.from_motion(self._at(rate), own, check)[own]
        return found

    def least(self, index: PoseIndex, seconds: Floats, frames: Ints) -> Singles:
        """Return the least possible distance in each segment of an index, infinite where unknown.

        seconds: frame time of each document. frames: of each.
        """
        if not self.moves:
            return index.near_pose(self.poses[0])
        found = np.full(len(index.radius), np.inf, np.float32)
        for rate in self._rates(seconds, frames):
            found = np.minimum(found, index.near_motion(self._at(rate), rate, seconds == rate))
        return found

    def _rates(self, seconds: Floats, frames: Ints) -> list[float]:
        """Return the frame times of documents that are long enough for the motion: one of their frames may match two
        of it. The unusual frame time of a single document does not affect the others.
        """
        if self.seconds is None:
            return []
        known = seconds > 0
        needed = (len(self.poses) - 1) * self.seconds / np.where(known, seconds, np.nan)
        rates: list[float] = np.unique(seconds[known & (needed <= 2 * frames + 2)]).tolist()
        return rates

    def _at(self, seconds: float) -> Array:
        if self.seconds is None or self.seconds == seconds:
            return self.poses
        return at_rate(self.poses, self.seconds, seconds)


def nearest_first(bounds: Sequence[Floats], limit: Callable[[], float]) -> Iterator[list[tuple[int, int]]]:
    """Some things at a time, each as (group, place in it), as long as they may be nearer than a limit.

    bounds: of each group, how far its things are at least. limit: how far those are now that count.
    """
    every = np.concatenate([np.empty(0), *bounds])
    group = np.repeat(np.arange(len(bounds)), list(map(len, bounds)))
    place = np.concatenate([np.empty(0, np.int64), *(np.arange(len(some)) for some in bounds)])
    order = np.argsort(every, kind="stable")
    order = order[: np.searchsorted(every[order], np.inf)]
    for at in range(0, len(order), TOGETHER):
        some = order[at : at + TOGETHER]
        some = some[every[some] <= limit()]
        if not len(some):
            return
        yield list(zip(group[some].tolist(), place[some].tolist(), strict=True))
