"""The way of a body over the ground: its root, where it faces, and its feet, at one rate for all clips.

Ground coordinates are a right-handed pair of level axes: a turn by a positive angle leads from the first to the second,
seen from above. Where Y points up they are z and x, where Z points up x and y, where X points up y and z.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from mcml.motion.bodies.stretch import HIPS, Stretch
from mcml.motion.hub_writer import Flags
from mcml.motion.skeleton import Array

RATE = 30.0
"""Rows of a track a second."""
FEET = ("left_foot", "right_foot")
JOINTS = (*HIPS, *FEET)
"""MCML's names of the joints that a track needs."""
_SMOOTH_PLACE, _SMOOTH_FACING = 0.5, 1.0
"""Seconds over which the root is smoothed: hips sway with each step, the way of the body does not."""


@dataclass(frozen=True)
class Track:
    """A body of n rows at `RATE`, in metres.

    place: (n, 2) of the root on the ground, smoothed. facing: (n,) radians, from the first ground axis, without jumps.
    hips: (n, 3) between the hips, feet: (n, 2, 3) left and right ankle, both as ground coordinates and height over the
    floor. known: (n,) False where the source lacks one of these. frame_time: seconds, of the source.
    """

    place: Array
    facing: Array
    hips: Array
    feet: Array
    known: Flags
    frame_time: float
    skipped: int

    def __len__(self) -> int:
        return len(self.place)

    def frame(self, row: int) -> int:
        """The frame of the source, from 0, at a row."""
        return self.skipped + round(row / RATE / self.frame_time)


def ground_axes(up: str) -> tuple[int, int, int]:
    """Indices of the two level axes and of the one that points up, "X", "Y" or "Z". An upward axis that points down
    exchanges the level ones."""
    axis = "XYZ".index(up[-1])
    first, second = (axis + 1) % 3, (axis + 2) % 3
    return (second, first, axis) if up.startswith("-") else (first, second, axis)


def track_of(stretch: Stretch) -> Track | None:
    """The track of a clip. None without the joints, a frame time, a unit of length or two rows, or where the body
    never stands upright."""
    metres, seconds = stretch.calibration.metres_per_step, stretch.frame_time
    if seconds is None or not seconds > 0 or np.isnan(metres) or any(name not in stretch.places for name in JOINTS):
        return None
    skipped = stretch.skipped
    frames = np.arange(0, stretch.frames - 1 - skipped + 1e-9, 1 / RATE / seconds)
    if len(frames) < 2:
        return None
    first, second, up = ground_axes(stretch.calibration.up)
    sign = -1.0 if stretch.calibration.up.startswith("-") else 1.0
    scale = metres * np.array([1.0, 1.0, sign])
    floor = (stretch.calibration.floor or 0.0) * (stretch.calibration.metres or 0.0)

    def at_rows(values: Array) -> Array:
        own = values[skipped:]
        low = np.minimum(frames.astype(np.intp), len(own) - 1)
        high = np.minimum(low + 1, len(own) - 1)
        part = (frames - low).reshape(-1, *[1] * (own.ndim - 1))
        between: Array = np.where(part > 0, own[low] + part * (own[high] - own[low]), own[low])
        return between

    def placed(values: Array) -> Array:
        points: Array = at_rows(values)[:, [first, second, up]] * scale
        points[:, 2] -= floor
        return points

    hips = placed(stretch.middle(HIPS))
    feet = np.stack([placed(stretch.at(name)) for name in FEET], axis=1)
    left = at_rows(stretch.level_left())[:, [first, second]]
    # Forward is to the right of the left.
    ahead = np.stack([left[:, 1], -left[:, 0]], axis=1)
    whole = np.concatenate([hips, feet.reshape(-1, 6), ahead], axis=1)
    known: Flags = ~np.isnan(whole).any(axis=1)
    if known.sum() < 2:
        return None
    place = _smooth(_bridge(hips[:, :2], known), _SMOOTH_PLACE)
    faced = _smooth(_bridge(ahead, known), _SMOOTH_FACING)
    facing = np.unwrap(np.arctan2(faced[:, 1], faced[:, 0]))
    return Track(place, facing, hips, feet, known, seconds, skipped)


def _bridge(values: Array, known: Flags) -> Array:
    """Straight lines over unknown rows; these rows are no part of the library."""
    if known.all():
        return values
    rows = np.arange(len(values))
    return np.stack([np.interp(rows, rows[known], column[known]) for column in values.T], axis=1)


def _smooth(values: Array, seconds: float) -> Array:
    window = min(round(seconds * RATE) | 1, len(values) if len(values) % 2 else len(values) - 1)
    if window <= 3:
        return values
    smooth: Array = scipy.signal.savgol_filter(values, window, 3, axis=0, mode="interp")
    return smooth
