"""The reference pose of a skeleton: the start of angles from rotations, the same for every clip of it.

If a body could stand in the rest pose, that is the reference. Rigs with all bones along one axis at rest, or without
offsets, use the most upright frame of the first clip of the skeleton. It is stored as a pose, so that a clip that is
cut, reversed or composed keeps its angles.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from mcml.motion.anatomy.axes import STANDS, Stance, stance_in, uprightness
from mcml.motion.anatomy.segment_frames import Frames, pelvis_frames, tilt_of
from mcml.motion.clip import Reference, ReferencePose
from mcml.motion.kinematics import Walker, rest_positions
from mcml.motion.pictures.figures import axis_of
from mcml.motion.rotations import IDENTITY
from mcml.motion.skeleton import Array, Skeleton, once_a_skeleton
from mcml.motion.units import DEGREES, Reading
from mcml.motion.vectors import angle_between, dot, length

SPINE: Final = ("waist", "torso2", "torso3", "torso4", "torso5", "torso6", "torso7")
"""Joints of the spine, the lowest first. The lowest one that a body has is in its pelvis, as the root is."""
PELVIS, ANKLES = "pelvis", ("left_foot", "right_foot")
"""Names of constants of a standing body: the tilt of the frame of its pelvis, and the dorsiflexion of its ankles."""
LOW: Final = 0.2
"""Height of a point of the pelvis above the line through the hips, in distances between these, below which it does not
tell where up is in the pelvis."""
MOST_TILTED: Final = 60.0
"""Degrees of tilt of a standing pelvis beyond which its points do not show where up is in it."""

DECIMALS = 6
"""Of the numbers of a pose that is kept."""


def stance_of(reference: Reference, skeleton: Skeleton, reading: Reading = DEGREES) -> Stance | None:
    """Return the anatomical axes of a reference; None if the pose of its frame is unknown.

    Raises ConversionError if left and right are unknown in it.
    """
    up = axis_of(reference.up)
    if reference.pose is not None:
        return stance_in(skeleton, np.array(reference.pose.positions), np.array(reference.pose.rotations), up)
    if reference.frame is not None:
        return None
    turned = np.tile(IDENTITY, (len(skeleton), 1))
    return stance_in(skeleton, rest_positions(skeleton, reading)[: len(skeleton)], turned, up)


@once_a_skeleton
def could_stand(skeleton: Skeleton, reading: Reading, up: str) -> bool:
    """Tell whether a body could stand in the rest pose."""
    rest = rest_positions(skeleton, reading)[None, : len(skeleton)]
    return bool(uprightness(skeleton, rest, axis_of(up))[0] > STANDS)


def pose_in(skeleton: Skeleton, reading: Reading, values: Array) -> ReferencePose:
    """The pose of one frame. values: (D,) of the skeleton's columns, without gaps."""
    positions, rotations = Walker(skeleton, reading).poses_at(values[None])
    places, turns = (np.round(each[0], DECIMALS).tolist() for each in (positions, rotations))
    return ReferencePose(tuple(map(tuple, places)), tuple(map(tuple, turns)))


def frames_of_pelvis(left_hip: Array, right_hip: Array, points: Sequence[Array]) -> Frames:
    """Return the frames of a pelvis by its hips and the first of some points (n, 3) that is above them in most frames.

    Points and hips are at one place in a pelvis, so any frames of a body choose the same point.
    """
    found = pelvis_frames(left_hip, right_hip, points[0])
    for point in points:
        frames = pelvis_frames(left_hip, right_hip, point)
        height = dot(point - (left_hip + right_hip) / 2, frames.z) / length(left_hip - right_hip)
        seen = height[np.isfinite(height)]
        if len(seen) and np.median(seen) > LOW:
            return frames
    nothing = np.full_like(found.x, np.nan)
    return Frames(nothing, found.y, nothing)


def dorsiflexion_of(knee: Array, ankle: Array, toes: Array) -> Array:
    """(n,) 90 degrees minus the angle between the shank and the line from ankle to toes, of positions (n, 3)."""
    return 90.0 - angle_between(knee - ankle, toes - ankle)


def standing_zeros(skeleton: Skeleton, positions: Array, up: Array) -> dict[str, float]:
    """Degrees of the pelvis and of the ankles in the frames of their joints, in the pose of a body that stands.

    positions: (J, 3). These constants are subtracted from angles: the frame of the joints of an upright pelvis leans,
    and a flat foot has an ankle higher than its toes. Unknown ones are left out.
    """
    at = {name: positions[None, index] for index, name in enumerate(skeleton.names)}
    found: dict[str, float] = {}
    points = [at[name] for name in pelvis_points(tuple(at)) if name in at]
    if "left_up_leg" in at and "right_up_leg" in at and points:
        tilt = float(tilt_of(frames_of_pelvis(at["left_up_leg"], at["right_up_leg"], points), up)[0])
        if abs(tilt) < MOST_TILTED:
            found[PELVIS] = round(tilt, DECIMALS)
    for ankle in ANKLES:
        side = ankle.partition("_")[0]
        if all(name in at for name in (ankle, f"{side}_low_leg", f"{side}_toes")):
            degrees = float(dorsiflexion_of(at[f"{side}_low_leg"], at[ankle], at[f"{side}_toes"])[0])
            if np.isfinite(degrees):
                found[ankle] = round(degrees, DECIMALS)
    return found


def pelvis_points(names: Sequence[str]) -> tuple[str, ...]:
    """The points of a pelvis besides its hips: the lowest joint of the spine, and the root."""
    lowest = next((name for name in SPINE if name in names), None)
    return ("Root",) if lowest is None else (lowest, "Root")
