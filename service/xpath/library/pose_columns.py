"""The poses of a group of documents side by side, and how unlike others they are: as `poses` says, in single
precision, which tells six digits of a distance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from service.motion.bodies.pose_index import WIDTH, Singles, later
from service.motion.bodies.poses import JOINTS, motion_distances, pose_distances
from service.xpath.nodes.numbering import Bools, Floats, Ints

BLOCK = 8192
"""Poses that are compared while they lie in the processor's cache."""
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
        # Where a joint is not known, those that both have count.
        some = np.flatnonzero(np.isnan(found))
        if len(some):
            found[some] = pose_distances(self._poses(some), pose[None])[:, 0]
        return found

    def from_motion(self, motion: Floats, own: Bools, check: Callable[[], None]) -> Floats:
        """(frames,) of the stretch that ends there from a motion (m, 20, 3), by dynamic time warping. own: which frames
        are of documents at the motion's frame rate; NaN in others."""
        found = np.full(len(self.vectors), np.nan)
        starts = np.isin(np.arange(len(own)), self.starts)[own]
        vectors = self.vectors[own]
        asked = motion.reshape(-1, WIDTH).astype(np.float32)
        if np.isnan(asked).any() or np.isnan(vectors).any():
            found[own] = self._by_parts(motion, np.flatnonzero(own), np.flatnonzero(starts))
        elif len(vectors):
            found[own] = warped(_apart(vectors, asked, check), starts, check)
        return found

    def _poses(self, frames: Ints) -> Floats:
        return self.vectors[frames].astype(np.float64).reshape(-1, len(JOINTS), 3)

    def _by_parts(self, motion: Floats, frames: Ints, starts: Ints) -> Floats:
        """A document at a time, where joints are not known."""
        parts = np.split(frames, starts[1:])
        return np.concatenate([np.empty(0), *(motion_distances(self._poses(part), motion) for part in parts)])


def _apart(vectors: Singles, asked: Singles, check: Callable[[], None]) -> Singles:
    """(m, frames) pose distances."""
    found = np.empty((len(asked), len(vectors)), np.float32)
    lengths = np.einsum("ij,ij->i", asked, asked)
    for at in range(0, len(vectors), BLOCK):
        check()
        some = vectors[at : at + BLOCK]
        squares = np.einsum("ij,ij->i", some, some)[:, None] + lengths - 2 * (some @ asked.T)
        rows, columns = np.nonzero(squares < NEAR)
        for first in range(0, len(rows), BLOCK):
            which = slice(first, first + BLOCK)
            exact = some[rows[which]] - asked[columns[which]]
            squares[rows[which], columns[which]] = np.einsum("ij,ij->i", exact, exact)
        found[:, at : at + BLOCK] = squares.T
    np.sqrt(found, out=found)
    found /= np.float32(np.sqrt(len(JOINTS)))
    return found


def warped(apart: Singles, starts: Bools, check: Callable[[], None]) -> Floats:
    """The recurrence of `poses.motion_distances` over documents one after the other. apart: (m, frames) pose distances.
    starts: which frames begin a document, before which nothing lies."""
    firsts = np.flatnonzero(starts)
    before, last = np.full(apart.shape[1], np.inf, np.float32), apart[0].copy()
    for place in range(1, len(apart)):
        check()
        here = later(before, 1, firsts)
        here += apart[place - 1]
        np.minimum(here, later(last, 1, firsts), out=here)
        np.minimum(here, later(last, 2, firsts), out=here)
        here += apart[place]
        before, last = last, here
    total = last.astype(np.float64) / len(apart)
    return np.where(np.isfinite(total), total, np.nan)
