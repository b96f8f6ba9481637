"""Poses that can be compared between bodies, and distances of poses and motions.

A pose is the positions of its joints from the root, to the body's left, up and forward, in leg lengths: position,
facing direction and size of the body are ignored. Motions are compared by dynamic time warping, with slopes from 1/2 to
2 (Müller 2007, 4.2; Sakoe, Chiba 1978).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from mcml.motion.bodies.stretch import HIPS, Stretch
from mcml.motion.edits.resampling import frame_places
from mcml.motion.skeleton import Array
from mcml.motion.vectors import cross

Flags = NDArray[np.bool_]

JOINTS: Final = (
    "waist", "torso7", "neck1", "Head",
    *(f"{side}_{part}" for side in ("left", "right") for part in (
        "shoulder", "up_arm", "low_arm", "hand", "up_leg", "low_leg", "foot", "toes")),
)  # fmt: skip
"""The joints of a pose, in order."""

ORIGIN: Final = "Root"
NEEDS: Final = tuple(dict.fromkeys((ORIGIN, *HIPS, *JOINTS)))
"""All that features are made from."""

FEWEST = 10
"""Joints that two poses must share to be compared."""


def pose_features(stretch: Stretch) -> Array:
    """(n, 20, 3) of JOINTS, to the left, up and on, in leg lengths; NaN where unknown."""
    calibration = stretch.calibration
    left = stretch.level_left()
    up = np.broadcast_to(stretch.up, left.shape)
    on = cross(left, up)
    if calibration.leg is None:
        return np.full((stretch.frames, len(JOINTS), 3), np.nan)
    vectors = stretch.stacked(JOINTS) - stretch.at(ORIGIN)
    x, y, z = vectors.transpose(2, 0, 1)
    sides = [x * each[:, 0] + y * each[:, 1] + z * each[:, 2] for each in (left, up, on)]
    found: Array = np.stack(sides, axis=2).transpose(1, 0, 2) * (calibration.step / calibration.leg)
    # A body that faces nowhere has no pose, though its heights are known.
    found[np.isnan(left[:, 0])] = np.nan
    return found


def pose_distances(features: Array, poses: Array) -> Array:
    """(n, m) how unlike poses are: the root of the mean square distance of joints, in leg lengths.

    features: (n, 20, 3), poses: (m, 20, 3). Joints that both have count; NaN where these are fewer than FEWEST.
    """
    rows, columns = _alike(features), _alike(poses)
    if len(rows) == len(columns) == 1:
        return _apart(features, poses, rows[0][0] & columns[0][0])
    found = np.full((len(features), len(poses)), np.nan)
    for has, own in rows:
        for other_has, others in columns:
            found[np.ix_(own, others)] = _apart(features[own], poses[others], has & other_has)
    return found


def _apart(features: Array, poses: Array, shared: Flags) -> Array:
    """(n, m) by some of the joints, (20,)."""
    count = int(shared.sum())
    if count < FEWEST:
        return np.full((len(features), len(poses)), np.nan)
    if count < len(shared):
        features, poses = features[:, shared], poses[:, shared]
    # By differences: equal poses have distance 0, and results are the same in any block.
    apart = scipy.spatial.distance.cdist(features.reshape(-1, 3 * count), poses.reshape(-1, 3 * count))
    distances: Array = apart / np.sqrt(count)
    return distances


def _alike(features: Array) -> list[tuple[Flags, NDArray[np.intp]]]:
    """(which joints (20,), rows) of poses that have the same joints."""
    has: Flags = np.logical_and.reduce(np.isfinite(features), axis=2)
    if not len(has):
        return []
    if (has == has[0]).all():
        return [(has[0], np.arange(len(has)))]
    kinds, kind_of = np.unique(has, axis=0, return_inverse=True)
    return [(kind, np.flatnonzero(kind_of.ravel() == number)) for number, kind in enumerate(kinds)]


def at_rate(features: Array, frame_time: float, new_frame_time: float) -> Array:
    """Features (n, 20, 3) at another frame rate, by linear interpolation. Times in seconds, from `frame_places`."""
    places = frame_places(len(features), frame_time, new_frame_time)
    first = np.floor(places).astype(np.intp)
    second = np.minimum(first + 1, len(features) - 1)
    part = (places - first)[:, None, None]
    between: Array = features[first] * (1 - part) + features[second] * part
    # A time at a frame is that frame, even if its neighbour lacks samples.
    return np.where(part == 0, features[first], between)


def motion_distances(features: Array, motion: Array) -> Array:
    """Return (n,) the distance to a motion of the frame range that ends in each frame: the mean pose distance along the
    best warping.

    features: (n, 20, 3), motion: (m, 20, 3) at the same frame rate (`at_rate`). With c the pose distances,
    D(i, j) = min(D(i-1, j-1) + c(i, j), D(i-2, j-1) + c(i-1, j) + c(i, j), D(i-1, j-2) + c(i, j)), over m: each frame
    of the motion counts once, frames of the range may be skipped or used twice. It begins anywhere. NaN where no range
    ends: in the first frames, and after poses that cannot be compared.
    """
    total, _ = _warped(features, motion)
    total = total / max(1, len(motion))
    return np.where(np.isfinite(total), total, np.nan)


def motion_starts(features: Array, motion: Array) -> NDArray[np.intp]:
    """Return (n,) the first frame of the range that ends in each frame with the distance in `motion_distances`; the
    frame itself where no range ends.
    """
    total, starts = _warped(features, motion)
    return np.where(np.isfinite(total), starts, np.arange(len(features))).astype(np.intp)


def _warped(features: Array, motion: Array) -> tuple[Array, Array]:
    """(n,) D(m, j), and where its way began."""
    apart = pose_distances(features, motion).T
    apart = np.where(np.isnan(apart), np.inf, apart)
    rows: Sequence[Array] = [_nothing(features), _nothing(features)]
    starts: Sequence[Array] = [_nothing(features), np.arange(len(features), dtype=np.float64)]
    for place, here in enumerate(apart):
        if not place:
            rows = [rows[1], here]
            continue
        # Frame for frame, two frames of the motion for one of the range, one for two.
        ways = np.stack([_later(rows[1], 1), _later(rows[0], 1) + apart[place - 1], _later(rows[1], 2)])
        began = np.stack([_later(starts[1], 1), _later(starts[0], 1), _later(starts[1], 2)])
        best = ways.argmin(axis=0)[None]
        rows = [rows[1], np.take_along_axis(ways, best, axis=0)[0] + here]
        starts = [starts[1], np.take_along_axis(began, best, axis=0)[0]]
    return rows[1], starts[1]


def _nothing(features: Array) -> Array:
    return np.full(len(features), np.inf)


def _later(row: Array, frames: int) -> Array:
    """Return (n,) values of a number of frames earlier."""
    moved = np.full(len(row), np.inf)
    moved[frames:] = row[: max(0, len(row) - frames)]
    return moved
