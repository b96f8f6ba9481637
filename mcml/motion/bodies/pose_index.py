"""A coarse index of poses: it finds candidates near a pose without a comparison of all poses.

Frames in a row are a segment: a ball around the mean of its poses, of which a few principal components are kept. The
distance of a pose to any pose of the segment is at least its distance to the ball, and leaving out components never
makes a vector longer. So these bounds exclude only poses that are farther away, and the rest is compared exactly.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mcml.motion.bodies.poses import FEWEST, JOINTS
from mcml.motion.skeleton import Array

Flags = NDArray[np.bool_]
Singles = NDArray[np.float32]
Places = NDArray[np.int64]
Some: TypeAlias = slice | Places

MADE: Final = 2
"""Version of the index: increased when its computation changes, so that stored indexes are built again."""
WIDTH: Final = 3 * len(JOINTS)
COMPONENTS = 12
"""Number of principal components: for walks, dances and fights they explain about 97 % of the variance."""
SECONDS = 1 / 15
"""About how long a segment is."""
FRAMES = 4
"""Of a segment where the frame time is not known."""
SLACK = np.float32(1e-4)
"""Leg lengths that rounding may move a bound by."""
ROUNDING = np.float32(4e-6)
"""Of the squares of lengths, that their difference may be wrong by."""
SAMPLE = 20_000
"""Segments that components are found from."""


@dataclass(frozen=True, eq=False)
class PoseIndex:
    """An index of consecutive documents.

    frames: of each. lengths: frames of its segments, the last of which may have fewer. ends: the index after its last
    segment. kind_of: the kind of its poses, by their joints. kinds: (k, 20) these joints. means: (k, WIDTH), bases: (k,
    COMPONENTS, WIDTH): for computing components. points: (segments, COMPONENTS + 2) the components of each centre, the
    square of their length, and 1: the product with the vector of a pose is the squared distance. radius, reach:
    (segments,) the greatest distance of a pose from the centre, and from its projection on the components; infinite if
    unbounded.
    """

    frames: Places
    lengths: Places
    ends: Places
    kind_of: Places
    kinds: Flags
    means: Singles
    bases: Singles
    points: Singles
    radius: Singles
    reach: Singles

    @property
    def nbytes(self) -> int:
        """About how much memory it takes."""
        return self.points.nbytes + 2 * self.radius.nbytes + self.bases.nbytes + 32 * len(self.frames) + 1000

    @property
    def starts(self) -> Places:
        """Of each document its first segment."""
        return self.ends - -(-self.frames // self.lengths)

    def segments(self, documents: Places, frames: Places) -> Places:
        """Return the segments of frames (from 0) of documents."""
        found: Places = self.starts[documents] + frames // self.lengths[documents]
        return found

    def near_pose(self, pose: Array) -> Singles:
        """(segments,) how unlike a pose (20, 3) those of each segment are at least, as `poses.pose_distances` counts;
        infinite where they cannot be compared."""
        found = np.full(len(self.radius), np.inf, np.float32)
        for kind, segments in self._of_kinds():
            _, bounds = self._bounds(kind, segments, pose[None])
            np.maximum(bounds[0], 0, out=bounds[0])
            found[segments] = bounds[0]
        return found

    def near_motion(self, motion: Array, seconds: float | None, own: Flags) -> Singles:
        """Return (segments,) the least possible distance to a motion (m, 20, 3) of a frame range that ends in the
        segment, as in `poses.motion_distances`. own: documents at the motion's frame rate; infinite in others. seconds:
        a frame of it.
        """
        length = segment_length(seconds)
        parts = [motion[at : at + length] for at in range(0, len(motion), length)]
        anchors = np.stack([part.mean(axis=0) for part in parts])
        known: Flags = np.logical_and.reduce(np.isfinite(motion), axis=2)
        uniform = bool((known == known[0]).all())
        begins = np.zeros(len(self.radius), bool)
        begins[self.starts[self.frames > 0]] = True
        found = np.full(len(self.radius), np.inf, np.float32)
        for kind, segments in self._of_kinds(own):
            if not uniform:
                found[segments] = 0
                continue
            shared, bounds = self._bounds(kind, segments, anchors)
            for part, anchor, bound in zip(parts, anchors, bounds, strict=True):
                # The bounds become what the part costs in each segment at least.
                apart = (part - anchor)[:, shared]
                slack = np.sqrt((apart**2).sum(axis=(1, 2)) / max(1, shared.sum())).sum()
                bound *= np.float32(len(part))
                bound -= np.float32(slack)
                np.maximum(bound, 0, out=bound)
            found[segments] = _path(bounds, begins[segments]) / np.float32(len(motion))
        return found

    def _of_kinds(self, own: Flags | None = None) -> Iterator[tuple[int, Some]]:
        """The segments of documents whose poses have the same joints."""
        counts = self.ends - self.starts
        for kind in range(len(self.kinds)):
            documents = self.kind_of == kind
            if own is not None:
                documents &= own
            if documents.any():
                yield kind, slice(None) if documents.all() else np.flatnonzero(np.repeat(documents, counts))

    def _bounds(self, kind: int, segments: Some, poses: Array) -> tuple[Flags, Singles]:
        """(20,) the joints that segments of a kind share with poses (m, 20, 3), and (m, segments) how unlike they are
        at least, by these; negative where they may be alike."""
        shared: Flags = self.kinds[kind] & np.isfinite(poses).all(axis=(0, 2))
        points = self.points[segments]
        if shared.sum() < FEWEST:
            return shared, np.full((len(poses), len(points)), np.inf, np.float32)
        counted = np.repeat(shared, 3)
        vectors = np.where(counted, poses.reshape(-1, WIDTH) - self.means[kind], 0).astype(np.float32)
        basis = np.where(counted, self.bases[kind], np.float32(0))
        if (shared == self.kinds[kind]).all():
            # Leaving out components never makes a vector longer.
            off, vectors = self.radius[segments], vectors @ basis.T
            asked = -2 * vectors
        else:
            # For a part of the joints, components are only approximate.
            components = points[:, :COMPONENTS]
            lengths = np.einsum("ij,ij->i", components @ (basis @ basis.T), components)
            points = np.column_stack([components, lengths * (1 - ROUNDING), points[:, -1]])
            off, asked = self.reach[segments], -2 * vectors @ basis.T
        lengths = np.einsum("ij,ij->i", vectors, vectors) * (1 - ROUNDING)
        bounds: Singles = np.column_stack([asked, np.ones(len(poses), np.float32), lengths]) @ points.T
        scale = 1 / np.float32(np.sqrt(shared.sum()))
        off = off * scale + SLACK
        for bound in bounds:
            np.maximum(bound, 0, out=bound)
            np.sqrt(bound, out=bound)
            bound *= scale
            bound -= off
        return shared, bounds


def segment_length(seconds: float | None) -> int:
    """Frames of a segment. seconds: a frame."""
    return max(1, round(SECONDS / seconds)) if seconds else FRAMES


@dataclass(frozen=True, eq=False)
class Balls:
    """The segments of a document. has: (20,) which joints its poses have. centres: (segments, WIDTH), 0 where unknown.
    radius: (segments,)."""

    frames: int
    length: int
    has: Flags
    centres: Singles
    radius: Singles


def balls_of(poses: Singles, seconds: float | None) -> Balls:
    """The segments of the poses (frames, WIDTH) of a document, in leg lengths, NaN where unknown. seconds: a frame."""
    length = segment_length(seconds)
    begins = np.arange(0, len(poses), length)
    known: Flags = np.logical_and.reduce(np.isfinite(poses).reshape(-1, len(JOINTS), 3), axis=2)
    has: Flags = np.logical_or.reduce(known, axis=0)
    if not len(begins):
        return Balls(0, length, has, np.empty((0, WIDTH), np.float32), np.empty(0, np.float32))
    whole: Flags = np.logical_and.reduce(known[:, has], axis=1)
    none = ~np.logical_or.reduce(known, axis=1)
    filled = np.where(np.repeat(has, 3) & whole[:, None], poses, np.float32(0))
    held = np.add.reduceat(whole.astype(np.float32), begins)
    centres = (np.add.reduceat(filled, begins, axis=0) / np.maximum(held, 1)[:, None]).astype(np.float32)
    apart = filled - np.repeat(centres, np.diff(np.append(begins, len(poses))), axis=0)
    squares: Singles = np.einsum("ij,ij->i", apart, apart)
    squares[~whole] = 0
    radius: Singles = np.sqrt(np.maximum.reduceat(squares, begins))
    # Nothing bounds poses of which some have other joints than the rest.
    radius[np.logical_or.reduceat(~(whole | none), begins)] = np.inf
    return Balls(len(poses), length, has, centres, radius)


def pose_index(documents: Sequence[Balls]) -> PoseIndex:
    """The index of documents that follow one another."""
    counts = np.array([len(balls.radius) for balls in documents], np.int64)
    ends = np.cumsum(counts)
    has = np.array([balls.has for balls in documents], bool).reshape(-1, len(JOINTS))
    kinds, kind_of = np.unique(has, axis=0, return_inverse=True)
    centres = np.concatenate([np.empty((0, WIDTH), np.float32), *(balls.centres for balls in documents)])
    own_kind = np.repeat(kind_of.reshape(-1), counts)
    radius = np.concatenate([np.empty(0, np.float32), *(balls.radius for balls in documents)])
    means = np.zeros((len(kinds), WIDTH), np.float32)
    bases = np.zeros((len(kinds), COMPONENTS, WIDTH), np.float32)
    points = np.ones((len(centres), COMPONENTS + 2), np.float32)
    reach = radius.copy()
    for kind in range(len(kinds)):
        segments = np.flatnonzero(own_kind == kind)
        means[kind], bases[kind] = _principal(centres[segments[:: 1 + len(segments) // SAMPLE]])
        for at in range(0, len(segments), SAMPLE):
            some = segments[at : at + SAMPLE]
            apart = centres[some] - means[kind]
            components = apart @ bases[kind].T
            points[some, :-2] = components
            points[some, -2] = np.einsum("ij,ij->i", components, components) * (1 - ROUNDING)
            left = apart - components @ bases[kind]
            reach[some] += np.sqrt(np.einsum("ij,ij->i", left, left))
    return PoseIndex(
        frames=np.array([balls.frames for balls in documents], np.int64),
        lengths=np.array([balls.length for balls in documents], np.int64),
        ends=ends.astype(np.int64),
        kind_of=kind_of.reshape(-1).astype(np.int64),
        kinds=kinds,
        means=means,
        bases=bases,
        points=points,
        radius=radius,
        reach=reach,
    )


def _principal(vectors: Singles) -> tuple[Singles, Singles]:
    """The mean of vectors, and (COMPONENTS, WIDTH) directions at right angles along which they differ most."""
    mean = vectors.mean(axis=0, dtype=np.float64) if len(vectors) else np.zeros(WIDTH)
    apart = vectors - mean
    _, directions = np.linalg.eigh(apart.T @ apart)
    return mean.astype(np.float32), np.ascontiguousarray(directions[:, ::-1][:, :COMPONENTS].T, np.float32)


def _path(costs: Singles, begins: Flags) -> Singles:
    """Return (segments,) the least sum of costs (parts, segments) along a path that ends in a segment.

    During a part of the motion, a frame range covers up to twice its frames: it ends in the same segment as the
    previous part, in the next one or in the one after; the part costs no less than in the cheapest of those. begins:
    the first segments of documents.
    """
    firsts = np.flatnonzero(begins)
    total = np.zeros(costs.shape[1], np.float32)
    for own in costs:
        cheapest = np.minimum(own, later(own, 1, firsts))
        ways = total + own, later(total, 1, firsts) + cheapest
        cheapest = np.minimum(cheapest, later(own, 2, firsts))
        total = np.minimum(np.minimum(*ways), later(total, 2, firsts) + cheapest)
    return total


def later(row: Singles, places: int, firsts: Places) -> Singles:
    """(n,) of one place before, or of two; infinite where a document has none. firsts: where documents begin."""
    moved = np.empty_like(row)
    moved[places:], moved[:places] = row[: len(row) - places], np.inf
    moved[firsts] = np.inf
    if places == 2:
        moved[firsts[firsts + 1 < len(row)] + 1] = np.inf
    return moved
