"""Loops: the best cut of a motion into one, and its end led to its beginning."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from mcml.errors import ConversionError
from mcml.motion.carriers import carriers
from mcml.motion.clip import FrameBlock
from mcml.motion.edits.pose_likeness import joint_features
from mcml.motion.edits.seam_feet import SeamFeet
from mcml.motion.edits.splicing import Placement, Poses, going_on, inertialize, joined_poses, placed, steps
from mcml.motion.feet.legs import Side
from mcml.motion.frames import in_columns, remade, rows_of
from mcml.motion.hub import HubReader, walked
from mcml.motion.hub_writer import HubWriter, Known
from mcml.motion.rotations import inverse, rotate
from mcml.motion.skeleton import Array, Convention, Skeleton
from mcml.motion.units import DEGREES, Reading

_CANDIDATES = 300
"""Frames at either end that are compared with one another."""
_SHORTEST = 4
"""Frames of a loop."""


@dataclass(frozen=True)
class Looped:
    """block: frames of the loop. first, last: which of the given frames they are, from 0.

    jump: the largest step from the last frame to the first, of the root or of an angle, in parts of the largest inside.
    turn: radians by which the body turns from one round to the next. locked: feet held at the end.
    """

    block: FrameBlock
    first: int
    last: int
    jump: float
    turn: float
    locked: tuple[Side, ...]


def close_loop(
    skeleton: Skeleton,
    block: FrameBlock,
    frame_time: float,
    seconds: float,
    search: float,
    *,
    lock_feet: bool = True,
    in_place: bool = False,
    up: str = "Y",
    reading: Reading = DEGREES,
) -> Looped:
    """Cut a motion so that it can be repeated, and lead its end to its beginning.

    seconds: of the end that is changed; over them the difference of poses and speeds to the first frame comes in, as
    for `inertialize` in reversed time. search: parts of the motion at either end, 0 to 0.5, in which the cut is where
    poses and movements are most alike; 0: all frames are kept. lock_feet: standing feet stay in place at the end.
    in_place: the body does not travel from round to round. Raises ConversionError for fewer than four frames.
    """
    if len(block) < _SHORTEST:
        raise ConversionError(f"a loop has at least {_SHORTEST} frames", remedy="Choose a longer range.")
    axis = np.eye(3)["XYZ".index(up.upper())]
    hub = HubReader(skeleton, reading).read(block)
    whole = Poses(hub.translations, hub.rotations, hub.scales)
    carry = carriers(skeleton, hub.translations)
    first, last = _cut(skeleton, whole, carry[0], frame_time, search, axis)
    loop = whole.rows(first, last + 1)
    size = len(loop)
    points = all(joint.convention is Convention.MARKER for joint in skeleton.joints)
    placement = going_on(skeleton, loop.rows(size - 2, size), loop.rows(0, 2), carry, axis, 1.0, points)
    feet = SeamFeet.of(skeleton, [loop], frame_time, axis) if lock_feet else None
    if feet is not None:
        stance = feet.stance(loop)
        placement = feet.keep_foot(placement, stance.rows(size - 1, size), stance.rows(0, 1))
    tail = min(max(round(seconds / frame_time), 0), size - 2)
    locked: tuple[Side, ...] = ()
    if tail:
        start = placed(skeleton, loop.rows(0, 2), carry, placement)
        end = _reverse(inertialize(_reverse(start), _reverse(loop.rows(size - tail - 2, size)), tail))
        if feet is not None and placement.shift is not None:
            again = stance.rows(0, 1).place(placement.turn(), placement.shift).over(tail)
            end, locked = feet.lock(end, stance.rows(size - tail, size), again, HubWriter(skeleton, reading))
        loop = joined_poses([loop.rows(0, size - tail), end])
    if in_place:
        loop = _without_travel(skeleton, loop, carry, placement)
    changed = np.zeros((size, len(skeleton)), dtype=bool)
    changed[size - tail :] = True
    if in_place:
        changed[:, list(carry)] = True
    writer = HubWriter(skeleton, reading)
    known = Known(hub.values[first : last + 1], ~changed, near=True)
    values = writer.write(loop.translations, loop.rotations, loop.scales, known)
    part = rows_of(block, first, last + 1)
    values[np.isnan(in_columns(part, skeleton.columns()))] = np.nan
    made = remade(part, skeleton.columns(), values, np.arange(size, dtype=np.intp), part.ids)
    return Looped(made, first, last, _jump(skeleton, loop, carry, axis, points), placement.angle, locked)


def _reverse(poses: Poses) -> Poses:
    return Poses(poses.translations[::-1], poses.rotations[::-1], poses.scales[::-1])


def _cut(
    skeleton: Skeleton, whole: Poses, carrier: int, frame_time: float, search: float, up: Array
) -> tuple[int, int]:
    """The first and last frame of the loop: the frame after the last is most like the first."""
    count = len(whole)
    window = min(round(search * count), count - _SHORTEST)
    if window < 1:
        return 0, count - 1
    stride = -(-window // _CANDIDATES)
    starts, ends = np.arange(0, window, stride), np.arange(count - 1, count - 1 - window, -stride)
    # One frame more on the inner side, for velocities.
    first, last = (
        joint_features(skeleton, whole.rows(*rows), carrier, up, frame_time)
        for rows in ((0, window + 1), (count - 1 - window, count))
    )
    costs: Array = scipy.spatial.distance.cdist(first[starts], last[ends - (count - 1 - window)])
    costs[ends[None, :] - starts[:, None] < _SHORTEST] = np.inf
    start, end = np.unravel_index(int(np.argmin(costs)), costs.shape)
    return int(starts[start]), int(ends[end]) - 1


def _without_travel(skeleton: Skeleton, loop: Poses, carry: tuple[int, ...], placement: Placement) -> Poses:
    """The loop with the way from round to round taken out, evenly over its frames."""
    positions, turned = walked(skeleton, loop.translations, loop.rotations)
    again = placed(skeleton, loop.rows(0, 1), carry, placement)
    travel = (walked(skeleton, again.translations, again.rotations)[0] - positions[:1])[0, list(carry)].mean(axis=0)
    travel = travel - (travel @ placement.up) * placement.up
    shift = -np.arange(len(loop))[:, None] / len(loop) * travel
    translations = loop.translations.copy()
    for joint in carry:
        parent = skeleton.joints[joint].parent
        translations[:, joint] += shift if parent < 0 else rotate(inverse(turned[:, parent]), shift)
    return Poses(translations, loop.rotations, loop.scales)


def _jump(skeleton: Skeleton, loop: Poses, carry: tuple[int, ...], up: Array, points: bool) -> float:
    size = len(loop)
    placement = going_on(skeleton, loop.rows(size - 2, size), loop.rows(0, 2), carry, up, 1.0, points)
    around = joined_poses([loop.rows(size - 1, size), placed(skeleton, loop.rows(0, 1), carry, placement)])
    largest = 0.0
    for step, most in zip(steps(skeleton, around, carry), steps(skeleton, loop, carry), strict=True):
        largest = max(largest, step / most if most else (0.0 if step < 1e-9 else np.inf))
    return float(largest)
