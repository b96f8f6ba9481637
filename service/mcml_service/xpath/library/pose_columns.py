"""The poses of a group of documents in one array, and their distances to others: as in `poses`, in single precision,
with six digits of a distance.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from mcml.motion.bodies.pose_index import WIDTH, Singles, later
from mcml.motion.bodies.poses import JOINTS, motion_distances, pose_distances
from mcml_service.xpath.nodes.numbering import Bools, Floats, Ints

BLOCK = 8192
"""Number of poses that are compared together, to fit the processor's cache."""
ROWS = 64
"""Poses of a motion that others are compared with together: memory is bounded by them."""
NEAR = np.float32(1e-3)
"""Sum of squares below which the difference of squares has lost too many digits."""


@dataclass(frozen=True, eq=False)
class PoseColumns:
    """vectors: (frames, WIDTH) in leg lengths, NaN where a joint is not known. starts: the first frame of each document
    that has any."""

    vectors: Singles
    starts: Ints

    @property
    def nbytes(self) -> int:
        return self.vectors.nbytes + self.starts.nbytes

    def from_pose(self, pose: Floats, check: Callable[[], None]) -> Floats:
        """(frames,) from one pose (20, 3)."""
        asked = pose.reshape(WIDTH).astype(np.float32)
        squares = np.empty(len(self.vectors), np.float32)
        for at in range(0, len(squares), BLOCK):
            apart = self.vectors[at : at + BLOCK] - asked
            np.einsum("ij,ij->i", apart, apart, out=squares[at : at + BLOCK])
        check()
        found = np.sqrt(squares.astype(np.float64) / len(JOINTS))
        # If a joint is unknown, only common joints are compared.
        some = np.flatnonzero(np.isnan(found))
        if len(some):
            found[some] = pose_distances(self._poses(some), pose[None])[:, 0]
        return found

    def from_motion(self, motion: Floats, own: Bools, check: Callable[[], None]) -> Floats:
        """Return (frames,) the distance of the range that ends there to a motion (m, 20, 3), by dynamic time warping.

        own: mask of frames of documents at the motion's frame rate; NaN in others.
        """
        found = np.full(len(self.vectors), np.nan)
        starts = np.isin(np.arange(len(own)), self.starts)[own]
        vectors = self.vectors[own]
        asked = motion.reshape(-1, WIDTH).astype(np.float32)
        if np.isnan(asked).any() or np.isnan(vectors).any():
            found[own] = self._by_parts(motion, np.flatnonzero(own), np.flatnonzero(starts))
        elif len(vectors):
            found[own] = warped(vectors, asked, starts, check)
        return found

    def _poses(self, frames: Ints) -> Floats:
        return self.vectors[frames].astype(np.float64).reshape(-1, len(JOINTS), 3)

    def _by_parts(self, motion: Floats, frames: Ints, starts: Ints) -> Floats:
        """A document at a time, where joints are not known."""
        parts = np.split(frames, starts[1:])
        return np.concatenate([np.empty(0), *(motion_distances(self._poses(part), motion) for part in parts)])


def _apart(vectors: Singles, asked: Singles, check: Callable[[], None]) -> Iterator[Singles]:
    """Yield (frames,) pose distances from each of the given poses."""
    lengths = np.einsum("ij,ij->i", vectors, vectors)
    for first in range(0, len(asked), ROWS):
        some = asked[first : first + ROWS]
        found = np.empty((len(some), len(vectors)), np.float32)
        for at in range(0, len(vectors), BLOCK):
            check()
            block = vectors[at : at + BLOCK]
            squares = lengths[at : at + BLOCK, None] + np.einsum("ij,ij->i", some, some) - 2 * (block @ some.T)
            rows, columns = np.nonzero(squares < NEAR)
            for near in range(0, len(rows), BLOCK):
                which = slice(near, near + BLOCK)
                exact = block[rows[which]] - some[columns[which]]
                squares[rows[which], columns[which]] = np.einsum("ij,ij->i", exact, exact)
            found[:, at : at + BLOCK] = squares.T
        np.sqrt(found, out=found)
        found /= np.float32(np.sqrt(len(JOINTS)))
        yield from found


def warped(vectors: Singles, asked: Singles, starts: Bools, check: Callable[[], None]) -> Floats:
    """The recurrence of `poses.motion_distances` over documents one after the other.

    asked: (m, WIDTH). starts: mask of first frames of documents.
    """
    firsts = np.flatnonzero(starts)
    rows = _apart(vectors, asked, check)
    apart = next(rows)
    before, last = np.full(len(vectors), np.inf, np.float32), apart.copy()
    for row in rows:
        check()
        here = later(before, 1, firsts)
        here += apart
        np.minimum(here, later(last, 1, firsts), out=here)
        np.minimum(here, later(last, 2, firsts), out=here)
        here += row
        before, last, apart = last, here, row
    total = last.astype(np.float64) / len(asked)
    return np.where(np.isfinite(total), total, np.nan)
